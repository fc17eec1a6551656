"""The .inp in CalculiX, unchanged, against our own analysis; and line by line."""

import shutil
import subprocess

import numpy as np
import pytest
from exported_meshes import VOLUME, all_kinds, hexahedra, hexahedra20, load_case, options_for

from fd2fem.errors import InputError
from fd2fem.meshing import write_mesh
from fd2fem.model import LoadCase, VolumeMesh
from solvers import analyse
from solvers.fem.assembly import body_force
from solvers.fem.elements import displacement_space

KINDS = ["hexahedron", "hexahedron20", "tetra10"]
NAMES = {"hexahedron": "C3D8", "hexahedron20": "C3D20", "tetra10": "C3D10"}
OPPOSITE = {"front": "back", "back": "front", "left": "right", "right": "left", "top": "base", "base": "top"}
# Corners of S1, S2, … by the element library of the CalculiX manual, nodes from 1.
CALCULIX_FACES = {
    "hexahedron": [(1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)],
    "tetra10": [(1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1)],
}
CALCULIX_FACES["hexahedron20"] = CALCULIX_FACES["hexahedron"]

needs_ccx = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="needs CalculiX (Debian and Ubuntu: calculix-ccx)"
)


@pytest.fixture(params=KINDS)
def mesh(request):
    return all_kinds()[request.param]


def ccx(folder, name):
    """Run a deck and give its table of results."""
    run = subprocess.run(
        ["ccx", "-i", name], cwd=folder, check=True, capture_output=True, text=True, timeout=300
    )
    assert "*WARNING" not in run.stdout
    assert "*ERROR" not in run.stdout
    return (folder / f"{name}.dat").read_text()


def displacements(text):
    """The last table of displacements, in the order of the nodes."""
    table = text[text.index("displacements", text.rindex("displacements")) :].split("\n\n")[1]
    return np.array([line.split() for line in table.strip().splitlines()], dtype=float)


def totals(text):
    """Total forces (s, 3) over BASE at the end of each step."""
    lines = text.splitlines()
    return np.array([lines[k + 2].split() for k, line in enumerate(lines) if "total force" in line], float)


@needs_ccx
@pytest.mark.parametrize("settlement", ["linear", "trough"])
@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_calculix_answers_as_we_do(tmp_path, kind, settlement):
    mesh, options = all_kinds()[kind], options_for(settlement)
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options))
    text = ccx(tmp_path, "wall")
    ours, theirs = analyse(mesh, options=options), displacements(text)
    assert theirs[:, 0].tolist() == list(range(1, len(mesh.nodes) + 1))
    # the table has seven digits
    assert np.abs(theirs[:, 1:] - ours.displacement).max() < 1e-6 * np.abs(ours.displacement).max()
    # CalculiX sums the internal forces: the reaction, less the weight that falls on the base nodes
    space = displacement_space(mesh)
    weight = body_force(space, [0, 0, -options.material.density * options.gravity]).reshape(-1, 3)
    expected = ours.reaction + weight[space.base].sum(axis=0)
    assert totals(text) == pytest.approx(np.tile(expected, (2, 1)), abs=1e-6 * ours.weight)


@needs_ccx
def test_the_8_node_mesh_answers_as_its_20_node_deck(tmp_path):
    """What `analyse` says of an 8-node mesh is what CalculiX says of its 20-node elements."""
    mesh, options = hexahedra(), options_for("linear")
    write_mesh(hexahedra20(mesh), tmp_path / "wall.inp", case=load_case(mesh, options))
    theirs = displacements(ccx(tmp_path, "wall"))[: len(mesh.nodes), 1:]
    ours = analyse(mesh, options=options).displacement
    assert np.abs(theirs - ours).max() < 1e-6 * np.abs(ours).max()


