"""The trough over a tunnel and what it does to a base."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from solvers.settlement import (
    LinearSettlement,
    PeckTrough,
    base_displacement,
    horizontal_movement,
    horizontal_strain,
    max_settlement,
    settlement_slope,
    trough_settlement,
    trough_volume,
    trough_width,
)

ORACLES = Path(__file__).parents[1] / "oracles"
TROUGH = tomllib.loads((ORACLES / "structural.toml").read_text(encoding="utf-8"))["trough"]
WIDTH, DEPTH, SMAX = TROUGH["width"], TROUGH["depth"], TROUGH["smax"]


def test_trough_of_the_worked_example():
    volume = trough_volume(TROUGH["volume_loss"], TROUGH["diameter"])
    width = trough_width(DEPTH, k=TROUGH["k"])
    assert volume == pytest.approx(TROUGH["volume"], rel=2e-6)
    assert width == WIDTH
    assert max_settlement(volume, width) == pytest.approx(SMAX, rel=1e-6)


def test_extremes_of_the_worked_example():
    x = np.array([0.0, WIDTH, np.sqrt(3) * WIDTH])
    slope = settlement_slope(x, smax=SMAX, width=WIDTH)
    movement = horizontal_movement(x, smax=SMAX, width=WIDTH, depth=DEPTH)
    strain = horizontal_strain(x, smax=SMAX, width=WIDTH, depth=DEPTH)
    assert slope[1] == pytest.approx(-TROUGH["largest_slope"], rel=5e-6)
    assert movement[1] == pytest.approx(-TROUGH["largest_horizontal"], rel=2e-6)
    assert strain[0] == pytest.approx(TROUGH["strain_over_axis"], rel=1e-6)
    assert strain[2] == pytest.approx(TROUGH["largest_strain"], rel=1e-6)


def test_trough_holds_the_lost_volume():
    x = np.linspace(-80, 80, 4001)
    assert np.trapezoid(trough_settlement(x, smax=SMAX, width=WIDTH), x) == pytest.approx(
        TROUGH["volume"], rel=2e-6
    )


def test_slope_and_strain_are_derivatives():
    x = np.linspace(-20, 20, 9)
    step = 1e-5
    ends = x + step, x - step
    slope = np.subtract(*(trough_settlement(e, smax=SMAX, width=WIDTH) for e in ends)) / (2 * step)
    strain = np.subtract(*(horizontal_movement(e, smax=SMAX, width=WIDTH, depth=DEPTH) for e in ends)) / (
        2 * step
    )
    assert np.allclose(slope, settlement_slope(x, smax=SMAX, width=WIDTH), atol=1e-10)
    assert np.allclose(strain, horizontal_strain(x, smax=SMAX, width=WIDTH, depth=DEPTH), atol=1e-10)


def test_base_under_the_trough():
    trough = PeckTrough(volume_loss=0.01, diameter=6.0, depth=15.0, centre=2.0)
    moved = base_displacement(trough, [2.0, 9.5, -5.5], extent=(-6.0, 10.0))
    # Over the axis straight down; 7.5 m to the right of it (x = i) down and to the left.
    assert moved[0] == pytest.approx([0.0, 0.0, -15.03977e-3], rel=1e-6)
    assert moved[1] == pytest.approx([-4.56104e-3, 0.0, -15.03977e-3 * np.exp(-0.5)], rel=1e-5)
    assert moved[2] == pytest.approx([4.56104e-3, 0.0, moved[1, 2]], rel=1e-5)


def test_linear_settlement_between_the_ends():
    load = LinearSettlement(-0.04, -0.02, -0.03, 0.01)
    moved = base_displacement(load, [1.0, 2.0, 5.0], extent=(1.0, 5.0))
    assert np.allclose(moved, [[-0.03, 0, -0.04], [-0.02, 0, -0.035], [0.01, 0, -0.02]])


def test_default_sinks_and_moves_most_at_the_left_end():
    moved = base_displacement(LinearSettlement(), [0.0, 4.95], extent=(0.0, 4.95))
    assert np.allclose(moved, [[-28.3e-3, 0, -44.5e-3], [-17.7e-3, 0, -17.8e-3]])


@settings(max_examples=30, deadline=None)
@given(
    ends=st.tuples(*[st.floats(-0.1, 0.1)] * 4),
    shares=st.lists(st.floats(0, 1), min_size=1, max_size=5),
    left=st.floats(-5, 5),
)
def test_linear_settlement_stays_between_its_ends(ends, shares, left):
    moved = base_displacement(LinearSettlement(*ends), left + 3 * np.array(shares), extent=(left, left + 3.0))
    for values, low, high in ((moved[:, 2], *sorted(ends[:2])), (moved[:, 0], *sorted(ends[2:]))):
        assert (values >= low - 1e-12).all()
        assert (values <= high + 1e-12).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearSettlement(vertical_left=-44.5), "'vertical_left': -44.5 m is no settlement"),
        (lambda: LinearSettlement(horizontal_right=float("nan")), "'horizontal_right': nan m"),
        (lambda: PeckTrough(1.0, 6.0, 15.0), "fraction between 0 and 0.2 .0.01 is 1 %., got 1.0"),
        (lambda: PeckTrough(-0.01, 6.0, 15.0), "'volume_loss'"),
        (lambda: PeckTrough(0.01, 0.0, 15.0), "'diameter': expected a positive number"),
        (lambda: PeckTrough(0.01, 6.0, 3.0), "axis at 3.0 m reaches the base"),
        (lambda: PeckTrough(0.01, 6.0, 15.0, centre=float("inf")), "'centre'"),
        (lambda: base_displacement(LinearSettlement(), [0.0], extent=(1.0, 1.0)), "'extent'"),
        (
            lambda: base_displacement(LinearSettlement(vertical_left=-0.5), [0.0], extent=(0.0, 4.0)),
            "wall of 4 m would move 0.5 m: check the settlement's unit",
        ),
    ],
)
def test_settlement_refuses(make, message):
    with pytest.raises(InputError, match=message):
        make()
