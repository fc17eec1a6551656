"""Input files for CalculiX and Abaqus: the mesh with its sets, and the whole analysis if a load is given."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TextIO

import numpy as np

from fd2fem.meshing.facet_owners import facet_owners
from fd2fem.meshing.quality import element_volumes
from fd2fem.meshing.text_rows import Table, format_rows, write_list, write_rows
from fd2fem.model import ElementKind, LoadCase, VolumeMesh
from fd2fem.model.checks import as_array

__all__ = ["write_inp"]

NAMES: Mapping[ElementKind, str] = MappingProxyType(
    {ElementKind.HEXAHEDRON: "C3D8", ElementKind.HEXAHEDRON20: "C3D20", ElementKind.TETRA10: "C3D10"}
)
"""Element types; they number their nodes as VTK does and their faces as `FACETS` does."""

PER_LINE = 16
"""Most entries of a data line."""

HEAD = """\
** Mesh of a facade. SI units: m, N, Pa, kg, s. x along the wall, y into it, z up.
** Node sets: ALL and a name per group; surfaces: the same names with _SURFACE; element set: WALL.
** Tried in CalculiX 2.20; written for Abaqus as well, but never run there.
"""

TOO_STIFF = """\
** C3D8 is far too stiff in bending, one element deep by a factor of three: use it with
** several elements across the thinnest pier, or write the mesh with 20-node elements.
"""

MATERIAL = """\
** The wall weighs {weight} N.
*MATERIAL, NAME=MASONRY
*ELASTIC
{young}, {poisson}
*DENSITY
{density}
*SOLID SECTION, ELSET=WALL, MATERIAL=MASONRY
*BOUNDARY
BASE, 1, 3
"""

WEIGHT = """\
** Step 1: the wall under its own weight, its base at rest.
*STEP
*STATIC
*DLOAD
WALL, GRAV, {gravity}, 0., 0., -1.
*NODE FILE
U, RF
*EL FILE
S
*NODE PRINT, NSET=BASE, TOTALS=YES
RF
*END STEP
"""

SETTLEMENT = """\
** {title}: the ground moves the base.
*STEP
*STATIC
*BOUNDARY
"""

RESULTS = """\
** RF is what the wall's stresses do to its base: the reaction, less the weight that falls on the base
** nodes themselves.
*NODE FILE
U, RF
*EL FILE
S
*NODE PRINT, NSET=ALL
U
*NODE PRINT, NSET=BASE, TOTALS=YES
RF
*END STEP
"""


def write_inp(mesh: VolumeMesh, path: Path, case: LoadCase | None = None) -> None:
    """Write an input file for CalculiX or Abaqus.

    It holds nodes, elements (set WALL), and for each group that has facets a node set of its name and a
    surface of the element faces. With a load case it is complete: material, a step of self-weight with
    the base at rest, a step in which the base moves, and requests for displacements, reactions and
    stresses; ``ccx -i NAME`` runs it as it is. The displacements at the end of the last step are the total
    ones. Without one it is for ``*INCLUDE`` in an analysis of one's own.

    Parameters
    ----------
    mesh : VolumeMesh
        8-node hexahedra become C3D8, 20-node ones C3D20, tetrahedra C3D10.
    path : Path
    case : LoadCase, optional

    Raises
    ------
    InputError
        If a group has facets that belong to no element, or with a load case, there is no group "base" or
        its displacements are not finite.

    Notes
    -----
    CalculiX reads no more than 20 characters of a number: coordinates and displacements carry 13 digits.
    """
    owners = facet_owners(mesh)
    analysis = "" if case is None else _analysis(mesh, case)
    with path.open("w", encoding="ascii", newline="\n") as stream:
        stream.write(HEAD)
        _write_mesh(stream, mesh)
        for name, owner in owners.items():
            stream.write(f"*NSET, NSET={name.upper()}\n")
            write_list(stream, "%d", mesh.group_nodes(name) + 1, per_line=PER_LINE, between=", ")
            stream.write(f"*SURFACE, NAME={name.upper()}_SURFACE, TYPE=ELEMENT\n")
            write_rows(stream, "%d, S%d\n", owner + 1)
        stream.write(analysis)


def _write_mesh(stream: TextIO, mesh: VolumeMesh) -> None:
    """Nodes and elements."""
    if mesh.kind is ElementKind.HEXAHEDRON:
        stream.write(TOO_STIFF)
    stream.write("*NODE, NSET=ALL\n")
    write_rows(stream, "%d, %.12e, %.12e, %.12e\n", _numbered(mesh.nodes))
    stream.write(f"*ELEMENT, TYPE={NAMES[mesh.kind]}, ELSET=WALL\n")
    entries = ["%d"] * (1 + mesh.kind.nodes)
    # A line that ends in a comma goes on in the next one.
    lines = [", ".join(entries[k : k + PER_LINE]) for k in range(0, len(entries), PER_LINE)]
    write_rows(stream, ",\n".join(lines) + "\n", _numbered(mesh.elements + 1))


def _analysis(mesh: VolumeMesh, case: LoadCase) -> str:
    """Material, the step of self-weight, the step in which the base moves."""
    base = mesh.group_nodes("base")
    moved = as_array("base", case.base(mesh.nodes[base]), (len(base), 3))
    axes = np.tile([1.0, 2.0, 3.0], len(base))
    table = np.column_stack([np.repeat(base + 1, 3), axes, axes, moved.ravel()])
    number = {name: f"{getattr(case, name):.13g}" for name in ("young", "poisson", "density", "gravity")}
    weight = case.density * case.gravity * element_volumes(mesh).sum()
    material = MATERIAL.format(weight=f"{weight:.8g}", **number)
    self_weight = WEIGHT.format(**number) if weight > 0.0 else ""
    settlement = SETTLEMENT.format(title="Step 2" if self_weight else "The only step")
    return material + self_weight + settlement + format_rows("%d, %d, %d, %.12e\n", table) + RESULTS


def _numbered(table: Table) -> Table:
    """The table with a first column that counts its rows from 1."""
    return np.column_stack([np.arange(1, len(table) + 1), table])