@needs_ccx
def test_c3d8_runs_and_is_stiffer(tmp_path):
    """No settlement, so the strain energy is half the weight's work: the stiffer, the less it sinks."""
    sunk = {}
    for kind in ("hexahedron", "hexahedron20"):
        mesh = all_kinds()[kind]
        options = options_for("linear")
        case = load_case(mesh, options)
        rest = LoadCase(case.young, case.poisson, case.density, 9.81, np.zeros_like)
        write_mesh(mesh, tmp_path / f"{kind}.inp", case=rest)
        sunk[kind] = displacements(ccx(tmp_path, kind))[:90, 3].min()
    assert 0.8 * sunk["hexahedron20"] > sunk["hexahedron"] > sunk["hexahedron20"]


@needs_ccx
def test_without_gravity_one_step_is_left(tmp_path):
    mesh, options = all_kinds()["hexahedron20"], options_for("linear", gravity=0.0)
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options))
    text = (tmp_path / "wall.inp").read_text()
    assert text.count("*STEP") == 1
    assert "GRAV" not in text
    ours, theirs = analyse(mesh, options=options), displacements(ccx(tmp_path, "wall"))
    assert np.abs(theirs[:, 1:] - ours.displacement).max() < 1e-6 * np.abs(ours.displacement).max()


PRESSURE = """*INCLUDE, INPUT=mesh.inp
*MATERIAL, NAME=MASONRY
*ELASTIC
3e9, 0.2
*SOLID SECTION, ELSET=WALL, MATERIAL=MASONRY
*BOUNDARY
{held}, 1, 3
*STEP
*STATIC
*DSLOAD
{pressed}_SURFACE, P, 1000.
*NODE PRINT, NSET={held}, TOTALS=ONLY
RF
*END STEP
"""


@needs_ccx
@pytest.mark.parametrize("pressed", OPPOSITE)
def test_a_pressure_on_each_surface(mesh, tmp_path, pressed):
    """The mesh alone, in a deck of one's own: what holds the far side balances the pressure."""
    write_mesh(mesh, tmp_path / "mesh.inp")
    deck = PRESSURE.format(held=OPPOSITE[pressed].upper(), pressed=pressed.upper())
    (tmp_path / "run.inp").write_text(deck)
    corners = mesh.nodes[mesh.groups[pressed][:, : 3 if mesh.kind.value == "tetra10" else 4]]
    spread = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    area = spread / 2 if mesh.kind.value == "tetra10" else spread
    # the pressure is -1000 n A, and the support gives it back
    found = np.array(ccx(tmp_path, "run").split()[-3:], dtype=float)
    assert found == pytest.approx(1000 * area, abs=1e-3)


def blocks(path):
    """Data lines of each keyword line, continuation lines joined."""
    found, key = {}, ""
    for line in path.read_text().splitlines():
        if line.startswith("*"):
            key = line if not line.startswith("**") else key
            found.setdefault(key, [])
        elif found[key] and found[key][-1].endswith(","):
            found[key][-1] += line
        else:
            found[key].append(line)
    return {key: [row.replace(" ", "").split(",") for row in rows] for key, rows in found.items()}


