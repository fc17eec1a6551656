"""Mesh files, by suffix."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from fd2fem.errors import InputError
from fd2fem.meshing.gmsh_files import read_msh, write_by_gmsh
from fd2fem.meshing.text_files import write_cdb, write_inp
from fd2fem.model import VolumeMesh

__all__ = ["MESH_SUFFIXES", "read_mesh", "write_mesh"]


def _write_vtu(mesh: VolumeMesh, path: Path) -> None:
    """Write VTK's unstructured grid; a point field per group is 1 on its nodes, 0 elsewhere."""
    import meshio

    fields = {}
    for name, facets in mesh.groups.items():
        fields[name] = np.zeros(len(mesh.nodes), dtype=np.int8)
        fields[name][facets] = 1
    grid = meshio.Mesh(np.array(mesh.nodes), [(mesh.kind.value, np.array(mesh.elements))], point_data=fields)
    grid.write(path, file_format="vtu")


_WRITERS: Mapping[str, Callable[[VolumeMesh, Path], None]] = {
    ".msh": write_by_gmsh,
    ".vtu": _write_vtu,
    ".inp": write_inp,
    ".cdb": write_cdb,
    ".med": write_by_gmsh,
}

MESH_SUFFIXES = tuple(_WRITERS)
"""Suffixes that `write_mesh` knows."""


def write_mesh(mesh: VolumeMesh, path: Path) -> None:
    """Write a mesh with its groups in the format that the suffix of `path` names.

    .msh: gmsh 4.1, physical groups. .vtu: ParaView, a point field per group. .inp: Abaqus and CalculiX,
    node sets. .cdb: ANSYS blocked archive, node components. .med: Salome and Code_Aster, groups of
    facets. Groups without facets are left out of all but .vtu. All lengths are metres.

    Parameters
    ----------
    mesh : VolumeMesh
    path : Path
        An existing file is overwritten.

    Raises
    ------
    InputError
        If the suffix is another, or the folder does not exist.
    MeshError
        If gmsh cannot write the file.
    """
    writer = _WRITERS.get(path.suffix)
    if writer is None:
        msg = f"Cannot write a mesh as '{path.name}': the suffix must be one of {', '.join(MESH_SUFFIXES)}."
        raise InputError(msg)
    if not path.parent.is_dir():
        msg = f"There is no folder {path.parent} to write {path.name} to: make it first."
        raise InputError(msg)
    writer(mesh, path)


def read_mesh(path: Path) -> VolumeMesh:
    """Read a .msh file with 8-node hexahedra or 10-node tetrahedra and the physical groups.

    Raises
    ------
    InputError
        If the suffix is another, the file is missing or damaged, holds other elements or lacks the
        group "base".
    """
    if path.suffix != ".msh":
        msg = f"Cannot read a mesh from '{path.name}': the suffix must be .msh."
        raise InputError(msg)
    return read_msh(path)
