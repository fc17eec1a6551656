"""A picture of each stage, in the manner of the paper's figures 4 to 20."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import (
    CellState,
    Comparison,
    Facade,
    FacadePoints,
    HoleKind,
    Reconstruction,
    rectangle,
)
from fd2fem.report.canvas import (
    BOUNDARY,
    CANDIDATE,
    INK,
    OCCLUSION,
    OPENING,
    REFERENCE,
    WALL,
    height_of,
    new_figure,
    patches,
    save,
)

__all__ = [
    "draw_boundary",
    "draw_comparison",
    "draw_lines",
    "draw_openings",
    "draw_relief",
    "draw_scan",
    "draw_voxels",
]

FloatArray = NDArray[np.float64]

DOTS = 60_000
"""More points than this do not show in a picture."""


def _some(points: FloatArray) -> FloatArray:
    """At most `DOTS` of the points."""
    return points[:: max(1, len(points) // DOTS)]


def draw_scan(points: FacadePoints, path: Path) -> None:
    """The sorted scan, from the front and from above."""
    low, high = points.xz.min(axis=0) - 3.0, points.xz.max(axis=0) + 3.0
    figure, axes = new_figure(2, height=height_of(points.xz))
    kinds = (
        ("behind", points.behind, OPENING),
        ("on the wall", np.insert(points.xz, 1, points.depth, axis=1), WALL),
        ("in front", points.front, "#4c8c4a"),
    )
    for axis, (across, up) in zip(axes, ((0, 2), (0, 1)), strict=True):
        for name, cloud, colour in kinds:
            shown = _some(cloud)
            axis.plot(shown[:, across], shown[:, up], ",", color=colour, rasterized=True)
            axis.plot([], [], "s", color=colour, label=name)
    axes[0].set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), title="from the front")
    scanners = points.scanners
    axes[1].plot(scanners[:, 0], scanners[:, 1], "k^", markersize=5, label="scanner")
    nearest = float(scanners[:, 1].min(initial=-10.0)) - 2.0
    axes[1].set(xlim=(low[0] - 4, high[0] + 4), ylim=(nearest, 6), title="from above", ylabel="y, m")
    axes[1].legend(fontsize=7, loc="lower right")
    save(figure, path)


def draw_boundary(reconstruction: Reconstruction, path: Path) -> None:
    """Boundary points, and the distribution of edge lengths with the threshold (figure 4)."""
    points, boundary = reconstruction.points, reconstruction.boundary
    figure, axes = new_figure(2, height=height_of(points.xz))
    shown = _some(points.xz)
    axes[0].plot(shown[:, 0], shown[:, 1], ",", color="#c9c9c9", rasterized=True)
    edge = points.xz[boundary.points]
    axes[0].plot(edge[:, 0], edge[:, 1], ".", color=BOUNDARY, markersize=1.5)
    axes[0].set_title("boundary points")
    axes[1].set_aspect("auto")
    limit = 3.0 * boundary.threshold
    axes[1].hist(np.minimum(boundary.edge_lengths, limit), bins=90, color=WALL, log=True)
    axes[1].axvline(boundary.threshold, color=BOUNDARY, label=f"threshold {boundary.threshold:.3f} m")
    axes[1].set(xlabel="edge length, m", ylabel="edges", title="lengths of triangle edges")
    axes[1].legend(fontsize=8)
    save(figure, path)


def draw_openings(reconstruction: Reconstruction, path: Path) -> None:
    """Holes with their verdicts, and the quadtree (figures 5 and 7)."""
    points, tree = reconstruction.points, reconstruction.quadtree
    figure, axes = new_figure(2, height=height_of(points.xz))
    for kind, colour in ((HoleKind.OPENING, OPENING), (HoleKind.OCCLUSION, OCCLUSION)):
        loops = [hole.loop for hole in reconstruction.holes if hole.kind is kind]
        patches(axes[0], loops, colour, alpha=0.7)
    for hole in reconstruction.holes:
        ring = np.vstack([rectangle(hole.x, hole.z, hole.width, hole.height), [[hole.x, hole.z]]])
        if hole.kind is HoleKind.OPENING:
            axes[0].plot(ring[:, 0], ring[:, 1], "-", color=INK, linewidth=0.8)
            axes[0].annotate(f"{hole.confidence:.2f}", ring[:4].mean(axis=0), fontsize=7, ha="center")
    edge = points.xz[reconstruction.boundary.points]
    axes[0].plot(edge[:, 0], edge[:, 1], ".", color=BOUNDARY, markersize=1)
    axes[0].set_title("holes: openings (blue), occlusions (grey)")
    for state, colour in ((CellState.FULL, WALL), (CellState.PARTIAL, BOUNDARY), (CellState.EMPTY, "white")):
        chosen = tree.state == state
        patches(axes[1], list(_boxes(tree.lower[chosen], tree.upper[chosen])), colour, edge="#777777")
    axes[1].set_title("quadtree: full, partial (red), empty")
    save(figure, path)


def _boxes(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Corners (n, 4, 2) of rectangles."""
    return np.stack(
        [
            lower,
            np.column_stack([upper[:, 0], lower[:, 1]]),
            upper,
            np.column_stack([lower[:, 0], upper[:, 1]]),
        ],
        axis=1,
    )


