"""The .cdb as mapdl-archive reads it, and field by field."""

import numpy as np
import pytest
from exported_meshes import all_kinds, hexahedra, load_case, options_for

from fd2fem.meshing import write_mesh
from fd2fem.model import VolumeMesh

KINDS = ["hexahedron", "hexahedron20", "tetra10"]
TYPES = {"hexahedron": 185, "hexahedron20": 186, "tetra10": 187}
# Edges on which ANSYS puts nodes Q to X and Y, Z, A, B of SOLID186, M to R of SOLID187 (Element Reference).
MIDDLES = {
    "hexahedron": [],
    "hexahedron20": ["IJ", "JK", "KL", "LI", "MN", "NO", "OP", "PM", "IM", "JN", "KO", "LP"],
    "tetra10": ["IJ", "JK", "KI", "IL", "JL", "KL"],
}


@pytest.fixture(params=KINDS)
def mesh(request):
    return all_kinds()[request.param]


@pytest.mark.parametrize("loaded", [False, True])
def test_mapdl_archive_reads_it(mesh, tmp_path, loaded):
    mapdl_archive = pytest.importorskip("mapdl_archive", reason="needs mapdl-archive to read the file back")
    case = load_case(mesh, options_for("trough")) if loaded else None
    write_mesh(mesh, tmp_path / "wall.cdb", case=case)
    archive = mapdl_archive.Archive(str(tmp_path / "wall.cdb"), parse_vtk=False)
    assert archive.nnum.tolist() == list(range(1, len(mesh.nodes) + 1))
    np.testing.assert_allclose(archive.nodes, mesh.nodes, atol=1e-13)
    assert archive.enum.tolist() == list(range(1, len(mesh.elements) + 1))
    assert archive.ekey.tolist() == [[1, TYPES[mesh.kind.value]]]
    elements = np.array([element[10:] for element in archive.elem])
    np.testing.assert_array_equal(elements, mesh.elements + 1)
    assert archive.material_type.tolist() == [1] * len(mesh.elements)
    filled = {name.upper() for name, facets in mesh.groups.items() if len(facets)}
    assert set(archive.node_components) == filled
    for name in filled:
        assert sorted(archive.node_components[name]) == (mesh.group_nodes(name.lower()) + 1).tolist()
    assert sorted(archive.element_components["WALL"]) == list(range(1, len(mesh.elements) + 1))


def test_middles_are_where_ansys_wants_them(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.cdb")
    lines = (tmp_path / "wall.cdb").read_text().splitlines()
    nodes, elements = read_blocks(lines, mesh)
    letters = "IJKL" if mesh.kind.value == "tetra10" else "IJKLMNOP"
    place = {letter: nodes[elements[:, 11 + k] - 1] for k, letter in enumerate(letters)}
    for k, (a, b) in enumerate(MIDDLES[mesh.kind.value], start=11 + len(letters)):
        np.testing.assert_allclose(nodes[elements[:, k] - 1], (place[a] + place[b]) / 2, atol=1e-12)
    # ANSYS: I, J, K, L right-handed about the direction to the other corners
    normal = np.cross(place["J"] - place["I"], place["K"] - place["I"])
    beyond = place["L"] if mesh.kind.value == "tetra10" else place["M"]
    assert (np.sum(normal * (beyond - place["I"]), axis=1) > 0).all()


def read_blocks(lines, mesh):
    """Nodes and elements by the formats that stand above them."""
    start = lines.index("(3i9,6e20.13)") + 1
    rows = lines[start : start + len(mesh.nodes)]
    nodes = np.array([[float(row[27 + 20 * c : 47 + 20 * c]) for c in range(3)] for row in rows])
    assert [int(row[:9]) for row in rows] == list(range(1, len(mesh.nodes) + 1))
    assert lines[start + len(mesh.nodes)] == "N,R5.3,LOC,       -1,"
    start = lines.index("(19i9)") + 1
    per_element = 1 if mesh.kind.nodes == 8 else 2
    end = start + per_element * len(mesh.elements)
    records = ["".join(lines[k : k + per_element]) for k in range(start, end, per_element)]
    assert all(len(line) <= 19 * 9 for line in lines[start:end])
    assert lines[end].strip() == "-1"
    elements = [[int(row[9 * c : 9 * c + 9]) for c in range(len(row) // 9)] for row in records]
    return nodes, np.array(elements)


def test_field_by_field(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.cdb")
    lines = (tmp_path / "wall.cdb").read_text().splitlines()
    assert f"ET,1,{TYPES[mesh.kind.value]}" in lines
    nodes, elements = read_blocks(lines, mesh)
    np.testing.assert_allclose(nodes, mesh.nodes, atol=1e-13)
    for k, fields in enumerate(elements.tolist()):
        assert fields[:11] == [1, 1, 1, 1, 0, 0, 0, 0, mesh.kind.nodes, 0, k + 1]
    np.testing.assert_array_equal(elements[:, 11:], mesh.elements + 1)
    for name, facets in mesh.groups.items():
        if not len(facets):
            assert not any(name.upper() in line for line in lines)
            continue
        members = mesh.group_nodes(name) + 1
        start = lines.index(f"CMBLOCK,{name.upper()},NODE,{len(members):8d}")
        assert lines[start + 1] == "(8i10)"
        text = "".join(lines[start + 2 : start + 2 + -(-len(members) // 8)])
        assert [int(text[10 * c : 10 * c + 10]) for c in range(len(members))] == members.tolist()
    assert lines[-1] == "FINISH"


def test_loads_field_by_field(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.cdb", case=load_case(mesh, options_for("linear")))
    lines = (tmp_path / "wall.cdb").read_text().splitlines()
    for command in ("MP,EX,1,3480000000", "MP,PRXY,1,0.16", "MP,DENS,1,1900", "ACEL,0,0,9.81"):
        assert command in lines
    base = mesh.group_nodes("base")
    found = [line.split(",") for line in lines if line.startswith("D,")]
    assert [(int(node), label) for _, node, label, _ in found] == [
        (node + 1, f"U{axis}") for node in base.tolist() for axis in "XYZ"
    ]
    # By hand: from -12 to -3 mm down and from -4 to 2 mm along a base of π m.
    x = mesh.nodes[base, 0] / np.pi
    expected = np.column_stack([-0.004 + 0.006 * x, 0 * x, -0.012 + 0.009 * x])
    moved = np.array([float(value) for *_, value in found]).reshape(-1, 3)
    np.testing.assert_allclose(moved, expected, atol=1e-14)


def test_lines_are_short_enough(mesh, tmp_path):
    """A comment of APDL holds 75 characters, a command line 640."""
    write_mesh(mesh, tmp_path / "wall.cdb", case=load_case(mesh, options_for("linear")))
    lines = (tmp_path / "wall.cdb").read_text().splitlines()
    assert all(len(line) <= 75 + len("/COM,") for line in lines if line.startswith("/COM"))
    assert "Never run in ANSYS" in (tmp_path / "wall.cdb").read_text()


def test_a_single_element(tmp_path):
    mapdl_archive = pytest.importorskip("mapdl_archive", reason="needs mapdl-archive to read the file back")
    wall = hexahedra()
    one = VolumeMesh(wall.nodes[wall.elements[0]], np.arange(8)[None], wall.kind, {})
    write_mesh(one, tmp_path / "one.cdb")
    archive = mapdl_archive.Archive(str(tmp_path / "one.cdb"), parse_vtk=False)
    assert list(archive.element_components["WALL"]) == [1]
