"""The wall as one CAD solid with the fewest faces, from its outline."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from fd2fem.errors import NumericsError
from fd2fem.model import Facade
from fd2fem.model.outlines import Oval
from fd2fem.solids.occ_shapes import (
    backwards,
    curve_edge,
    curved_face,
    line_edge,
    make_solid,
    plane_face,
    turned,
    vertex,
)
from fd2fem.solids.rims import wall_rims
from fd2fem.solids.wall_division import LevelLine, Piece, WallDivision, divide_wall
from fd2fem.solids.wall_loops import back_loops

if TYPE_CHECKING:
    from cadquery import Solid

__all__ = ["cad_wall"]

SAME = 1e-6
"""Largest relative difference of volume between a facade and its solid."""


def cad_wall(facade: Facade) -> "Solid":
    """The wall of a facade, its doors and windows left out, as one solid with the fewest faces.

    Its front is one face at y = 0. Each edge of the outline and of an opening makes one face, as deep as
    the wall; arcs make parts of cylinders. Where the thickness changes from storey to storey, each has
    a back of its own, and level ledges lie between them. The volume is the facade's: arcs have exactly
    the area of their corners.

    Parameters
    ----------
    facade : Facade

    Returns
    -------
    solid : cadquery.Solid
        Facade frame, m.

    Raises
    ------
    InputError
        If the wall falls into pieces, or hangs together by an edge.
    NumericsError
        If OpenCASCADE finds no sound solid in it.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> solid = cad_wall(Facade(rectangle(0, 0, 4, 3), 0.5))
    >>> round(solid.Volume(), 9), len(solid.Faces())
    (6.0, 6)
    """
    from cadquery import Solid

    shapes = _Shapes(divide_wall(facade, wall_rims(facade)))
    numbers = range(len(shapes.division.edges))
    faces = [_front(shapes), *(_side(shapes, number) for number in numbers), *_backs(shapes)]
    solid = Solid(make_solid([*faces, *(_ledge(shapes, line) for line in shapes.division.lines)]))
    volume = float(solid.Volume())
    if not solid.isValid() or abs(volume - facade.volume) > SAME * facade.volume:
        msg = (
            f"OpenCASCADE finds no sound solid in the wall ({volume:.9g} m³, expected {facade.volume:.9g}): "
            "look for edges or gaps of less than a micrometre."
        )
        raise NumericsError(msg)
    return solid


@dataclass(frozen=True)
class _Shapes:
    """Vertices and edges of a divided wall, each made when it is first asked for."""

    division: WallDivision
    made: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    depths: dict[int, list[float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Collect the depths at which something meets each node's line along y."""
        depths: dict[int, set[float]] = {node: {0.0} for node in range(len(self.division.nodes))}
        for piece in (piece for parts in self.division.pieces for piece in parts):
            for node in (piece.start, piece.end):
                depths[node].add(self.depth(piece.band))
        self.depths.update({node: sorted(values) for node, values in depths.items()})

    def depth(self, band: int) -> float:
        """Thickness of a band, m."""
        return self.division.bands[band].thickness

    def vertex(self, node: int, y: float) -> Any:
        """The vertex of a node at a depth."""
        key = (node, y)
        if key not in self.made:
            x, z = self.division.nodes[node]
            self.made[key] = vertex(x, y, z)
        return self.made[key]

    def edge(self, start: int, end: int, y: float, oval: Oval | None = None) -> Any:
        """The edge from node to node at a depth."""
        key = (start, end, y, oval)
        if key not in self.made:
            ends = self.vertex(start, y), self.vertex(end, y)
            self.made[key] = line_edge(*ends) if oval is None else curve_edge(oval, y, *ends)
        return self.made[key]

    def along(self, node: int, start: float, end: float) -> list[Any]:
        """Edges along y at a node, from depth to depth."""
        low, high = sorted((start, end))
        found = []
        for pair in pairwise(y for y in self.depths[node] if low <= y <= high):
            key = (node, *pair)
            if key not in self.made:
                self.made[key] = line_edge(*(self.vertex(node, y) for y in pair))
            found.append(self.made[key])
        return found if end >= start else turned(found)


def _front(shapes: _Shapes) -> Any:
    division = shapes.division
    loops = [[_front_edge(shapes, number) for number in rim] for rim in division.rims]
    return plane_face((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), loops)


def _front_edge(shapes: _Shapes, number: int) -> Any:
    parts = shapes.division.pieces[number]
    return shapes.edge(parts[0].start, parts[-1].end, 0.0, shapes.division.edges[number].oval)


def _side(shapes: _Shapes, number: int) -> Any:
    """The face along y of one edge of the rims."""
    edge, parts = shapes.division.edges[number], shapes.division.pieces[number]
    start, end = (0.0, 1.0) if edge.oval is None else (edge.oval.start, edge.oval.end)
    first, last = shapes.depth(parts[0].band), shapes.depth(parts[-1].band)
    loop = [(backwards(_front_edge(shapes, number)), start)]
    loop += [(shape, start) for shape in shapes.along(parts[0].start, 0.0, first)]
    before = first
    for piece in parts:
        depth = shapes.depth(piece.band)
        angle = start if piece.oval is None else piece.oval.start
        loop += [(shape, angle) for shape in shapes.along(piece.start, before, depth)]
        loop.append((_back_edge(shapes, piece, piece.band), angle))
        before = depth
    loop += [(shape, end) for shape in shapes.along(parts[-1].end, last, 0.0)]
    if edge.oval is not None:
        return curved_face(edge.oval, loop)
    (x0, z0), (x1, z1) = edge.start, edge.end
    return plane_face((x0, 0.0, z0), (z1 - z0, 0.0, x0 - x1), [[shape for shape, _ in loop]])


def _back_edge(shapes: _Shapes, item: Piece | LevelLine, band: int) -> Any:
    """The edge of a piece or a level line at the back of a band, with that band on its left."""
    if isinstance(item, Piece):
        return shapes.edge(item.start, item.end, shapes.depth(band), item.oval)
    edge = shapes.edge(item.left, item.right, shapes.depth(band))
    return backwards(edge) if band == item.below else edge


def _backs(shapes: _Shapes) -> list[Any]:
    """The faces at the back."""
    faces = []
    for band, loops in back_loops(shapes.division):
        chains = [turned([_back_edge(shapes, item, band) for item in loop]) for loop in loops]
        faces.append(plane_face((0.0, shapes.depth(band), 0.0), (0.0, 1.0, 0.0), chains))
    return faces


def _ledge(shapes: _Shapes, line: LevelLine) -> Any:
    """The level face at a level line: it looks up where the wall gets thinner there, else down."""
    below, above = shapes.depth(line.below), shapes.depth(line.below + 1)
    left, right = line.left, line.right
    loop = [
        shapes.edge(left, right, above),
        *shapes.along(right, above, below),
        backwards(shapes.edge(left, right, below)),
        *shapes.along(left, below, above),
    ]
    x, z = shapes.division.nodes[left]
    return plane_face((x, 0.0, z), (0.0, 0.0, np.sign(below - above)), [loop])
