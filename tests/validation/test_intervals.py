"""Appendix B against the paper's tables and scipy.stats."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from fd2fem.errors import InputError
from validation import (
    mean_error,
    normal_interval,
    normal_interval_from_moments,
    standard_deviation,
    standard_uncertainty,
    t_interval,
    t_interval_from_moments,
)

COLUMNS = [
    (table, building, k)
    for table in ("table3", "table4")
    for building in ("building1", "building2", "building3")
    for k in range(4)
]


@pytest.mark.parametrize(("table", "building", "column"), COLUMNS)
def test_paper_column_follows_from_its_mean_and_std(paper, table, building, column):
    rows = paper[table][building]
    n = rows["n"]
    interval = t_interval_from_moments(rows["average"][column], rows["std"][column], n=n)
    uncertainty = standard_uncertainty(rows["std"][column], n=n)
    # Mean, std and bound are each rounded to 0.1 mm, so each is off by up to 0.05 mm.
    slack = 0.05 + 0.05 + 2.0 * 0.05 / math.sqrt(n)
    assert interval.lower == pytest.approx(rows["lower"][column], abs=slack)
    assert interval.upper == pytest.approx(rows["upper"][column], abs=slack)
    assert uncertainty == pytest.approx(rows["standard_uncertainty"][column], abs=0.07)
    assert (interval.n, interval.level, interval.method) == (n, 0.90, "t")


def test_building3_of_table3_is_misprinted(paper):
    # Its row "lower" is the row of upper bounds: 20 columns of the 24 hold as printed.
    rows = paper["table3"]["building3"]
    for k in range(4):
        interval = t_interval_from_moments(rows["average"][k], rows["std"][k], n=56)
        assert interval.upper == pytest.approx(rows["printed_lower"][k], abs=0.12)
        assert abs(interval.lower - rows["printed_lower"][k]) > 20.0


def test_normal_quantile_does_not_reproduce_small_samples(paper):
    # With n = 8 equation 8 is too narrow by some 9 mm: the paper used equation 9.
    rows = paper["table3"]["building1"]
    interval = normal_interval_from_moments(rows["average"][0], rows["std"][0], n=8)
    assert interval.lower - rows["lower"][0] == pytest.approx(
        102.8 / math.sqrt(8) * (1.8946 - 1.6449), abs=0.2
    )


def test_moments_by_hand():
    # 2, 4, 4, 4, 5, 5, 7, 9: mean 5, sum of squares 32, so s² = 32/7.
    errors = [2, 4, 4, 4, 5, 5, 7, 9]
    assert mean_error(errors) == 5.0
    assert standard_deviation(errors) == pytest.approx(math.sqrt(32 / 7), rel=1e-15)
    assert standard_uncertainty(math.sqrt(32 / 7), n=8) == pytest.approx(math.sqrt(4 / 7), rel=1e-15)


def test_two_values_by_hand():
    # One degree of freedom: t at 95 % is tan(0.45 π) = 6.3138; s/√n of (0, 2) is 1.
    interval = t_interval([0.0, 2.0])
    assert interval.upper == pytest.approx(1.0 + math.tan(0.45 * math.pi), rel=1e-12)


ERRORS = arrays(
    np.float64, st.integers(2, 60), elements=st.floats(-1.0, 1.0).map(lambda v: round(v, 6))
).filter(lambda e: np.ptp(e) > 1e-3)


@settings(max_examples=60, deadline=None)
@given(ERRORS, st.floats(0.05, 0.995))
def test_intervals_are_those_of_scipy(errors, level):
    scale = stats.sem(errors)
    for interval, expected in (
        (t_interval(errors, level=level), stats.t.interval(level, len(errors) - 1, errors.mean(), scale)),
        (normal_interval(errors, level=level), stats.norm.interval(level, errors.mean(), scale)),
    ):
        assert (interval.lower, interval.upper) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_equal_errors_leave_no_width():
    interval = t_interval([0.005] * 6)
    assert interval.lower == pytest.approx(0.005, abs=1e-17)
    assert interval.upper == pytest.approx(0.005, abs=1e-17)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: t_interval([]), "needs at least 2, got 0"),
        (lambda: normal_interval([1.0]), "needs at least 2, got 1"),
        (lambda: mean_error([1.0]), "needs at least 2, got 1"),
        (lambda: standard_uncertainty(1.0, n=1), "needs at least 2, got 1"),
        (lambda: t_interval([1.0, float("nan")]), "1 of 2 values are not finite"),
        (lambda: t_interval([1.0, 2.0], level=1.0), "'level'.* between 0 and 1"),
        (lambda: t_interval([1.0, 2.0], level=90), "'level'.* got 90"),
        (lambda: normal_interval([1.0, 2.0], level=float("nan")), "'level'.* got nan"),
        (lambda: t_interval_from_moments(0.0, -1.0, n=8), "'std'.* got -1.0"),
        (lambda: t_interval_from_moments(0.0, float("inf"), n=8), "'std'.* got inf"),
        (lambda: t_interval_from_moments(float("nan"), 1.0, n=8), "'mean'.* got nan"),
        (lambda: normal_interval_from_moments(0.0, 1.0, n=1), "needs at least 2, got 1"),
    ],
)
def test_refuses(call, match):
    with pytest.raises(InputError, match=match):
        call()
