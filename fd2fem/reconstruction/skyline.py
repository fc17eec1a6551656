"""The wall's outline where it may be no rectangle: gables, stepped parapets, leaning ends, missing corners.

Seen from above, from the left and from the right, the wall's end is divided into straight pieces
(:mod:`~fd2fem.reconstruction.profiles`); at the foot only large missing corners count, for cars and doors
leave gaps there too. Then each piece is moved, and turned where its two halves disagree by more than their
errors (:mod:`~fd2fem.reconstruction.outline_edges`). A wall that nothing contradicts is a rectangle.
"""

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.model import Side, SpacingGrid
from fd2fem.reconstruction.outline_edges import (
    REACH,
    Edge,
    WallPoints,
    close,
    measured,
    without_parallels,
    without_slivers,
)
from fd2fem.reconstruction.profiles import Hidden, Profile, WallCells, profile, rim, wall_cells
from fd2fem.reconstruction.sampling import Sampling
from fd2fem.reconstruction.wall_ends import corner_notch, side_edge, top_edges

__all__ = ["OutlineFit", "fit_outline"]

FloatArray = NDArray[np.float64]

FAR_CORNER = 0.1
"""No corner lies farther beyond the wall's points, in shares of the wall's larger extent."""


@dataclass(frozen=True, eq=False)
class OutlineFit:
    """The wall's outline.

    Attributes
    ----------
    ring : (k, 2) float array, m
        Corners, counter-clockwise from the lower left; edges that are upright or level are exactly so.
    sigma : (k,) float array, m
        Standard error of each edge, from its corner to the next one; infinite for a given ground.
    kinds : tuple of str
        What each edge is: ``"bottom"``, ``"right"``, ``"top"``, ``"left"``, ``"step"`` or ``"notch"``.
    """

    ring: FloatArray
    sigma: FloatArray
    kinds: tuple[str, ...]

    @property
    def rectangular(self) -> bool:
        """Whether the wall is a rectangle with upright and level edges."""
        return len(self.ring) == 4 and len(np.unique(self.ring[:, 0])) == len(np.unique(self.ring[:, 1])) == 2


def fit_outline(
    xz: FloatArray,
    *,
    sampling: Sampling,
    gaps: list[FloatArray],
    ground: float | None = None,
    hidden: Hidden | None = None,
    min_feature: float = 0.4,
    grid: SpacingGrid | None = None,
) -> OutlineFit:
    """Outline of a wall from its points.

    Parameters
    ----------
    xz : (n, 2) float array, m
        The wall's points, sorted by x.
    sampling : Sampling
    gaps : list of (k, 2) float arrays, m
        Outlines of openings and of filled occlusions: no points there does not mean no wall.
    ground : float or None, m
        Where the wall stands; ``None``: where its points end.
    hidden : function or None
        Tells for places (k, 2) on the wall whether something hid them from the scanner.
    min_feature : float, m
        Narrower chimneys and gaps are left out.
    grid : SpacingGrid or None
        The local point spacing, where it was measured.

    Returns
    -------
    OutlineFit

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> wall = rng.uniform([0, 0], [8, 6], (30_000, 2))
    >>> wall = wall[wall[:, 1] < 6 - 0.5 * abs(wall[:, 0] - 4)]
    >>> order = np.argsort(wall[:, 0])
    >>> fit = fit_outline(wall[order], sampling=Sampling(0.04, 0.0, 0.0), gaps=[])
    >>> fit.kinds, bool(abs(fit.ring[:, 1].max() - 6.0) < 0.03)
    (('bottom', 'right', 'top', 'top', 'left'), True)
    """
    cells = wall_cells(xz, sampling.spacing, gaps, grid=grid)
    wall = WallPoints(xz[rim(cells, 2.0 * REACH * sampling.spacing)], sampling, gaps, min_feature)
    seen = {side: profile(xz, cells, side, sampling.spacing, hidden) for side in Side}
    extent = _extent(cells)
    bottom = float(extent[0][1]) if ground is None else ground
    chain, aside = _first_guess(wall, seen, extent, bottom, sure=hidden is not None)
    wall, fixed = replace(wall, gaps=[*gaps, *aside]), ground is not None
    fitted = _fitted(chain, wall, fixed=fixed)
    if fitted is None:
        fitted = _settled(_plain(chain), wall, fixed=fixed)
    return OutlineFit(
        close(fitted), np.array([edge.sigma for edge in fitted]), tuple(edge.kind for edge in fitted)
    )