def draw_lines(reconstruction: Reconstruction, path: Path) -> None:
    """Boundary lines and the points that they run through (figure 8)."""
    points, facade = reconstruction.points, reconstruction.facade
    figure, axes = new_figure(2, height=height_of(points.xz))
    shown = _some(points.xz)
    for axis in axes:
        axis.plot(shown[:, 0], shown[:, 1], ",", color="#c9c9c9", rasterized=True)
        for ring in (facade.outline, *(opening.outline for opening in facade.openings)):
            axis.plot(*np.vstack([ring, ring[:1]]).T, "-", color=INK, linewidth=0.7)
        for line in reconstruction.lines:
            used = points.xz[line.points]
            axis.plot(used[:, 0], used[:, 1], ".", color=BOUNDARY, markersize=2)
            axis.plot(*np.array([line.start, line.end]).T, "-", color=OPENING, linewidth=1)
    axes[0].set_title("boundary lines by least squares")
    rings = [opening.outline for opening in facade.openings] or [facade.outline]
    corner = rings[0][np.argmax(rings[0] @ [-1.0, 1.0])]
    axes[1].set(
        xlim=corner[0] + np.array([-0.3, 0.3]),
        ylim=corner[1] + np.array([-0.6, 0.3]),
        title="a corner; black: freed from bias",
    )
    save(figure, path)


def draw_relief(reconstruction: Reconstruction, path: Path) -> None:
    """How far the face lies out of its plane, and what was seen through, hidden or attached."""
    points, rays, facade = reconstruction.points, reconstruction.rays, reconstruction.facade
    from matplotlib.colors import ListedColormap

    figure, axes = new_figure(2, height=height_of(points.xz))
    relief = points.relief
    ends = relief.low + relief.cell * (np.array(relief.values.shape) - 0.5)
    # On a plain wall the colours would else show tenths of a millimetre as a bulge.
    limit = max(1.0, 1000.0 * float(np.nanmax(np.abs(relief.values))))
    image = axes[0].imshow(
        1000.0 * relief.values.T,
        origin="lower",
        vmin=-limit,
        vmax=limit,
        extent=(relief.low[0] - relief.cell / 2, ends[0], relief.low[1] - relief.cell / 2, ends[1]),
        cmap="RdBu_r",
    )
    figure.colorbar(image, ax=axes[0], shrink=0.6, label="mm behind the plane")
    axes[0].set_title("out-of-plane map of the face")
    hidden = (rays.shadow > 0).all(axis=0) if rays.stations else rays.before > 0
    seen = np.where(rays.wall > 0, 1.0, np.where(hidden, 3.0, np.where(rays.through > 0, 2.0, np.nan)))
    end = rays.low + rays.cell * np.array(rays.wall.shape)
    axes[1].imshow(
        seen.T,
        origin="lower",
        extent=(rays.low[0], end[0], rays.low[1], end[1]),
        cmap=ListedColormap([WALL, OPENING, OCCLUSION]),
        vmin=0.5,
        vmax=3.5,
    )
    for name, colour in (("wall", WALL), ("seen through", OPENING), ("in shadow", OCCLUSION)):
        axes[1].plot([], [], "s", color=colour, label=name)
    for thing in points.attachments:
        ring = rectangle(thing.x, thing.z, thing.width, thing.height)
        axes[1].plot(*np.vstack([ring, ring[:1]]).T, "-", color=BOUNDARY, linewidth=0.8)
        axes[1].annotate(thing.kind, ring[3], fontsize=6, color=BOUNDARY)
    for axis in axes:
        for ring in (facade.outline, *(opening.outline for opening in facade.openings)):
            axis.plot(*np.vstack([ring, ring[:1]]).T, "-", color=INK, linewidth=0.7)
    axes[1].legend(fontsize=7, loc="upper right")
    axes[1].set_title("what the rays say")
    save(figure, path)


