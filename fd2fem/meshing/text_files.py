"""Meshes as text for Abaqus, CalculiX and ANSYS."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh

__all__ = ["write_cdb", "write_inp"]

IntArray = NDArray[np.intp]

ABAQUS: Mapping[ElementKind, str] = {ElementKind.HEXAHEDRON: "C3D8", ElementKind.TETRA10: "C3D10"}
ANSYS: Mapping[ElementKind, int] = {ElementKind.HEXAHEDRON: 185, ElementKind.TETRA10: 187}
"""Element types; both programs number the nodes of these as VTK does."""


def write_inp(mesh: VolumeMesh, path: Path) -> None:
    """Write an Abaqus or CalculiX input file: nodes, elements (set WALL), a node set per group.

    Coordinates carry 13 digits: CalculiX reads no more than 20 characters of a number.
    """
    count = len(mesh.nodes)
    with path.open("w", encoding="ascii") as stream:
        stream.write("** mesh of a facade, SI units: m; x along the wall, y into it, z up\n*NODE, NSET=ALL\n")
        table = np.column_stack([np.arange(1, count + 1), mesh.nodes])
        np.savetxt(stream, table, fmt="%d, %.12e, %.12e, %.12e")
        stream.write(f"*ELEMENT, TYPE={ABAQUS[mesh.kind]}, ELSET=WALL\n")
        numbers = np.arange(1, len(mesh.elements) + 1)
        np.savetxt(stream, np.column_stack([numbers, mesh.elements + 1]), fmt="%d", delimiter=", ")
        for name in _filled(mesh):
            stream.write(f"*NSET, NSET={name.upper()}\n")
            for line in _lines(mesh.group_nodes(name) + 1, per_line=12):
                stream.write(", ".join(map(str, line)) + "\n")


def write_cdb(mesh: VolumeMesh, path: Path) -> None:
    """Write an ANSYS archive in blocked format, for CDREAD: nodes, elements, a node component per group.

    Elements are SOLID185 or SOLID187 with type, material and section 1; the material is the user's to
    define. Coordinates carry 14 digits.

    References
    ----------
    ANSYS Mechanical APDL, Programmer's Reference, the format of the file that CDWRITE writes.
    """
    nodes, elements = len(mesh.nodes), len(mesh.elements)
    with path.open("w", encoding="ascii") as stream:
        stream.write(
            f"/COM, mesh of a facade: m; x along the wall, y into it, z up\n/PREP7\nET,1,{ANSYS[mesh.kind]}\n"
        )
        stream.write(f"NBLOCK,6,SOLID,{nodes:9d},{nodes:9d}\n(3i9,6e20.13)\n")
        numbers = np.arange(1, nodes + 1)
        zeros = np.zeros(nodes)
        table = np.column_stack([numbers, zeros, zeros, mesh.nodes])
        np.savetxt(stream, table, fmt="%9d" * 3 + "%20.13E" * 3, delimiter="")
        stream.write(f"N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,{elements:9d},{elements:9d}\n(19i9)\n")
        np.savetxt(stream, _element_fields(mesh), fmt=_element_format(mesh.kind), delimiter="")
        stream.write(f"{-1:9d}\n")
        for name in _filled(mesh):
            members = mesh.group_nodes(name) + 1
            stream.write(f"CMBLOCK,{name.upper()},NODE,{len(members):8d}\n(8i10)\n")
            for line in _lines(members, per_line=8):
                stream.write("".join(f"{number:10d}" for number in line) + "\n")
        stream.write("FINISH\n")


def _element_fields(mesh: VolumeMesh) -> IntArray:
    """Fields (e, 19 or 21) of the element block: 11 attributes, then the nodes."""
    count = len(mesh.elements)
    attributes = np.zeros((count, 11), dtype=np.intp)
    attributes[:, :4] = 1  # material, type, real constants, section
    attributes[:, 8] = mesh.kind.nodes
    attributes[:, 10] = np.arange(1, count + 1)
    return np.column_stack([attributes, mesh.elements + 1])


def _element_format(kind: ElementKind) -> str:
    """19 fields on the first line, the other nodes on a second one."""
    return "%9d" * 19 + ("\n" + "%9d" * (kind.nodes - 8) if kind.nodes > 8 else "")


def _filled(mesh: VolumeMesh) -> list[str]:
    """Groups that have facets."""
    return [name for name, facets in mesh.groups.items() if len(facets)]


def _lines(numbers: IntArray, *, per_line: int) -> Iterator[list[int]]:
    """The numbers, so many at a time."""
    for start in range(0, len(numbers), per_line):
        yield numbers[start : start + per_line].tolist()
