"""Meshes with named groups by gmsh, their quality, and the files they are written to."""

from fd2fem.meshing.cells import front_cells
from fd2fem.meshing.exports import MESH_SUFFIXES, read_mesh, write_mesh
from fd2fem.meshing.hexahedra import mesh_facade
from fd2fem.meshing.options import ElementShape, MeshOptions
from fd2fem.meshing.order import quadratic_mesh
from fd2fem.meshing.quality import mesh_quality
from fd2fem.meshing.tetrahedra import mesh_facade_tetrahedra, mesh_step

__all__ = [
    "MESH_SUFFIXES",
    "ElementShape",
    "MeshOptions",
    "front_cells",
    "mesh_facade",
    "mesh_facade_tetrahedra",
    "mesh_quality",
    "mesh_step",
    "quadratic_mesh",
    "read_mesh",
    "write_mesh",
]
