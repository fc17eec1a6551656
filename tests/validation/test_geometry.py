"""Facades with known shifts: every error is known in advance."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from fd2fem.errors import InputError
from fd2fem.model import Facade, Opening, OpeningKind, rectangle
from validation import compare_facades, match_openings

TWO = [(1.0, 1.0, 1.2, 1.5), (5.0, 4.0, 0.9, 1.8)]


def test_known_shift(facade_of):
    # Opening 1 is 10 mm wider and 5 mm further right, opening 2 20 mm lower and 8 mm higher up.
    reference = facade_of(TWO)
    candidate = facade_of([(1.005, 1.0, 1.21, 1.5), (5.0, 4.008, 0.9, 1.78)], length=9.97, height=8.01)
    comparison = compare_facades(candidate, reference)
    geometry = comparison.geometry
    assert geometry["length"]["error_m"] == pytest.approx(-0.03, abs=1e-12)
    assert geometry["length"]["relative_error"] == pytest.approx(-0.003, abs=1e-12)
    assert geometry["height"]["error_m"] == pytest.approx(0.01, abs=1e-12)
    # 1.21 x 1.5 + 0.9 x 1.78 against 1.2 x 1.5 + 0.9 x 1.8
    assert geometry["opening_area"]["candidate"] == pytest.approx(3.417, abs=1e-12)
    assert geometry["opening_area"]["reference"] == pytest.approx(3.42, abs=1e-12)
    assert geometry["opening_area"]["error_m2"] == pytest.approx(-0.003, abs=1e-12)
    first, second = geometry["openings"]["matched"]
    assert first == pytest.approx(
        {
            "candidate_id": 1,
            "reference_id": 1,
            "width_error_m": 0.01,
            "height_error_m": 0.0,
            "x_error_m": 0.005,
            "z_error_m": 0.0,
        },
        abs=1e-12,
    )
    assert second["height_error_m"] == pytest.approx(-0.02, abs=1e-12)
    assert second["z_error_m"] == pytest.approx(0.008, abs=1e-12)
    assert comparison.passed
    assert comparison.reasons == ()


def test_statistics_of_the_known_shift(facade_of):
    candidate = facade_of([(1.005, 1.0, 1.21, 1.5), (5.0, 4.008, 0.9, 1.78)])
    geometry = compare_facades(candidate, facade_of(TWO), level=0.95).geometry
    for key, errors in (
        ("opening_dimensions", [0.01, 0.0, 0.0, -0.02]),
        ("opening_positions", [0.005, 0.0, 0.0, 0.008]),
    ):
        lower, upper = stats.t.interval(0.95, 3, np.mean(errors), stats.sem(errors))
        expected = {
            "n": 4,
            "mean_m": np.mean(errors),
            "std_m": np.std(errors, ddof=1),
            "standard_uncertainty_m": stats.sem(errors),
            "min_m": min(errors),
            "max_m": max(errors),
            "lower_m": lower,
            "upper_m": upper,
            "level": 0.95,
        }
        row = geometry[key]
        assert {name: row[name] for name in expected} == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("building", ["building1", "building3"])
@pytest.mark.parametrize("column", range(4))
def test_the_papers_facades_pass_at_5_percent_but_not_at_a_tenth(paper, facade_of, building, column):
    # One opening stands for all: only its area counts here.
    def facade(length, height, area):
        return facade_of([(1.0, 1.0, area / (height - 2.0), height - 2.0)], length, height)

    table = paper["table2"][building]
    names = ("length", "height", "opening_area")
    candidate = facade(*(table[name][column] for name in names))
    reference = facade(*(table["cad"][name] for name in names))
    assert compare_facades(candidate, reference).passed
    assert not compare_facades(candidate, reference, tolerance=0.001).passed


def test_opening_area_reason(facade_of):
    reference = facade_of([(1.0, 1.0, 2.0, 3.0)])
    candidate = facade_of([(1.0, 1.0, 2.124, 3.0)])
    comparison = compare_facades(candidate, reference)
    assert not comparison.passed
    assert comparison.reasons == (
        "opening area is 6.2 % larger than the reference (tolerance 5 %): 6.372 against 6 m²",
    )


def test_every_overall_shortfall_has_its_reason(facade_of):
    comparison = compare_facades(facade_of([], 9.0, 9.0), facade_of([], 10.0, 8.0))
    assert [reason.split(" (")[0] for reason in comparison.reasons] == [
        "length is 10 % smaller than the reference",
        "height is 12.5 % larger than the reference",
    ]
    assert not comparison.geometry["length"]["passed"]


def test_missing_and_extra_fail(facade_of):
    reference = facade_of([*TWO, (8.0, 1.0, 1.0, 1.0)])
    candidate = facade_of([*TWO, (8.0, 5.0, 1.0, 1.0)])
    comparison = compare_facades(candidate, reference)
    openings = comparison.geometry["openings"]
    assert (openings["missing"], openings["extra"], openings["passed"]) == ([3], [3], False)
    assert comparison.geometry["opening_area"]["passed"]
    assert not comparison.passed
    assert comparison.reasons == (
        "opening 3 (window, 1.000 x 1.000 m at x = 8.000, z = 1.000) of the reference is missing",
        "opening 3 (window, 1.000 x 1.000 m at x = 8.000, z = 5.000) of the candidate "
        "is not in the reference",
    )


@pytest.mark.parametrize("swap", [True, False])
def test_a_missing_or_an_extra_one_alone_fails(facade_of, swap):
    # 0.1 m² more or less of 3.5 m² is within the tolerance: the count decides.
    walls = [facade_of(TWO), facade_of([*TWO, (8.0, 1.0, 0.4, 0.25)])]
    candidate, reference = walls[::-1] if swap else walls
    comparison = compare_facades(candidate, reference)
    assert comparison.geometry["opening_area"]["passed"]
    assert not comparison.geometry["openings"]["passed"]
    assert not comparison.passed
    assert len(comparison.reasons) == 1


def test_two_windows_taken_for_one(facade_of):
    # The wide candidate holds both centres; it overlaps the second more.
    reference = facade_of([(1.0, 1.0, 1.0, 1.0), (2.2, 1.0, 1.5, 1.0)])
    matches = match_openings(facade_of([(1.0, 1.0, 2.7, 1.0)]), reference)
    assert [(c.id, r.id) for c, r in matches.pairs] == [(1, 2)]
    assert [opening.id for opening in matches.missing] == [1]


def test_overlapping_corner_is_no_match(facade_of):
    matches = match_openings(facade_of([(1.6, 1.6, 1.0, 1.0)]), facade_of([(1.0, 1.0, 1.0, 1.0)]))
    assert matches.pairs == ()
    assert (len(matches.missing), len(matches.extra)) == (1, 1)


def test_assignment_is_the_best_in_total(facade_of):
    # Along x, m: references 1.0-2.0 and 2.1-3.1; candidates 1.2-3.0 and 3.02-3.1. Taking the largest
    # overlap first pairs 1 with 2 (0.9/1.9 = 0.47) and leaves one over; 0.8/2.0 + 0.08 = 0.48 is better.
    reference = facade_of([(1.0, 1.0, 1.0, 1.0), (2.1, 1.0, 1.0, 1.0)])
    candidate = facade_of([(1.2, 1.0, 1.8, 1.0), (3.02, 1.0, 0.08, 1.0)])
    matches = match_openings(candidate, reference)
    assert [(c.id, r.id) for c, r in matches.pairs] == [(1, 1), (2, 2)]


def test_an_arched_door_counts_by_its_outline():
    arch = [[1, 0], [2, 0], [2, 2], [1.5, 2.4], [1, 2]]
    door = Opening(1, OpeningKind.DOOR, np.array(arch, dtype=float))
    wall = rectangle(0, 0, 6, 5)
    comparison = compare_facades(Facade(wall, 0.3, (door,)), Facade(wall, 0.3, (door,)))
    assert comparison.geometry["opening_area"]["reference"] == pytest.approx(2.2, abs=1e-12)
    assert comparison.passed


def test_walls_without_openings(facade_of):
    bare = facade_of([])
    comparison = compare_facades(bare, bare)
    area = comparison.geometry["opening_area"]
    assert (area["relative_error"], area["passed"], comparison.passed) == (None, True, True)
    assert comparison.geometry["opening_dimensions"]["n"] == 0
    assert comparison.geometry["opening_dimensions"]["mean_m"] is None
    assert comparison.geometry["opening_positions"]["upper_m"] is None


def test_invented_opening_in_a_bare_wall(facade_of):
    comparison = compare_facades(facade_of([(1.0, 1.0, 1.0, 1.2)]), facade_of([]))
    assert not comparison.passed
    assert comparison.geometry["opening_area"]["relative_error"] is None
    assert comparison.reasons[0] == "opening area is 1.2 m² where the reference has none"


def test_geometry_is_json(facade_of):
    comparison = compare_facades(facade_of(TWO), facade_of(TWO))
    text = json.dumps(dict(comparison.geometry), allow_nan=False)
    assert json.loads(text) == comparison.geometry


@pytest.mark.parametrize(("tolerance", "level"), [(0.0, 0.9), (1.0, 0.9), (math.nan, 0.9), (0.05, 0.0)])
def test_refuses(facade_of, tolerance, level):
    with pytest.raises(InputError, match="expected a number between 0 and 1"):
        compare_facades(facade_of([]), facade_of([]), tolerance=tolerance, level=level)


@st.composite
def walls(draw):
    """Windows in a grid of bays 2 x 3 m, each of its own size and place within its bay."""
    columns, rows = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    fraction = st.floats(0.0, 1.0)
    openings = []
    for k in range(rows):
        for i in range(columns):
            width, height = 0.6 + draw(fraction), 0.6 + 1.8 * draw(fraction)
            x = 2.0 * i + 0.1 + draw(fraction) * (1.8 - width)
            z = 3.0 * k + 0.1 + draw(fraction) * (2.8 - height)
            openings.append(Opening(len(openings) + 1, OpeningKind.WINDOW, rectangle(x, z, width, height)))
    return Facade(rectangle(0, 0, 2.0 * columns, 3.0 * rows), 0.35, tuple(openings))


@settings(max_examples=40, deadline=None)
@given(walls())
def test_a_facade_agrees_with_itself(wall):
    comparison = compare_facades(wall, wall)
    assert comparison.passed
    assert comparison.geometry["length"]["error_m"] == 0.0
    for row in comparison.geometry["openings"]["matched"]:
        assert row["candidate_id"] == row["reference_id"]
        assert [row[f"{name}_error_m"] for name in ("width", "height", "x", "z")] == [0.0] * 4
    assert comparison.geometry["opening_dimensions"]["max_m"] == 0.0


@settings(max_examples=40, deadline=None)
@given(walls(), st.floats(-0.09, 0.09), st.floats(0.02, 0.08))
def test_a_scaled_wall_fails_if_and_only_if_beyond_the_tolerance(wall, error, tolerance):
    # Length and height scale by 1 + e, the opening area by (1 + e)²: the area decides.
    factor = 1.0 + error
    scaled = Facade(
        wall.outline * factor,
        wall.thickness,
        tuple(replace(opening, outline=opening.outline * factor) for opening in wall.openings),
    )
    comparison = compare_facades(scaled, wall, tolerance=tolerance)
    for name, expected in (("length", error), ("height", error), ("opening_area", factor**2 - 1.0)):
        row = comparison.geometry[name]
        assert row["relative_error"] == pytest.approx(expected, abs=1e-9)
        if abs(abs(expected) - tolerance) > 1e-6:
            assert row["passed"] is (abs(expected) < tolerance)
            assert any(reason.startswith(name.replace("_", " ")) for reason in comparison.reasons) is (
                abs(expected) > tolerance
            )
    assert comparison.passed is (not comparison.reasons)


@settings(max_examples=40, deadline=None)
@given(walls(), st.randoms(use_true_random=False))
def test_order_of_openings_does_not_matter(wall, random):
    shifted = [replace(opening, outline=opening.outline * 1.001) for opening in wall.openings]
    candidate = Facade(wall.outline, wall.thickness, tuple(shifted))
    expected = compare_facades(candidate, wall).geometry
    random.shuffle(shifted)
    found = compare_facades(Facade(wall.outline, wall.thickness, tuple(shifted)), wall).geometry
    assert found["openings"] == expected["openings"]
    assert found["opening_positions"] == expected["opening_positions"]
