"""Which long triangles make up one hole."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

__all__ = ["PASSAGE", "cluster_triangles"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

PASSAGE = 0.75
"""Holes joined by a passage narrower than this share of the smallest opening are two holes."""


def cluster_triangles(
    other: IntArray, wide: tuple[BoolArray, BoolArray], areas: FloatArray, smallest: float
) -> IntArray:
    """Number the holes that the long triangles make up, the largest first.

    Triangles joined through sides wider than a passage are the cores of holes. The rest are narrow gaps,
    joined through their long sides; those that border on one core only and are no larger than what a passage
    cuts off a corner are part of it.

    Parameters
    ----------
    other : (t, 3) int array
        The neighbour across each side, -1 for none.
    wide : two (t, 3) bool arrays
        Whether a side is longer than the threshold, and longer than a passage.
    areas : (t,) float array, m²
    smallest : float, m²
        Area from which on triangles joined through wide sides are a core.
    """
    reachable, passable = wide[0] & (other >= 0), wide[1] & (other >= 0)
    core = _components(other, passable)
    is_core = np.bincount(core, areas, minlength=1)[core] > smallest
    result = np.where(is_core, core, -1)
    # The rim, triangle by triangle.
    for side in range(3):
        joins = ~is_core & (result < 0) & reachable[:, side]
        joins[joins] = is_core[other[joins, side]]
        result[joins] = core[other[joins, side]]
    # The rest, gap by gap.
    rest = result < 0
    gap = _components(other, reachable & rest[:, None] & rest[other])
    beside = _single_neighbour(gap, np.where(reachable & rest[:, None], result[other], -1))
    corner = rest & (np.bincount(gap, areas, minlength=1)[gap] < PASSAGE**2 * smallest) & (beside[gap] >= 0)
    result = np.where(corner, beside[gap], np.where(rest, gap + len(core), result))
    name = np.unique(result, return_inverse=True)[1].ravel()
    rank = np.argsort(np.argsort(-np.bincount(name, areas), kind="stable"))
    return rank[name].astype(np.intp)


def _single_neighbour(gap: IntArray, beside: IntArray) -> IntArray:
    """The one core that each gap borders on, -1 for none or several, from those beside triangles (t, 3)."""
    first, last = np.full(len(gap), len(gap)), np.full(len(gap), -1)
    for side in beside.T:
        there = side >= 0
        np.minimum.at(first, gap[there], side[there])
        np.maximum.at(last, gap[there], side[there])
    return np.where(first == last, last, -1)


def _components(other: IntArray, linked: BoolArray) -> IntArray:
    """Connected components of triangles, given each one's neighbours and which of these count."""
    first, side = np.nonzero(linked)
    shape = (len(other), len(other))
    graph = sparse.coo_array((np.ones(len(first)), (first, other[first, side])), shape=shape)
    component: IntArray = connected_components(graph, directed=False)[1].astype(np.intp)
    return component
