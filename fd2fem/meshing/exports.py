"""Mesh files, by suffix."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from fd2fem.errors import InputError
from fd2fem.meshing.ansys_file import write_cdb
from fd2fem.meshing.calculix_file import write_inp
from fd2fem.meshing.gmsh_files import WALL, read_msh, write_by_gmsh
from fd2fem.meshing.vtu_file import write_vtu
from fd2fem.model import LoadCase, VolumeMesh

__all__ = ["MESH_SUFFIXES", "read_mesh", "write_mesh"]

_MESH_WRITERS: Mapping[str, Callable[[VolumeMesh, Path], None]] = {
    ".msh": write_by_gmsh,
    ".vtu": write_vtu,
    ".med": write_by_gmsh,
}
_ANALYSIS_WRITERS: Mapping[str, Callable[[VolumeMesh, Path, LoadCase | None], None]] = {
    ".inp": write_inp,
    ".cdb": write_cdb,
}

MESH_SUFFIXES = (".msh", ".vtu", ".inp", ".cdb", ".med")
"""Suffixes that `write_mesh` knows, in lower case."""

USABLE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,23}")
"""Names that every program takes; Code_Aster allows 24 characters, the fewest."""
TAKEN = ("all", WALL)
"""Names of the sets that the writers themselves make."""


def write_mesh(mesh: VolumeMesh, path: Path, *, case: LoadCase | None = None) -> None:
    """Write a mesh with its groups in the format that the suffix of `path` names.

    .msh: gmsh 4.1, physical groups. .vtu: ParaView, an array of the points and of the facets per group.
    .inp: CalculiX and Abaqus, node sets and surfaces. .cdb: ANSYS blocked archive, node components.
    .med: Salome and Code_Aster, groups of facets. The elements are "wall" in all but .vtu. Groups without
    facets are left out of all but .vtu. All lengths are metres.

    Parameters
    ----------
    mesh : VolumeMesh
    path : Path
        An existing file is overwritten. The suffix may be in capitals.
    case : LoadCase, optional
        Material, self-weight and movement of the base: .inp and .cdb hold them, the other formats have no
        place for them.

    Raises
    ------
    InputError
        If the suffix is another, the folder does not exist, a group has a name that not all programs take,
        or what .inp and .cdb need of groups and load case is missing.
    MeshError
        If gmsh cannot write the file.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        msg = f"Cannot write a mesh as '{path.name}': the suffix must be one of {', '.join(MESH_SUFFIXES)}."
        raise InputError(msg)
    if not path.parent.is_dir():
        msg = f"There is no folder {path.parent} to write {path.name} to: make it first."
        raise InputError(msg)
    _check_names(mesh)
    if suffix in _ANALYSIS_WRITERS:
        _ANALYSIS_WRITERS[suffix](mesh, path, case)
    else:
        _MESH_WRITERS[suffix](mesh, path)


def _check_names(mesh: VolumeMesh) -> None:
    """Two names that differ in capitals only are one to ANSYS, Abaqus and CalculiX."""
    seen = set(TAKEN)
    for name in mesh.groups:
        if not USABLE_NAME.fullmatch(name) or name.lower() in seen:
            msg = (
                f"Cannot write the group '{name}': a name is a letter, then at most 23 letters, digits "
                "and '_', and differs from 'wall', 'all' and the others in more than capitals."
            )
            raise InputError(msg)
        seen.add(name.lower())


def read_mesh(path: Path) -> VolumeMesh:
    """Read a .msh file with 8-node or 20-node hexahedra or 10-node tetrahedra and the physical groups.

    Raises
    ------
    InputError
        If the suffix is another, the file is missing or damaged, holds other elements or lacks the
        group "base".
    """
    if path.suffix.lower() != ".msh":
        msg = f"Cannot read a mesh from '{path.name}': the suffix must be .msh."
        raise InputError(msg)
    return read_msh(path)
