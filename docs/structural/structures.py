"""Structures that crack or yield."""

import masonry_benchmarks as benchmarks
import numpy as np

from fd2fem.errors import ConvergenceError
from solvers.steps.stepping import StepMode, SteppingOptions
from structural.rows import Row, Rows, read_targets


def bar_rows() -> Rows:
    """A bar that is pulled until it is broken."""
    values = read_targets("benchmarks")["bar"]
    for mode in StepMode:
        options = SteppingOptions(steps=200, mode=mode, tolerance=1e-8)
        for band in values["bands"]:
            case = f"bar, cracks {1000 * band:g} mm wide, {mode.value}, N/m"
            yield Row(case, "Bazant & Oh: Gf", values["energy"], bar_energy(band, options))


def bar_energy(band: float, options: SteppingOptions) -> float:
    """Energy that the bar's crack takes, N/m; nan where an equilibrium is not found."""
    try:
        return benchmarks.crack_band_bar(band, options).dissipated
    except ConvergenceError:
        return float("nan")


PUSHES = (0.55e-3, 0.575e-3, 0.6e-3, 2e-3, 4e-3, 8e-3, 11e-3, 14e-3, 20e-3)
"""Of the sphere's inner face, m: yielding passes 150 mm between the first two; the last are at the limit."""


def sphere_rows() -> Rows:
    """A thick sphere under inner pressure, whose cone is Mohr and Coulomb's."""
    values = read_targets("benchmarks")["sphere"]
    found = benchmarks.first_yield(radial=8, around=4)
    yield Row("thick sphere, first yield, MPa", "Hill", values["first_yield"] / 1e6, found / 1e6)
    path = benchmarks.pushed_sphere(PUSHES, values["front"], radial=8, around=3)
    outer, pressure = [state.outer for state in path], [state.pressure for state in path]
    found = float(np.interp(values["displacement"], outer, pressure))
    case = "its pressure when it has yielded to 150 mm, MPa"
    yield Row(case, "Hill", values["pressure"] / 1e6, found / 1e6)
    found = benchmarks.thick_sphere(values["pressure"], values["front"], radial=12, around=6)
    yield Row("its outer displacement then, mm", "Hill", 1e3 * values["displacement"], 1e3 * found)
    yield Row("its largest pressure, MPa", "Hill", values["limit"] / 1e6, max(pressure) / 1e6)


def beam_rows() -> Rows:
    """Petersson's notched beam."""
    values = read_targets("benchmarks")["beam"]
    for mode, steps in ((StepMode.IMPLICIT, 20), (StepMode.IMPLEX, 40)):
        curve = benchmarks.petersson_beam(SteppingOptions(steps=steps, mode=mode))
        for deflection, load in zip(values["deflection"], values["load"], strict=True):
            case = f"notched beam at {1e3 * deflection:g} mm, {mode.value}, N"
            yield Row(case, "Petersson; Code_Aster SSNP166a", load, curve.at(deflection))


def structure_rows() -> Rows:
    """All of them."""
    yield from bar_rows()
    yield from sphere_rows()
    yield from beam_rows()
