"""The trough over a tunnel and what it does to a base."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from solvers.ground.settlement import (
    FunctionSettlement,
    LinearSettlement,
    PeckTrough,
    SettlementTable,
    SettlementTrough,
    base_displacement,
    base_stations,
    horizontal_movement,
    horizontal_strain,
    max_settlement,
    settlement_record,
    settlement_slope,
    swap_horizontal,
    trough_settlement,
    trough_volume,
    trough_width,
)

ORACLES = Path(__file__).parents[2] / "oracles"
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
    ends=st.tuples(*[st.floats(-0.07, 0.07)] * 4),
    shares=st.lists(st.floats(0, 1), min_size=1, max_size=5),
    left=st.floats(-5, 5),
)
def test_linear_settlement_stays_between_its_ends(ends, shares, left):
    moved = base_displacement(LinearSettlement(*ends), left + 3 * np.array(shares), extent=(left, left + 3.0))
    for values, low, high in ((moved[:, 2], *sorted(ends[:2])), (moved[:, 0], *sorted(ends[2:]))):
        assert (values >= low - 1e-12).all()
        assert (values <= high + 1e-12).all()


def test_the_other_reading_of_the_horizontal_movement():
    load = swap_horizontal(LinearSettlement())
    moved = base_displacement(load, [0.0, 4.95], extent=(0.0, 4.95))
    assert np.allclose(moved, [[-17.7e-3, 0, -44.5e-3], [-28.3e-3, 0, -17.8e-3]])
    assert swap_horizontal(load) == LinearSettlement()


SHARES = st.lists(st.floats(0, 1), min_size=1, max_size=8)


@settings(max_examples=30, deadline=None)
@given(ends=st.tuples(*[st.floats(-0.03, 0.03)] * 4), shares=SHARES)
def test_a_function_and_a_table_of_a_line_are_a_line(ends, shares):
    load = LinearSettlement(*ends)
    extent = -1.5, 2.5
    x = -1.5 + 4.0 * np.array(shares)
    expected = base_displacement(load, x, extent=extent)

    def line(at):
        share = (at + 1.5) / 4.0
        up, across = ((1 - share) * one + share * other for one, other in (ends[:2], ends[2:]))
        return np.column_stack([across, 0 * at, up])

    rows = np.array([-2.0, -1.5, 0.1, 0.7, 2.5])
    ux, uy, uz = line(rows).T
    table = SettlementTable(x=tuple(rows), ux=tuple(ux), uy=tuple(uy), uz=tuple(uz))
    for other in (FunctionSettlement(line), table):
        assert np.allclose(base_displacement(other, x, extent=extent), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    "load",
    [
        LinearSettlement(-0.04, -0.02, -0.03, 0.01),
        SettlementTable(x=(0, 1, 4), uz=(-0.01, 0, 0.01), uy=(0, 0.01, 0)),
        PeckTrough(0.01, 6.0, 15.0, centre=1.0),
        SettlementTrough(0.02, 4.0, 10.0),
    ],
)
def test_positions_are_points_of_the_front(load):
    x = np.array([0.0, 0.4, 3.0, 4.0])
    points = np.column_stack([x, 0 * x, [0.0, 0.1, -2.0, 3.0]])
    moved = base_displacement(load, points, extent=(0.0, 4.0))
    assert np.array_equal(moved, base_displacement(load, x, extent=(0.0, 4.0)))
    # Only a skew tunnel tells the front from the back.
    behind = base_displacement(load, points + np.array([0.0, 0.3, 0.0]), extent=(0.0, 4.0))
    assert np.allclose(moved, behind, rtol=0, atol=1e-15)


def test_a_step_of_the_ground_is_a_settlement():
    def step(x):
        return np.column_stack([0 * x, 0 * x, np.where(x < 2.0, 0.0, -0.009)])

    moved = base_displacement(FunctionSettlement(step), [1.9, 2.1], extent=(0.0, 4.0))
    assert moved[:, 2].tolist() == [0.0, -0.009]


def test_stations_are_the_rows_under_the_wall():
    table = SettlementTable(x=(-1, 0.0, 1, 2, 7), uz=(0,) * 5)
    assert base_stations(table, extent=(0.5, 2.0)).tolist() == [0.5, 1.0, 2.0]
    evenly = base_stations(LinearSettlement(), extent=(0.5, 2.0))
    assert (evenly[0], evenly[-1]) == (0.5, 2.0)
    assert (np.diff(evenly) > 0).all()


def sag(x):
    return np.column_stack([0 * x, 0 * x, -1e-3 * np.cos(x)])


@pytest.mark.parametrize(
    ("load", "expected"),
    [
        (LinearSettlement(0.0, 0.0, 0.0, 1e-3), {"kind": "LinearSettlement", "horizontal_right": 1e-3}),
        (SettlementTable(x=(0, 1), uz=(0, -1e-3)), {"kind": "SettlementTable", "uz": [0.0, -1e-3]}),
        (PeckTrough(0.01, 6.0, 15.0, soil="clay"), {"kind": "PeckTrough", "soil": "clay", "k": None}),
        (SettlementTrough(0.02, 4.0, 10.0), {"kind": "SettlementTrough", "smax": 0.02}),
        (FunctionSettlement(sag), {"kind": "FunctionSettlement", "function": "sag"}),
    ],
)
def test_record_in_json(load, expected):
    record = json.loads(json.dumps(settlement_record(load), allow_nan=False))
    assert record | expected == record


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
        (
            lambda: base_displacement(LinearSettlement(0, 0, 0, 0.22), [0.0], extent=(0.0, 4.0)),
            "stretch by 0.055 between x = .* more than 0.05: check the settlement's unit",
        ),
        (
            lambda: base_displacement(LinearSettlement(0, 0, 0.22, 0), [0.0], extent=(0.0, 4.0)),
            "shorten by 0.055 between",
        ),
        (
            lambda: base_displacement(LinearSettlement(-0.3, 0, 0, 0), [0.0], extent=(0.0, 4.0)),
            "slope by 0.075 between",
        ),
        (
            lambda: base_displacement(
                SettlementTable(x=(0, 2, 2.5, 5), uz=(0,) * 4, uy=(0, 0, 0.1, 0)), [0.0], extent=(0.0, 5.0)
            ),
            "shear by 0.2 between x = 2 and 2.25 m",
        ),
        (lambda: base_displacement(LinearSettlement(), [[0.0, 1.0]], extent=(0.0, 4.0)), "'points'"),
        (lambda: base_displacement(LinearSettlement(), [float("nan")], extent=(0.0, 4.0)), "not finite"),
        (lambda: FunctionSettlement(0.01), "'function': expected a function of positions, got 0.01"),
        (
            lambda: base_displacement(FunctionSettlement(np.cos), [0.0], extent=(0.0, 4.0)),
            "'settlement function': expected shape",
        ),
        (
            lambda: base_displacement(
                FunctionSettlement(lambda x: sag(x) + np.inf), [0.0], extent=(0.0, 4.0)
            ),
            "'settlement function': .* not finite",
        ),
    ],
)
def test_settlement_refuses(make, message):
    with pytest.raises(InputError, match=message):
        make()
