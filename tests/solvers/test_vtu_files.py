"""The series of states for ParaView, read back by meshio and as XML."""

import dataclasses
from xml.etree import ElementTree as ET

import meshio
import numpy as np
import pytest

from fd2fem.errors import InputError
from solvers import AnalysisOptions, LinearSettlement, MasonryLaw, SteppingOptions
from solvers.results import read_response, response_to_dict, write_response
from solvers.steps.masonry_analysis import analyse_steps
from solvers.vtu_files import StepSeries

OPTIONS = AnalysisOptions(
    masonry=MasonryLaw(), settlement=LinearSettlement(0, 0, -0.001, 0.002), stepping=SteppingOptions(steps=6)
)


@pytest.fixture(scope="module")
def mesh(grid):
    return grid(np.linspace(0, 2, 9), [0, 0.25], np.linspace(0, 1, 5))


@pytest.fixture(scope="module")
def run(mesh, tmp_path_factory):
    folder = tmp_path_factory.mktemp("series")
    seen = []
    series = StepSeries(folder, mesh, frames=3)

    def on_step(state):
        seen.append(state)
        series(state)

    return folder, analyse_steps(mesh, options=OPTIONS, on_step=on_step), seen


def _listed(folder):
    root = ET.parse(folder / "response.pvd").getroot()
    return [(float(item.get("timestep")), item.get("file")) for item in root.iter("DataSet")]


def test_the_list_names_evenly_spaced_states(run):
    folder, _, seen = run
    entries = _listed(folder)
    assert [share for share, _ in entries] == pytest.approx([0, 1 / 3, 2 / 3, 1], abs=0.17)
    assert entries[0] == (0.0, "steps/step_0000.vtu")
    assert entries[-1][0] == pytest.approx(1.0)
    assert sorted(path.name for path in (folder / "steps").iterdir()) == [
        name.removeprefix("steps/") for _, name in entries
    ]
    assert len(seen) > len(entries)


def test_the_last_state_is_the_response(run):
    folder, response, _ = run
    grid = meshio.read(folder / _listed(folder)[-1][1])
    assert np.array_equal(grid.point_data["displacement"], response.displacement)
    assert np.array_equal(grid.cell_data["crack_opening"][0], response.crack_opening)
    assert grid.cell_data["crack_normal"][0].shape == (len(response.mesh.elements), 3)


def test_directions_are_those_of_the_principal_stresses(run):
    folder, response, _ = run
    write_response(response, folder)
    grid = meshio.read(folder / "response.vtu")
    s = response.stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    for name, column in (("direction1", 0), ("direction3", 2)):
        n = grid.point_data[name]
        assert np.allclose(np.linalg.norm(n, axis=1), 1.0)
        stretched = np.einsum("nij,nj->ni", s, n)
        assert np.allclose(stretched, response.principal_stress[:, [column]] * n, atol=1e-6 * np.abs(s).max())


def test_the_response_comes_back_whole(run, tmp_path):
    _, response, _ = run
    write_response(response, tmp_path)
    again = read_response(tmp_path)
    for name in ("crack_opening", "crack_normal", "dissipation"):
        assert np.array_equal(getattr(again, name), getattr(response, name))
    assert response_to_dict(again) == response_to_dict(response)
    assert [step["share"] for step in again.history] == [step["share"] for step in response.history]


def test_an_analysis_that_goes_on_adds_to_the_list(run, mesh, tmp_path):
    folder, _, seen = run
    series = StepSeries(tmp_path, mesh, frames=3)
    for state in seen[:4]:
        series(state)
    # Begun again from the third state, as if the process had been killed.
    series = StepSeries(tmp_path, mesh, frames=3)
    for state in seen[2:]:
        series(state)
    assert _listed(tmp_path) == _listed(folder)


def test_no_frames_are_no_series(mesh, tmp_path):
    with pytest.raises(InputError, match="frames"):
        StepSeries(tmp_path, mesh, frames=0)


def test_history_holds_the_load_settlement_curve(run):
    _, response, seen = run
    figures = response_to_dict(response)
    assert [step["share"] for step in figures["history"]] == [state.record.share for state in seen]
    keys = {field.name for field in dataclasses.fields(seen[0].record)}
    assert set(figures["history"][0]) == keys | {"settlement", "feet"}
