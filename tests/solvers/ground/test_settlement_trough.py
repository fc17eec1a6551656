"""The trough of a tunnel that passes the wall at an angle."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from solvers.ground.settlement import PeckTrough, SettlementTable, Soil, base_displacement, settlement_trough
from solvers.ground.settlement_trough import SettlementTrough, trough_displacement
from solvers.ground.trough import (
    axis_distance,
    horizontal_strain,
    settlement_slope,
    soil_trough_width,
)

ORACLES = Path(__file__).parents[2] / "oracles"
TROUGH = tomllib.loads((ORACLES / "structural.toml").read_text(encoding="utf-8"))["trough"]

TROUGHS = st.builds(
    SettlementTrough,
    smax=st.floats(0.001, 0.05),
    width=st.floats(2.0, 10.0),
    depth=st.floats(5.0, 30.0),
    centre=st.floats(-10, 10),
    skew=st.floats(-90, 90),
    offset=st.floats(-10, 10),
)
PLAN = st.lists(st.tuples(st.floats(-20, 20), st.floats(-5, 5)), min_size=1, max_size=5).map(np.array)


def test_width_by_soil():
    assert soil_trough_width(TROUGH["depth"], soil=Soil.CLAY) == pytest.approx(TROUGH["clay_width"])
    assert soil_trough_width(TROUGH["depth"], soil=Soil.SAND) == pytest.approx(TROUGH["sand_width"])
    in_sand = settlement_trough(PeckTrough(0.01, 6.0, TROUGH["depth"], soil=Soil.SAND))
    assert in_sand.width == pytest.approx(TROUGH["sand_width"])
    # The same volume in a narrower trough is deeper.
    assert in_sand.smax == pytest.approx(TROUGH["smax"] * TROUGH["width"] / TROUGH["sand_width"], rel=1e-6)


def test_tunnel_gives_the_trough_of_the_worked_example():
    names = "volume_loss", "diameter", "depth", "k"
    trough = settlement_trough(PeckTrough(**{name: TROUGH[name] for name in names}))
    assert trough.smax == pytest.approx(TROUGH["smax"], rel=1e-6)
    assert trough.width == TROUGH["width"]


@settings(max_examples=100, deadline=None)
@given(trough=TROUGHS, plan=PLAN)
def test_ground_moves_straight_to_the_axis(trough, plan):
    # In plan the axis is a line: the foot of the perpendicular on it, by vectors alone.
    angle = np.deg2rad(trough.skew)
    along = np.array([np.sin(angle), np.cos(angle)])
    # `offset` from the wall's point, which lies to the right of the axis, seen along it.
    to_the_right = np.cross([*along, 0.0], [0.0, 0.0, 1.0])[:2]
    origin = np.array([trough.centre, 0.0]) - trough.offset * to_the_right
    foot = origin + ((plan - origin) @ along)[:, None] * along
    distance = np.linalg.norm(plan - foot, axis=1)
    S = trough.smax * np.exp(-(distance**2) / (2 * trough.width**2))
    moved = trough_displacement(trough, plan)
    assert np.allclose(moved[:, :2], (S / trough.depth)[:, None] * (foot - plan), rtol=0, atol=1e-14)
    assert np.allclose(moved[:, 2], -S, rtol=0, atol=1e-14)


@settings(max_examples=50, deadline=None)
@given(trough=TROUGHS, plan=PLAN)
def test_mirrored_tunnel_gives_the_mirrored_trough(trough, plan):
    mirrored = SettlementTrough(
        trough.smax, trough.width, trough.depth, -trough.centre, -trough.skew, -trough.offset
    )
    moved = trough_displacement(mirrored, plan * [-1, 1])
    assert np.allclose(moved * [-1, 1, 1], trough_displacement(trough, plan), rtol=0, atol=1e-15)


@pytest.mark.parametrize("skew", [0.0, 20.0, -50.0, 75.0])
def test_strain_and_slope_along_the_wall_are_derivatives(skew):
    trough = SettlementTrough(0.02, 4.0, 10.0, centre=1.0, skew=skew)
    x, step = np.linspace(-9, 9, 7), 1e-5
    ahead, back = (trough_displacement(trough, np.column_stack([x + h, 0 * x])) for h in (step, -step))
    rate = (ahead - back) / (2 * step)
    distance = (x - 1.0) * np.cos(np.deg2rad(skew))
    cosine, sine = np.cos(np.deg2rad(skew)), np.sin(np.deg2rad(skew))
    strain = horizontal_strain(distance, smax=0.02, width=4.0, depth=10.0)
    slope = settlement_slope(distance, smax=0.02, width=4.0)
    assert np.allclose(rate[:, 0], strain * cosine**2, rtol=0, atol=1e-10)
    assert np.allclose(rate[:, 1], -strain * cosine * sine, rtol=0, atol=1e-10)
    assert np.allclose(rate[:, 2], -slope * cosine, rtol=0, atol=1e-10)


@pytest.mark.parametrize("skew", [0.0, 35.0, -60.0])
def test_section_of_a_skew_trough_holds_more_volume(skew):
    trough = settlement_trough(PeckTrough(0.01, 6.0, 15.0, centre=-3.0, skew=skew))
    x = np.linspace(-200, 200, 8001)
    section = -np.trapezoid(trough_displacement(trough, np.column_stack([x, 0 * x]))[:, 2], x)
    assert section == pytest.approx(TROUGH["volume"] / np.cos(np.deg2rad(skew)), rel=2e-6)


def test_no_skew_is_square_to_the_wall():
    points = np.array([[-4.0, 0.3, 0.0], [0.0, 0.0, 0.0], [7.5, -0.2, 0.0]])
    moved = base_displacement(PeckTrough(0.01, 6.0, 15.0, skew=0.0), points, extent=(-8.0, 8.0))
    assert (moved[:, 1] == 0.0).all()
    assert moved[2] == pytest.approx([-TROUGH["largest_horizontal"], 0.0, -TROUGH["smax"] * np.exp(-0.5)])


def test_tunnel_along_the_wall_pulls_it_as_a_whole():
    # 7.5 m behind the front, which is the distance i: down, and into the wall.
    trough = PeckTrough(0.01, 6.0, 15.0, skew=90.0, offset=7.5)
    moved = base_displacement(trough, [0.0, 3.0, 8.0], extent=(0.0, 8.0))
    expected = [0.0, TROUGH["largest_horizontal"], -TROUGH["smax"] * np.exp(-0.5)]
    assert np.allclose(moved, expected, rtol=0, atol=1e-8)


def test_offset_is_measured_from_the_axis():
    assert axis_distance([[2.0, 0.0]], centre=2.0, offset=-3.0, skew=40.0) == pytest.approx([-3.0])


def test_table_of_a_trough_is_the_trough():
    trough = PeckTrough(0.02, 6.0, 12.0, centre=3.0, skew=25.0, soil=Soil.CLAY)
    rows = np.linspace(-1.0, 9.0, 401)
    ux, uy, uz = base_displacement(trough, rows, extent=(-1.0, 9.0)).T
    table = SettlementTable(x=tuple(rows), ux=tuple(ux), uy=tuple(uy), uz=tuple(uz))
    x = np.linspace(0.0, 8.0, 97)
    moved = base_displacement(table, x, extent=(0.0, 8.0))
    # Linear interpolation over h = 25 mm: h² / 8 times the curvature, Smax / i² = 1e-3 / m at most.
    assert np.allclose(moved, base_displacement(trough, x, extent=(0.0, 8.0)), rtol=0, atol=1e-7)
    at_rows = base_displacement(table, rows, extent=(-1.0, 9.0))
    assert np.allclose(at_rows, np.column_stack([ux, uy, uz]), rtol=0, atol=1e-16)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"skew": 91.0}, "'skew': expected an angle between -90 and 90 degrees, got 91.0"),
        ({"skew": float("nan")}, "'skew'"),
        ({"offset": float("inf")}, "'offset': expected a finite number"),
        ({"k": 0.0}, "'k': expected a positive number, got 0.0"),
        ({"k": 0.4, "soil": Soil.CLAY}, "Give either k or soil of a trough, not both: k = 0.4, soil = clay"),
        ({"diameter": 0.4, "depth": 0.3, "soil": Soil.SAND}, "0.3 m is too shallow .* trough in sand"),
        ({"volume_loss": float("nan")}, "'volume_loss'"),
    ],
)
def test_peck_refuses(values, message):
    with pytest.raises(InputError, match=message):
        PeckTrough(**{"volume_loss": 0.01, "diameter": 6.0, "depth": 15.0} | values)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"smax": 15.0}, "'smax': 15.0 m is no settlement of a wall; give metres"),
        ({"smax": -0.01}, "'smax': expected a settlement, which counts downwards, got -0.01 m"),
        ({"width": 0.0}, "'width'"),
        ({"depth": float("nan")}, "'depth'"),
        ({"skew": -100.0}, "'skew'"),
    ],
)
def test_trough_refuses(values, message):
    with pytest.raises(InputError, match=message):
        SettlementTrough(**{"smax": 0.01, "width": 5.0, "depth": 15.0} | values)
