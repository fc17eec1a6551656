"""The back faces of a divided wall as closed chains of pieces and level lines."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.checks import signed_area
from fd2fem.solids.rim_edges import edge_points
from fd2fem.solids.wall_division import LevelLine, Piece, WallDivision

__all__ = ["Loop", "back_loops"]

Loop = list[Piece | LevelLine]
FloatArray = NDArray[np.float64]


def back_loops(division: WallDivision) -> list[tuple[int, list[Loop]]]:
    """The band of each back face, and its loops, the outer one first, with the wall on their left.

    Seen from outside, as all of the division.
    """
    import shapely

    faces: list[tuple[int, list[Loop]]] = []
    for band in range(len(division.bands)):
        outer: list[tuple[shapely.Polygon, list[Loop]]] = []
        holes: list[tuple[FloatArray, Loop]] = []
        for loop in _chains(division, band):
            ring = _ring(division, loop, band)
            if signed_area(ring) > 0.0:
                outer.append((shapely.Polygon(ring), [loop]))
            else:
                holes.append((ring, loop))
        for ring, loop in holes:
            hole = shapely.Polygon(ring)
            home = max(outer, key=lambda face: float(face[0].intersection(hole).area))
            home[1].append(loop)
        faces += [(band, loops) for _, loops in outer]
    return faces


def _chains(division: WallDivision, band: int) -> list[Loop]:
    """Closed chains around the parts of one band."""
    onwards: dict[int, tuple[Piece | LevelLine, int]] = {}
    for piece in (piece for parts in division.pieces for piece in parts if piece.band == band):
        onwards[piece.start] = piece, piece.end
    for line in division.lines:
        if line.below == band:
            onwards[line.right] = line, line.left
        elif line.below + 1 == band:
            onwards[line.left] = line, line.right
    chains: list[Loop] = []
    while onwards:
        first = node = next(iter(onwards))
        chain: Loop = []
        while not chain or node != first:
            item, node = onwards.pop(node)
            chain.append(item)
        chains.append(chain)
    return chains


def _ring(division: WallDivision, loop: Loop, band: int) -> FloatArray:
    """Corners (k, 2), m, of a loop, its curves as chords."""
    points: list[FloatArray] = []
    for item in loop:
        if isinstance(item, LevelLine):
            points.append(np.array([division.nodes[item.right if item.below == band else item.left]]))
        else:
            points.append(edge_points(division.nodes[item.start], item.oval))
    return np.concatenate(points)
