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


ELEMENTS = [ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE, ElementType.TETRA10]


@pytest.mark.parametrize("element", ELEMENTS)
def test_le1(element):
    assert benchmarks.nafems_le1(element) == pytest.approx(TARGETS["le1"]["stress"], rel=0.02)


@pytest.mark.parametrize(
    "element", [ELEMENTS[0], *(pytest.param(element, marks=pytest.mark.slow) for element in ELEMENTS[1:])]
)
def test_le10(element):
    assert benchmarks.nafems_le10(element) == pytest.approx(TARGETS["le10"]["stress"], rel=0.02)


@pytest.mark.parametrize("element", ELEMENTS)
def test_le11(element):
    assert benchmarks.nafems_le11(element) == pytest.approx(TARGETS["le11"]["stress"], rel=0.02)


@pytest.mark.parametrize("element", ELEMENTS)
def test_kirsch(element):
    assert benchmarks.kirsch(element) == pytest.approx(TARGETS["kirsch"]["factor"], rel=0.01)


@pytest.mark.parametrize(
    ("element", "ratio"),
    [(element, 1.0) for element in ELEMENTS] + [(ElementType.HEXAHEDRON8, 1.0 / 1.5)],
)
def test_cantilever_one_element_deep(element, ratio):
    assert benchmarks.cantilever(element, 1) == pytest.approx(ratio, rel=0.01)


@pytest.mark.parametrize("element", [ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE])
def test_patch(element):
    stress = benchmarks.patch_test(PATCH["inner_nodes"], element)
    expected = [PATCH["direct_stress"]] * 3 + [PATCH["shear_stress"]] * 3
    assert np.abs(stress - expected).max() < 1e-12 * PATCH["direct_stress"]


def test_re_entrant_corner_has_no_largest_stress():
    # From 16 to 32 elements in an arm; towards the corner's own factor as they shrink.
    assert benchmarks.corner_growth(16) == pytest.approx(TARGETS["corner"]["growth"], rel=0.01)
