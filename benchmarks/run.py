"""Time the chain against named peers, measured in the same run: ``python benchmarks/run.py``.

``python benchmarks/run.py --large`` also triangulates five million points, which takes minutes and gigabytes;
``python benchmarks/run.py reconstruction`` measures that section only.

Every line gives our seconds, the peer's, and the ratio peer / ours: above 1 we are faster. CPU seconds are
what counts on a busy machine, wall seconds stand beside them. Short measurements are the best of three.
"""

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.drawings import stand_in
from fd2fem.meshing import MeshOptions, mesh_facade, write_mesh
from fd2fem.model import Facade, PointCloud, VolumeMesh
from fd2fem.reconstruction import reconstruct, voxelise
from fd2fem.scans import read_scan, write_las
from fd2fem.solids import solid_from_voxels, write_anf
from solvers import AnalysisOptions, base_displacement, elasticity_matrix, lame_parameters, read_response
from solvers.assembly import stiffness
from solvers.elements import Space, displacement_space

POINTS = (50_000, 200_000, 650_000)
MANY_POINTS = 5_000_000
PATTERNS = {"grid": "jittered grid", "lines": "scan lines"}
SECTIONS = ("reconstruction", "reading", "analysis", "neutral_file")
READ_POINTS = 500_000
MESH_SIZE = 0.17
"""Element edge, m: about 50,000 unknowns in Building 1."""
INTORDER = 5
"""27 points in a hexahedron, as ours; scikit-fem's own choice would be 343."""
OPTIONS = AnalysisOptions()


@dataclass(frozen=True)
class Seconds:
    """What one measurement took."""

    cpu: float
    wall: float


def timed(task: Callable[[], object], repeat: int = 1) -> Seconds:
    """Best of `repeat` runs of a task."""
    runs = []
    for _ in range(repeat):
        wall, cpu = perf_counter(), process_time()
        task()
        runs.append(Seconds(process_time() - cpu, perf_counter() - wall))
    return min(runs, key=lambda run: run.cpu)


def timed_process(command: list[str], folder: Path, env: dict[str, str]) -> Seconds:
    """A whole process, from its start to its end."""
    before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    subprocess.run(command, cwd=folder, env=env, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Seconds(cpu, perf_counter() - wall)


def row(name: str, ours: Seconds, peer_name: str, peer: Seconds) -> None:
    """Print one comparison."""
    print(
        f"{name:34s} {ours.cpu:8.3f} {ours.wall:8.3f}   {peer_name:34s} {peer.cpu:8.3f} {peer.wall:8.3f}   "
        f"{peer.cpu / ours.cpu:6.2f} {peer.wall / ours.wall:6.2f}"
    )


def head(title: str) -> None:
    """Print the columns' names."""
    print(f"\n{title}")
    print(f"{'ours':34s} {'CPU s':>8s} {'wall s':>8s}   {'peer':34s} {'CPU s':>8s} {'wall s':>8s}   ", end="")
    print(f"{'CPU':>6s} {'wall':>6s}")


def wall_cloud(facade: Facade, count: int, pattern: str = "random") -> PointCloud:
    """About `count` points of a facade's front, 2 mm of noise, in random order, a scanner before it.

    They lie evenly random ("random"), one in each square of a grid ("grid"), or on level lines four times as
    far apart as the points along them ("lines").
    """
    rng = np.random.default_rng(7)
    size = np.array([facade.length, facade.height])
    spacing = float(np.sqrt(facade.wall_area / count))
    if pattern == "random":
        xz = rng.uniform(0.0, 1.0, (int(count * size.prod() / facade.wall_area), 2)) * size
    else:
        across, up = (0.5, 2.0) if pattern == "lines" else (1.0, 1.0)
        sides = (np.arange(0.5, n) for n in np.floor(size / spacing / [across, up]))
        xz = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2) * [across, up] * spacing
        xz += (
            rng.uniform(-0.3, 0.3, xz.shape) * spacing
            if pattern == "grid"
            else rng.normal(0.0, 5e-4, xz.shape)
        )
    for opening in facade.openings:
        low, high = opening.outline.min(axis=0), opening.outline.max(axis=0)
        xz = xz[~((xz > low) & (xz < high)).all(axis=1)]
    points = rng.permutation(np.insert(xz, 1, rng.normal(0.0, 0.002, len(xz)), axis=1))
    return PointCloud(points, "benchmark", scanners=[[facade.length / 2, -12.0, 1.6]])


