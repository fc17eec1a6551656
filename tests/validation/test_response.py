"""Responses with known differences."""

import math

import numpy as np
import pytest

from fd2fem.errors import InputError
from validation import compare_responses, judge, response_notes

SCALARS = {
    "max_displacement_m": "max_displacement",
    "max_principal_stress_pa": "max_principal_stress",
    "p95_principal_stress_pa": "p95_principal_stress",
    "p99_principal_stress_pa": "p99_principal_stress",
    "rms_stress_pa": "rms_stress",
    "strain_energy_j": "strain_energy",
}
FIELDS = ["displacement_l2", "displacement_l2_without_rigid_motion"]


def stretch(x):
    return np.column_stack([1e-3 * x[:, 0], 0 * x[:, 0], -2e-3 * x[:, 2]])


def rigid(x):
    return np.cross([0.001, 0.005, -0.002], x) + np.array([0.01, -0.02, -0.03])


@pytest.fixture
def wall(grid_mesh):
    return grid_mesh(np.linspace(0, 5, 6), [0, 0.35], np.linspace(0, 12, 9), holes=[(2, 3), (2, 6)])


def rows(candidate, reference, **options):
    return {q.quantity: q for q in compare_responses(candidate, reference, **options)}


def test_names_and_gates(wall, response_on):
    same = response_on(wall, stretch)
    found = rows(same, same)
    assert list(found) == [*SCALARS, "vertical_reaction_n", *FIELDS]
    assert [name for name, q in found.items() if q.gated] == ["max_displacement_m", "max_principal_stress_pa"]
    assert all(q.passed and q.relative_difference == pytest.approx(0.0, abs=1e-12) for q in found.values())
    assert all(q.uncertainty is None for q in found.values())


@pytest.mark.parametrize(("key", "name"), SCALARS.items())
@pytest.mark.parametrize(("factor", "passed"), [(1.04, True), (1.06, False), (0.96, True), (0.94, False)])
def test_one_scalar_differs(wall, response_on, key, name, factor, passed):
    reference = response_on(wall, stretch)
    value = getattr(reference, name)
    found = rows(response_on(wall, stretch, **{name: value * factor}), reference)
    assert found[key].relative_difference == pytest.approx(factor - 1.0, rel=1e-9)
    assert (found[key].candidate, found[key].reference) == (value * factor, value)
    assert [other for other, q in found.items() if not q.passed] == ([] if passed else [key])


def test_reaction_is_the_vertical_one(wall, response_on):
    candidate = response_on(wall, stretch, reaction=np.array([9e9, 9e9, 3.3e5]))
    found = rows(candidate, response_on(wall, stretch))["vertical_reaction_n"]
    assert found.relative_difference == pytest.approx(0.1)


def test_the_papers_building_1(paper, wall, response_on):
    printed = paper["response"]["building1"]
    models = [
        response_on(
            wall,
            stretch,
            max_displacement=printed["max_displacement_m"][which],
            max_principal_stress=printed["max_principal_stress_pa"][which],
        )
        for which in ("scan", "cad")
    ]
    found = rows(*models)
    assert 100 * found["max_displacement_m"].relative_difference == pytest.approx(2.5, abs=0.05)
    assert found["max_displacement_m"].passed
    assert 100 * found["max_principal_stress_pa"].relative_difference == pytest.approx(8.5, abs=0.1)
    assert not found["max_principal_stress_pa"].passed


def test_cracking_is_reported_where_there_is_any(wall, response_on):
    cracked = response_on(wall, stretch, dissipated_energy=10.0, max_crack_opening=1e-3)
    found = rows(cracked, response_on(wall, stretch, max_crack_opening=1e-3))
    assert (found["dissipated_energy_j"].relative_difference, found["dissipated_energy_j"].passed) == (
        None,
        False,
    )
    assert found["max_crack_opening_m"].relative_difference == 0.0


