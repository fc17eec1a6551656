"""Files that a response is written to."""

import json

import numpy as np
import pytest
from exported_meshes import hexahedra20

from fd2fem.errors import InputError
from solvers import AnalysisOptions, LinearSettlement
from solvers.fem.elasticity import analyse
from solvers.results import read_response, response_to_dict, write_response

CONTRACT = {
    "schema", "converged", "max_displacement_m", "max_principal_stress_pa", "p95_principal_stress_pa",
    "p99_principal_stress_pa", "rms_stress_pa", "reaction_n", "strain_energy_j", "dissipated_energy_j",
    "max_crack_opening_m", "damage_class", "mesh", "solver", "timings_s", "final_principal_stress_pa", "feet",
    "damage", "history",
}  # fmt: skip

SCALARS = (
    "weight", "max_displacement", "max_principal_stress", "p95_principal_stress", "p99_principal_stress",
    "rms_stress", "strain_energy", "dissipated_energy", "max_crack_opening", "damage_class", "dofs",
    "final_principal_stress", "feet",
)  # fmt: skip


@pytest.fixture(scope="module")
def response(punched_wall):
    return analyse(punched_wall)


@pytest.fixture
def folder(response, tmp_path):
    write_response(response, tmp_path / "new" / "out")
    return tmp_path / "new" / "out"


def test_figures(response):
    figures = json.loads(json.dumps(response_to_dict(response), allow_nan=False))
    assert set(figures) >= CONTRACT
    assert figures["schema"] == "fd2fem/response-1"
    assert figures["converged"] is True
    assert figures["max_displacement_m"] == np.linalg.norm(response.displacement, axis=1).max()
    assert figures["max_principal_stress_pa"] == response.principal_stress[:, 0].max()
    # 7 x 7 x 2 nodes, all of them on the opening's rim or off it but the one in its middle; 32 elements.
    assert figures["mesh"]["nodes"] == 2 * (49 - 1)
    assert figures["mesh"]["elements"] == 32
    assert figures["solver"]["settlement"]["vertical_left"] == -0.0445
    assert set(figures["timings_s"]) == {"assemble", "solve", "stress"}


def test_nothing_else_is_left(folder):
    assert sorted(path.name for path in folder.iterdir()) == ["response.json", "response.vtu"]


@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10"])
def test_what_is_read_back_is_what_was_written(kind, punched_wall, tetrahedra, tmp_path):
    change = {"hexahedron": lambda mesh: mesh, "hexahedron20": hexahedra20, "tetra10": tetrahedra}[kind]
    response = analyse(change(punched_wall))
    write_response(response, tmp_path)
    again = read_response(tmp_path)
    for name in ("displacement", "stress", "principal_stress", "reaction", "largest_stress"):
        assert np.array_equal(getattr(again, name), getattr(response, name))
    for name in SCALARS:
        assert getattr(again, name) == getattr(response, name)
    assert np.array_equal(again.mesh.nodes, response.mesh.nodes)
    assert np.array_equal(again.mesh.elements, response.mesh.elements)
    assert again.mesh.kind is response.mesh.kind
    assert again.solver == response.solver
    assert again.timings == response.timings


def test_vtk_reads_the_fields(response, folder):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(folder / "response.vtu"))
    size = vtkCellSizeFilter()
    size.SetInputConnection(reader.GetOutputPort())
    size.Update()
    grid = size.GetUnstructuredGridOutput()
    fields = {
        name: vtk_to_numpy(grid.GetPointData().GetArray(name))
        for name in ("displacement", "stress", "principal_stress")
    }
    cells = grid.GetCellData()
    assert np.array_equal(fields["displacement"], response.displacement)
    assert np.array_equal(fields["stress"], response.stress)
    assert np.array_equal(fields["principal_stress"], response.principal_stress)
    assert vtk_to_numpy(cells.GetArray("Volume")).sum() == pytest.approx((9 - 1) * 0.4)
    first = response.mesh.elements[0]
    assert vtk_to_numpy(cells.GetArray("sigma1"))[0] == pytest.approx(
        response.principal_stress[first, 0].mean()
    )
    assert vtk_to_numpy(cells.GetArray("largest_sigma1")).max() == response.max_principal_stress


def test_after_a_single_solve_there_is_one_stress_for_all_steps(response):
    assert response.final_principal_stress == response.max_principal_stress
    # At the nodes: the number and the picture agree.
    assert response.largest_stress.max() == response.max_principal_stress
    assert response.history == ()


def test_damage_of_an_elastic_wall_is_classed_by_strain_alone(punched_wall):
    # By hand: a wall that tilts as a whole is not strained; the beam is drawn out by 0.9 mm in 3 m.
    tilt = analyse(
        punched_wall, options=AnalysisOptions(settlement=LinearSettlement(0, -0.003, 0, 0), gravity=0)
    )
    assert tilt.damage["tensile_strain"] == pytest.approx(0.0, abs=1e-5)
    assert (tilt.damage["strain_class"], tilt.damage_class) == (0, -1)
    assert not any(name.startswith("crack") or "cracks" in name for name in tilt.damage)
    drawn = analyse(punched_wall, options=AnalysisOptions(settlement=LinearSettlement(0, 0, 0, 0.0009)))
    assert drawn.damage["equivalent_beam"]["tensile_strain"] == pytest.approx(0.0003, rel=1e-6)
    assert drawn.damage["equivalent_beam"]["damage_class"] == 0