def draw_voxels(reconstruction: Reconstruction, path: Path) -> None:
    """Full voxels after the flying-voxel tests, and one flight of each kind (figures 9 and 10)."""
    voxels, facade = reconstruction.voxels, reconstruction.facade
    figure, axes = new_figure(2, height=height_of(facade.outline))
    full = voxels.state == CellState.FULL
    for axis in axes:
        patches(axis, list(_boxes(voxels.lower[full], voxels.upper[full])), WALL, edge="#6b4a2a")
    patches(axes[0], [hole.outline for hole in facade.filled_holes], "none", edge=INK)
    axes[0].set_title("full voxels; outlined: filled occlusions")
    centres = (voxels.lower + voxels.upper) / 2.0
    start = centres[full][len(centres[full]) // 3]
    low, high = facade.outline.min(axis=0), facade.outline.max(axis=0)
    for end in ((low[0], start[1]), (high[0], start[1]), (start[0], low[1]), (start[0], high[1])):
        axes[1].plot([start[0], end[0]], [start[1], end[1]], "-", color="#c21ac2", linewidth=1)
    for opening in facade.openings:
        end = opening.outline.mean(axis=0)
        axes[1].plot([start[0], end[0]], [start[1], end[1]], "-", color="#e02020", linewidth=1)
    axes[1].plot(*start, "ks", markersize=4)
    axes[1].set_title("flights of one voxel: LS1 and LS2")
    save(figure, path)


def draw_comparison(candidate: Facade, reference: Facade, comparison: Comparison, path: Path) -> None:
    """Both outlines over one another, and the relative differences beside the tolerance."""
    figure, axes = new_figure(2, height=height_of(reference.outline))
    for facade, colour, style, name in (
        (reference, REFERENCE, "-", "reference"),
        (candidate, CANDIDATE, "--", "candidate"),
    ):
        for number, ring in enumerate([facade.outline, *(opening.outline for opening in facade.openings)]):
            closed = np.vstack([ring, ring[:1]])
            label = name if number == 0 else None
            axes[0].plot(closed[:, 0], closed[:, 1], style, color=colour, linewidth=1, label=label)
    axes[0].legend(fontsize=7)
    axes[0].set_title("geometry")
    rows = [
        (name, comparison.geometry[name]["relative_error"])
        for name in ("length", "height", "opening_area")
        if name in comparison.geometry
    ]
    rows += [(item.quantity, item.relative_difference) for item in comparison.response]
    shown = [(name, 100.0 * value) for name, value in rows if value is not None]
    axes[1].set_aspect("auto")
    axes[1].barh([name for name, _ in shown], [value for _, value in shown], color=CANDIDATE)
    for side in (-1, 1):
        axes[1].axvline(100 * side * comparison.tolerance, color=INK, linestyle=":")
    axes[1].axvline(0.0, color=INK, linewidth=0.6)
    axes[1].invert_yaxis()
    axes[1].set(xlabel="candidate - reference, %", ylabel="", title=f"passed: {comparison.passed}")
    save(figure, path)
