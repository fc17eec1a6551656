"""Structures that crack or yield, against closed forms and a cohesive crack."""

import tomllib
from pathlib import Path

import masonry_benchmarks as benchmarks
import numpy as np
import pytest
from material_point import LAW, cone_value

from solvers.steps.stepping import StepMode, SteppingOptions

ORACLES = Path(__file__).parents[1] / "oracles"
TARGETS = tomllib.loads((ORACLES / "benchmarks.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("mode", StepMode)
@pytest.mark.parametrize("band", TARGETS["bar"]["bands"])
def test_crack_band_takes_the_fracture_energy(band, mode):
    options = SteppingOptions(steps=200, mode=mode, tolerance=1e-8)
    bar = benchmarks.crack_band_bar(band, options)
    assert bar.dissipated == pytest.approx(TARGETS["bar"]["energy"], rel=0.01)
    # Independent of the first: the force at the end times its way, less what is still elastic.
    assert bar.work == pytest.approx(TARGETS["bar"]["energy"], rel=0.01)


def test_thick_sphere_first_yields_inside():
    # Lamé: radial -p, hoop p (b³ + 2 a³) / (2 (b³ - a³)).
    inner, outer = benchmarks.INNER**3, benchmarks.OUTER**3
    pressure = TARGETS["sphere"]["first_yield"]
    hoop = pressure * (outer + 2 * inner) / (2 * (outer - inner))
    assert cone_value(np.array([hoop, hoop, -pressure])) == pytest.approx(0.0, abs=1e-6 * LAW.cone)


def test_thick_sphere_of_elements_first_yields():
    found = benchmarks.first_yield(radial=6, around=3)
    assert found == pytest.approx(TARGETS["sphere"]["first_yield"], rel=1e-3)


@pytest.mark.slow
def test_thick_sphere_yields_to_its_radius():
    values = TARGETS["sphere"]
    found = benchmarks.thick_sphere(values["pressure"], values["front"], radial=8, around=4)
    assert found == pytest.approx(values["displacement"], rel=1e-4)


@pytest.mark.slow
def test_thick_sphere_to_its_limit():
    values = TARGETS["sphere"]
    pushes = [0.55e-3, 0.575e-3, 0.6e-3, 2e-3, 4e-3, 8e-3, 11e-3, 14e-3, 20e-3]
    path = benchmarks.pushed_sphere(pushes, values["front"], radial=6, around=2)
    outer, pressure = [state.outer for state in path], [state.pressure for state in path]
    # Two elements over an eighth of a turn: three digits.
    assert np.interp(values["displacement"], outer, pressure) == pytest.approx(values["pressure"], rel=2e-3)
    assert max(pressure) == pytest.approx(values["limit"], rel=2e-3)
    # There it stays: all of the sphere yields.
    assert pressure[-1] == pytest.approx(pressure[-2], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "steps"), [(StepMode.IMPLICIT, 20), (StepMode.IMPLEX, 40)])
def test_petersson_beam(mode, steps):
    curve = benchmarks.petersson_beam(SteppingOptions(steps=steps, mode=mode))
    values = TARGETS["beam"]
    found = [curve.at(deflection) for deflection in values["deflection"]]
    assert found == pytest.approx(values["load"], rel=0.05)
