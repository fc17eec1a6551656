"""The look that the figures share."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "BOUNDARY",
    "CANDIDATE",
    "INK",
    "OCCLUSION",
    "OPENING",
    "REFERENCE",
    "WALL",
    "height_of",
    "new_figure",
    "patches",
    "save",
]

WALL, OPENING, OCCLUSION = "#b5763f", "#3f7fb5", "#8a8a8a"
BOUNDARY, INK = "#c22f2f", "#222222"
CANDIDATE, REFERENCE = "#c2571a", "#1a5fc2"


def height_of(points: NDArray[np.float64], width: float = 4.2) -> float:
    """Height of a figure, inches, whose axes are `width` wide and show these (n, 2) points."""
    extent = np.ptp(points, axis=0)
    return float(np.clip(width * extent[1] / max(extent[0], 1e-9), 3.0, 9.0)) + 0.8


def new_figure(columns: int, *, height: float, width: float = 4.2) -> "tuple[Figure, NDArray[Any]]":
    """A figure with so many equal-aspect axes side by side; no display is needed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * columns, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = np.atleast_1d(figure.subplots(1, columns))
    for axis in axes:
        axis.set_aspect("equal")
        axis.tick_params(labelsize=7)
        axis.set_xlabel("x, m", fontsize=8)
        axis.set_ylabel("z, m", fontsize=8)
    return figure, axes


def patches(
    axes: "Axes", rings: list[NDArray[np.float64]], colour: str, *, edge: str = "none", alpha: float = 1.0
) -> None:
    """Fill closed polygons."""
    from matplotlib.collections import PolyCollection

    axes.add_collection(
        PolyCollection(rings, facecolors=colour, edgecolors=edge, linewidths=0.4, alpha=alpha)
    )
    axes.autoscale_view()


def save(figure: "Figure", path: Path) -> None:
    """Write a PNG."""
    figure.savefig(path, dpi=130)
