"""The local point spacing, from the triangles over small patches of the wall."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import Delaunay, QhullError

from fd2fem.errors import ReconstructionError
from fd2fem.model.spacing import SpacingGrid
from fd2fem.reconstruction.triangulation import bounds, side_lengths, triangle_areas

__all__ = ["local_spacing"]

FloatArray = NDArray[np.float64]

CELL = 1.0
"""Edge of the coarse cells, m, unless the wall is so large that there would be too many."""
PATCHES = (64, 400)
"""At least and at most so many cells; between them one for every `POINTS_PER_CELL` points."""
POINTS_PER_CELL = 4000
PATCH = 64
"""Points in a patch: the median of its sides is known to 5 %, and that of three patches by three to 2 %."""
STRIP = 0.125
"""Points so close to the middle of a column of cells, in cells, are looked at first."""
LONGER = 0.8
"""Share of the edges that are shorter than the longest fifth."""
TRIES = 8
"""How often a patch is made larger or smaller until it holds enough points, and not too many."""


def local_spacing(xz: FloatArray) -> SpacingGrid:
    """Measure how far apart the points lie in each part of a wall.

    Parameters
    ----------
    xz : (n, 2) float array, m
        Points without duplicates; those sorted by x are not copied.

    Returns
    -------
    SpacingGrid

    Raises
    ------
    ReconstructionError
        If all points lie on one line.

    Examples
    --------
    >>> x, z = np.meshgrid(np.arange(0.0, 3.0, 0.02), np.arange(0.0, 3.0, 0.02), indexing="ij")
    >>> grid = local_spacing(np.column_stack([x.ravel(), z.ravel()]))
    >>> grid.spacing_at([[1.5, 1.5]]).round(4).tolist()
    [0.02]
    """
    if np.any(xz[1:, 0] < xz[:-1, 0]):
        xz = xz[np.argsort(xz[:, 0], kind="stable")]
    low, high = bounds(xz)
    extent = high - low
    count = np.clip(len(xz) / POINTS_PER_CELL, *PATCHES)
    cell = max(CELL, float(np.sqrt(extent.prod() / count)), float(extent.max()) / PATCHES[1])
    shape = np.maximum(np.ceil(extent / cell), 1).astype(np.intp)
    edge, spacing = np.full(shape, np.nan), np.full(shape, np.nan)
    every = []
    for (column, row), seed, half in _seeds(xz, low, cell, shape):
        sides, areas = _patch(xz, seed, half, limit=cell)
        if len(sides):
            median, longer = _quantiles(sides, (0.5, LONGER))
            # Most edges run along scan lines that are rough; those across are still one in three.
            edge[column, row] = max(median, longer / 2.0)
            wall = sides.max(axis=1) < 4.0 * edge[column, row]
            spacing[column, row] = np.sqrt(2.0 * areas[wall].mean())
            every.append(sides.ravel())
    if not every:
        msg = f"The wall's {len(xz)} points cannot be triangulated: they may lie on one line."
        raise ReconstructionError(msg)
    return SpacingGrid(low, cell, _smooth(edge), _smooth(spacing), np.concatenate(every))


def _seeds(
    xz: FloatArray, low: FloatArray, cell: float, shape: NDArray[np.intp]
) -> Iterator[tuple[tuple[int, int], FloatArray, float]]:
    """Each cell with points: its column and row, a point near its centre (2,), half of a patch's edge, m.

    Such a point is on the wall even where the centre is not.
    """
    for column in range(shape[0]):
        centre = low[0] + (column + 0.5) * cell
        left = np.ones(shape[1], dtype=np.bool_)
        # First along the middle of the column, then, for cells with a hole there, all over it.
        for reach in (STRIP * cell, 0.5 * cell):
            start, stop = np.searchsorted(xz[:, 0], [centre - reach, centre + reach])
            strip = xz[start:stop]
            row = np.minimum(((strip[:, 1] - low[1]) / cell).astype(np.intp), shape[1] - 1)
            off = np.hypot(strip[:, 0] - centre, strip[:, 1] - low[1] - (row + 0.5) * cell)
            nearest = np.full(shape[1], np.inf)
            np.minimum.at(nearest, row, off)
            count = np.bincount(row, minlength=shape[1])
            for index in np.flatnonzero(off == nearest[row]):
                if left[row[index]]:
                    left[row[index]] = False
                    density = count[row[index]] / (2.0 * reach * cell)
                    yield (column, int(row[index])), strip[index], 0.5 * float(np.sqrt(PATCH / density))
            if not left.any():
                break


def _patch(xz: FloatArray, seed: FloatArray, half: float, *, limit: float) -> tuple[FloatArray, FloatArray]:
    """Sides (t, 3), m, and areas (t,), m², of the triangles over a patch; none of too few points."""
    inside, grown = xz[:0], False
    for _ in range(TRIES):
        start, stop = np.searchsorted(xz[:, 0], [seed[0] - half, seed[0] + half])
        strip = xz[start:stop]
        inside = strip[np.abs(strip[:, 1] - seed[1]) <= half]
        # Along a single scan line, the points are closer than the lines are.
        single = not len(inside) or np.diff(bounds(inside), axis=0).min() < 0.9 * half
        if (single or len(inside) < PATCH / 2) and half < limit:
            half, grown = min(1.4 * half, limit), True
        elif len(inside) > 2.5 * PATCH and not grown:
            half *= np.sqrt(PATCH / len(inside))
        else:
            break
    try:
        triangulation = Delaunay(inside - seed)
    except (QhullError, ValueError):  # too few points, or all on one scan line
        return np.empty((0, 3)), np.empty(0)
    triangles = triangulation.simplices
    sides = side_lengths(inside, triangles)
    # Triangles that lie along the patch's border with their longest side fill up its hull.
    fills = ((triangulation.neighbors < 0) & (sides >= sides.max(axis=1, keepdims=True))).any(axis=1)
    return sides[~fills], triangle_areas(inside[triangles[~fills]])


def _quantiles(values: FloatArray, shares: tuple[float, ...]) -> list[float]:
    """The same as ``np.quantile``, which takes ten times as long for so few values."""
    ranked = np.sort(values, axis=None)
    places = [share * (len(ranked) - 1) for share in shares]
    return [
        float(np.interp(place, (int(place), int(place) + 1), ranked[int(place) : int(place) + 2]))
        for place in places
    ]


def _smooth(values: FloatArray) -> FloatArray:
    """Fill the cells without a value from the nearest, and take out single odd ones."""
    nearest = ndimage.distance_transform_edt(np.isnan(values), return_distances=False, return_indices=True)
    smooth: FloatArray = ndimage.median_filter(values[tuple(nearest)], size=3, mode="nearest")
    return smooth
