"""Run the benchmarks of the structural half and write `verification.md`: `python docs/verification.py`.

Targets and their sources are in `tests/oracles/`; what is computed is what the tests compute.
"""

import sys
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
TESTS = HERE.parent / "tests"
sys.path.insert(0, str(TESTS))

# The cases are those of the tests, whose folder had to be put on the path first: hence E402.
import elastic_benchmarks as elastic  # noqa: E402
import masonry_benchmarks as masonry  # noqa: E402
import material_point as point  # noqa: E402

from fd2fem.errors import ConvergenceError  # noqa: E402
from solvers.fem.elements import ElementType  # noqa: E402
from solvers.ground.settlement import PeckTrough, settlement_trough  # noqa: E402
from solvers.steps.stepping import StepMode, SteppingOptions  # noqa: E402

PAGE = HERE / "verification.md"

INTRODUCTION = """\
# Verification of the structural half

Written by `python docs/verification.py`, which runs every case; no figure below is typed by hand. The
targets come from outside this code: closed forms, published benchmarks, other programs. They and their
sources in full are in `tests/oracles/`; the same cases, with their tolerances, are tests in `tests/solvers/`.

The difference is relative to the target, or absolute where that is 0. A crack that is "implicit" softens
within a step; with "implex", the strength is foretold from the step before, as in the analysis of a wall.
Elements are 20-node hexahedra in linear elasticity and in the sphere, 8-node ones with incompatible modes in
bar and beam. A case that finds no equilibrium is "nan".
"""

ROUND_OFF = 1e-12
"""Relative differences below this are none."""


@dataclass(frozen=True)
class Row:
    """One line of a table; `target` and `found` in the unit that `case` names."""

    case: str
    source: str
    target: float
    found: float

    def __str__(self) -> str:
        difference = self.found - self.target
        told = f"{100 * difference / abs(self.target):+.2g} %" if self.target else f"{difference:.1g}"
        if abs(difference) <= ROUND_OFF * abs(self.target):
            told = "0"
        return f"| {self.case} | {self.source} | {self.target:.7g} | {self.found:.7g} | {told} |"


Rows = Iterator[Row]


def read_targets(name: str) -> dict[str, Any]:
    """Targets of a file in `tests/oracles`."""
    return tomllib.loads((TESTS / "oracles" / f"{name}.toml").read_text(encoding="utf-8"))


def strength_rows() -> Rows:
    """The masonry law where its strength has a closed form, MPa."""
    values = read_targets("masonry")
    found = -point.triaxial_test(0.0, -0.02).stress[2] / 1e6
    strength = values["uniaxial_compression"]["strength"]
    yield Row("uniaxial compression, MPa", "Mohr-Coulomb", strength, found)
    triaxial = values["triaxial"]
    for confinement, stress in zip(triaxial["confinement"], triaxial["axial_stress"], strict=True):
        found = point.triaxial_test(confinement * 1e6, -0.03).stress[2] / 1e6
        yield Row(f"triaxial compression at {confinement:g} MPa, MPa", "Mohr-Coulomb", stress, found)
    uncracked = point.LAW._replace(eta=0.0)
    found = point.MaterialPoint(uncracked, strength=point.NEVER).move([0, 0, 0, 0.02, 0, 0]).stress[3] / 1e6
    yield Row("pure shear, no cracks, MPa", "Drucker & Prager", values["pure_shear"]["strength"], found)
    found = point.MaterialPoint(strength=point.NEVER).move([0.01, 0.01, 0.01, 0, 0, 0]).stress[0] / 1e6
    yield Row("apex of the cone, no cracks, MPa", "Drucker & Prager", values["apex"]["mean_stress"], found)
    edge = point.MaterialPoint(ductility=np.inf).move([0.016, 0.016, -0.017, 0, 0, 0]).stress[2] / 1e6
    yield Row("edge of cone and two cracks, MPa", "closed form", values["corner"]["least_stress"], edge)


def program_rows() -> Rows:
    """The masonry law against other programs."""
    values = read_targets("masonry")
    aster = values["code_aster"]
    found = point.aster_test(aster, aster["share"])
    for share, stress, (ours, _) in zip(aster["share"], aster["axial_stress"], found, strict=True):
        yield Row(f"softening cone at {100 * share:g} %, MPa", "Code_Aster SSNV168a", stress, ours)
    for share, strain, (_, ours) in zip(aster["share"], aster["p"], found, strict=True):
        yield Row(f"its plastic strain at {100 * share:g} %", "Code_Aster SSNV168a", strain, ours)
    triaxial = values["opensees"]["triaxial"]
    for confinement, lateral in zip(triaxial["confinement"], triaxial["lateral_strain"], strict=True):
        ours = point.triaxial_test(confinement * 1e6, triaxial["axial_strain"]).strain[0]
        yield Row(f"lateral strain at {confinement:g} MPa", "OpenSeesPy DruckerPrager", lateral, ours)
    for number, path in enumerate(values["opensees"]["paths"], start=1):
        ours = path_difference(path)
        yield Row(f"strain path {number}, largest difference, MPa", "OpenSeesPy DruckerPrager", 0.0, ours)
    softening = values["asd_concrete"]
    pulled = point.MaterialPoint(
        ductility=point.MASONRY.fracture_energy / (0.1 * point.MASONRY.tensile_strength)
    )
    ours = [pulled.drive({0: strain}).stress[0] / 1e6 for strain in softening["strain"]]
    worst = float(np.abs(np.subtract(ours, softening["stress"])).max())
    yield Row("softening, largest difference, MPa", "OpenSeesPy ASDConcrete3D", 0.0, worst)


