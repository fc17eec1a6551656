"""Quadrilaterals on the front of a wall, swept through its thickness, and the names of the surfaces."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.quads import QuadMesh
from fd2fem.model import GROUPS, ElementKind, Facade, Group, VolumeMesh, edge_groups

__all__ = ["band_thickness", "sweep"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


def band_thickness(facade: Facade, quads: QuadMesh) -> FloatArray:
    """Thickness (q,) of the wall, m, at each quadrilateral."""
    bands = facade.bands
    middle = quads.points[quads.quads, 1].mean(axis=1)
    number = np.searchsorted([band.low for band in bands], middle, side="right") - 1
    thickness = np.array([band.thickness for band in bands], dtype=np.float64)
    return np.asarray(thickness[np.maximum(number, 0)])


def sweep(quads: QuadMesh, facade: Facade, *, slabs: tuple[tuple[float, int], ...]) -> VolumeMesh:
    """Hexahedra between the front, y = 0, and the back, with the groups of :data:`~fd2fem.model.GROUPS`.

    Parameters
    ----------
    quads : QuadMesh
        None of them on both sides of a storey's level.
    facade : Facade
    slabs : tuple of (float, int)
        Depth at which each slab ends, m, and its layers of elements.
    """
    ends = np.r_[0.0, [depth for depth, _ in slabs]]
    parts = [
        np.linspace(near, deep, layers + 1)[1:]
        for near, deep, (_, layers) in zip(ends, ends[1:], slabs, strict=False)
    ]
    depth = np.r_[0.0, np.concatenate(parts)]
    layers = np.searchsorted(depth, band_thickness(facade, quads))
    n = len(quads.points)
    # Seen against y, x to z runs clockwise about it, so the layer deeper in the wall is VTK's lower face.
    elements = np.vstack(
        [
            np.hstack([quads.quads[layers > k] + (k + 1) * n, quads.quads[layers > k] + k * n])
            for k in range(len(depth) - 1)
        ]
    )
    groups = {
        **_rims(quads, facade, layers),
        Group.FRONT: quads.quads,
        Group.BACK: quads.quads[:, ::-1] + n * layers[:, None],
    }
    used, renumbered = np.unique(elements, return_inverse=True)
    return VolumeMesh(
        nodes=np.column_stack([quads.points[used % n, 0], depth[used // n], quads.points[used % n, 1]]),
        elements=renumbered.reshape(-1, 8),
        kind=ElementKind.HEXAHEDRON,
        groups={name: np.searchsorted(used, groups[Group(name)]) for name in GROUPS},
    )


def _rims(quads: QuadMesh, facade: Facade, layers: IntArray) -> dict[Group, IntArray]:
    """Facets through the thickness by group; of `quads`, those with 0 to `layers` layers exist."""
    n = len(quads.points)
    edges = np.stack([quads.quads, np.roll(quads.quads, -1, axis=1)], axis=2).reshape(-1, 2)
    deep = np.repeat(layers, 4)
    shallow = _layers_beyond(edges, deep, count=n)
    rim = np.flatnonzero(shallow == 0)
    names = np.full(len(edges), None, dtype=object)
    names[rim] = edge_groups(facade, quads.points[edges[rim, 0]], quads.points[edges[rim, 1]])
    names[(shallow > 0) & (shallow < deep)] = Group.LEDGES
    groups = {}
    for group in (Group.BASE, Group.TOP, Group.LEFT, Group.RIGHT, Group.REVEALS, Group.LEDGES):
        facets = [np.empty((0, 4), dtype=np.intp)]
        for k in range(int(layers.max())):
            start, end = edges[(names == group) & (shallow <= k) & (k < deep)].T + k * n
            facets.append(np.stack([start, start + n, end + n, end], axis=1))
        groups[group] = np.vstack(facets)
    return groups


def _layers_beyond(edges: IntArray, layers: IntArray, *, count: int) -> IntArray:
    """Layers (e,) of the quadrilateral on the other side of each edge (e, 2); 0 where there is none."""
    key = edges[:, 0] * count + edges[:, 1]
    order = np.argsort(key)
    opposite = edges[:, 1] * count + edges[:, 0]
    place = np.minimum(np.searchsorted(key, opposite, sorter=order), len(key) - 1)
    found = key[order[place]] == opposite
    return np.where(found, layers[order[place]], 0)
