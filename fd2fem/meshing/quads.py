"""Quadrilaterals on the front of a wall, by gmsh."""

from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.lattice import Lattice
from fd2fem.meshing.session import gmsh_session

__all__ = ["QuadMesh", "lattice_quads"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

QUAD = 3
"""gmsh's number for a quadrilateral of 4 nodes."""


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

    @property
    def areas(self) -> FloatArray:
        """Area (q,) of each quadrilateral, m²."""
        diagonals = self.points[self.quads[:, 2:]] - self.points[self.quads[:, :2]]
        first, second = diagonals[:, 0], diagonals[:, 1]
        return np.asarray(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))


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
