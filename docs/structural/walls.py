"""Walls that crack, for the pages: what is run, what is kept of it, and its figures."""

from collections import deque
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.drawings import stand_in
from fd2fem.drawings.facade_toml import facade_from_toml
from fd2fem.errors import ConvergenceError
from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.model import ElementKind, Facade, VolumeMesh
from solvers import (
    AnalysisOptions,
    BaseKind,
    BaseOptions,
    LinearSettlement,
    MasonryLaw,
    PeckTrough,
    principal_stress,
    swap_horizontal,
)
from solvers.damage.bays import bay_strain
from solvers.damage.classes import assess_damage
from solvers.damage.cracks import crack_widths, element_cracks
from solvers.ground.settlement import Settlement
from solvers.steps.masonry_analysis import StepAnalysis, prepare, snapshots
from solvers.steps.stepping import Snapshot

FloatArray = NDArray[np.float64]

RECORD = Path(__file__).with_name("walls.json")
"""Figures of all cases, as last run."""

FAILED = "failed"
"""Under this key stands why a case has no figures."""

TROUGH_WALL = """
name = "wall over a trough"
source = "made up: two storeys of three windows, no door"
units = "m"
length = 9.0
height = 6.0
thickness = 0.35
openings = [
    { kind = "window", x = 1.0, z = 1.0, width = 1.0, height = 1.25 },
    { kind = "window", x = 4.0, z = 1.0, width = 1.0, height = 1.25 },
    { kind = "window", x = 7.0, z = 1.0, width = 1.0, height = 1.25 },
    { kind = "window", x = 1.0, z = 3.75, width = 1.0, height = 1.25 },
    { kind = "window", x = 4.0, z = 3.75, width = 1.0, height = 1.25 },
    { kind = "window", x = 7.0, z = 3.75, width = 1.0, height = 1.25 },
]
"""
TROUGH = PeckTrough(volume_loss=0.01, diameter=6.0, depth=10.0, k=0.5, centre=2.0)
"""Sags under the left third of that wall and hogs under the rest."""
GENTLE = replace(TROUGH, volume_loss=0.005)
"""The same with half of the settlement, for the joints under the base."""

FIELDS = ("displacement", "opening", "normal", "dissipated")

PAPER = LinearSettlement()
SWAPPED = swap_horizontal(PAPER)


@dataclass(frozen=True)
class Case:
    """A wall, its elements, and what happens to it."""

    wall: str
    size: float
    settlement: Settlement
    energy: float = 100.0
    base: BaseKind = BaseKind.TIED

    def facade(self) -> Facade:
        """The wall as drawn."""
        if self.wall == "trough":
            return facade_from_toml(TROUGH_WALL, source="docs/structural/walls.py")
        return stand_in(self.wall)

    def options(self) -> AnalysisOptions:
        """Of the analysis: the defaults but for what the case says."""
        return AnalysisOptions(
            settlement=self.settlement,
            masonry=MasonryLaw(fracture_energy=self.energy),
            base=BaseOptions(kind=self.base),
        )


@dataclass(frozen=True, eq=False)
class Run:
    """What is drawn: of each element how far its crack is open, m, its normal, and the energy it took, J."""

    mesh: VolumeMesh
    displacement: FloatArray
    opening: FloatArray
    normal: FloatArray
    dissipated: FloatArray


def building_cases() -> dict[str, Case]:
    """Building 1 under both readings of its horizontal movement."""
    cases = {
        f"building1 {letter} {size:.4g}": Case("building1", size, settlement)
        for letter, settlement in (("a", PAPER), ("b", SWAPPED))
        for size in (0.25, 0.175, 0.125, 1 / 12)
    }
    for energy in (1.0, 50.0, 200.0):
        cases[f"building1 a 0.25 Gf {energy:g}"] = Case("building1", 0.25, PAPER, energy)
    return cases


def trough_cases() -> dict[str, Case]:
    """A wall over a trough: four joints between it and the ground."""
    return {f"trough {kind.value} 0.25": Case("trough", 0.25, GENTLE, base=kind) for kind in BaseKind}


def run_case(case: Case) -> tuple[dict[str, object], Run | None]:
    """Run a case; its figures, as JSON values, and what is drawn. One that finds no equilibrium has none."""
    mesh = mesh_facade(case.facade(), options=MeshOptions(size=case.size))
    analysis = prepare(mesh, options=case.options())
    try:
        (last,) = deque(snapshots(analysis), maxlen=1)
    except ConvergenceError as error:
        return {"elements": len(mesh.elements), FAILED: str(error)}, None
    model = analysis.tangent.model
    cracks = element_cracks(last.fields.crack, model.volumes, model.band)
    displacement = last.motion.displacement[: len(mesh.nodes)]
    run = Run(mesh, displacement, cracks.opening, cracks.normal, last.dissipated)
    return figures(analysis, last, run), run


def figures(analysis: StepAnalysis, last: Snapshot, run: Run) -> dict[str, object]:
    """Of the last state; stresses are those at integration points."""
    history, record, mesh = last.history, last.history[-1], analysis.mesh
    sigma = principal_stress(last.fields.stress)[..., 0]
    volume = analysis.tangent.model.volumes
    p99 = np.percentile(sigma.ravel(), 99, weights=volume.ravel(), method="inverted_cdf")
    widths = crack_widths(mesh, run.opening)
    strain = bay_strain(mesh, run.displacement)
    damage = assess_damage(tensile_strain=strain, crack_widths=widths if len(widths) else [0.0])
    gap = run.displacement[analysis.tangent.model.support.points, 2] - analysis.settled[:, 2]
    return {
        "elements": len(mesh.elements),
        "steps": len(history) - 1,
        "iterations": sum(step.iterations for step in history),
        "displacement": record.max_displacement,
        "sigma_last": record.max_principal_stress,
        "sigma_all": max(step.max_principal_stress for step in history),
        "sigma_p99": float(p99),
        "sigma_rms": float(np.sqrt(np.average(sigma**2, weights=volume))),
        "feet": foot_forces(analysis, last).tolist(),
        "strain_energy": record.strain_energy,
        "dissipated": record.dissipated_energy,
        "opening": float(run.opening.max()),
        "visible_cracks": len(widths),
        "strain": strain,
        "strain_class": int(damage.strain_class),
        "crack_class": int(damage.crack_class),
        "gap": float(gap.max()),
    }


def foot_forces(analysis: StepAnalysis, last: Snapshot) -> FloatArray:
    """Forces (2, 3), N, of the ground on the left and the right half of the base."""
    points = analysis.tangent.model.support.points
    force = (last.force - analysis.tangent.model.weight).reshape(-1, 3)[points]
    x = analysis.space.points[points, 0]
    left = x < (x.min() + x.max()) / 2
    return np.array([force[left].sum(axis=0), force[~left].sum(axis=0)])


def write_run(run: Run, path: Path) -> None:
    """Keep what is drawn."""
    mesh = {"nodes": run.mesh.nodes, "elements": run.mesh.elements, "base": run.mesh.groups["base"]}
    np.savez(path, **mesh, **{name: getattr(run, name) for name in FIELDS})


def read_run(path: Path) -> Run:
    """What was kept."""
    with np.load(path) as kept:
        mesh = VolumeMesh(kept["nodes"], kept["elements"], ElementKind.HEXAHEDRON, {"base": kept["base"]})
        return Run(mesh, *(kept[name] for name in FIELDS))
