"""Record what OpenSees finds for small walls: ``python benchmarks/record_opensees.py > opensees_wall.toml``.

The walls are grids of whole elements, so that a test can build them without a mesher, and their masonry is
so tough that elements as coarse as these do not snap back.
"""

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from opensees_wall import Job, Result, Unloading, analyse_fresh, wall_job

from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.model import Facade, Opening, OpeningKind, VolumeMesh, rectangle
from solvers import AnalysisOptions, LinearSettlement, MasonryLaw, PeckTrough, Settlement, SteppingOptions

STEPS = 200
FRACTURE_ENERGY = 200.0
OPEN = 1e-6
"""Narrower cracks, m, are not recorded."""
HEAD = """\
# Small walls of masonry that cracks, by another program: made by benchmarks/record_opensees.py with
# OpenSeesPy 3.7.1 (openseespylinux 3.7.1.2), nDMaterial ASDConcrete3D (M. Petracca, G. Camata), stdBrick,
# IMPL-EX in {steps} steps. E = 3.48 GPa, nu = 0.16, 1900 kg/m3, ft = 1.15 MPa, Gf = {energy:.0f} N/m,
# our exponential softening at 48 points, in a band of V^(1/3); fc = 26 MPa. `open`: a crack that is relieved
# stays open (plastic strain); `closed`: it closes (damage).
#
# `displacement`: rows x, z, m, and ux, uz, mm, of nodes of the front, open and then closed. `cracks`: rows
# x, z of an element's middle, m, and its mean opening, mm, open and then closed. `left_foot`: force of the
# ground on the base left of the middle, N. `stress`: the largest first principal one at a point, MPa, in the
# last step and of all steps. `max_displacement`: mm.
"""
WALL = Facade(
    outline=rectangle(0.0, 0.0, 6.0, 6.0),
    thickness=0.3,
    openings=tuple(
        Opening(id=number, kind=OpeningKind.WINDOW, outline=rectangle(x, 2.5, 1.0, 1.5))
        for number, x in ((1, 1.0), (2, 4.0))
    ),
)
PORTAL = Facade(
    outline=rectangle(0.0, 0.0, 3.0, 4.0),
    thickness=0.25,
    openings=(Opening(id=1, kind=OpeningKind.DOOR, outline=rectangle(0.5, 0.0, 2.0, 2.0)),),
)
CASES: dict[str, tuple[Facade, float, float, Settlement]] = {
    "hogging_wall": (WALL, 0.5, 1.0, PeckTrough(volume_loss=0.005, diameter=6.0, depth=12.0, centre=-6.0)),
    "stretched_portal": (PORTAL, 0.25, 0.5, LinearSettlement(-0.02, -0.008, -0.012, -0.008)),
    "pressed_portal": (PORTAL, 0.25, 0.5, LinearSettlement(-0.02, -0.008, -0.008, -0.012)),
}
"""Facade, element size, distance of the nodes that are recorded, and settlement."""


def left_foot(job: Job, result: Result) -> list[float]:
    """Force, N, of the ground on the base left of its middle."""
    x = job.nodes[job.base, 0]
    return [round(value, 1) for value in result.reaction[x < x.mean()].sum(axis=0).tolist()]


def lines(name: str, mesh: VolumeMesh, spacing: float, found: dict[str, tuple[Job, Result]]) -> Iterator[str]:
    """A case as TOML."""
    yield f"\n[{name}]"
    for key, (job, result) in found.items():
        stress = result.largest_stress / 1e6
        yield f"{key}.left_foot = {left_foot(job, result)}"
        yield f"{key}.stress = [{stress[-1]:.4f}, {stress.max():.4f}]"
        yield f"{key}.max_displacement = {1e3 * np.linalg.norm(result.displacement, axis=1).max():.5f}"
    on_grid = np.abs(mesh.nodes / spacing - np.round(mesh.nodes / spacing)).max(axis=1) < 1e-6
    chosen = np.flatnonzero(on_grid & (mesh.nodes[:, 1] < 1e-9))
    yield "displacement = ["
    for node in chosen[np.lexsort(mesh.nodes[chosen].T)]:
        moved = np.concatenate([1e3 * result.displacement[node, ::2] for _, result in found.values()])
        x, _, z = mesh.nodes[node]
        yield f"    [{x:g}, {z:g}, {', '.join(f'{u:.5f}' for u in moved)}],"
    yield "]\ncracks = ["
    opening = np.stack([result.opening.mean(axis=1) for _, result in found.values()], axis=1)
    middles = mesh.nodes[mesh.elements].mean(axis=1)
    for element in np.flatnonzero((opening > OPEN).any(axis=1)):
        x, _, z = middles[element]
        yield f"    [{x:g}, {z:g}, {', '.join(f'{width:.5f}' for width in 1e3 * opening[element])}],"
    yield "]"


def main() -> None:
    """Analyse all cases, and print them."""
    print(HEAD.format(steps=STEPS, energy=FRACTURE_ENERGY), end="")
    law = MasonryLaw(fracture_energy=FRACTURE_ENERGY)
    with tempfile.TemporaryDirectory() as folder:
        for name, (facade, size, spacing, settlement) in CASES.items():
            mesh = mesh_facade(facade, options=MeshOptions(size=size))
            options = AnalysisOptions(
                masonry=law, settlement=settlement, stepping=SteppingOptions(steps=STEPS)
            )
            job = wall_job(mesh, options)
            jobs = {kind.value: replace(job, unloading=kind.value) for kind in Unloading}
            found = {kind: (job, analyse_fresh(job, Path(folder))[0]) for kind, job in jobs.items()}
            print(*lines(name, mesh, spacing, found), sep="\n", flush=True)
            print(f"{name}: {len(mesh.elements)} elements", file=sys.stderr)


if __name__ == "__main__":
    main()
