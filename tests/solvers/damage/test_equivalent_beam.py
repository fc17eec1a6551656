"""The equivalent beam against its sources, beam theory, and profiles in closed form."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from fd2fem.errors import InputError
from solvers.damage.beam_strains import (
    EquivalentBeam,
    ZoneKind,
    bending_strain,
    combined_bending_strain,
    combined_diagonal_strain,
    diagonal_strain,
)
from solvers.damage.classes import DamageClass
from solvers.damage.equivalent_beam import beam_check_to_dict, equivalent_beam_check
from solvers.damage.settlement_profile import Profile, deflection, profile_zones
from solvers.ground.settlement import (
    FunctionSettlement,
    LinearSettlement,
    PeckTrough,
    SettlementTable,
    base_displacement,
)

FOLDER = Path(__file__).parents[2] / "oracles"
ORACLES = tomllib.loads((FOLDER / "damage.toml").read_text(encoding="utf-8"))
TROUGH = tomllib.loads((FOLDER / "structural.toml").read_text(encoding="utf-8"))["trough"]
SMAX, WIDTH = TROUGH["smax"], TROUGH["width"]
PECK = PeckTrough(volume_loss=0.01, diameter=6.0, depth=15.0, centre=1.0)
MEASURE = st.floats(0.5, 50.0)


@pytest.mark.parametrize(("kind", "slenderness", "bending", "diagonal"), ORACLES["beam"]["rows"])
def test_strains_of_the_published_beams(kind, slenderness, bending, diagonal):
    beam = EquivalentBeam(ZoneKind(kind), length=8.0 * slenderness, height=8.0)
    # Four digits are printed.
    assert bending_strain(1.0, beam) == pytest.approx(bending, abs=5e-5)
    assert diagonal_strain(1.0, beam) == pytest.approx(diagonal, abs=5e-5)


@given(kind=st.sampled_from(ZoneKind), length=MEASURE, height=MEASURE, e_over_g=st.floats(0.5, 15))
def test_strains_of_a_beam_under_a_load_in_the_middle(kind, length, height, e_over_g):
    # Timoshenko's beam of E = 1 and shear coefficient 1.5 under P = 1, which Burland & Wroth start from.
    I, t = (height**3 / 12, height / 2) if kind is ZoneKind.SAGGING else (height**3 / 3, height)  # noqa: E741
    G = 1 / e_over_g
    middle = length**3 / (48 * I) * (1 + 18 * I / (length**2 * height * G))
    fibre = length / 4 * t / I
    shear = 1.5 * 0.5 / height / G
    beam = EquivalentBeam(kind, length=length, height=height, e_over_g=e_over_g)
    assert bending_strain(middle / length, beam) == pytest.approx(fibre, rel=1e-12)
    assert diagonal_strain(middle / length, beam) == pytest.approx(shear / 2, rel=1e-12)


def test_combination_of_the_worked_example():
    oracle = ORACLES["combination"]
    strain = combined_diagonal_strain(oracle["diagonal"], oracle["horizontal"], poisson=oracle["poisson"])
    assert strain == pytest.approx(oracle["principal"], abs=5e-9)
    assert combined_bending_strain(3e-4, -1e-4) == pytest.approx(2e-4)


@given(diagonal=st.floats(0, 0.01), horizontal=st.floats(-0.01, 0.01), poisson=st.floats(0, 0.49))
def test_combined_diagonal_strain_is_the_largest_principal_strain(diagonal, horizontal, poisson):
    tensor = [[horizontal, diagonal], [diagonal, -poisson * horizontal]]
    strain = combined_diagonal_strain(diagonal, horizontal, poisson=poisson)
    assert strain == pytest.approx(np.linalg.eigvalsh(tensor)[-1], abs=1e-15)


def test_trough_is_parted_at_its_inflections():
    check = equivalent_beam_check(PECK, extent=(1.0 - 2 * WIDTH, 1.0 + 2 * WIDTH), height=15.0)
    left, middle, right = check.zones
    assert [zone.kind for zone in check.zones] == ["hogging", "sagging", "hogging"]
    # The curvature is taken linear between stations 30 mm apart: h² / i off at most.
    assert (middle.start, middle.end) == pytest.approx((1.0 - WIDTH, 1.0 + WIDTH), abs=2e-4)
    sag = SMAX * (1 - np.exp(-0.5))
    assert middle.deflection == pytest.approx(sag, rel=1e-4)
    assert middle.deflection_ratio == pytest.approx(sag / (2 * WIDTH), rel=1e-4)
    assert middle.horizontal_strain == pytest.approx(-TROUGH["largest_horizontal"] / WIDTH, rel=1e-4)
    # L/H = 1: the coefficients of the published beam.
    assert middle.bending_strain == pytest.approx(1.2245 * sag / (2 * WIDTH), rel=2e-4)
    assert middle.diagonal_strain == pytest.approx(0.7959 * sag / (2 * WIDTH), rel=2e-4)
    assert left.deflection == pytest.approx(right.deflection, rel=1e-6)
    assert left.tensile_strain == pytest.approx(right.tensile_strain, rel=1e-6)
    assert check.max_settlement == pytest.approx(SMAX, rel=1e-6)
    assert check.max_slope == pytest.approx(TROUGH["largest_slope"], rel=1e-5)
    assert check.max_horizontal_strain == pytest.approx(TROUGH["largest_strain"], rel=1e-4)
    assert not check.rankin_negligible


def test_hogging_beside_the_trough():
    # From i to 2 i: farthest from the chord where the slope is the chord's, t exp(-t²/2) = e^-½ - e^-2.
    chord = np.exp(-0.5) - np.exp(-2.0)
    t = brentq(lambda t: t * np.exp(-(t**2) / 2) - chord, 1.0, 2.0)
    bow = SMAX * (np.exp(-0.5) - chord * (t - 1) - np.exp(-(t**2) / 2))
    check = equivalent_beam_check(PECK, extent=(1.0 + WIDTH, 1.0 + 2 * WIDTH), height=7.5, poisson=0.2)
    (zone,) = check.zones
    ratio = bow / WIDTH
    stretch = (2 * np.exp(-2.0) - np.exp(-0.5)) * SMAX / TROUGH["depth"] * -1
    assert zone.kind is ZoneKind.HOGGING
    assert zone.deflection_ratio == pytest.approx(ratio, rel=1e-4)
    assert zone.horizontal_strain == pytest.approx(stretch, rel=1e-4)
    bending = 0.7229 * ratio + stretch
    diagonal = 0.4 * stretch + np.hypot(0.6 * stretch, 0.9398 * ratio)
    assert zone.combined_bending_strain == pytest.approx(bending, rel=2e-4)
    assert zone.combined_diagonal_strain == pytest.approx(diagonal, rel=2e-4)
    assert check.tensile_strain == pytest.approx(max(bending, diagonal), rel=2e-4)
    assert check.damage_class is DamageClass.NEGLIGIBLE


# Rows half a metre apart bow by 0.01 mm at most between them; the fourth digit hides 0.05 mm of each.
@pytest.mark.parametrize(("digits", "error", "share"), [(9, 2e-5, 0.01), (4, 3e-4, 0.1)])
def test_table_has_the_zones_of_the_trough(digits, error, share):
    extent = -14.0, 16.0
    rows = np.arange(-14.0, 16.1, 0.5)
    moved = base_displacement(PECK, rows, extent=extent).round(digits)
    table = SettlementTable(x=tuple(rows), ux=tuple(moved[:, 0]), uz=tuple(moved[:, 2]))
    exact, rounded = (equivalent_beam_check(load, extent=extent, height=10.0) for load in (PECK, table))
    assert [zone.kind for zone in rounded.zones] == [zone.kind for zone in exact.zones]
    for one, other in zip(rounded.zones, exact.zones, strict=True):
        assert one.deflection == pytest.approx(other.deflection, abs=error)
    assert rounded.tensile_strain == pytest.approx(exact.tensile_strain, rel=share)


@settings(max_examples=30, deadline=None)
@given(
    bow=st.floats(0.5e-3, 0.05),
    tilt=st.floats(-0.02, 0.02),
    left=st.floats(-20, 20),
    up=st.sampled_from([1, -1]),
)
def test_parabola_is_one_zone_whatever_its_tilt(bow, tilt, left, up):
    def parabola(x):
        share = (x - left) / 6.0
        return np.column_stack([0 * x, 0 * x, up * bow * 4 * share * (1 - share) + tilt * share])

    check = equivalent_beam_check(FunctionSettlement(parabola), extent=(left, left + 6.0), height=4.0)
    (zone,) = check.zones
    assert zone.kind is (ZoneKind.HOGGING if up > 0 else ZoneKind.SAGGING)
    assert zone.deflection == pytest.approx(bow, rel=1e-6)
    assert zone.horizontal_strain == 0.0


def test_linear_settlement_only_stretches():
    load = LinearSettlement(-0.01, -0.03, -2e-3, 1e-3)
    check = equivalent_beam_check(load, extent=(0.0, 5.0), height=12.0, poisson=0.16)
    (zone,) = check.zones
    assert zone.kind is ZoneKind.STRAIGHT
    assert (zone.deflection, zone.bending_strain, zone.diagonal_strain) == (0.0, 0.0, 0.0)
    assert check.tensile_strain == pytest.approx(6e-4, rel=1e-12)
    assert check.damage_class is DamageClass.VERY_SLIGHT
    assert check.max_slope == pytest.approx(4e-3)


def test_mirrored_ground_gives_the_mirrored_check():
    left = PeckTrough(0.02, 6.0, 10.0, centre=-2.0, skew=30.0)
    right = PeckTrough(0.02, 6.0, 10.0, centre=2.0, skew=-30.0)
    one, other = (equivalent_beam_check(load, extent=(-12.0, 12.0), height=10.0) for load in (left, right))
    assert one.tensile_strain == pytest.approx(other.tensile_strain, rel=1e-9)
    assert len(one.zones) == len(other.zones) == 3
    for a, b in zip(one.zones, reversed(other.zones), strict=True):
        assert (a.start, a.end) == pytest.approx((-b.end, -b.start), abs=1e-9)
        assert a.deflection_ratio == pytest.approx(b.deflection_ratio, rel=1e-6)


def test_more_volume_loss_is_more_damage():
    classes = [
        equivalent_beam_check(PeckTrough(loss, 8.0, 12.0), extent=(0.0, 15.0), height=8.0).damage_class
        for loss in (0.001, 0.01, 0.03, 0.1)
    ]
    assert classes == sorted(classes)
    assert (classes[0], classes[-1]) == (DamageClass.NEGLIGIBLE, DamageClass.SEVERE)


def test_straight_end_belongs_to_its_zone():
    x = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    u = np.array([0.0, 0.0, -0.01, -0.02, -0.02, -0.02])
    zones = profile_zones(Profile(x, 0 * x, u))
    assert [zone.kind for zone in zones] == ["hogging", "sagging"]
    assert (zones[0].start, zones[1].end) == (0.0, 5.0)
    # The bends at 1 and 3 m are equally sharp.
    assert zones[0].end == zones[1].start == pytest.approx(2.0)
    assert [deflection(Profile(x, 0 * x, u), zone) for zone in zones] == pytest.approx([0.005, 0.01 * 2 / 3])


def test_slight_zone_is_taken_into_its_neighbours():
    x = np.arange(9.0)
    u = -0.01 * np.sin(np.pi * x / 8)
    u[4] += 1.6e-3
    assert [zone.kind for zone in profile_zones(Profile(x, 0 * x, u))] == ["sagging", "hogging", "sagging"]
    (zone,) = profile_zones(Profile(x, 0 * x, u), smallest=2e-3)
    assert zone == ("sagging", 0.0, 8.0)


@pytest.mark.parametrize("count", [41, 301, 3001])
def test_noise_of_a_level_hides_no_zone(count):
    extent = -14.0, 16.0
    rows = np.linspace(*extent, count)
    moved = base_displacement(PECK, rows, extent=extent)
    noise = np.random.default_rng(5).normal(0.0, 3e-5, count)
    table = SettlementTable(x=tuple(rows), ux=tuple(moved[:, 0]), uz=tuple(moved[:, 2] + noise))
    check, exact = (equivalent_beam_check(load, extent=extent, height=10.0) for load in (table, PECK))
    assert [zone.kind for zone in check.zones] == ["hogging", "sagging", "hogging"]
    # Noise of 0.03 mm moves the inflections by a metre or two; 0.76 to 1.17 was seen over 300 draws.
    assert check.tensile_strain == pytest.approx(exact.tensile_strain, rel=0.3)


def test_check_in_json():
    check = equivalent_beam_check(PECK, extent=(-14.0, 16.0), height=10.0)
    record = json.loads(json.dumps(beam_check_to_dict(check), allow_nan=False))
    assert record["damage_label"] == check.damage_class.label
    governing = record["zones"][record["governing"]]
    strains = governing["combined_bending_strain"], governing["combined_diagonal_strain"]
    assert max(strains) == record["tensile_strain"] == check.tensile_strain
    assert governing["kind"] in {"hogging", "sagging"}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"height": 0.0}, "'height': expected a positive number"),
        ({"e_over_g": -1.0}, "'e_over_g'"),
        ({"poisson": 0.5}, "'poisson': expected a number between -1 and 0.5, got 0.5"),
        ({"extent": (1.0, 1.0)}, "'extent'"),
    ],
)
def test_check_refuses(values, message):
    with pytest.raises(InputError, match=message):
        equivalent_beam_check(PECK, **{"extent": (0.0, 5.0), "height": 5.0} | values)


def test_table_must_cover_the_wall():
    table = SettlementTable(x=(0.0, 4.0), uz=(0.0, -0.01))
    with pytest.raises(InputError, match="covers x = 0 to 4 m"):
        equivalent_beam_check(table, extent=(0.0, 5.0), height=5.0)
