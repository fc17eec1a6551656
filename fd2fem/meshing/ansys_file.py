"""ANSYS archives in blocked format (.cdb): a database of mesh, components, material and loads."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.text_rows import format_rows, write_list, write_rows
from fd2fem.model import ElementKind, LoadCase, VolumeMesh
from fd2fem.model.checks import as_array

__all__ = ["write_cdb"]

IntArray = NDArray[np.intp]

ELEMENTS: Mapping[ElementKind, tuple[int, str]] = MappingProxyType(
    {
        ElementKind.HEXAHEDRON: (185, "KEYOPT,1,2,2\n"),
        ElementKind.HEXAHEDRON20: (186, "KEYOPT,1,2,1\n"),
        ElementKind.TETRA10: (187, ""),
    }
)
"""Element type and its formulation: SOLID185 with enhanced strains, as the plain one is too stiff in
bending; SOLID186 fully integrated. All number their nodes as VTK does."""

HEAD = """\
/COM,Mesh of a facade. SI units: m, N, Pa, kg, s.
/COM,x along the wall, y into it, z up.
/COM,Written after the documentation of CDWRITE's blocked format, and read back
/COM,by mapdl-archive. Never run in ANSYS: check what CDREAD reports.
"""

LOADS = """\
/COM,Self-weight and settlement of the base act together, in one linear solve.
MP,EX,1,{young}
MP,PRXY,1,{poisson}
MP,DENS,1,{density}
ACEL,0,0,{gravity}
"""


def write_cdb(mesh: VolumeMesh, path: Path, case: LoadCase | None = None) -> None:
    """Write an ANSYS archive in blocked format, for ``CDREAD,DB``.

    It holds nodes, elements with type, material and section 1 (SOLID185, SOLID186 or SOLID187), the element
    component WALL and a node component per group that has facets. With a load case, material 1,
    gravity and the final displacements of the base nodes too: ``/SOLU``, ``SOLVE`` is all that is left.

    Parameters
    ----------
    mesh : VolumeMesh
    path : Path
    case : LoadCase, optional

    Raises
    ------
    InputError
        If, with a load case, there is no group "base" or its displacements are not finite.

    References
    ----------
    ANSYS Mechanical APDL, Programmer's Reference, the format of the file that CDWRITE writes.
    """
    loads = "" if case is None else _loads(mesh, case)
    number, formulation = ELEMENTS[mesh.kind]
    with path.open("w", encoding="ascii", newline="\n") as stream:
        stream.write(f"{HEAD}/PREP7\nET,1,{number}\n{formulation}")
        _write_blocks(stream, mesh)
        _write_components(stream, mesh)
        stream.write(f"{loads}FINISH\n")


def _write_blocks(stream: TextIO, mesh: VolumeMesh) -> None:
    """Nodes, their coordinates with 14 digits, and elements."""
    nodes, elements = len(mesh.nodes), len(mesh.elements)
    stream.write(f"NBLOCK,6,SOLID,{nodes:9d},{nodes:9d}\n(3i9,6e20.13)\n")
    table = np.column_stack([np.arange(1, nodes + 1), mesh.nodes])
    write_rows(stream, "%9d        0        0" + "%20.13E" * 3 + "\n", table)
    stream.write(f"N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,{elements:9d},{elements:9d}\n(19i9)\n")
    fields = np.zeros((elements, 11 + mesh.kind.nodes), dtype=np.intp)
    fields[:, :4] = 1  # material, type, real constants, section
    fields[:, 8] = mesh.kind.nodes
    fields[:, 10] = np.arange(1, elements + 1)
    fields[:, 11:] = mesh.elements + 1
    # 19 fields on the first line, the nodes beyond the eighth on a second one
    more = mesh.kind.nodes - 8
    write_rows(stream, "%9d" * 19 + ("\n" + "%9d" * more if more else "") + "\n", fields)
    stream.write(f"{-1:9d}\n")


def _write_components(stream: TextIO, mesh: VolumeMesh) -> None:
    """The elements as a component, and the nodes of each group as one."""
    # A negative number ends the range that the number before it starts.
    wall = np.array([1, -len(mesh.elements)][: len(mesh.elements)])
    _write_component(stream, "WALL,ELEM", wall)
    for name, facets in mesh.groups.items():
        if len(facets):
            _write_component(stream, f"{name.upper()},NODE", mesh.group_nodes(name) + 1)


def _write_component(stream: TextIO, name: str, numbers: IntArray) -> None:
    stream.write(f"CMBLOCK,{name},{len(numbers):8d}\n(8i10)\n")
    write_list(stream, "%10d", numbers, per_line=8, between="")


def _loads(mesh: VolumeMesh, case: LoadCase) -> str:
    """Material, gravity, displacements of the base nodes."""
    base = mesh.group_nodes("base")
    moved = as_array("base", case.base(mesh.nodes[base]), (len(base), 3))
    number = {name: f"{getattr(case, name):.13g}" for name in ("young", "poisson", "density", "gravity")}
    node = base + 1
    table = np.column_stack([node, moved[:, 0], node, moved[:, 1], node, moved[:, 2]])
    return LOADS.format(**number) + format_rows("D,%d,UX,%.12e\nD,%d,UY,%.12e\nD,%d,UZ,%.12e\n", table)
