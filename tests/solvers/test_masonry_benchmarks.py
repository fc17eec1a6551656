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


@pytest.mark.slow
def test_thick_sphere_yields_to_its_radius():
    values = TARGETS["sphere"]
    found = benchmarks.thick_sphere(values["pressure"], values["front"], steps=1, radial=8, around=4)
    assert found == pytest.approx(values["displacement"], rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "steps"), [(StepMode.IMPLICIT, 20), (StepMode.IMPLEX, 40)])
def test_petersson_beam(mode, steps):
    curve = benchmarks.petersson_beam(SteppingOptions(steps=steps, mode=mode))
    values = TARGETS["beam"]
    found = [curve.at(deflection) for deflection in values["deflection"]]
    assert found == pytest.approx(values["load"], rel=0.05)