def test_a_rigid_motion_apart(wall, response_on):
    reference = response_on(wall, stretch)
    candidate = response_on(wall, lambda x: stretch(x) + rigid(x))
    found = rows(candidate, reference)
    assert found[FIELDS[0]].relative_difference > 0.5
    assert not found[FIELDS[0]].passed
    assert found[FIELDS[1]].relative_difference == pytest.approx(0.0, abs=1e-12)
    assert found[FIELDS[1]].passed
    assert found[FIELDS[1]].candidate == pytest.approx(found[FIELDS[1]].reference, rel=1e-12)


def test_a_scaled_field_differs_by_its_scale(wall, response_on):
    reference = response_on(wall, stretch)
    candidate = response_on(wall, lambda x: 0.97 * stretch(x))
    found = rows(candidate, reference)
    for name in FIELDS:
        assert found[name].relative_difference == pytest.approx(0.03, rel=1e-9)
        assert found[name].candidate == pytest.approx(0.97 * found[name].reference, rel=1e-9)
    assert not rows(candidate, reference, tolerance=0.02)[FIELDS[0]].passed


def test_rms_of_a_stretched_bar(grid_mesh, response_on):
    # u = 1e-3 x over 0..5 m: RMS by the midpoint rule on 500 cells is 1e-3·5/√3 to 1e-6 relative.
    mesh = grid_mesh(np.linspace(0, 5, 501), [0, 0.3], [0, 1])
    bar = response_on(mesh, lambda x: np.column_stack([1e-3 * x[:, 0], 0 * x[:, 0], 0 * x[:, 0]]))
    found = rows(bar, bar)
    assert found[FIELDS[0]].reference == pytest.approx(5e-3 / math.sqrt(3), rel=2e-6)


def test_walls_of_different_size_and_mesh(grid_mesh, response_on):
    # The same linear field on a wall 20 mm shorter with another mesh: the fields agree where both have wall.
    reference = response_on(grid_mesh(np.linspace(0, 5, 6), [0, 0.35], np.linspace(0, 12, 9)), stretch)
    candidate = response_on(
        grid_mesh(np.linspace(0, 4.98, 8), [0, 0.2, 0.35], np.linspace(0, 11.9, 14)), stretch
    )
    found = rows(candidate, reference)
    for name in FIELDS:
        assert found[name].relative_difference == pytest.approx(0.0, abs=1e-12)


def test_models_that_do_not_move(wall, response_on):
    still = response_on(wall, np.zeros_like)
    found = rows(still, still)
    assert all(found[name].relative_difference is None and found[name].passed for name in FIELDS)
    moved = rows(response_on(wall, stretch), still)
    assert all(moved[name].relative_difference is None and not moved[name].passed for name in FIELDS)


def test_a_purely_rigid_reference_has_no_deformation_to_compare(wall, response_on):
    turned = response_on(wall, rigid)
    found = rows(turned, turned)[FIELDS[1]]
    assert (found.relative_difference, found.passed) == (None, True)


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("model", ["candidate", "reference"])
@pytest.mark.parametrize(("key", "name"), [*SCALARS.items(), ("dissipated_energy_j", "dissipated_energy")])
def test_refuses_what_is_not_finite(wall, response_on, key, name, model, value):
    models = {"candidate": response_on(wall, stretch), "reference": response_on(wall, stretch)}
    models[model] = response_on(wall, stretch, **{name: value})
    with pytest.raises(InputError, match=f"'{key}' of the {model}: {value} is not finite"):
        compare_responses(models["candidate"], models["reference"])


@pytest.mark.parametrize("tolerance", [0.0, 1.0, 5.0, math.nan])
def test_refuses_tolerance(wall, response_on, tolerance):
    same = response_on(wall, stretch)
    with pytest.raises(InputError, match="'tolerance': expected a number between 0 and 1"):
        compare_responses(same, same, tolerance=tolerance)


def feet(*forces):
    return tuple({"reaction_n": list(force)} for force in forces)


CRACKED = {"dissipated_energy": 10.0, "max_crack_opening": 1e-3, "damage_class": 1}


