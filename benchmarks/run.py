"""Time the chain against named peers, measured in the same run: ``python benchmarks/run.py``.

``python benchmarks/run.py --large`` also triangulates five million points and analyses a million unknowns,
which takes minutes and gigabytes;
``python benchmarks/run.py reconstruction`` measures that section only.

Every line gives our seconds, the peer's, and the ratio peer / ours: above 1 we are faster. CPU seconds are
what counts on a busy machine, wall seconds stand beside them. Short measurements are the best of three.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from cracking import cracking
from elastic import assembly, elastic_analysis, large_analysis
from numpy.typing import NDArray
from timing import Seconds, head, row, timed

from fd2fem.drawings import stand_in
from fd2fem.model import Facade, PointCloud
from fd2fem.reconstruction import reconstruct, voxelise
from fd2fem.scans import read_scan, write_las
from fd2fem.solids import solid_from_voxels, write_anf

POINTS = (50_000, 200_000, 650_000)
MANY_POINTS = 5_000_000
PATTERNS = {"grid": "jittered grid", "lines": "scan lines"}
SECTIONS = ("reconstruction", "reading", "analysis", "cracking", "neutral_file")
READ_POINTS = 500_000


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
    parser.add_argument("--large", action="store_true", help="also the largest cases")
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
            assembly()
            elastic_analysis(folder)
            if arguments.large:
                large_analysis(folder)
        if "cracking" in chosen:
            cracking(folder, large=arguments.large)
        if "neutral_file" in chosen:
            neutral_file(folder)
    print(f"\nwhole run: {perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
