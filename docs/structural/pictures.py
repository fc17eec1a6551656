"""Pictures of cracked walls: how far each element's crack is open, and which way it runs."""

from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from structural.walls import Run

FloatArray = NDArray[np.float64]

SHOWN = 0.01e-3, 2e-3
"""Openings, m, from the palest to the darkest colour; narrower cracks are left blank."""
SCALE = LogNorm(1e3 * SHOWN[0], 1e3 * SHOWN[1])
COLOURS = mpl.colormaps["YlOrRd"]


def columns(run: Run) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quadrilaterals (c, 4, 2) of the wall's front; opening (c,) and normal (c, 3) of the widest crack."""
    corners = run.mesh.nodes[run.mesh.elements]
    middle = corners.mean(axis=1)
    order = np.argsort(corners[..., 1], axis=1, kind="stable")[:, :4]
    front = np.take_along_axis(corners, order[..., None], axis=1)[..., [0, 2]]
    turn = np.arctan2(front[..., 1] - middle[:, None, 2], front[..., 0] - middle[:, None, 0])
    front = np.take_along_axis(front, np.argsort(turn, axis=1)[..., None], axis=1)
    _, column = np.unique(np.round(middle[:, [0, 2]], 6), axis=0, return_inverse=True)
    widest = np.lexsort((-run.opening, column.ravel()))
    first = widest[np.unique(column.ravel()[widest], return_index=True)[1]]
    return front[first], run.opening[first], run.normal[first]


def draw_cracks(axes: Axes, run: Run, title: str) -> PolyCollection:
    """A wall, undeformed; a stroke along each crack."""
    front, opening, normal = columns(run)
    cracked = opening >= SHOWN[0]
    axes.add_collection(PolyCollection(front, facecolor="0.93", edgecolor="0.8", linewidth=0.2))
    faces = PolyCollection(front[cracked], array=1e3 * opening[cracked], norm=SCALE, cmap=COLOURS)
    faces.set_edgecolor("0.6")
    faces.set_linewidth(0.2)
    axes.add_collection(faces)
    middle = front[cracked].mean(axis=1)
    size = np.sqrt(np.ptp(front[cracked], axis=1).prod(axis=1))
    along = np.column_stack([-normal[cracked, 2], normal[cracked, 0]])
    half = 0.42 * size[:, None] * along
    strokes = np.stack([middle - half, middle + half], axis=1)
    axes.add_collection(LineCollection(strokes, colors="k", linewidth=0.7))
    axes.set_aspect("equal")
    axes.autoscale()
    axes.set_title(title, fontsize=8)
    axes.axis("off")
    return faces


def foot_figure(runs: Mapping[str, Run], path: Path, *, width: float, height: float) -> None:
    """The feet of a wall's two outer piers, `width` and `height` of them, m, from several analyses."""
    figure = Figure(figsize=(9.0, 3.0), layout="constrained")
    panels = figure.subplots(1, 2 * len(runs), squeeze=False)
    for number, (title, run) in enumerate(runs.items()):
        x = run.mesh.nodes[:, 0]
        for side, left in enumerate((x.min(), x.max() - width)):
            axes = panels[0, 2 * number + side]
            faces = draw_cracks(axes, run, f"{title}\n{('left', 'right')[side]}")
            axes.set_xlim(left - 0.02, left + width + 0.02)
            axes.set_ylim(-0.02, height)
    bar = figure.colorbar(faces, ax=panels.ravel().tolist(), shrink=0.8, aspect=30)
    bar.set_label("crack opening, mm", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    figure.savefig(path, dpi=130)


def overlap(first: Run, second: Run, cell: float = 0.25) -> float:
    """Part of the dissipated energy that two analyses of a wall place in the same cells, 0.25 m wide."""
    shares = []
    for run in (first, second):
        where = np.floor(run.mesh.nodes[run.mesh.elements].mean(axis=1)[:, [0, 2]] / cell + 1e-9)
        shares.append((where.astype(int), run.dissipated / run.dissipated.sum()))
    top = np.max([where.max(axis=0) for where, _ in shares], axis=0) + 1
    grids = []
    for where, share in shares:
        grid = np.zeros(top)
        np.add.at(grid, (where[:, 0], where[:, 1]), share)
        grids.append(grid)
    return float(np.minimum(*grids).sum())
