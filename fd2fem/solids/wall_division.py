"""A wall of several thicknesses, divided at its storeys: what its faces are bounded by.

Seen from outside, the levels where the thickness changes cut the rims' edges into pieces and part the wall
along level lines. Each line becomes a ledge, each closed chain of pieces and lines a back face.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Band, Facade
from fd2fem.model.outlines import Oval
from fd2fem.solids.rim_edges import Edge, Point
from fd2fem.solids.rims import WallRims

__all__ = ["LevelLine", "Piece", "WallDivision", "divide_wall"]

FloatArray = NDArray[np.float64]

ON_LEVEL = 5e-8
"""A corner this close to the level of a storey, m, lies on it."""
TOUCH = 1e-6
"""A curve whose highest or lowest point is this close to a level, m, touches it."""
FULL_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Piece:
    """The part of an edge within one band: nodes where it starts and ends, and its curve unless straight."""

    start: int
    end: int
    band: int
    oval: Oval | None = None


@dataclass(frozen=True)
class LevelLine:
    """A line inside the wall, from node `left` to `right`, between the bands `below` and `below + 1`."""

    left: int
    right: int
    below: int


@dataclass(frozen=True)
class WallDivision:
    """A wall divided at its storeys.

    Attributes
    ----------
    bands : tuple of Band
        Neighbours differ in thickness.
    nodes : tuple of (x, z), m
        Ends of the pieces.
    edges : tuple of Edge
        Of all rims, one rim after the other.
    pieces : tuple of tuple of Piece
        Of each edge, in turn.
    rims : tuple of range
        The edges of each rim, the outer one first.
    lines : tuple of LevelLine
    """

    bands: tuple[Band, ...]
    nodes: tuple[Point, ...]
    edges: tuple[Edge, ...]
    pieces: tuple[tuple[Piece, ...], ...]
    rims: tuple[range, ...]
    lines: tuple[LevelLine, ...]


def divide_wall(facade: Facade, rims: WallRims) -> WallDivision:
    """Divide the wall with the given rims at the storeys of `facade`.

    Raises
    ------
    InputError
        If an edge touches the level of a storey in a point, where the wall would hang together by an edge.

    Examples
    --------
    >>> from fd2fem.model import Storey, rectangle
    >>> from fd2fem.solids.rims import wall_rims
    >>> facade = Facade(rectangle(0, 0, 4, 6), 0.5, storeys=(Storey(3.0, 0.4),))
    >>> division = divide_wall(facade, wall_rims(facade))
    >>> [division.nodes[line.left] for line in division.lines], len(division.pieces[1])
    ([(0.0, 3.0)], 2)
    """
    edges = tuple(edge for rim in rims.all for edge in rim)
    bands = _bands(facade, edges)
    levels = np.array([band.low for band in bands[1:]])
    ends = np.cumsum([len(rim) for rim in rims.all]).tolist()
    ranges = tuple(range(a, b) for a, b in zip([0, *ends], ends, strict=False))
    following = [n for r in ranges for n in (*r[1:], r[0])]
    nodes: list[Point] = [edge.start for edge in edges]
    pieces: list[tuple[Piece, ...]] = []
    for number, edge in enumerate(edges):
        _check_touch(edge, levels)
        cuts, inner = _cut(edge, levels)
        chain = [number, *range(len(nodes), len(nodes) + len(inner)), following[number]]
        nodes += inner
        parts = [_part(edge.oval, a, b) for a, b in pairwise(cuts)]
        pieces.append(
            tuple(
                Piece(a, b, _band(nodes[a], nodes[b], part, levels), part)
                for a, b, part in zip(chain, chain[1:], parts, strict=False)
            )
        )
    lines = _level_lines(levels, nodes, [piece for parts in pieces for piece in parts])
    return WallDivision(bands, tuple(nodes), edges, tuple(pieces), ranges, lines)


def _bands(facade: Facade, edges: Sequence[Edge]) -> tuple[Band, ...]:
    """Bands of a facade, neighbours of one thickness joined; levels that nearly meet a corner moved to it."""
    corners = np.array([edge.start[1] for edge in edges])
    bands: list[Band] = []
    for band in facade.bands:
        if bands and bands[-1].thickness == band.thickness:
            bands[-1] = replace(bands[-1], high=band.high)
            continue
        near = float(corners[np.abs(corners - band.low).argmin()])
        low = near if bands and abs(near - band.low) < 2 * ON_LEVEL else band.low
        if bands:
            bands[-1] = replace(bands[-1], high=low)
        bands.append(replace(band, low=low))
    return tuple(bands)


def _check_touch(edge: Edge, levels: FloatArray) -> None:
    """Raise if a curve is level where a storey begins."""
    oval = edge.oval
    if oval is None or not len(levels):
        return
    low, high = sorted((oval.start, oval.end))
    for angle, z in ((np.pi / 2.0, oval.z + oval.b), (-np.pi / 2.0, oval.z - oval.b)):
        turned = angle + FULL_TURN * np.ceil((low - angle) / FULL_TURN + 1e-9)
        if turned < high - 1e-9 and np.abs(levels - z).min() < TOUCH:
            raise _touches((oval.x, z))


def _touches(at: Point) -> InputError:
    msg = (
        f"A storey begins where an edge touches its level in the point x = {at[0]:.3f}, z = {at[1]:.3f}: the "
        "wall behind would hang together by an edge; let the storey begin some millimetres higher or lower."
    )
    return InputError(msg)


def _cut(edge: Edge, levels: FloatArray) -> tuple[list[float], list[Point]]:
    """Where levels cut an edge: angles on its curve (or fractions), its ends included; points between."""
    inner: list[tuple[float, Point]] = []
    oval = edge.oval
    (x0, z0), (x1, z1) = edge.start, edge.end
    for level in levels.tolist():
        if oval is None:
            if min(z0, z1) + ON_LEVEL < level < max(z0, z1) - ON_LEVEL:
                part = (level - z0) / (z1 - z0)
                inner.append((part, (x0 + part * (x1 - x0), level)))
            continue
        for angle in _crossings(oval, level):
            point = (float(oval.x + oval.a * np.cos(angle)), level)
            if min(np.hypot(*np.subtract(point, end)) for end in (edge.start, edge.end)) > 2 * ON_LEVEL:
                inner.append((angle, point))
    first, last = (0.0, 1.0) if oval is None else (oval.start, oval.end)
    inner.sort(reverse=last < first)
    return [first, *(cut for cut, _ in inner), last], [point for _, point in inner]


def _crossings(oval: Oval, level: float) -> list[float]:
    """Angles between a curve's ends where it crosses a level."""
    sine = (level - oval.z) / oval.b
    if abs(sine) >= 1.0:
        return []
    low, high = sorted((oval.start, oval.end))
    rising = float(np.arcsin(sine))
    turned = [a + FULL_TURN * np.ceil((low - a) / FULL_TURN) for a in (rising, np.pi - rising)]
    return [float(a) for a in turned if low < a < high]


