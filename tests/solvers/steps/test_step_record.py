"""What a step records, and what is kept of all of them: against the axes themselves, and by hand."""

import csv
import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from solvers import (
    AnalysisOptions,
    LinearSettlement,
    MasonryLaw,
    SteppingOptions,
    read_response,
    write_response,
)
from solvers.fem.stress import principal_stress
from solvers.steps.masonry_analysis import analyse_steps, prepare, snapshots
from solvers.steps.step_record import largest_stress, raised_stress

STRETCH = LinearSettlement(0.0, -0.001, -0.001, 0.002)
OPTIONS = AnalysisOptions(masonry=MasonryLaw(), settlement=STRETCH, stepping=SteppingOptions(steps=8))


@pytest.fixture(scope="module")
def mesh(grid):
    return grid(np.linspace(0, 2, 9), [0, 0.25], np.linspace(0, 1, 5))


@pytest.fixture(scope="module")
def seen(mesh):
    return list(snapshots(prepare(mesh, options=OPTIONS)))


@pytest.fixture(scope="module")
def response(mesh):
    return analyse_steps(mesh, options=OPTIONS)


@given(arrays(np.float64, (4, 3, 6), elements=st.floats(-1e6, 1e6)))
def test_the_largest_stress_is_found_without_looking_at_all_of_them(stress):
    sigma1 = principal_stress(stress)[..., 0]
    slack = 1e-9 * (1.0 + np.abs(stress).max())
    assert largest_stress(stress) == pytest.approx(sigma1.max(), abs=slack)
    before = np.array([-np.inf, 0.0, 5e5, 1e7])
    expected = np.maximum(before, sigma1.max(axis=1))
    assert np.allclose(raised_stress(before, stress), expected, rtol=0, atol=slack)


def test_the_largest_stress_is_that_of_all_steps_and_the_strength_its_limit(response, seen):
    strength = MasonryLaw().tensile_strength
    each = np.array([principal_stress(one.fields.stress)[..., 0].max(axis=1) for one in seen])
    assert np.allclose(response.largest_stress, np.minimum(each.max(axis=0), strength), rtol=1e-12)
    assert response.max_principal_stress == response.largest_stress.max() == strength
    assert [step["max_principal_stress"] for step in response.history] == pytest.approx(
        np.minimum(each.max(axis=1), strength).tolist(), rel=1e-12
    )
    # Cracks have set the wall free: the last step alone would tell less of most elements.
    assert (response.largest_stress > each[-1] + 1e3).any()
    assert 0.0 < response.final_principal_stress <= strength


def test_the_crack_that_progress_tells_of_is_the_one_of_the_response(response):
    assert response.dissipated_energy > 0.0
    assert response.history[-1]["max_crack_opening"] == response.max_crack_opening
    assert response.max_crack_opening == response.crack_opening.max()
    assert response.damage["crack_width"] == response.max_crack_opening


def test_a_crack_is_as_wide_as_the_energy_that_it_took_says(mesh):
    # By hand: a crack of the width w takes Gf (1 - exp(-w ft / Gf)) of its area, V / h.
    law = MasonryLaw(fracture_energy=1000.0)
    options = dataclasses.replace(OPTIONS, masonry=law)
    response = analyse_steps(mesh, options=options)
    area = 0.25**3 / prepare(mesh, options=options).tangent.model.band
    share = response.dissipation / (law.fracture_energy * area)
    partly = (share > 0.01) & (share < 0.95)
    width = -np.log(1.0 - share[partly]) * law.fracture_energy / law.tensile_strength
    ratio = response.crack_opening[partly] / width
    # The energy is also taken by what opens the other ways: at least as much.
    assert (ratio < 1.0 + 1e-6).all()
    assert ratio.max() > 0.95


def test_an_analysis_that_goes_on_remembers_what_was_before(response, mesh, tmp_path):
    state = tmp_path / "state.npz"
    steps = snapshots(prepare(mesh, options=OPTIONS), state=state)
    for _ in range(5):
        next(steps)
    resumed = analyse_steps(mesh, options=OPTIONS, state=state)
    assert np.allclose(resumed.largest_stress, response.largest_stress, rtol=1e-6)
    assert len(resumed.history) == len(response.history)
    for one, other in zip(resumed.history, response.history, strict=True):
        assert np.allclose(one["feet"], other["feet"], atol=1e-4 * response.weight)


def test_the_curve_is_a_table(response, tmp_path):
    write_response(response, tmp_path)
    with (tmp_path / "load_settlement.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["step"]) for row in rows] == list(range(len(response.history)))
    for row, step in zip(rows, response.history, strict=True):
        assert float(row["settlement_m"]) == step["settlement"]
        assert float(row["reaction_z_n"]) == step["reaction"][2]
        assert [float(row[f"foot1_{axis}_n"]) for axis in "xyz"] == step["feet"][0]
        assert float(row["dissipated_energy_j"]) == step["dissipated_energy"]
        assert int(row["iterations"]) == step["iterations"]
    # By hand: the ground sinks by nothing at one end and 1 mm at the other.
    assert float(rows[-1]["settlement_m"]) == pytest.approx(0.001)


def test_what_is_new_comes_back_from_disk(response, tmp_path):
    write_response(response, tmp_path)
    again = read_response(tmp_path)
    assert np.array_equal(again.largest_stress, response.largest_stress)
    assert again.final_principal_stress == response.final_principal_stress
    assert [dict(foot) for foot in again.feet] == [dict(foot) for foot in response.feet]


def test_an_elastic_wall_on_springs_has_no_class_by_cracks(mesh):
    elastic = analyse_steps(mesh, options=dataclasses.replace(OPTIONS, masonry=None))
    assert (elastic.damage_class, elastic.knows_cracks) == (-1, False)
    assert "crack_class" not in elastic.damage
    assert elastic.damage["equivalent_beam"]["max_settlement"] == pytest.approx(0.001)
