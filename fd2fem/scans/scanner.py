"""A virtual terrestrial laser scanner: the point cloud that a scan of a known facade gives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Facade, PointCloud
from fd2fem.model.checks import check_positive
from fd2fem.scans.casting import Target, cast_rays, prepare_target
from fd2fem.scans.rays import check_ray_count, displaced, field_of_view, ray_grid
from fd2fem.scans.scene import Scene
from fd2fem.scans.street import default_stations, street_scene
from fd2fem.scans.surfaces import REFLECTANCE, Hits, Material

__all__ = ["ScannerOptions", "simulate_scan"]

FloatArray = NDArray[np.float64]

STRADDLE = 0.05
"""Two surfaces in one beam farther apart than this, m, can give a mixed pixel."""
INTENSITY_NOISE = 0.02
"""Standard deviation of the intensity."""
LIMITS = {
    "angular_step": 45.0,
    "range_noise": 1.0,
    "beam_divergence": 0.1,
    "mixed_pixels": 1.0,
    "glass_return": 1.0,
}
"""Largest value that makes sense for some of the options, in their units."""


@dataclass(frozen=True)
class ScannerOptions:
    """How the virtual scanner stands and measures.

    Attributes
    ----------
    stations : tuple of (x, y, z), m
        Where it stands, facade frame (y < 0: in front of the wall). Empty: one station for facades up
        to 8 m long, two for longer ones (see :func:`~fd2fem.scans.street.default_stations`).
    angular_step : float, degrees
        Between neighbouring rays, horizontally and vertically.
    range_noise : float, m
        Standard deviation along the ray.
    beam_divergence : float, rad
        Full angle of the beam; two surfaces within it give mixed pixels.
    mixed_pixels : float
        Share of the beams on two surfaces that return a point between them, 0 to 1.
    glass_return : float
        Share of the rays that return from a pane of glass, 0 to 1; the others go on into the room.
    max_range : float, m
    seed : int

    Raises
    ------
    InputError
        If a value is out of its range or a station does not stand in front of the wall.
    """

    stations: tuple[tuple[float, float, float], ...] = ()
    angular_step: float = 0.06
    range_noise: float = 0.002
    beam_divergence: float = 0.0003
    mixed_pixels: float = 0.5
    glass_return: float = 0.1
    max_range: float = 150.0
    seed: int = 0

    def __post_init__(self) -> None:
        check_positive("angular_step", self.angular_step)
        check_positive("max_range", self.max_range)
        for name, limit in LIMITS.items():
            if not 0.0 <= getattr(self, name) <= limit:
                msg = f"Invalid '{name}': expected 0 to {limit:g}, got {getattr(self, name)}."
                raise InputError(msg)
        if self.seed < 0:
            msg = f"Invalid 'seed': expected 0 or more, got {self.seed}."
            raise InputError(msg)
        for station in self.stations:
            if len(station) != 3 or not np.isfinite(station).all():
                msg = f"Invalid 'stations': expected three finite coordinates each, got {station}."
                raise InputError(msg)
            if station[1] >= 0.0:
                msg = (
                    f"Invalid 'stations': {station} is in or behind the wall; "
                    "the street is where y < 0 in the facade frame."
                )
                raise InputError(msg)


def simulate_scan(
    facade: Facade, *, options: ScannerOptions | None = None, scene: Scene | None = None
) -> PointCloud:
    """Scan a known facade.

    Rays on a regular grid of azimuth and elevation leave each station; each returns the first surface
    it meets, with noise along the ray, and near edges now and then a mixed pixel.

    Parameters
    ----------
    facade : Facade
    options : ScannerOptions, optional
    scene : Scene, optional
        Default: a street (see :func:`~fd2fem.scans.street.street_scene`) with the scanner's seed.

    Returns
    -------
    PointCloud
        World frame, with intensity, the scanner's stations and the station of each point. The same for the
        same seed.

    Raises
    ------
    InputError
        If a station stands inside an object, no ray meets the wall, or the step asks for too many rays.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> facade = Facade(rectangle(0, 0, 4, 3), thickness=0.35)
    >>> cloud = simulate_scan(facade, options=ScannerOptions(angular_step=1.0), scene=Scene.empty())
    >>> bool(abs(cloud.points[:, 1]).max() < 0.01)
    True
    """
    chosen = options or ScannerOptions()
    stations = np.array(chosen.stations or default_stations(facade), dtype=np.float64)
    around = street_scene(facade, seed=chosen.seed, stations=chosen.stations) if scene is None else scene
    _check_stations(stations, around)
    views = [field_of_view(facade, around, station) for station in stations]
    check_ray_count(views, chosen.angular_step)
    target = prepare_target(facade, around)
    rng = np.random.default_rng(chosen.seed)
    points, intensity, numbers, on_wall = [], [], [], 0
    for number, (station, view) in enumerate(zip(stations, views, strict=True)):
        for directions in ray_grid(view, chosen.angular_step, rng=rng):
            measured = _measure(target, station, directions=directions, options=chosen, rng=rng)
            points.append(station + measured.distance[:, None] * directions[measured.ray])
            intensity.append(measured.intensity)
            numbers.append(np.full(len(measured.ray), number, dtype=np.int32))
            on_wall += measured.on_wall
    if on_wall == 0:
        msg = (
            f"No ray meets the wall: decrease the angular step ({chosen.angular_step} degrees), "
            f"increase the range ({chosen.max_range} m) or move the stations."
        )
        raise InputError(msg)
    return PointCloud(
        facade.frame.to_world(np.concatenate(points)),
        source=f"virtual scan, seed {chosen.seed}",
        intensity=np.concatenate(intensity),
        scanners=facade.frame.to_world(stations),
        station=np.concatenate(numbers),
    )


@dataclass(frozen=True, eq=False)
class _Measured:
    """The rays that returned: index, distance (m), intensity; and how many of them came from the wall."""

    ray: NDArray[np.intp]
    distance: FloatArray
    intensity: FloatArray
    on_wall: int


def _measure(
    target: Target,
    station: FloatArray,
    *,
    directions: FloatArray,
    options: ScannerOptions,
    rng: np.random.Generator,
) -> _Measured:
    """What the scanner records for each ray."""
    count = len(directions)
    chance = rng.random((count, 2))
    centre = cast_rays(
        target, station, directions=directions, chance=chance, glass_return=options.glass_return
    )
    distance, intensity = centre.distance.copy(), _intensity(centre)
    if options.mixed_pixels > 0.0 and options.beam_divergence > 0.0:
        edge = displaced(directions, 0.5 * options.beam_divergence, rng=rng)
        # The same chances: else glass and leaves would differ between centre and rim of one beam.
        rim = cast_rays(target, station, directions=edge, chance=chance, glass_return=options.glass_return)
        both = np.flatnonzero(np.isfinite(distance) & np.isfinite(rim.distance))
        apart = both[np.abs(distance[both] - rim.distance[both]) > STRADDLE]
        mixed = apart[rng.random(len(apart)) < options.mixed_pixels]
        share = rng.random(len(mixed))
        distance[mixed] = share * distance[mixed] + (1.0 - share) * rim.distance[mixed]
        intensity[mixed] = share * intensity[mixed] + (1.0 - share) * _intensity(rim)[mixed]
    ray = np.flatnonzero(distance <= options.max_range)
    noisy = distance[ray] + options.range_noise * rng.standard_normal(len(ray))
    strength = np.clip(intensity[ray] + INTENSITY_NOISE * rng.standard_normal(len(ray)), 0.0, 1.0)
    return _Measured(ray, noisy, strength, int(np.count_nonzero(centre.material[ray] == Material.WALL)))


def _intensity(hits: Hits) -> FloatArray:
    """Lambert's law: reflectance times the cosine of the incidence; the range is taken as corrected for."""
    return REFLECTANCE[hits.material] * hits.cosine


def _check_stations(stations: FloatArray, scene: Scene) -> None:
    """Raise if a station is under the ground or inside something."""
    for station in stations:
        x, y, z = (float(value) for value in station)
        where = f"the station ({x:g}, {y:g}, {z:g}) m"
        if scene.ground and z <= 0.0:
            msg = f"Invalid 'stations': {where} is under the ground; z must be positive."
            raise InputError(msg)
        for body in scene.bodies:
            if body.contains((x, y, z)):
                msg = f"Invalid 'stations': {where} is inside a {type(body).__name__.lower()}; move it."
                raise InputError(msg)
