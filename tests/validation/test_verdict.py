"""The joined verdict and comparison.json."""

import json
import math

import pytest

from fd2fem.errors import InputError
from fd2fem.model import Comparison, QuantityComparison
from validation import compare_facades, comparison_to_dict, judge, write_comparison

DISPLACEMENT = QuantityComparison("max_displacement_m", 0.1021, 0.0996, 0.0251, passed=True)
STRESS = QuantityComparison("max_principal_stress_pa", 1.14e6, 1.05e6, 0.0857, passed=False)
ENERGY = QuantityComparison("strain_energy_j", 2.0, 1.0, 1.0, passed=False, gated=False)


@pytest.fixture
def good(facade_of):
    wall = facade_of([(1.0, 1.0, 1.2, 1.5)])
    return compare_facades(wall, wall)


@pytest.fixture
def bad(facade_of):
    return compare_facades(facade_of([], length=9.0), facade_of([]))


def test_all_within(good):
    verdict = judge(good, [DISPLACEMENT])
    assert verdict.passed
    assert verdict.reasons == ()
    assert verdict.geometry == good.geometry
    assert verdict.response == (DISPLACEMENT,)


def test_response_alone_can_fail(good):
    verdict = judge(good, [DISPLACEMENT, STRESS])
    assert not verdict.passed
    assert verdict.reasons == (
        "largest principal stress is 8.57 % larger than the reference (tolerance 5 %): "
        "1.14e+06 against 1.05e+06 Pa",
    )


def test_geometry_alone_can_fail(bad):
    verdict = judge(bad, [DISPLACEMENT])
    assert not verdict.passed
    assert verdict.reasons == bad.reasons


def test_reasons_of_both(bad):
    assert len(judge(bad, [STRESS]).reasons) == 2


def test_what_is_not_gated_does_not_decide(good):
    assert judge(good, [DISPLACEMENT, ENERGY]).passed


def test_responses_without_facades():
    assert judge(None, [DISPLACEMENT]).passed
    assert judge(None, [DISPLACEMENT]).geometry == {}


def test_a_failed_geometry_without_reasons_still_fails():
    assert not judge(Comparison(0.05, False, {}), [DISPLACEMENT]).passed


def test_nan_fails():
    lost = QuantityComparison("max_displacement_m", math.nan, 0.1, math.nan, passed=False)
    verdict = judge(None, [lost])
    assert not verdict.passed
    assert verdict.reasons == ("largest displacement is not a finite number: nan against 0.1",)


@pytest.mark.parametrize(
    ("quantities", "tolerance", "match"),
    [
        ([], 0.05, "Nothing to judge by"),
        ([ENERGY], 0.05, "Nothing to judge by"),
        ([DISPLACEMENT], 0.0, "'tolerance': expected a number between 0 and 1"),
        ([DISPLACEMENT], 0.01, "'max_displacement_m' says passed = True, .* tolerance of 0.01"),
        ([STRESS], 0.1, "'max_principal_stress_pa' says passed = False"),
        (
            [QuantityComparison("max_displacement_m", math.nan, 0.1, 0.0, passed=True)],
            0.05,
            "says passed = True, but nan",
        ),
    ],
)
def test_refuses(quantities, tolerance, match):
    with pytest.raises(InputError, match=match):
        judge(None, quantities, tolerance=tolerance)


def test_refuses_another_tolerance(good):
    with pytest.raises(InputError, match=r"0\.1, but the facades were compared with 0\.05"):
        judge(good, [DISPLACEMENT], tolerance=0.1)


def test_file_has_the_keys_of_its_schema(tmp_path, good):
    path = tmp_path / "comparison.json"
    write_comparison(judge(good, [DISPLACEMENT, STRESS, ENERGY]), path)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["schema"] == "fd2fem/comparison-1"
    assert set(content) == {"schema", "tolerance", "passed", "reasons", "notes", "geometry", "response"}
    assert (content["tolerance"], content["passed"]) == (0.05, False)
    assert content["response"][0] == {
        "quantity": "max_displacement_m",
        "candidate": 0.1021,
        "reference": 0.0996,
        "relative_difference": 0.0251,
        "uncertainty": None,
        "passed": True,
        "gated": True,
    }
    assert [row["gated"] for row in content["response"]] == [True, True, False]
    assert content["geometry"]["openings"]["matched"][0]["reference_id"] == 1
    assert content["reasons"] == [judge(None, [STRESS]).reasons[0]]
    assert list(tmp_path.iterdir()) == [path]


def test_dictionary_is_what_the_file_holds(tmp_path, good):
    path = tmp_path / "comparison.json"
    write_comparison(good, path)
    assert json.loads(path.read_text(encoding="utf-8")) == comparison_to_dict(good)


def test_nothing_is_written_of_figures_that_are_not_finite(tmp_path):
    path = tmp_path / "comparison.json"
    path.write_text("before", encoding="utf-8")
    lost = QuantityComparison("max_displacement_m", math.nan, 0.1, math.nan, passed=False)
    with pytest.raises(InputError, match="a figure of the comparison is not finite"):
        write_comparison(judge(None, [lost]), path)
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]