def test_files_of_earlier_versions_are_read(response, folder):
    path = folder / "response.json"
    figures = json.loads(path.read_text(encoding="utf-8"))
    for name in ("feet", "final_principal_stress_pa"):
        del figures[name]
    path.write_text(json.dumps(figures), encoding="utf-8")
    _replace(folder, 'Name="largest_sigma1"', 'Name="what_no_one_reads"')
    again = read_response(folder)
    assert again.feet == ()
    assert again.final_principal_stress == response.max_principal_stress
    assert np.array_equal(again.largest_stress, response.largest_stress)


def test_vtk_reads_20_node_elements(punched_wall, tmp_path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import VTK_QUADRATIC_HEXAHEDRON
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    response = analyse(hexahedra20(punched_wall))
    write_response(response, tmp_path)
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "response.vtu"))
    reader.Update()
    grid = reader.GetOutput()
    assert {grid.GetCellType(k) for k in range(grid.GetNumberOfCells())} == {VTK_QUADRATIC_HEXAHEDRON}
    found = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
    assert np.array_equal(found, response.displacement)


def _edit(folder, **changes):
    path = folder / "response.json"
    figures = json.loads(path.read_text(encoding="utf-8")) | changes
    path.write_text(json.dumps({k: v for k, v in figures.items() if v != "drop"}), encoding="utf-8")


def _replace(folder, old, new):
    path = folder / "response.vtu"
    data = path.read_bytes()
    assert old.encode() in data
    path.write_bytes(data.replace(old.encode(), new.encode()))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda f: (f / "response.json").unlink(), "response.json does not exist"),
        (lambda f: (f / "response.vtu").unlink(), "response.vtu does not exist"),
        (lambda f: (f / "response.json").write_text("{", encoding="utf-8"), "response.json cannot be read"),
        (lambda f: (f / "response.json").write_bytes(b"\xff\xfe\x00"), "response.json cannot be read"),
        (lambda f: (f / "response.json").write_text("[]", encoding="utf-8"), "has the schema None"),
        (lambda f: (f / "response.vtu").write_text("", encoding="utf-8"), "no VTU file"),
        (lambda f: (f / "response.vtu").write_text("<VTKFile/>", encoding="utf-8"), "no VTU file"),
        (lambda f: _replace(f, 'Points" NumberOfComponents="3"', 'Points" NumberOfComponents="7"'), "no VTU"),
        (lambda f: _replace(f, 'Name="stress"', 'Name="strain"'), "lacks 'stress'"),
        (lambda f: _replace(f, 'Name="principal_stress" Num', 'Name="x" Num'), "lacks 'principal_stress'"),
        (lambda f: _edit(f, schema="fd2fem/response-9"), "schema 'fd2fem/response-9', expected"),
        (lambda f: _edit(f, reaction_n="drop"), "lacks 'reaction_n'"),
        (lambda f: _edit(f, reaction_n=[1, 2]), "is damaged"),
        (lambda f: _edit(f, reaction_n=None), "is damaged"),
        (lambda f: _edit(f, weight_n="heavy"), "is damaged"),
        (lambda f: _edit(f, rms_stress_pa=float("nan")), "is damaged .* not finite"),
        (lambda f: _edit(f, strain_energy_j=None), "is damaged"),
        (lambda f: _edit(f, converged=False), "does not state that the analysis converged"),
        (lambda f: _edit(f, solver=3), "is damaged"),
        (lambda f: _edit(f, mesh=[]), "is damaged"),
        (lambda f: _edit(f, mesh={"nodes": 3, "dofs": 9}), "lacks 'elements'"),
        (lambda f: _edit(f, mesh={"nodes": 3, "elements": 1, "dofs": 9}), "belong to different meshes"),
    ],
)
def test_damaged_files_are_refused(folder, damage, message):
    damage(folder)
    with pytest.raises(InputError, match=message):
        read_response(folder)


@pytest.mark.parametrize("share", [0.05, 0.2, 0.5, 0.8, 0.95, 0.99])
def test_a_file_cut_short_is_refused(folder, share):
    path = folder / "response.vtu"
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match=r"response.vtu is no VTU file|is damaged|lacks"):
        read_response(folder)


def test_swapped_bytes_raise_nothing_else(folder):
    path = folder / "response.vtu"
    data = path.read_bytes()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        broken = bytearray(data)
        for place in rng.integers(0, len(data), 3):
            broken[place] = int(rng.integers(0, 256))
        path.write_bytes(bytes(broken))
        try:
            read_response(folder)
        except InputError:
            continue
