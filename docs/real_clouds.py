"""Two scans that others published, reconstructed: the figures of `real_clouds.md`, and its tables on stdout.

`python docs/real_clouds.py FOLDER` reads the clouds from a folder and writes the figures beside this file.
`real_clouds.md` tells where the clouds come from, and what to make of what was found.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import HoleKind, Opening, PointCloud, Reconstruction
from fd2fem.reconstruction import ReconstructionOptions, reconstruct
from fd2fem.reconstruction.options import Override
from fd2fem.reconstruction.plane import facade_depth
from fd2fem.scans import read_scan

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BESIDE = 0.6
"""Points so far before or behind the wall's face are drawn, m."""
DOTS = 15_000
"""More points than this do not show in a picture."""
COLOURS = 32
"""Of a picture."""
PAPER, INK, WALL, OPENING, FILLED = "white", "#222222", "#c22f2f", "#1a5fc2", "#2f7d3b"


@dataclass(frozen=True)
class View:
    """One wall of a cloud, and how it is reconstructed.

    Openings between the two heights `panels`, m, are parts of the panels under the windows: an override
    fills each, as a user would who looks at the picture.
    """

    title: str
    options: ReconstructionOptions
    panels: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Study:
    """A cloud, its walls, and the figure of them."""

    cloud: str
    views: tuple[View, ...]
    figure: str
    size: tuple[float, float]
    widths: tuple[float, ...]


BUILDING = Study(
    "cgal_building.ply",
    (
        View("left wing (wall 2)", ReconstructionOptions(wall=2, wall_band=0.2), panels=(5.4, 7.3)),
        View("right wing (wall 1)", ReconstructionOptions(wall=1, wall_band=0.2), panels=(5.4, 7.3)),
    ),
    "real_building.png",
    (11.0, 4.4),
    (1.0, 1.0),
)
TOWER = Study(
    "clocktower_face_30mm.ply",
    (
        View("base (wall 2)", ReconstructionOptions(wall=2)),
        View("whole face (wall_band 0.2)", ReconstructionOptions(wall_band=0.2)),
    ),
    "real_tower.png",
    (7.5, 7.5),
    (1.7, 1.0),
)


def judged(cloud: PointCloud, view: View) -> Reconstruction:
    """Reconstruct a wall, and once more with overrides where openings are parts of panels."""
    found = reconstruct(cloud, options=view.options)
    low, high = view.panels
    overrides = tuple(
        Override(round(each.x + each.width / 2, 2), round(each.z + each.height / 2, 2), HoleKind.OCCLUSION)
        for each in found.facade.openings
        if each.z > low and each.z + each.height < high
    )
    return reconstruct(cloud, options=replace(view.options, overrides=overrides)) if overrides else found


def draw(study: Study, found: Sequence[Reconstruction], cloud: PointCloud, path: Path) -> None:
    """Draw the walls of a cloud side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    figure = Figure(figsize=study.size, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(1, len(found), width_ratios=study.widths)
    for number, (view, each) in enumerate(zip(study.views, found, strict=True)):
        axes = figure.add_subplot(grid[number])
        axes.set_title(view.title, fontsize=9)
        draw_wall(axes, each, cloud)
    figure.savefig(path, dpi=100)
    # Dots fill a picture with colours in between that nobody sees, and that take most of its file.
    with Image.open(path) as picture:
        picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def draw_wall(axes: "Axes", found: Reconstruction, cloud: PointCloud) -> None:
    """Draw the points by their depth, the outline, the openings by number, and hatched what was filled."""
    facade = found.facade
    local = facade.frame.to_facade(cloud.points)
    depth = facade_depth(found.points, local)
    low, high = facade.outline.min(axis=0) - 0.8, facade.outline.max(axis=0) + 0.8
    x, _, z = local.T
    shown = np.flatnonzero(
        (x > low[0]) & (x < high[0]) & (z > low[1]) & (z < high[1]) & (np.abs(depth) < BESIDE)
    )
    shown = shown[:: max(1, len(shown) // DOTS)]
    # What lies deepest is drawn last: it shows through the openings.
    shown = shown[np.argsort(depth[shown])]
    axes.scatter(x[shown], z[shown], c=depth[shown], cmap="Greys", vmin=-0.4, vmax=0.5, s=1.4, linewidths=0)
    for hole in facade.filled_holes:
        axes.fill(*hole.outline.T, facecolor="none", edgecolor=FILLED, hatch="/////", linewidth=0.6)
    draw_ring(axes, facade.outline, WALL)
    for opening in facade.openings:
        draw_ring(axes, opening.outline, OPENING)
        axes.annotate(
            f"{opening.id}\n{opening.confidence:.2f}",
            opening.outline.mean(axis=0),
            fontsize=7,
            color=OPENING,
            ha="center",
            va="center",
            bbox={"boxstyle": "round,pad=0.15", "facecolor": PAPER, "edgecolor": "none"},
        )
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("x, m", fontsize=8, color=INK)
    axes.set_ylabel("z, m", fontsize=8, color=INK)
    axes.tick_params(labelsize=7)


def draw_ring(axes: "Axes", ring: NDArray[np.float64], colour: str) -> None:
    """Draw a closed outline."""
    axes.plot(*np.vstack([ring, ring[:1]]).T, "-", color=colour, linewidth=1.3)


def table(view: View, found: Reconstruction) -> str:
    """What was found on a wall, in Markdown."""
    facade = found.facade
    lines = [
        f"**{view.title}**: {facade.length:.2f} x {facade.height:.2f} m, {len(facade.outline)} corners, "
        f"{len(facade.openings)} opening{'s' * (len(facade.openings) != 1)} of {facade.opening_area:.2f} m², "
        f"{len(facade.filled_holes)} filled holes; points {1000 * found.points.spacing:.0f} mm apart.",
        "",
        "| | shape | x, m | z, m | width, m | height, m | sigma (left, right, bottom, top), mm |",
        "|---|---|---|---|---|---|---|",
        *(row(opening) for opening in facade.openings),
        "",
        *(f"- override: {each['x']:.2f}, {each['z']:.2f}" for each in facade.record["options"]["overrides"]),
        *(f"- {warning}" for warning in facade.record["warnings"]),
        "",
    ]
    return "\n".join(lines)


def row(opening: Opening) -> str:
    """An opening as a row of the table."""
    sigma = opening.sigma
    edges = (sigma.left, sigma.right, sigma.bottom, sigma.top)
    shape = "door" if opening.kind.value == "door" else opening.evidence["shape"]
    sizes = (opening.x, opening.z, opening.width, opening.height)
    return (
        f"| {opening.id} | {shape} | "
        + " | ".join(f"{size:.2f}" for size in sizes)
        + " | "
        + ", ".join(f"{1000 * each:.0f}" for each in edges)
        + " |"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Reconstruct the clouds and draw them."""
    parser = argparse.ArgumentParser(description="Figures and tables of real_clouds.md.")
    parser.add_argument("folder", type=Path, help="folder with the clouds")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(__file__).parent, help="folder to write to (default: docs)"
    )
    given = parser.parse_args(arguments)
    for study in (BUILDING, TOWER):
        cloud = read_scan(given.folder / study.cloud)
        found = [judged(cloud, view) for view in study.views]
        draw(study, found, cloud, given.output / study.figure)
        tables = (table(view, each) for view, each in zip(study.views, found, strict=True))
        sys.stdout.write("\n".join([f"## {study.cloud}", "", *tables]) + "\n")


if __name__ == "__main__":
    main()
