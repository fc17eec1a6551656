"""Masonry that cracks, step by step, beside OpenSees on the same mesh.

``python benchmarks/cracking.py MESH ELEMENT`` analyses a mesh file: the process that is measured.
"""

import os
import sys
from pathlib import Path

import numpy as np
from opensees_wall import Result, analyse_fresh, installed, wall_job
from timing import Seconds, head, row, timed_process

from fd2fem.drawings import stand_in
from fd2fem.meshing import MeshOptions, mesh_facade, read_mesh, write_mesh
from fd2fem.model import Response, VolumeMesh
from solvers import (
    AnalysisOptions,
    MasonryLaw,
    SteppingOptions,
    analyse,
    read_response,
    write_response,
)
from solvers.fem.elements import ElementType

SIZES = (0.25, 0.125)
"""Element edges, m, in Building 1: 1,132 and 6,600 elements."""
LARGE_SIZE = 0.0833
"""17,608 elements; ours alone."""
STEPS = 50
PARTS = ("material", "assembly", "solve", "other")
ENVIRONMENT = {"OMP_NUM_THREADS": str(os.cpu_count())}
"""Of the processes that are measured, where the caller's does not say otherwise."""


def wall_options(element: ElementType) -> AnalysisOptions:
    """The paper's masonry and settlement."""
    return AnalysisOptions(element=element, masonry=MasonryLaw(), stepping=SteppingOptions(steps=STEPS))


def analyse_here(path: str, element: str) -> None:
    """Mesh file to response on disk, in this process."""
    response = analyse(read_mesh(Path(path)), options=wall_options(ElementType(element)))
    write_response(response, Path(path).with_suffix(""))


def ours_fresh(mesh: VolumeMesh, element: ElementType, folder: Path) -> tuple[Response, Seconds]:
    """The same in a process of its own."""
    write_mesh(mesh, folder / "wall.msh")
    command = [sys.executable, __file__, str(folder / "wall.msh"), element.value]
    seconds = timed_process(command, folder, ENVIRONMENT | os.environ)
    return read_response(folder / "wall"), seconds


def print_iterations(response: Response) -> None:
    """Where the time of an iteration goes."""
    count = response.solver["iterations"]
    parts = "  ".join(f"{name} {response.timings[name] / count:.4f}" for name in PARTS)
    steps = response.solver["steps"]
    print(f"  {steps} steps, {count} iterations; wall s of one: {parts}; {response.solver['name']}")


def print_agreement(response: Response, peer: Result) -> None:
    """How near the two answers are."""
    difference = np.linalg.norm(response.displacement - peer.displacement)
    share = difference / np.linalg.norm(peer.displacement)
    opening = response.crack_opening.max(), peer.opening.mean(axis=1).max()
    print(
        f"  {peer.iterations} iterations of the peer, wall s of one: {peer.seconds / peer.iterations:.4f}; "
        f"displacements differ by {share:.1e} (L2); widest crack, mm: "
        f"{1e3 * opening[0]:.2f} and {1e3 * opening[1]:.2f}"
    )


def compared(mesh: VolumeMesh, folder: Path) -> None:
    """A mesh by both, in the element that both have."""
    element = ElementType.HEXAHEDRON8
    title = f"{len(mesh.elements):,} elements, {element}"
    response, ours = ours_fresh(mesh, element, folder)
    if installed():
        peer, seconds = analyse_fresh(wall_job(mesh, wall_options(element)), folder)
        row(title, ours, "OpenSees, ASDConcrete3D, stdBrick", seconds)
        print_agreement(response, peer)
    else:
        print(f"{title:34s} {ours.cpu:8.3f} {ours.wall:8.3f}   openseespy is not installed: skipped")
    print_iterations(response)


def alone(mesh: VolumeMesh, folder: Path) -> None:
    """A mesh by ours, in the element that walls are analysed with."""
    response, ours = ours_fresh(mesh, ElementType.INCOMPATIBLE, folder)
    title = f"{len(mesh.elements):,} elements, {ElementType.INCOMPATIBLE}"
    print(f"{title:34s} {ours.cpu:8.3f} {ours.wall:8.3f}")
    print_iterations(response)


def cracking(folder: Path, *, large: bool) -> None:
    """A mesh file to results on disk, whole processes, beside OpenSees on the same mesh."""
    head(f"Masonry that cracks, {STEPS} steps from file to file (Building 1)")
    # Compiles what is not compiled yet, once per machine.
    ours_fresh(
        mesh_facade(stand_in("building1"), options=MeshOptions(size=0.5)), ElementType.HEXAHEDRON8, folder
    )
    for size in SIZES:
        mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=size))
        compared(mesh, folder)
        alone(mesh, folder)
    if large:
        alone(mesh_facade(stand_in("building1"), options=MeshOptions(size=LARGE_SIZE)), folder)


if __name__ == "__main__":
    analyse_here(*sys.argv[1:])