def test_mesh_line_by_line(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.inp")
    read = blocks(tmp_path / "wall.inp")
    nodes = np.array(read["*NODE, NSET=ALL"], dtype=float)
    assert nodes[:, 0].tolist() == list(range(1, len(mesh.nodes) + 1))
    np.testing.assert_allclose(nodes[:, 1:], mesh.nodes, rtol=1e-12, atol=1e-15)
    elements = np.array(read[f"*ELEMENT, TYPE={NAMES[mesh.kind.value]}, ELSET=WALL"], dtype=int)
    assert elements[:, 0].tolist() == list(range(1, len(mesh.elements) + 1))
    np.testing.assert_array_equal(elements[:, 1:], mesh.elements + 1)
    faces = CALCULIX_FACES[mesh.kind.value]
    for name, facets in mesh.groups.items():
        if not len(facets):
            assert not any(name.upper() in key for key in read)
            continue
        members = [int(field) for row in read[f"*NSET, NSET={name.upper()}"] for field in row]
        assert members == (np.unique(facets) + 1).tolist()
        rows = read[f"*SURFACE, NAME={name.upper()}_SURFACE, TYPE=ELEMENT"]
        assert len(rows) == len(facets)
        for (element, face), facet in zip(rows, facets, strict=True):
            own = elements[int(element) - 1, list(faces[int(face[1:]) - 1])]
            assert set(own) == set(facet[: len(own)] + 1)
    assert not any(key.startswith(("*STEP", "*MATERIAL")) for key in read)


def test_analysis_line_by_line(tmp_path):
    mesh, options = all_kinds()["hexahedron20"], options_for("linear")
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options))
    text = (tmp_path / "wall.inp").read_text()
    before, first, second = text.split("*STEP\n")
    assert "*ELASTIC\n3480000000, 0.16\n*DENSITY\n1900\n" in before
    assert "*SOLID SECTION, ELSET=WALL, MATERIAL=MASONRY\n" in before
    assert "*BOUNDARY\nBASE, 1, 3\n" in before
    assert "WALL, GRAV, 9.81, 0., 0., -1.\n" in first
    weight = float(before.partition("The wall weighs ")[2].split()[0])
    assert weight == pytest.approx(1900 * 9.81 * VOLUME, rel=1e-7)
    assert "*BOUNDARY" not in first
    rows = second.partition("*BOUNDARY\n")[2].partition("*")[0].splitlines()
    table = np.array([row.split(",") for row in rows], dtype=float).reshape(-1, 3, 4)
    assert (table[:, :, 0] == mesh.group_nodes("base")[:, None] + 1).all()
    assert (table[:, :, 1] == [1, 2, 3]).all()
    assert (table[:, :, 2] == [1, 2, 3]).all()
    # By hand: from -12 to -3 mm down and from -4 to 2 mm along a base of π m.
    x = mesh.nodes[mesh.group_nodes("base"), 0] / np.pi
    expected = np.column_stack([-0.004 + 0.006 * x, 0 * x, -0.012 + 0.009 * x])
    np.testing.assert_allclose(table[:, :, 3], expected, atol=1e-14)
    for request in ("*NODE FILE\nU, RF\n", "*EL FILE\nS\n", "*NODE PRINT, NSET=BASE, TOTALS=YES\nRF\n"):
        assert request in first
        assert request in second
    assert "*NODE PRINT, NSET=ALL\nU\n" in second


def test_within_what_calculix_reads(mesh, tmp_path):
    tiny = LoadCase(1.23456789012345e-300, 1 / 3, 1e20 / 3, 9.80665, lambda p: -p * 1e-200 / 3)
    far = VolumeMesh(mesh.nodes - [1e7 / 3, 1e-150, -2e5], mesh.elements, mesh.kind, mesh.groups)
    write_mesh(far, tmp_path / "wall.inp", case=tiny)
    for line in (tmp_path / "wall.inp").read_text().splitlines():
        fields = line.split(",")
        assert len(line) <= (132 if line.startswith("*") else 300)
        if not line.startswith("*"):
            # a comma at the end only says that the list goes on
            assert len([field for field in fields if field.strip()]) <= 16
            assert all(len(field.strip()) <= 20 for field in fields)


def test_the_warning_about_c3d8(tmp_path):
    for kind, mesh in all_kinds().items():
        write_mesh(mesh, tmp_path / f"{kind}.inp")
        text = (tmp_path / f"{kind}.inp").read_text()
        assert ("too stiff in bending" in text) == (kind == "hexahedron")


@pytest.mark.parametrize("suffix", [".inp", ".cdb"])
@pytest.mark.parametrize(
    ("groups", "base", "message"),
    [
        ({}, np.zeros_like, "The mesh has no group 'base'"),
        (None, lambda p: p[:, 0], r"Invalid 'base': expected shape \(18, 3\), got \(18,\)"),
        (None, lambda p: np.full(p.shape, np.nan), "Invalid 'base': 54 of 54 values are not finite"),
    ],
)
def test_cases_at_fault(tmp_path, suffix, groups, base, message):
    mesh = hexahedra()
    mesh = VolumeMesh(mesh.nodes, mesh.elements, mesh.kind, mesh.groups if groups is None else groups)
    case = LoadCase(3e9, 0.2, 1900.0, 9.81, base)
    with pytest.raises(InputError, match=message):
        write_mesh(mesh, tmp_path / f"wall{suffix}", case=case)
    assert not list(tmp_path.iterdir())