@dataclass(frozen=True)
class FreshRun:
    """What a process that has done nothing else takes for a cloud, the first time and then.

    `memory`: the most that numpy and Python hold beyond the cloud, in MB. `steps`: wall seconds of the last
    time.
    """

    points: int
    openings: int
    first: Seconds
    then: Seconds
    memory: float
    steps: dict[str, float]


def run_here(pattern: str, count: int) -> FreshRun:
    """Reconstruct a cloud in this process."""
    cloud = wall_cloud(stand_in("building3"), count, pattern)
    first = timed(lambda: reconstruct(cloud))
    results: list[Any] = []
    then = timed(lambda: results.append(reconstruct(cloud)), 3 if count < MANY_POINTS else 1)
    facade = results.pop().facade
    # Not while it is timed: keeping count of the memory takes time.
    tracemalloc.start()
    reconstruct(cloud)
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    steps = dict(facade.record["timings_s"])
    return FreshRun(len(cloud), len(facade.openings), first, then, memory, steps)


def run_fresh(pattern: str, count: int) -> FreshRun:
    """Reconstruct a cloud in a process of its own."""
    command = [sys.executable, __file__, "--fresh", pattern, str(count)]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return FreshRun(**found | {name: Seconds(**found[name]) for name in ("first", "then")})


def reconstruction(*, large: bool) -> None:
    """Points in memory to a facade, beside one triangulation of the same points."""
    from scipy.spatial import Delaunay

    head("Reconstruction, points in memory to facade (Building 3, 19.4 x 17 m)")
    runs = []
    for pattern, pattern_name in PATTERNS.items():
        for count in (*POINTS, MANY_POINTS):
            run = run_fresh(pattern, count)
            runs.append((pattern, run))
            name = f"{run.points:,} points, {pattern_name}"
            if count == MANY_POINTS and not (large and pattern == "grid"):
                print(f"{name:34s} {run.then.cpu:8.3f} {run.then.wall:8.3f}")
                continue
            xz = wall_cloud(stand_in("building3"), count, pattern).points[:, ::2].copy()
            peer = timed(lambda xz=xz: Delaunay(xz), 3 if count < 100_000 else 1)
            row(name, run.then, "scipy.spatial.Delaunay alone", peer)
    print("  the first time in the fresh process; the most memory; wall s of the last time, step by step:")
    for pattern, run in runs:
        text = "  ".join(f"{step} {seconds:.2f}" for step, seconds in run.steps.items())
        print(
            f"  {pattern:5s} {run.points:9,}: {run.openings} openings; {run.first.cpu:.3f} CPU s, "
            f"{run.memory:.0f} MB; {text}"
        )


def write_ply(points: NDArray[np.float64], path: Path) -> None:
    """Binary PLY with double coordinates."""
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(header.encode() + points.astype("<f8").tobytes())


def read_plain_ply(path: Path) -> NDArray[np.float64]:
    """The least that reading can cost: one header, one known layout."""
    with path.open("rb") as file:
        while file.readline() != b"end_header\n":
            pass
        return np.fromfile(file, dtype="<f8").reshape(-1, 3)


