"""A wall of masonry that cracks, analysed by OpenSees: the mesh, the load and the softening of ours.

OpenSees has no law like ours. ``ASDConcrete3D`` (M. Petracca, G. Camata) is one of damage, d+ in tension and
d- in compression, that takes any softening curve. It is given ours, with the crack band of each element, and
is told what becomes of a crack whose stress falls. Three things stay different:

- It takes the equivalent tensile stress from Lubliner's surface for a compressive strength of ten times the
  tensile one, so that pressure across a crack's direction lowers the strength: by s3 / (10 ft), about.
- Damage grows point by point; ours is the same in all of an element.
- Stress is damaged by the sign of the undamaged one. A wide crack stretches the point so much that this one
  pulls in all directions: a wide crack carries no pressure along itself either, where ours does.

``python benchmarks/opensees_wall.py JOB RESULT`` analyses one wall: the process that is measured. It needs
nothing but numpy and openseespy, which may also stand where PYTHONPATH says.
"""

import os
import sys
from dataclasses import asdict, dataclass, fields
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from timing import Seconds

    from fd2fem.model import VolumeMesh
    from solvers import AnalysisOptions

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

COMPRESSIVE_STRENGTH = 26e6
"""So far beyond what walls bear that the law stays elastic in compression."""
FLOOR = 1e-3
"""Part of the tensile strength that a wide crack keeps, as in ours."""
CURVE_POINTS = 48
"""Of the softening curve, between which OpenSees interpolates; it takes 0.3 % more energy by that."""
BALANCED = 1e-2
"""Norm of the forces out of balance, N, at which an iteration ends."""
TETRAHEDRA = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
"""Six that make up a hexahedron with plane facets."""


class Unloading(StrEnum):
    """What becomes of a crack whose stress falls: it stays open (plastic strain), or closes (damage)."""

    OPEN = "open"
    CLOSED = "closed"


@dataclass(frozen=True, eq=False)
class Job:
    """A wall to be analysed.

    Attributes
    ----------
    nodes : (n, 3) float array, m
    elements : (e, 8) int array
    base : (k,) int array
        Nodes of the base.
    settled : (k, 3) float array, m
        Their displacement when all of the settlement is applied.
    young, poisson, density : float, SI units
    strength, fracture_energy : float, Pa and N/m
        In tension.
    gravity : float, m/s²
    unloading : str
    steps : int
        Of the settlement.
    """

    nodes: FloatArray
    elements: IntArray
    base: IntArray
    settled: FloatArray
    young: float = 3.48e9
    poisson: float = 0.16
    density: float = 1900.0
    strength: float = 1.15e6
    fracture_energy: float = 100.0
    gravity: float = 9.81
    unloading: str = Unloading.OPEN.value
    steps: int = 50


@dataclass(frozen=True, eq=False)
class Result:
    """What OpenSees found.

    Attributes
    ----------
    displacement : (n, 3) float array, m
    reaction : (k, 3) float array, N
        At the base's nodes; by IMPL-EX, of stresses that are a little out of balance.
    stress : (e, 8, 6) float array, Pa
        At the integration points.
    opening : (e, 8) float array, m
        Crack strain times the crack band, at the integration points.
    largest_stress : (steps + 1,) float array, Pa
        Largest σ1 at a point in each step, the self-weight first.
    iterations : int
        Equations solved.
    seconds : float
        Wall seconds of the steps, without setting up and without reading results.
    """

    displacement: FloatArray
    reaction: FloatArray
    stress: FloatArray
    opening: FloatArray
    largest_stress: FloatArray
    iterations: int
    seconds: float


def write_record(record: Job | Result, path: Path) -> None:
    """A job or a result to a file."""
    np.savez(path, **asdict(record))


def read_record(kind: type[Any], path: Path) -> Any:
    """The same from a file."""
    with np.load(path) as arrays:
        values = {item.name: arrays[item.name] for item in fields(kind)}
    return kind(**{name: value if value.ndim else value.item() for name, value in values.items()})


def installed() -> bool:
    """Whether there is an OpenSees to compare with."""
    return find_spec("openseespy") is not None


def wall_job(mesh: "VolumeMesh", options: "AnalysisOptions", *, unloading: Unloading = Unloading.OPEN) -> Job:
    """What OpenSees is to do for the same wall, tied to the same ground, in as many steps."""
    from solvers import MasonryLaw, base_displacement

    law, base, x = options.masonry or MasonryLaw(), mesh.group_nodes("base"), mesh.nodes[:, 0]
    return Job(
        nodes=mesh.nodes,
        elements=mesh.elements,
        base=base,
        settled=base_displacement(options.settlement, x[base], extent=(x.min(), x.max())),
        young=options.material.young,
        poisson=options.material.poisson,
        density=options.material.density,
        strength=law.tensile_strength,
        fracture_energy=law.fracture_energy,
        gravity=options.gravity,
        unloading=unloading.value,
        steps=options.stepping.steps,
    )


def analyse_fresh(job: Job, folder: Path) -> "tuple[Result, Seconds]":
    """Analyse a wall in a process of its own."""
    from timing import timed_process

    write_record(job, folder / "job.npz")
    command = [sys.executable, __file__, str(folder / "job.npz"), str(folder / "result.npz")]
    seconds = timed_process(command, folder, dict(os.environ))
    return read_record(Result, folder / "result.npz"), seconds


