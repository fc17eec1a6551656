"""Classical benchmarks of linear elasticity."""

import tomllib
from pathlib import Path

import elastic_benchmarks as benchmarks
import numpy as np
import pytest

from solvers.fem.elements import ElementType

FOLDER = Path(__file__).parents[1] / "oracles"
TARGETS = tomllib.loads((FOLDER / "benchmarks.toml").read_text(encoding="utf-8"))
PATCH = tomllib.loads((FOLDER / "structural.toml").read_text(encoding="utf-8"))["patch_test"]


def test_le1():
    assert benchmarks.nafems_le1() == pytest.approx(TARGETS["le1"]["stress"], rel=0.01)


def test_le10():
    assert benchmarks.nafems_le10() == pytest.approx(TARGETS["le10"]["stress"], rel=0.01)


def test_le11():
    assert benchmarks.nafems_le11() == pytest.approx(TARGETS["le11"]["stress"], rel=0.01)


def test_kirsch():
    assert benchmarks.kirsch() == pytest.approx(TARGETS["kirsch"]["factor"], rel=2e-3)


@pytest.mark.parametrize("element", [ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE])
def test_patch(element):
    stress = benchmarks.patch_test(PATCH["inner_nodes"], element)
    expected = [PATCH["direct_stress"]] * 3 + [PATCH["shear_stress"]] * 3
    assert np.abs(stress - expected).max() < 1e-12 * PATCH["direct_stress"]


def test_re_entrant_corner_has_no_largest_stress():
    # From 16 to 32 elements in an arm; towards the corner's own factor as they shrink.
    assert benchmarks.corner_growth(16) == pytest.approx(TARGETS["corner"]["growth"], rel=0.01)
