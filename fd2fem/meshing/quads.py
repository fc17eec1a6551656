"""Quadrilaterals on the front of a wall, by gmsh."""

from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.lattice import Lattice
from fd2fem.meshing.options import MeshOptions
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.walls import WallRings

__all__ = ["QuadMesh", "free_quads", "lattice_quads"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

QUAD = 3
"""gmsh's number for a quadrilateral of 4 nodes."""
FLATTENING = 50.0
"""A curved edge is followed to within the element size over this."""


@dataclass(frozen=True, eq=False)
class QuadMesh:
    """Quadrilaterals in the facade's plane.

    Attributes
    ----------
    points : (n, 2) float array, m
        x, z; every one is a corner.
    quads : (q, 4) int array
        Corners, counter-clockwise in x, z.
    """

    points: FloatArray
    quads: IntArray


def lattice_quads(lattice: Lattice, columns: IntArray, rows: IntArray) -> QuadMesh:
    """Transfinite quadrilaterals: `columns[i]` by `rows[j]` in each macro cell (i, j) that is wall.

    Raises
    ------
    MeshError
        If gmsh fails.
    """
    with gmsh_session() as gmsh:
        geo = gmsh.model.geo
        number = np.arange(1, lattice.points[..., 0].size + 1).reshape(lattice.points.shape[:2])
        beside_wall = np.pad(lattice.wall, 1)
        for i, j in np.argwhere(
            beside_wall[1:, 1:] | beside_wall[:-1, 1:] | beside_wall[1:, :-1] | beside_wall[:-1, :-1]
        ):
            geo.addPoint(*lattice.points[i, j], 0.0, tag=int(number[i, j]))
        along, up = {}, {}
        for i, j in np.argwhere(beside_wall[1:-1, 1:] | beside_wall[1:-1, :-1]):
            along[i, j] = geo.addLine(int(number[i, j]), int(number[i + 1, j]))
            geo.mesh.setTransfiniteCurve(along[i, j], int(columns[i]) + 1)
        for i, j in np.argwhere(beside_wall[1:, 1:-1] | beside_wall[:-1, 1:-1]):
            up[i, j] = geo.addLine(int(number[i, j]), int(number[i, j + 1]))
            geo.mesh.setTransfiniteCurve(up[i, j], int(rows[j]) + 1)
        for i, j in np.argwhere(lattice.wall):
            loop = geo.addCurveLoop([along[i, j], up[i + 1, j], -along[i, j + 1], -up[i, j]])
            surface = geo.addPlaneSurface([loop])
            geo.mesh.setTransfiniteSurface(surface)
            geo.mesh.setRecombine(2, surface)
        geo.synchronize()
        return _generate(gmsh)


def free_quads(rings: WallRings, *, options: MeshOptions) -> QuadMesh:
    """Unstructured quadrilaterals on a wall with slanted or curved edges.

    Edges are first thinned to corners that follow them within `options.size` / 50 (a polygon of 1 mm
    chords would force 1 mm elements). Blossom pairs triangles of twice the size, and each pair is split
    into four, so at least two elements lie across any pier; where `options.pier_elements` is higher,
    they get smaller near openings that are close to one another or to the outline.

    Raises
    ------
    MeshError
        If gmsh fails or leaves a triangle.
    """
    import shapely

    wall = shapely.Polygon(rings.outer, rings.holes).simplify(options.size / FLATTENING)
    thin = [shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(wall)]
    quality = {
        "Mesh.Algorithm": 6.0,  # frontal Delaunay
        "Mesh.RecombinationAlgorithm": 1.0,  # Blossom
        "Mesh.RecombineAll": 1.0,
        "Mesh.SubdivisionAlgorithm": 1.0,  # all quadrilaterals
        "Mesh.MeshSizeMax": 2.0 * options.size,
    }
    with gmsh_session(quality) as gmsh:
        geo = gmsh.model.geo
        loops = []
        for ring, sizes in zip(thin, _sizes(thin, options=options), strict=True):
            tags = [geo.addPoint(x, z, 0.0, size) for (x, z), size in zip(ring, sizes, strict=True)]
            loops.append(
                geo.addCurveLoop([geo.addLine(*ends) for ends in zip(tags, tags[1:] + tags[:1], strict=True)])
            )
        geo.addPlaneSurface(loops)
        geo.synchronize()
        return _generate(gmsh)


def _sizes(rings: list[FloatArray], *, options: MeshOptions) -> list[FloatArray]:
    """Element size at each corner: less where the next ring is close."""
    import shapely

    loops = [shapely.LinearRing(ring) for ring in rings]
    sizes = []
    for k, ring in enumerate(rings):
        others = shapely.union_all(loops[:k] + loops[k + 1 :])
        gap = (
            np.full(len(ring), np.inf) if others.is_empty else shapely.distance(shapely.points(ring), others)
        )
        sizes.append(2.0 * np.minimum(options.size, gap / options.pier_elements))
    return sizes


def _generate(gmsh: ModuleType) -> QuadMesh:
    """Mesh the surfaces of the model; keep used nodes, numbered densely."""
    try:
        gmsh.model.mesh.generate(2)
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"gmsh could not mesh the wall: {error}. Try another element size or simplify the outline."
        raise MeshError(msg) from error
    kinds, _, corners = gmsh.model.mesh.getElements(2)
    if list(kinds) != [QUAD]:
        msg = "gmsh could not fill the wall with quadrilaterals only: try another element size."
        raise MeshError(msg)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    place = np.empty(int(tags.max()) + 1, dtype=np.intp)
    place[tags.astype(np.intp)] = np.arange(len(tags))
    used, quads = np.unique(place[corners[0].astype(np.intp)], return_inverse=True)
    points = coordinates.reshape(-1, 3)[used, :2]
    quads = quads.reshape(-1, 4)
    diagonals = points[quads[:, 2:]] - points[quads[:, :2]]
    turn = diagonals[:, 0, 0] * diagonals[:, 1, 1] - diagonals[:, 0, 1] * diagonals[:, 1, 0]
    quads[turn < 0.0] = quads[turn < 0.0, ::-1]
    return QuadMesh(points=points, quads=quads)