def _part(oval: Oval | None, start: float, end: float) -> Oval | None:
    return None if oval is None else replace(oval, start=start, end=end)


def _band(start: Point, end: Point, oval: Oval | None, levels: FloatArray) -> int:
    """The band that a piece belongs to: where it lies, or if that is a level, on the side of the wall."""
    if oval is not None:
        return int(np.searchsorted(levels, oval.z + oval.b * np.sin((oval.start + oval.end) / 2.0)))
    middle = (start[1] + end[1]) / 2.0
    near = np.flatnonzero(np.abs(levels - middle) < ON_LEVEL)
    if len(near) and abs(start[1] - end[1]) < 2 * ON_LEVEL:
        return int(near[0]) + (1 if end[0] > start[0] else 0)
    return int(np.searchsorted(levels, middle))


def _level_lines(
    levels: FloatArray, nodes: Sequence[Point], pieces: Sequence[Piece]
) -> tuple[LevelLine, ...]:
    """Lines inside the wall on each level, between the nodes where the rims cross it."""
    into = {piece.end: piece for piece in pieces}
    out = {piece.start: piece for piece in pieces}
    lines: list[LevelLine] = []
    for number, level in enumerate(levels.tolist()):
        on_level = sorted((x, node) for node, (x, z) in enumerate(nodes) if abs(z - level) < ON_LEVEL)
        left: int | None = None
        for _, node in on_level:
            away = _direction(nodes, out[node], nodes[node], level)
            back = _direction(nodes, into[node], nodes[node], level)
            goes_right, goes_left = _inside(0.0, away, back), _inside(np.pi, away, back)
            if goes_right and goes_left:
                raise _touches(nodes[node])
            if goes_left and left is not None:
                lines.append(LevelLine(left, node, number))
            left = node if goes_right else None
    return tuple(lines)


def _direction(nodes: Sequence[Point], piece: Piece, node: Point, level: float) -> float:
    """Direction, radians, in which a piece leaves one of its ends, which lies on a level."""
    ends = [nodes[piece.start], nodes[piece.end]]
    is_start = ends[0] == node
    if piece.oval is None:
        x, z = ends[1] if is_start else ends[0]
    else:
        # A little along the curve: where it is level, its bend decides which side it leaves to.
        part, oval = 0.01 if is_start else 0.99, piece.oval
        angle = oval.start + part * (oval.end - oval.start)
        x, z = float(oval.x + oval.a * np.cos(angle)), float(oval.z + oval.b * np.sin(angle))
    rise = 0.0 if piece.oval is None and abs(z - level) < ON_LEVEL else z - node[1]
    return float(np.arctan2(rise, x - node[0])) % FULL_TURN


def _inside(direction: float, away: float, back: float) -> bool:
    """Whether a direction lies in the wall, which is on the left of the rim: from `away` on to `back`."""
    return 0.0 < (direction - away) % FULL_TURN < (back - away) % FULL_TURN