def reading(folder: Path) -> None:
    """Each format's reader, with all its checks, beside the plainest way to the same coordinates."""
    import laspy

    cloud = wall_cloud(stand_in("building3"), READ_POINTS)
    survey = PointCloud(cloud.points + np.array([715_830.0, 734_120.0, 12.5]), "benchmark")
    for suffix in ("las", "laz"):
        write_las(survey, folder / f"scan.{suffix}")
    write_ply(survey.points, folder / "scan.ply")
    np.savetxt(folder / "scan.xyz", survey.points, fmt="%.4f")
    head(f"Reading, {len(survey):,} points")
    peers: dict[str, tuple[str, Callable[[Path], object]]] = {
        "las": ("laspy.read(...).xyz", lambda path: laspy.read(path).xyz),
        "laz": ("laspy.read(...).xyz", lambda path: laspy.read(path).xyz),
        "ply": ("numpy.fromfile after the header", read_plain_ply),
        "xyz": ("numpy.loadtxt", np.loadtxt),
    }
    for suffix, (name, reader) in peers.items():
        path = folder / f"scan.{suffix}"
        ours = timed(lambda path=path: read_scan(path), 3)
        row(f"read_scan, .{suffix}", ours, name, timed(lambda path=path, reader=reader: reader(path), 3))


def stock_stiffness(mesh: VolumeMesh) -> Any:
    """The same stiffness by scikit-fem's own form."""
    import skfem
    from skfem.models.elasticity import linear_elasticity

    order = [6, 2, 5, 7, 1, 3, 4, 0]  # VTK's corners as scikit-fem's reference element has them
    grid = skfem.MeshHex(mesh.nodes.T.copy(), mesh.elements[:, order].T.copy())
    basis = skfem.Basis(grid, skfem.ElementVector(skfem.ElementHexS2()), intorder=INTORDER)
    lame = lame_parameters(OPTIONS.material)
    return skfem.asm(linear_elasticity(lame.first, lame.shear), basis)


def assembly(mesh: VolumeMesh, space: Space) -> None:
    """Our stiffness matrix beside scikit-fem's stock form, on the same mesh and points."""
    elasticity = elasticity_matrix(OPTIONS.material)
    ours, stock = stiffness(space, elasticity), stock_stiffness(mesh)
    # The two number their unknowns differently, so it is the sorted diagonals that must agree.
    own, other = (np.sort(matrix.diagonal()) for matrix in (ours, stock))
    difference = np.abs(own - other).max() / own.max()
    head(f"Stiffness matrix, {len(mesh.elements):,} 20-node hexahedra, {space.unknowns:,} unknowns")
    peer = timed(lambda: stock_stiffness(mesh))
    row("solvers.assembly.stiffness", timed(lambda: stiffness(space, elasticity), 3), "scikit-fem", peer)
    print(f"  largest difference of the diagonals {difference:.1e} of the largest; intorder {INTORDER}")


def write_deck(space: Space, mesh: VolumeMesh, path: Path) -> None:
    """The same analysis for CalculiX: C3D20, self-weight, the base moved."""
    material = OPTIONS.material
    ends = float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
    moved = base_displacement(OPTIONS.settlement, space.points[space.base, 0], extent=ends)
    with path.open("w", encoding="ascii") as deck:
        deck.write("*NODE, NSET=ALL\n")
        numbers = np.arange(1, len(space.points) + 1)
        np.savetxt(deck, np.column_stack([numbers, space.points]), fmt="%d, %.12e, %.12e, %.12e")
        deck.write("*ELEMENT, TYPE=C3D20, ELSET=WALL\n")
        for number, nodes in enumerate(space.connectivity + 1, start=1):
            deck.write(f"{number}, {', '.join(map(str, nodes[:15]))},\n{', '.join(map(str, nodes[15:]))}\n")
        deck.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{material.young}, {material.poisson}\n")
        deck.write(f"*DENSITY\n{material.density}\n*SOLID SECTION, ELSET=WALL, MATERIAL=M\n")
        deck.write("*STEP\n*STATIC\n*BOUNDARY\n")
        for node, values in zip(space.base + 1, moved, strict=True):
            deck.writelines(f"{node}, {axis}, {axis}, {value:.12e}\n" for axis, value in enumerate(values, 1))
        deck.write(f"*DLOAD\nWALL, GRAV, {OPTIONS.gravity}, 0., 0., -1.\n")
        deck.write("*NODE PRINT, NSET=ALL\nU\n*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n")


