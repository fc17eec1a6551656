"""Classes of damage against the tables that define them."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.errors import InputError
from solvers.damage.classes import (
    DamageClass,
    assess_damage,
    assessment_to_dict,
    crack_damage_class,
    crack_damage_parameter,
    distortion_damage_class,
    distortion_strain,
    rankin_negligible,
    strain_damage_class,
    strain_label,
)

ORACLES = tomllib.loads((Path(__file__).parents[2] / "oracles" / "damage.toml").read_text(encoding="utf-8"))
STRAINS = st.floats(-0.05, 0.05)


@pytest.mark.parametrize(("strain", "number"), ORACLES["strain_class"]["rows"])
def test_class_by_strain(strain, number):
    assert strain_damage_class(strain) == number


@pytest.mark.parametrize(("widths", "number"), ORACLES["crack_class"]["rows"])
def test_class_by_cracks(widths, number):
    assert crack_damage_class(widths) == number


@pytest.mark.parametrize(("strain", "number"), ORACLES["distortion"]["rows"])
def test_class_by_distortion(strain, number):
    assert distortion_damage_class(strain) == number


def test_names_of_the_classes():
    names = "negligible", "very slight", "slight", "moderate", "severe", "very severe"
    assert tuple(one.label for one in DamageClass) == names
    assert strain_label(DamageClass.SEVERE) == "severe to very severe"


def test_principal_strain_of_the_worked_example():
    oracle = ORACLES["distortion"]
    strain = distortion_strain(oracle["angular_distortion"], oracle["lateral_strain"])
    assert strain == pytest.approx(oracle["principal_strain"], rel=5e-7)


@given(distortion=STRAINS, lateral=STRAINS)
def test_principal_strain_is_the_largest_over_all_directions(distortion, lateral):
    theta = np.linspace(-np.pi / 2, np.pi / 2, 721)
    around = lateral * np.cos(theta) ** 2 + distortion * np.sin(theta) * np.cos(theta)
    strain = distortion_strain(distortion, lateral)
    assert strain >= around.max() - 1e-15
    # Half a degree at most from the extreme of a curve with curvature 2 (strain - lateral / 2).
    assert strain == pytest.approx(around.max(), abs=1e-4 * (abs(distortion) + abs(lateral)) + 1e-15)
    angle = np.arctan2(distortion, lateral) / 2
    formula = lateral * np.cos(angle) ** 2 + distortion * np.sin(angle) * np.cos(angle)
    assert strain == pytest.approx(formula, abs=1e-15)


@pytest.mark.parametrize(("settlement", "slope", "passes"), [(0.99, 0.99, 1), (1.01, 0.5, 0), (0.5, 1.01, 0)])
def test_first_screen(settlement, slope, passes):
    oracle = ORACLES["rankin"]
    assert rankin_negligible(settlement * oracle["settlement"], -slope * oracle["slope"]) == bool(passes)


@pytest.mark.parametrize(("widths", "lengths", "psi"), ORACLES["crack_parameter"]["rows"])
def test_crack_parameter(widths, lengths, psi):
    assert crack_damage_parameter(widths, lengths) == pytest.approx(psi, rel=1e-6)


def test_no_crack_is_no_damage():
    assert crack_damage_parameter([], []) == 0.0
    assert crack_damage_parameter([0.0], [1.0]) == 0.0


@given(a=STRAINS, b=STRAINS)
def test_more_strain_is_never_less_damage(a, b):
    low, high = sorted((a, b))
    assert strain_damage_class(low) <= strain_damage_class(high)
    assert distortion_damage_class(low) <= distortion_damage_class(high)


@given(widths=st.lists(st.floats(0, 0.05), max_size=6), another=st.floats(0, 0.05))
def test_another_crack_is_never_less_damage(widths, another):
    assert crack_damage_class(widths) <= crack_damage_class([*widths, another])


def test_assessment_in_json():
    damage = assess_damage(tensile_strain=0.4e-2, crack_widths=[2e-3, 30e-3])
    text = json.dumps(assessment_to_dict(damage), allow_nan=False)
    assert json.loads(text) == {
        "tensile_strain": 0.004,
        "strain_class": 4,
        "strain_label": "severe to very severe",
        "crack_width": 0.03,
        "crack_class": 5,
        "crack_label": "very severe",
    }


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: strain_damage_class(float("nan")), "not a number"),
        (lambda: distortion_damage_class(float("nan")), "not a number"),
        (lambda: crack_damage_class([1e-3, -1e-3]), "'widths': -0.001 m is negative"),
        (lambda: crack_damage_class([float("nan")]), "'widths': 1 of 1 values are not finite"),
        (lambda: crack_damage_class([[1e-3]]), "'widths': expected shape"),
        (lambda: crack_damage_parameter([1e-3], []), "'lengths': 0 values for 1 widths"),
        (lambda: assess_damage(tensile_strain=0.0, crack_widths=[-1.0]), "'crack_widths'"),
    ],
)
def test_damage_refuses(make, message):
    with pytest.raises(InputError, match=message):
        make()
