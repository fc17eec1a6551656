"""Better tetrahedra by moving the nodes of bad ones, without changing the surface."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.quality import tetrahedron_shapes

__all__ = ["relocate"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

PASSES = 5
"""Times that bad tetrahedra are gone through."""
MOST = 300
"""Tetrahedra, the worst ones, that are gone through each time."""
TRIES = 10
"""Steps of the search for a node's place."""
FIRST_STEP = 0.2
"""Length of the first one, part of the mean length of the edges there."""
FLAT = 1e-12
"""Eigenvalue, of the normals about a node, up to which it may move in that direction."""


def relocate(nodes: FloatArray, corners: IntArray, facets: IntArray, *, target: float) -> FloatArray:
    """Nodes (n, 3), m, moved so that the worst tetrahedra get better where they are worse than `target`.

    A node moves where the worst of its tetrahedra is best, as far as a search in ever smaller steps finds
    it: inner nodes freely, those on a plane surface within it, those on a straight crease along it. So the
    surface stays what it is.

    Parameters
    ----------
    nodes : (n, 3) array, m
    corners : (e, 4) int array
        Tetrahedra.
    facets : (f, 3) int array
        Their boundary.
    target : float
        Scaled Jacobian from which on a tetrahedron is let alone.

    References
    ----------
    After Freitag and Ollivier-Gooch, Tetrahedral mesh improvement using swapping and smoothing,
    Int. J. Numer. Meth. Engng 40, 1997 (optimization-based smoothing; the search here is by compass).
    """
    nodes = nodes.copy()
    owners = np.argsort(corners.ravel(), kind="stable") // 4
    first = np.r_[0, np.cumsum(np.bincount(corners.ravel(), minlength=len(nodes)))]
    walls = _normals(nodes, facets)
    for _ in range(PASSES):
        shapes = tetrahedron_shapes(nodes[corners])
        bad = np.flatnonzero(shapes < target)
        bad = bad[np.argsort(shapes[bad])][:MOST]
        moved = False
        for node in dict.fromkeys(corners[bad].ravel().tolist()):
            moved |= _move(nodes, corners[owners[first[node] : first[node + 1]]], node, walls[node])
        if not moved:
            break
    return nodes


def _normals(nodes: FloatArray, facets: IntArray) -> FloatArray:
    """Sum over the facets about each node of the products (n, 3, 3) of their normals with themselves."""
    corner = nodes[facets]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    products = np.zeros((len(nodes), 3, 3))
    for own in range(3):
        np.add.at(products, facets[:, own], normal[:, :, None] * normal[:, None, :])
    return products


def _move(nodes: FloatArray, around: IntArray, node: int, wall: FloatArray) -> bool:
    """Move one node, in place, to where the worst of the tetrahedra `around` (t, 4) is best."""
    values, vectors = np.linalg.eigh(wall)
    free = vectors.T[values < FLAT]
    if not len(free):
        return False
    compass = np.vstack([free, -free])
    corner = nodes[around]
    own = around == node
    step = FIRST_STEP * float(np.linalg.norm(corner - nodes[node], axis=2).sum()) / (3.0 * len(around))
    start = best = float(tetrahedron_shapes(corner).min())
    for _ in range(TRIES):
        places = nodes[node] + step * compass
        tried = np.where(own[None, :, :, None], places[:, None, None, :], corner[None])
        worst = tetrahedron_shapes(tried.reshape(-1, 4, 3)).reshape(len(places), -1).min(axis=1)
        chosen = int(worst.argmax())
        if worst[chosen] > best:
            best = float(worst[chosen])
            nodes[node], corner = places[chosen], tried[chosen]
        else:
            step /= 2.0
    return best > start
