"""Meshes with named groups by gmsh, their quality, and the files they are written to."""

from fd2fem.meshing.exports import MESH_SUFFIXES, read_mesh, write_mesh
from fd2fem.meshing.hexahedra import mesh_facade
from fd2fem.meshing.options import MeshOptions
from fd2fem.meshing.quality import mesh_quality
from fd2fem.meshing.tetrahedra import mesh_step

__all__ = [
    "MESH_SUFFIXES",
    "MeshOptions",
    "mesh_facade",
    "mesh_quality",
    "mesh_step",
    "read_mesh",
    "write_mesh",
]