def test_a_wall_that_cracks_is_judged_by_what_settles_with_the_mesh_too(wall, response_on):
    same = response_on(wall, stretch, feet=feet([0.0, 0.0, 3e5]), **CRACKED)
    gated = [name for name, q in rows(same, same).items() if q.gated]
    assert gated == ["max_displacement_m", "max_principal_stress_pa", "strain_energy_j", "foot_reactions_n"]
    elastic = response_on(wall, stretch, feet=feet([0.0, 0.0, 3e5]))
    assert [name for name, q in rows(elastic, elastic).items() if q.gated] == gated[:2]
    assert rows(same, elastic)["foot_reactions_n"].gated


def test_forces_on_the_feet_differ_as_vectors(wall, response_on):
    # By hand: (3, 0, 4) against (-3, 0, 4), as long but 6 apart; the other foot is the same.
    first = response_on(wall, stretch, feet=feet([3e3, 0.0, 4e3], [0.0, 0.0, 12e3]), **CRACKED)
    second = response_on(wall, stretch, feet=feet([-3e3, 0.0, 4e3], [0.0, 0.0, 12e3]), **CRACKED)
    found = rows(first, second)["foot_reactions_n"]
    assert found.candidate == found.reference == pytest.approx(13e3)
    assert found.relative_difference == pytest.approx(6 / 13)
    assert not found.passed
    verdict = judge(None, compare_responses(first, second))
    assert verdict.reasons == (
        "forces of the ground on the feet differ by 46.2 % of the reference's (tolerance 5 %)",
    )
    assert judge(None, compare_responses(first, first)).passed


def test_walls_on_different_numbers_of_feet_fall_short(wall, response_on):
    one = response_on(wall, stretch, feet=feet([0.0, 0.0, 3e5]), **CRACKED)
    two = response_on(wall, stretch, feet=feet([0.0, 0.0, 1e5], [0.0, 0.0, 2e5]), **CRACKED)
    found = rows(one, two)["foot_reactions_n"]
    assert (found.relative_difference, found.passed) == (None, False)
    assert judge(None, compare_responses(one, two)).reasons == (
        "the walls do not stand on the same number of feet",
    )


def test_feet_that_carry_nothing_agree(wall, response_on):
    idle = response_on(wall, stretch, feet=feet([0.0, 0.0, 0.0]))
    found = rows(idle, idle)["foot_reactions_n"]
    assert (found.relative_difference, found.passed) == (None, True)


def test_classes_of_damage_are_compared_where_both_walls_may_crack(wall, response_on):
    slight, none = response_on(wall, stretch, damage_class=2), response_on(wall, stretch, damage_class=0)
    found = rows(slight, none)["damage_class"]
    assert (found.candidate, found.reference, found.passed, found.gated) == (2, 0, False, False)
    assert rows(none, none)["damage_class"].passed
    assert "damage_class" not in rows(slight, response_on(wall, stretch))


def test_stresses_at_the_strength_say_little_and_the_comparison_says_so(wall, response_on):
    masonry = {"masonry": {"tensile_strength": 1.15e6}}
    at_strength = response_on(wall, stretch, max_principal_stress=1.15e6, solver=masonry)
    (note,) = response_notes(at_strength, at_strength)
    assert "1.15 and 1.15 MPa" in note
    assert judge(None, compare_responses(at_strength, at_strength), notes=[note]).notes == (note,)
    below = response_on(wall, stretch, max_principal_stress=1.14e6, solver=masonry)
    elastic = response_on(wall, stretch, max_principal_stress=1.15e6, solver={"masonry": None})
    for other in (below, elastic, response_on(wall, stretch, max_principal_stress=1.15e6)):
        assert response_notes(at_strength, other) == response_notes(other, at_strength) == ()


def test_a_note_says_that_one_wall_is_elastic(wall, response_on):
    elastic, cracked = (
        response_on(wall, stretch, solver={"law": law}) for law in ("linear elastic", "Drucker-Prager")
    )
    (note,) = response_notes(cracked, elastic)
    assert note.startswith("the candidate is Drucker-Prager, the reference linear elastic")
    assert response_notes(elastic, elastic) == ()