def analysis(mesh: VolumeMesh, space: Space, folder: Path) -> None:
    """A mesh file to results on disk, whole processes."""
    head(f"Elastic analysis from file to file, {space.unknowns:,} unknowns")
    env = os.environ | {"OMP_NUM_THREADS": str(os.cpu_count())}
    write_mesh(mesh, folder / "wall.msh")
    command = [sys.executable, "-m", "fd2fem", "analyse", "wall.msh", "-o", "out", "--force", "--quiet"]
    ours = timed_process(command, folder, env)
    if shutil.which("ccx") is None:
        print(f"fd2fem analyse: {ours.cpu:.2f} CPU s, {ours.wall:.2f} wall s; ccx is not on PATH: skipped")
        return
    write_deck(space, mesh, folder / "wall.inp")
    peer = timed_process(["ccx", "wall"], folder, env)
    row("fd2fem analyse wall.msh", ours, "CalculiX (ccx), C3D20, same mesh", peer)
    response = read_response(folder / "out")
    theirs = np.genfromtxt(folder / "wall.dat", skip_header=3)[: len(mesh.nodes), 1:]
    largest = response.max_displacement
    difference = np.linalg.norm(theirs, axis=1).max() / largest - 1.0
    print(f"  largest displacement {1000 * largest:.3f} mm; relative difference {difference:.1e}")
    print("  ours, wall s: " + "  ".join(f"{step} {took:.2f}" for step, took in response.timings.items()))


def neutral_file(folder: Path) -> None:
    """Voxels per second into the neutral file; there is no peer."""
    voxels = voxelise(stand_in("building3"), max_size=0.198)
    solid = solid_from_voxels(voxels)
    build = timed(lambda: solid_from_voxels(voxels), 3)
    write = timed(lambda: write_anf(solid, folder / "wall.anf"), 3)
    size = (folder / "wall.anf").stat().st_size / 1e6
    print(f"\nNeutral file, {len(solid.volumes):,} voxels, {size:.0f} MB")
    for name, seconds in (("solid_from_voxels", build), ("write_anf", write)):
        rate = len(solid.volumes) / seconds.cpu
        print(f"{name:34s} {seconds.cpu:8.3f} {seconds.wall:8.3f}   {rate:,.0f} voxels per CPU second")


def main() -> None:
    """Run all of it, or what is asked for."""
    parser = argparse.ArgumentParser(description="Time the chain against named peers.")
    parser.add_argument("sections", nargs="*", metavar="section", help=", ".join(SECTIONS) + "; default: all")
    parser.add_argument("--large", action="store_true", help="also triangulate five million points")
    parser.add_argument("--fresh", nargs=2, metavar=("PATTERN", "COUNT"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.fresh:
        print(json.dumps(asdict(run_here(arguments.fresh[0], int(arguments.fresh[1])))))
        return
    chosen = arguments.sections or SECTIONS
    if unknown := set(chosen) - set(SECTIONS):
        parser.error(f"no section {', '.join(sorted(unknown))}: choose from {', '.join(SECTIONS)}")
    start = perf_counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if "reconstruction" in chosen:
            reconstruction(large=arguments.large)
        if "reading" in chosen:
            reading(folder)
        if "analysis" in chosen:
            mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=MESH_SIZE))
            space = displacement_space(mesh)
            assembly(mesh, space)
            analysis(mesh, space, folder)
        if "neutral_file" in chosen:
            neutral_file(folder)
    print(f"\nwhole run: {perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