def _fitted(chain: list[Edge], wall: WallPoints, *, fixed: bool) -> list[Edge] | None:
    """The edges where their points say that they are, or None where these do not make a ring."""
    try:
        fitted = without_slivers(
            _settled(without_parallels(chain), wall, fixed=fixed), wall.min_feature / 4.0
        )
        ring = close(fitted)
    except ReconstructionError:
        # Ragged points can make neighbours of edges that run side by side and meet nowhere.
        return None
    low, high = wall.xz.min(axis=0), wall.xz.max(axis=0)
    # Edges that are nearly parallel meet far beyond the wall.
    slack = FAR_CORNER * float((high - low).max())
    near = (ring > low - slack).all() and (ring < high + slack).all()
    return fitted if near and shapely.Polygon(ring).is_valid else None


def _first_guess(
    wall: WallPoints,
    seen: dict[Side, Profile],
    extent: tuple[FloatArray, FloatArray],
    bottom: float,
    *,
    sure: bool,
) -> tuple[list[Edge], list[FloatArray]]:
    """Closed chain of edges by the profiles, and strips of the skyline that say nothing."""
    left, right = (side_edge(wall, seen[side], side) for side in (Side.LEFT, Side.RIGHT))
    between = (_innermost(left, -1.0, *extent), _innermost(right, 1.0, *extent))
    top, aside = top_edges(wall, seen[Side.TOP], between, sure=sure)
    at_left, at_right = (
        corner_notch(wall, seen[Side.BOTTOM], bottom, between, side, sure=sure)
        for side in (Side.LEFT, Side.RIGHT)
    )
    foot = Edge((0.0, -1.0), -bottom, "bottom")
    return [foot, *at_right[::-1], right, *top[::-1], left, *at_left], aside


def _plain(chain: list[Edge]) -> list[Edge]:
    """Four edges of a chain: the foot, the ends, and the highest top made level."""
    edges = {edge.kind: edge for edge in chain}
    level = max(edge.offset for edge in chain if edge.kind == "top")
    return [edges["bottom"], edges["right"], Edge((0.0, 1.0), level, "top"), edges["left"]]


def _settled(chain: list[Edge], wall: WallPoints, *, fixed: bool) -> list[Edge]:
    """Each edge where its points say that it is; slanted ones again, for turning changes what lies beside."""
    for turn in range(3):
        ring = close(chain)
        chain = [
            edge
            if (turn and edge.exact) or (fixed and number == 0)
            else measured(edge, ring[number], ring[(number + 1) % len(ring)], wall)
            for number, edge in enumerate(chain)
        ]
        chain = without_parallels(chain)
    return chain


def _extent(cells: WallCells) -> tuple[FloatArray, FloatArray]:
    """Corners of the box that the wall's cells fill, without a few ragged ones, m."""
    low, high = np.empty(2), np.empty(2)
    for axis in (0, 1):
        counts = cells.wall.sum(axis=1 - axis)
        filled = np.flatnonzero(counts > 0.05 * np.quantile(counts, 0.9))
        low[axis], high[axis] = cells.origin[axis] + cells.size * np.array([filled[0], filled[-1] + 1])
    return low, high


def _innermost(end: Edge, sign: float, low: FloatArray, high: FloatArray) -> float:
    """X of an end where it lies furthest in the wall, m."""
    x = [(end.offset - end.normal[1] * z) / end.normal[0] for z in (float(low[1]), float(high[1]))]
    return min(x) if sign > 0 else max(x)