def crack_bands(nodes: FloatArray, elements: IntArray) -> FloatArray:
    """Cube root (e,), m, of the volume of each element, as ours."""
    corners = nodes[elements[:, TETRAHEDRA]]
    edges = corners[:, :, 1:] - corners[:, :, :1]
    return np.asarray(np.cbrt(np.linalg.det(edges).sum(axis=1) / 6.0))


def softening_curve(job: Job, band: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Crack strain, stress and damage of a bar under tension, from the peak on.

    The stress is that of ours, ft exp(-crack strain · band · ft / Gf).
    """
    decay = np.linspace(0.0, -np.log(FLOOR), CURVE_POINTS)
    crack = decay * job.fracture_energy / (band * job.strength)
    stress = job.strength * np.exp(-decay)
    if job.unloading == Unloading.OPEN:
        return crack, stress, np.zeros(CURVE_POINTS)
    return crack, stress, 1.0 - stress / (stress + job.young * crack)


def add_element(ops: Any, job: Job, number: int, band: float) -> None:
    """An element and its material, of the same number; numbers count from 1."""
    crack, stress, damage = softening_curve(job, band)
    strain = stress / job.young + crack
    tension = [
        argument
        for flag, values in (("-Te", strain), ("-Ts", stress), ("-Td", damage))
        for argument in (flag, 0.0, *values.tolist())
    ]
    peak = COMPRESSIVE_STRENGTH / job.young
    compression = [
        "-Ce",
        0.0,
        peak,
        2.0 * peak,
        "-Cs",
        0.0,
        *2 * [COMPRESSIVE_STRENGTH],
        "-Cd",
        0.0,
        0.0,
        0.0,
    ]
    ops.nDMaterial("ASDConcrete3D", number, job.young, job.poisson, *tension, *compression, "-implex")
    nodes = (job.elements[number - 1] + 1).tolist()
    ops.element("stdBrick", number, *nodes, number, 0.0, 0.0, -job.density * job.gravity)


def build(ops: Any, job: Job, bands: FloatArray) -> None:
    """The wall, and a load in steps of one unit of time: two of self-weight, then the settlement.

    IMPL-EX extrapolates from the last two steps: the second step of self-weight lets it begin at rest.
    """
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    for number, place in enumerate(job.nodes.tolist(), start=1):
        ops.node(number, *place)
    for number, band in enumerate(bands.tolist(), start=1):
        add_element(ops, job, number, band)
    end = 1.0 + 1.0 / job.steps
    ops.timeSeries("Path", 1, "-time", 0.0, 2.0, 3.0 + job.steps, "-values", 0.0, 0.0, end)
    ops.pattern("Plain", 1, 1)
    for node, moved in zip((job.base + 1).tolist(), job.settled.tolist(), strict=True):
        for axis, value in enumerate(moved, start=1):
            ops.sp(node, axis, value)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("Mumps")
    ops.test("NormUnbalance", BALANCED, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static", "-noWarnings")


def stresses(ops: Any, count: int) -> FloatArray:
    """Stresses (e, 8, 6), Pa: xx, yy, zz, xy, yz, xz."""
    rows = [ops.eleResponse(number, "stresses") for number in range(1, count + 1)]
    return np.array(rows).reshape(count, 8, 6)


def first_principal(stress: FloatArray) -> FloatArray:
    """Largest principal stress of (..., 6)."""
    tensors = stress[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*stress.shape[:-1], 3, 3)
    return np.asarray(np.linalg.eigvalsh(tensors)[..., 2])


def openings(ops: Any, job: Job, bands: FloatArray) -> FloatArray:
    """Openings (e, 8), m, from the equivalent strains: what of them is not elastic, times the band."""
    found = []
    for number, band in enumerate(bands, start=1):
        crack, stress, _ = softening_curve(job, band)
        strain = stress / job.young + crack
        points = [
            ops.eleResponse(number, "material", str(n), "equivalentTotalStrain")[0] for n in range(1, 9)
        ]
        beyond = np.maximum(np.array(points) - strain[-1], 0.0)
        found.append(band * (np.interp(points, strain, crack) + beyond))
    return np.array(found)


def analyse_here(job: Job) -> Result:
    """Analyse a wall in this process."""
    import openseespy.opensees as ops

    bands = crack_bands(job.nodes, job.elements)
    build(ops, job, bands)
    largest, iterations, seconds = [], 0, 0.0
    for step in range(-1, job.steps + 1):
        start = perf_counter()
        if ops.analyze(1) != 0:
            msg = f"OpenSees found no equilibrium in step {step} of {job.steps}."
            raise RuntimeError(msg)
        seconds += perf_counter() - start
        iterations += ops.testIter()
        if step >= 0:
            largest.append(float(first_principal(stresses(ops, len(bands))).max()))
    ops.reactions()
    return Result(
        displacement=np.array([ops.nodeDisp(number) for number in range(1, len(job.nodes) + 1)]),
        reaction=np.array([ops.nodeReaction(number) for number in (job.base + 1).tolist()]),
        stress=stresses(ops, len(bands)),
        opening=openings(ops, job, bands),
        largest_stress=np.array(largest),
        iterations=iterations,
        seconds=seconds,
    )


if __name__ == "__main__":
    write_record(analyse_here(read_record(Job, Path(sys.argv[1]))), Path(sys.argv[2]))
