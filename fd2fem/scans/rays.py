"""The rays of a scan: a regular grid of azimuth and elevation."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Facade
from fd2fem.model.checks import check_positive
from fd2fem.scans.casting import prepare_target
from fd2fem.scans.scene import Scene
from fd2fem.scans.street import default_stations

__all__ = ["View", "check_ray_count", "displaced", "field_of_view", "ray_grid", "step_for_spacing"]

FloatArray = NDArray[np.float64]

CHUNK = 250_000
"""Rays cast at a time; keeps the memory below 0.3 GB."""
MAX_RAYS = 200_000_000
"""More rays than this, over all stations, are taken for a mistake in the angular step."""
LOWEST = -30.0
"""How far down a scan of the street looks, degrees."""


@dataclass(frozen=True)
class View:
    """A window of azimuth (from the wall's normal to the right) and elevation, rad."""

    left: float
    right: float
    low: float
    high: float


def field_of_view(facade: Facade, scene: Scene, station: FloatArray) -> View:
    """The window that holds the wall and its margin, and the street down to near the scanner."""
    x, y, z = station
    start, end = -scene.margin, facade.length + scene.margin
    distances = np.hypot(np.array([np.clip(x, start, end), start, end]) - x, y)
    elevations = np.arctan2(
        np.array([0.0, facade.height + scene.margin])[:, None] - z, [distances.min(), distances.max()]
    )
    low = np.radians(LOWEST) if scene.ground else elevations.min()
    return View(
        float(np.arctan2(start - x, -y)),
        float(np.arctan2(end - x, -y)),
        float(min(low, elevations.min())),
        float(elevations.max()),
    )


def _grid_shape(view: View, step: float) -> tuple[int, int]:
    """Number of azimuths and elevations; `step` in degrees."""
    size = np.radians(step)
    return int((view.right - view.left) / size) + 1, int((view.high - view.low) / size) + 1


def ray_grid(view: View, step: float, *, rng: np.random.Generator) -> Iterator[FloatArray]:
    """Unit directions (n, 3) in chunks, column by column as a scanner turns; the grid starts at random."""
    columns, rows = _grid_shape(view, step)
    size = np.radians(step)
    first_azimuth, first_elevation = (view.left, view.low) + size * rng.random(2)
    for start in range(0, columns * rows, CHUNK):
        column, row = np.divmod(np.arange(start, min(start + CHUNK, columns * rows)), rows)
        azimuth, elevation = first_azimuth + size * column, first_elevation + size * row
        level = np.cos(elevation)
        yield np.column_stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(elevation)])


def displaced(directions: FloatArray, angle: float, *, rng: np.random.Generator) -> FloatArray:
    """Unit vectors at `angle`, rad, from each direction, on a random side."""
    right = np.column_stack([directions[:, 1], -directions[:, 0], np.zeros(len(directions))])
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(right, directions)
    side = rng.uniform(0.0, 2.0 * np.pi, len(directions))
    across = np.cos(side)[:, None] * right + np.sin(side)[:, None] * up
    return np.asarray(np.cos(angle) * directions + np.sin(angle) * across)


def check_ray_count(views: Sequence[View], step: float) -> None:
    """Raise if the angular step asks for more rays than anyone wants to wait for."""
    count = sum(columns * rows for columns, rows in (_grid_shape(view, step) for view in views))
    if count > MAX_RAYS:
        msg = (
            f"Invalid 'angular_step': {step} degrees asks for {count:.3g} rays, more than {MAX_RAYS:.0e}; "
            "increase it."
        )
        raise InputError(msg)


def step_for_spacing(
    facade: Facade, spacing: float, *, stations: tuple[tuple[float, float, float], ...] = ()
) -> float:
    """Angular step, degrees, that puts about one point per spacing² on the wall, over all stations.

    A ray grid of step s puts J/s² points on a unit of wall, where J = ∂(azimuth, elevation)/∂(x, z);
    so s = spacing · sqrt(mean over the wall of the stations' J).

    Parameters
    ----------
    facade : Facade
    spacing : float, m
        Mean point spacing wanted.
    stations : tuple of (x, y, z), m, optional
        As in `ScannerOptions`.

    Raises
    ------
    InputError
        If the spacing is not positive.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> facade = Facade(rectangle(0, 0, 0.1, 0.1), thickness=0.35)
    >>> round(step_for_spacing(facade, 0.1, stations=((0.05, -10.0, 0.05),)), 3)  # 10 mrad
    0.573
    """
    import shapely

    check_positive("spacing", spacing)
    across = np.linspace(0.0, facade.length, 201)
    up = np.linspace(0.0, facade.height, 201)
    x, z = np.meshgrid(0.5 * (across[1:] + across[:-1]), 0.5 * (up[1:] + up[:-1]))
    wall = prepare_target(facade, Scene.empty()).wall
    on_wall = shapely.contains_xy(wall, x.ravel(), z.ravel())
    jacobian = np.zeros(np.count_nonzero(on_wall))
    for sx, sy, sz in stations or default_stations(facade):
        square = (x.ravel()[on_wall] - sx) ** 2 + sy**2
        jacobian += abs(sy) / np.sqrt(square) / (square + (z.ravel()[on_wall] - sz) ** 2)
    return float(np.degrees(spacing * np.sqrt(jacobian.mean())))
