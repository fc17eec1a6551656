"""How sparse a scan may be: Tables 2 to 4 and Figures 16 to 18 of the paper, ours beside the paper's.

`python docs/density_study.py` scans the three stand-ins virtually, thins each scan to the paper's
densities, reconstructs, holds the result against the drawing, and writes `density_study.md` with its
figures to this folder.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from density_study_page import Outcome, write_study

from fd2fem.drawings import STAND_INS, stand_in
from fd2fem.model import Facade, OpeningKind, PointCloud
from fd2fem.pipeline import ORIGINAL_COUNTS, scan_facade
from fd2fem.reconstruction import ReconstructionOptions, reconstruct
from fd2fem.scans import Density, ScannerOptions, Scene, resample_to
from validation import compare_facades, match_openings


def run_building(name: str, *, seed: int) -> list[Outcome]:
    """Scan a stand-in once, with nothing around it, and reconstruct it at every density."""
    drawing = stand_in(name)
    scanner = ScannerOptions(seed=seed)
    scan = scan_facade(drawing, scanner=scanner, scene=Scene.empty(), original_points=ORIGINAL_COUNTS[name])
    clouds = {density: resample_to(scan, density, seed=seed) for density in Density}
    return [measure(cloud, name, density, seed=seed) for density, cloud in clouds.items()]


def measure(cloud: PointCloud, building: str, density: Density, *, seed: int) -> Outcome:
    """Reconstruct one data set by the default options and hold it against the drawing."""
    drawing = stand_in(building)
    start = perf_counter()
    facade = reconstruct(cloud, options=ReconstructionOptions(thickness=drawing.thickness)).facade
    seconds = perf_counter() - start
    geometry = dict(compare_facades(facade, drawing).geometry)
    scores = tuple(edge_scores(facade, drawing))
    return Outcome(building, density, seed, len(cloud), seconds, geometry, scores)


def edge_scores(facade: Facade, drawing: Facade) -> list[float]:
    """Error over sigma of each edge of the openings found, where the scan has them.

    Unlike the paper's positions these do not count from the corner of the wall that was found. The foot of
    a door is the ground and no edge of its own.
    """
    scores: list[float] = []
    for found, true in match_openings(facade, drawing).pairs:
        corners = [(found.x, 0.0, found.z), (found.x + found.width, 0.0, found.z + found.height)]
        (left, _, bottom), (right, _, top) = facade.frame.to_world(corners)
        sigma = found.sigma
        scores += [
            (left - true.x) / sigma.left,
            (right - true.x - true.width) / sigma.right,
            (top - true.z - true.height) / sigma.top,
        ]
        if true.kind is not OpeningKind.DOOR:
            scores.append((bottom - true.z) / sigma.bottom)
    return scores


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description="Errors against density, ours beside the paper's.")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(__file__).parent, help="folder to write to (default: docs)"
    )
    parser.add_argument("--seeds", type=int, default=5, help="scans of each building (default: 5)")
    given = parser.parse_args(arguments)
    outcomes = []
    for seed in range(given.seeds):
        for name in STAND_INS:
            sys.stderr.write(f"{name}, scan {seed + 1} of {given.seeds}\n")
            outcomes += run_building(name, seed=seed)
    given.output.mkdir(parents=True, exist_ok=True)
    write_study(outcomes, given.output)


if __name__ == "__main__":
    main()
