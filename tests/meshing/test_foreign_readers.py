"""What of a mesh other programs find in its files: the table of the documentation, a row per reader.

Run as a script, the module prints the table.
"""

import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from exported_meshes import VOLUME, all_kinds, load_case, options_for

from fd2fem.meshing import write_mesh
from fd2fem.meshing.session import gmsh_session

KINDS = ["hexahedron", "hexahedron20", "tetra10"]
FACETS = {"hexahedron": "quad", "hexahedron20": "quad8", "tetra10": "triangle6"}


@dataclass
class Found:
    """What a program found in a file; None where the format, or the program, has no such thing."""

    nodes: np.ndarray
    elements: np.ndarray
    node_groups: dict[str, set[int]] | None = None
    facet_groups: dict[str, set[frozenset[int]]] | None = None
    wall: int | None = None
    base: np.ndarray | None = None


def gmsh_finds(path, mesh):
    number, facet = {"hexahedron": (5, 3), "hexahedron20": (17, 16), "tetra10": (11, 9)}[mesh.kind.value]
    with gmsh_session():
        gmsh.merge(str(path))
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        nodes = np.empty((len(tags), 3))
        nodes[tags.astype(int) - 1] = coordinates.reshape(-1, 3)
        _, elements = gmsh.model.mesh.getElementsByType(number)
        groups, wall = {}, None
        for dim, group in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dim, group).strip()
            entities = gmsh.model.getEntitiesForPhysicalGroup(dim, group)
            kind = number if dim == 3 else facet
            tables = [gmsh.model.mesh.getElementsByType(kind, entity) for entity in entities]
            if name == "wall":
                wall = sum(len(found) for found, _ in tables)
            else:
                groups[name] = as_sets(np.concatenate([t for _, t in tables]) - 1, mesh)
    # gmsh numbers the edges of a hexahedron 01 03 04 12 15 23 26 37 45 47 56 67, of a tetrahedron … 23 13
    order = {
        "hexahedron": list(range(8)),
        "hexahedron20": [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
        "tetra10": [*range(8), 9, 8],
    }[mesh.kind.value]
    table = elements.reshape(-1, mesh.kind.nodes)[:, order] - 1
    return Found(nodes, table, facet_groups=groups, wall=wall)


def meshio_finds_msh(path, mesh):
    back = meshio.read(path)
    groups = {
        name: {
            frozenset(facet.tolist())
            for k, rows in enumerate(back.cell_sets[name])
            for facet in back.cells[k].data[rows]
        }
        for name in mesh.groups
        if name in back.cell_sets
    }
    wall = sum(len(rows) for rows in back.cell_sets["wall"])
    return Found(back.points, back.cells_dict[mesh.kind.value], facet_groups=groups, wall=wall)


def meshio_finds_vtu(path, mesh):
    back = meshio.read(path)
    cells, facets = (block.data for block in back.cells)
    on_nodes = {name: set(np.flatnonzero(back.point_data[name]).tolist()) for name in mesh.groups}
    on_facets = {name: as_sets(facets[back.cell_data[name][1] == 1], mesh) for name in mesh.groups}
    return Found(back.points, cells, node_groups=on_nodes, facet_groups=on_facets)


def vtk_finds(path, mesh):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    flat, count = vtk_to_numpy(grid.GetCells().GetConnectivityArray()), len(mesh.elements)
    facets = flat[count * mesh.kind.nodes :].reshape(-1, mesh.kind.facet_nodes)

    def array(data, name):
        return vtk_to_numpy(data.GetArray(name))

    on_nodes = {n: set(np.flatnonzero(array(grid.GetPointData(), n)).tolist()) for n in mesh.groups}
    on_cells = {n: array(grid.GetCellData(), n)[count:] == 1 for n in mesh.groups}
    return Found(
        vtk_to_numpy(grid.GetPoints().GetData()),
        flat[: count * mesh.kind.nodes].reshape(count, -1),
        node_groups=on_nodes,
        facet_groups={name: as_sets(facets[at], mesh) for name, at in on_cells.items()},
    )


def meshio_finds_inp(path, mesh):
    back = meshio.read(path)
    return Found(
        back.points,
        back.cells_dict[mesh.kind.value],
        node_groups={name.lower(): set(map(int, nodes)) for name, nodes in back.point_sets.items()},
        wall=len(back.cell_sets["WALL"][0]),
    )


def mapdl_archive_finds(path, mesh):  # noqa: ARG001
    mapdl_archive = pytest.importorskip("mapdl_archive", reason="needs mapdl-archive to read the file back")
    back = mapdl_archive.Archive(str(path), parse_vtk=False)
    return Found(
        back.nodes,
        np.array([element[10:] for element in back.elem]) - 1,
        node_groups={n.lower(): {int(k) - 1 for k in nodes} for n, nodes in back.node_components.items()},
        wall=len(back.element_components["WALL"]),
    )


def meshio_finds_med(path, mesh):
    pytest.importorskip("h5py", reason="meshio needs h5py to read MED")
    back = meshio.read(path)
    (facets,) = (k for k, block in enumerate(back.cells) if block.type == FACETS[mesh.kind.value])
    (solids,) = (k for k, block in enumerate(back.cells) if block.type == mesh.kind.value)
    tags = {name: tag for tag, names in back.cell_tags.items() for name in names}
    at = {name: back.cell_data["cell_tags"][facets] == tag for name, tag in tags.items()}
    return Found(
        back.points,
        from_med(back.cells[solids].data, mesh),
        facet_groups={
            n: as_sets(back.cells[facets].data[rows], mesh) for n, rows in at.items() if n != "wall"
        },
        wall=int((back.cell_data["cell_tags"][solids] == tags["wall"]).sum()),
    )


def medcoupling_finds(path, mesh):
    medcoupling = pytest.importorskip("medcoupling", reason="needs medcoupling, the library of Salome")
    back = medcoupling.MEDFileMesh.New(str(path))
    solid = back.getMeshAtLevel(0)
    # Positive in MED's own orientation; the middles where MED itself would put them.
    assert solid.getMeasureField(False).getArray().accumulate()[0] == pytest.approx(VOLUME)
    straight = solid.deepCopy()
    straight.convertQuadraticCellsToLinear()
    if mesh.kind.value != "hexahedron":
        straight.convertLinearCellsToQuadratic(0)
        ours, theirs = (
            m.getCoords().toNumPyArray()[connectivity(m, mesh.kind.nodes)] for m in (solid, straight)
        )
        np.testing.assert_allclose(ours, theirs, atol=1e-14)
    groups = {
        name: as_sets(connectivity(back.getGroup(-1, name), mesh.kind.facet_nodes), mesh)
        for name in back.getGroupsNames()
        if name != "wall"
    }
    return Found(
        back.getCoords().toNumPyArray(),
        from_med(connectivity(solid, mesh.kind.nodes), mesh),
        facet_groups=groups,
        wall=back.getGroup(0, "wall").getNumberOfCells(),
    )


def connectivity(grid, width):
    return grid.getNodalConnectivity().toNumPyArray().reshape(-1, width + 1)[:, 1:]


def from_med(elements, mesh):
    """MED counts the corners the other way round: 0 3 2 1, in a tetrahedron 0 2 1 3."""
    order = {
        "hexahedron": [0, 3, 2, 1, 4, 7, 6, 5],
        "hexahedron20": [0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17],
        "tetra10": [0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    }[mesh.kind.value]
    return elements[:, order]


def calculix_finds(path, mesh):
    """What CalculiX writes of its model: coordinates with six digits, the base by the forces on it."""
    if shutil.which("ccx") is None:
        pytest.skip("needs CalculiX (Debian and Ubuntu: calculix-ccx)")
    command = ["ccx", "-i", path.stem]
    subprocess.run(command, cwd=path.parent, check=True, capture_output=True, timeout=300)
    lines = path.with_suffix(".frd").read_text().splitlines()
    nodes = [[float(row[13 + 12 * k : 25 + 12 * k]) for k in range(3)] for row in block(lines, "    2C")]
    rows = [row for row in block(lines, "    3C") if row.startswith(" -2")]
    numbers = [int(row[3 + 10 * k : 13 + 10 * k]) - 1 for row in rows for k in range(len(row) // 10)]
    elements = np.array(numbers).reshape(-1, mesh.kind.nodes)
    if mesh.kind.value == "hexahedron20":  # .frd lists the upright edges before the upper ones
        elements = elements[:, [*range(12), *range(16, 20), *range(12, 16)]]
    tables = path.with_suffix(".dat").read_text().split("\n\n")
    moved = last(tables, "displacements")[mesh.group_nodes("base"), 1:]
    held = {int(node) - 1 for node in last(tables, "forces (fx,fy,fz) for set BASE")[:, 0]}
    return Found(np.array(nodes), elements, node_groups={"base": held}, base=moved)


def block(lines, title):
    """The rows between a title of a .frd file and the end of its block."""
    start = next(k for k, line in enumerate(lines) if line.startswith(title)) + 1
    return lines[start : lines.index(" -3", start)]


def last(tables, title):
    """The numbers that follow the last such title of a .dat file."""
    at = max(k for k, text in enumerate(tables) if text.strip().startswith(title))
    return np.array([line.split() for line in tables[at + 1].strip().splitlines()], dtype=float)


def as_sets(facets, mesh):
    return {frozenset(f) for f in np.asarray(facets).astype(int).reshape(-1, mesh.kind.facet_nodes).tolist()}


@dataclass(frozen=True)
class Row:
    """A line of the table: the file, the reader, how near the coordinates are, what else comes through."""

    suffix: str
    reader: str
    finds: Callable[..., Found]
    tolerance: float
    node_groups: str = "-"
    facet_groups: str = "-"
    wall: str = "-"
    loads: str = "-"


YES, NOT_READ = "yes", "in the file, not read"
ROWS = (
    Row(".msh", "gmsh 4.15", gmsh_finds, 1e-15, facet_groups=YES, wall=YES),
    Row(".msh", "meshio 5.3", meshio_finds_msh, 1e-15, facet_groups=YES, wall=YES),
    Row(".vtu", "VTK 9.6", vtk_finds, 0.0, node_groups=YES, facet_groups=YES),
    Row(".vtu", "meshio 5.3", meshio_finds_vtu, 0.0, node_groups=YES, facet_groups=YES),
    Row(
        ".inp", "CalculiX 2.20", calculix_finds, 1e-5,
        node_groups=YES, facet_groups=YES, wall=YES, loads=YES,
    ),
    Row(
        ".inp", "meshio 5.3", meshio_finds_inp, 1e-12,
        node_groups=YES, facet_groups=NOT_READ, wall=YES, loads=NOT_READ,
    ),
    Row(
        ".cdb", "mapdl-archive 0.4", mapdl_archive_finds, 1e-13, node_groups=YES, wall=YES, loads=NOT_READ,
    ),
    Row(".med", "gmsh 4.15", gmsh_finds, 1e-15, facet_groups=YES, wall=YES),
    Row(".med", "medcoupling 9 (Salome)", medcoupling_finds, 1e-15, facet_groups=YES, wall=YES),
    Row(".med", "meshio 5.3", meshio_finds_med, 1e-15, facet_groups=YES, wall=YES),
)  # fmt: skip


def check(row, mesh, folder):
    """Write and read, and compare all that the row says comes through."""
    path = folder / f"wall{row.suffix}"
    case = load_case(mesh, options_for("trough"))
    write_mesh(mesh, path, case=case)
    found = row.finds(path, mesh)
    np.testing.assert_allclose(found.nodes, mesh.nodes, rtol=row.tolerance, atol=row.tolerance)
    np.testing.assert_array_equal(found.elements, mesh.elements)
    filled = {name: facets for name, facets in mesh.groups.items() if len(facets)}
    if row.reader.startswith("CalculiX"):
        # Of the sets it prints the one that its forces are asked for; the surfaces bear a pressure elsewhere.
        assert found.node_groups == {"base": set(mesh.group_nodes("base").tolist())}
        np.testing.assert_allclose(found.base, case.base(mesh.nodes[mesh.group_nodes("base")]), atol=1e-8)
        return
    if row.node_groups == YES:
        expected = {name: set(np.unique(facets).tolist()) for name, facets in filled.items()}
        assert {name: nodes for name, nodes in found.node_groups.items() if nodes} == expected
    if row.facet_groups == YES:
        expected = {name: as_sets(facets, mesh) for name, facets in filled.items()}
        assert {name: facets for name, facets in found.facet_groups.items() if facets} == expected
    if row.wall == YES:
        assert found.wall == len(mesh.elements)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.suffix[1:]}-{row.reader.split()[0]}")
def test_what_comes_through(row, kind, tmp_path):
    check(row, all_kinds()[kind], tmp_path)


def table():
    """The table of the documentation; what could not be run here is marked so."""
    lines = [
        "| file | read back by | nodes, elements | node groups | facet groups | element set | loads | here |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in ROWS:
        said = "passed"
        for mesh in all_kinds().values():
            with tempfile.TemporaryDirectory() as folder:
                try:
                    check(row, mesh, Path(folder))
                except pytest.skip.Exception as skipped:
                    said = f"not run: {skipped}"
        near = "exact" if row.tolerance == 0.0 else f"to {row.tolerance:g}"
        cells = (row.suffix, row.reader, near, row.node_groups, row.facet_groups, row.wall, row.loads, said)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())  # noqa: T201
