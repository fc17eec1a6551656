"""The lines that a wall's elements must follow: its rings and the levels of its storeys, as chains.

A chain runs from one sharp corner, or from where a level meets an edge, to the next and bends only gently
between. So a node may stand on any of its corners, and where elements are large enough, one may be skipped.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.walls import WallRings

__all__ = ["GENTLE", "Chain", "cut_ring", "thin", "turns", "wall_chains"]

FloatArray = NDArray[np.float64]

GENTLE = np.radians(30.0)
"""A corner that turns by less is none for the elements."""
ON_LEVEL = 1e-9
"""A corner this close to a storey's level, m, lies on it."""


@dataclass(frozen=True, eq=False)
class Chain:
    """A run of corners (k, 2), m, ends included; of a smooth ring the first one again at the end.

    `ring` numbers the rings, from 0; each piece of a level counts as one, but has wall on both sides.
    """

    corners: FloatArray
    ring: int
    level: bool

    @property
    def steps(self) -> FloatArray:
        """Length (k - 1,) of each edge, m."""
        return np.asarray(np.linalg.norm(np.diff(self.corners, axis=0), axis=1))


def wall_chains(rings: WallRings, levels: Sequence[float]) -> tuple[Chain, ...]:
    """Chains of a wall's rings, in their sense (wall on the left), and of its level lines, to the right.

    Parameters
    ----------
    rings : WallRings
    levels : sequence of float, m
        Heights of the lines that run through the wall from edge to edge.

    Examples
    --------
    >>> wall = WallRings(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]), ())
    >>> [chain.corners.tolist() for chain in wall_chains(wall, [1.0])][-1]
    [[0.0, 1.0], [4.0, 1.0]]
    """
    import shapely

    cut = [cut_ring(ring, levels) for ring in rings.all]
    wall = shapely.Polygon(cut[0], cut[1:])
    shapely.prepare(wall)
    corners = np.vstack(cut)
    lines: list[FloatArray] = []
    for level in levels:
        x = np.unique(corners[corners[:, 1] == level, 0])
        inside = shapely.contains_xy(wall, (x[:-1] + x[1:]) / 2.0, level)
        lines += [
            np.array([[left, level], [right, level]])
            for (left, right), within in zip(pairwise(x.tolist()), inside, strict=True)
            if within
        ]
    junctions = {tuple(end) for line in lines for end in line.tolist()}
    chains = [
        Chain(run, number, level=False) for number, ring in enumerate(cut) for run in _runs(ring, junctions)
    ]
    chains += [Chain(line, len(cut) + number, level=True) for number, line in enumerate(lines)]
    return tuple(chains)


def cut_ring(ring: FloatArray, levels: Sequence[float]) -> FloatArray:
    """Add a corner wherever a ring (k, 2) crosses a level, exactly on it."""
    ring = ring.copy()
    for level in levels:
        ring[np.abs(ring[:, 1] - level) < ON_LEVEL, 1] = level
    cut: list[list[float]] = []
    for (x0, z0), (x1, z1) in zip(ring.tolist(), np.roll(ring, -1, axis=0).tolist(), strict=True):
        cut.append([x0, z0])
        between = sorted(level for level in levels if min(z0, z1) < level < max(z0, z1))
        for level in between if z1 > z0 else between[::-1]:
            cut.append([x0 + (level - z0) / (z1 - z0) * (x1 - x0), level])
    return np.array(cut)


def _runs(ring: FloatArray, junctions: set[tuple[float, ...]]) -> list[FloatArray]:
    """Break a ring at its sharp corners and at `junctions`."""
    ends = np.flatnonzero(
        (np.abs(turns(ring)) > GENTLE) | [tuple(corner) in junctions for corner in ring.tolist()]
    )
    if not len(ends):
        return [np.vstack([ring, ring[:1]])]
    closed = np.vstack([np.roll(ring, -ends[0], axis=0), ring[ends[0]]])
    return [closed[i : j + 1] for i, j in pairwise([*(ends - ends[0]).tolist(), len(ring)])]


def turns(ring: FloatArray) -> FloatArray:
    """Angle (k,), radians, by which a ring's direction changes at each corner; to the left is more than 0."""
    after = np.roll(ring, -1, axis=0) - ring
    before = np.roll(after, 1, axis=0)
    return np.asarray(
        np.arctan2(
            before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.einsum("ki,ki->k", before, after)
        )
    )


def thin(chain: Chain, *, tolerance: float) -> Chain:
    """The chain with fewer corners, up to about `tolerance` (m) off, and the very same area beside it.

    Of each two neighbours kept, one corner between makes up for the area of those left out.
    """
    import shapely

    corners = chain.corners
    if len(corners) < 4:
        return chain
    kept = shapely.get_coordinates(shapely.LineString(corners).simplify(tolerance)).tolist()
    thinned, position = [corners[:1]], 0
    listed = corners.tolist()
    for corner in kept[1:]:
        following = listed.index(corner, position + 1)
        if following > position + 1:
            thinned.append(_apex(corners[position : following + 1])[None])
        thinned.append(corners[following : following + 1])
        position = following
    return Chain(np.vstack(thinned), chain.ring, chain.level)


def _apex(run: FloatArray) -> FloatArray:
    """The corner (2,) above the middle of a run's chord that bounds the same area with it."""
    start, chord = run[0], run[-1] - run[0]
    local = run - start
    area = 0.5 * float(np.sum(local[:-1, 0] * local[1:, 1] - local[1:, 0] * local[:-1, 1]))
    across = np.array([chord[1], -chord[0]])
    return np.asarray(start + chord / 2.0 + 2.0 * area / float(chord @ chord) * across)