def path_difference(path: dict[str, list[float]]) -> float:
    """Largest difference in stress, MPa, at the end of a strain path."""
    driven = point.MaterialPoint(strength=9.7e6, ductility=np.inf)
    for share in (0.25, 0.5, 0.75, 1.0):
        driven.move(share * np.array(path["strain"]))
    return float(np.abs(driven.stress / 1e6 - path["stress"]).max())


def elastic_rows() -> Rows:
    """Linear elasticity."""
    values, patch = read_targets("benchmarks"), read_targets("structural")["patch_test"]
    expected = [patch["direct_stress"]] * 3 + [patch["shear_stress"]] * 3
    for element in (ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE):
        stress = elastic.patch_test(patch["inner_nodes"], element)
        worst = float(np.abs(stress - expected).max()) / patch["direct_stress"]
        yield Row(f"patch test, {element.value}, largest relative difference", "MacNeal & Harder", 0.0, worst)
    cases: dict[str, Callable[[], float]] = {
        "le1": elastic.nafems_le1,
        "le10": elastic.nafems_le10,
        "le11": elastic.nafems_le11,
    }
    for name, case in cases.items():
        yield Row(f"{name.upper()}, MPa", "NAFEMS", values[name]["stress"] / 1e6, case() / 1e6)
    yield Row("plate with a hole, stress factor", "Kirsch", values["kirsch"]["factor"], elastic.kirsch())
    growth = elastic.corner_growth(16)
    yield Row("re-entrant corner, growth per halving", "Williams", values["corner"]["growth"], growth)


def masonry_rows() -> Rows:
    """Structures that crack or yield."""
    values = read_targets("benchmarks")
    for mode in StepMode:
        options = SteppingOptions(steps=200, mode=mode, tolerance=1e-8)
        for band in values["bar"]["bands"]:
            energy = bar_energy(band, options)
            case = f"bar, cracks {1000 * band:g} mm wide, {mode.value}, N/m"
            yield Row(case, "Bazant & Oh: Gf", values["bar"]["energy"], energy)
    sphere = values["sphere"]
    found = masonry.thick_sphere(sphere["pressure"], sphere["front"], steps=1, radial=8, around=4)
    yield Row("thick sphere, yielding to 150 mm, mm", "Hill", 1e3 * sphere["displacement"], 1e3 * found)
    beam = values["beam"]
    for mode, steps in ((StepMode.IMPLICIT, 20), (StepMode.IMPLEX, 40)):
        curve = masonry.petersson_beam(SteppingOptions(steps=steps, mode=mode))
        for deflection, load in zip(beam["deflection"], beam["load"], strict=True):
            case = f"notched beam at {1e3 * deflection:g} mm, {mode.value}, N"
            yield Row(case, "Petersson; Code_Aster SSNP166a", load, curve.at(deflection))


def bar_energy(band: float, options: SteppingOptions) -> float:
    """Energy that the bar's crack takes, N/m; nan where an equilibrium is not found."""
    try:
        return masonry.crack_band_bar(band, options).dissipated
    except ConvergenceError:
        return float("nan")


def trough_rows() -> Rows:
    """The settlement trough of a tunnel."""
    values = read_targets("structural")["trough"]
    trough = settlement_trough(
        PeckTrough(values["volume_loss"], values["diameter"], values["depth"], k=values["k"])
    )
    yield Row("trough, distance to the inflection, m", "Peck; O'Reilly & New", values["width"], trough.width)
    yield Row("trough, largest settlement, mm", "Peck", 1e3 * values["smax"], 1e3 * trough.smax)


SECTIONS: dict[str, Callable[[], Rows]] = {
    "Masonry at a point: closed forms": strength_rows,
    "Masonry at a point: other programs": program_rows,
    "Linear elasticity": elastic_rows,
    "Structures that crack or yield": masonry_rows,
    "Ground": trough_rows,
}


def table(rows: Rows) -> str:
    """A table of Markdown."""
    head = "| Case | Source | Target | Ours | Difference |\n|---|---|---:|---:|---:|"
    return "\n".join([head, *map(str, rows)])


def main() -> None:
    """Run all cases and write the page."""
    parts = [INTRODUCTION]
    for title, rows in SECTIONS.items():
        parts.append(f"## {title}\n\n{table(rows())}\n")
    PAGE.write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
