"""A street to scan a facade from: where the scanner stands, and what stands in its way."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Facade
from fd2fem.scans.scene import Body, Foliage, Neighbour, Post, Scene, Vehicle

__all__ = ["default_stations", "street_scene"]

FloatArray = NDArray[np.float64]
Stations = tuple[tuple[float, float, float], ...]

EYE = 1.6
"""Height of the scanner above the ground, m."""
LONG = 8.0
"""A facade longer than this, m, takes two stations."""
VISIBLE = 0.6
"""Share of each jamb, each head and each side of the wall that the objects must leave in sight."""
RIM = 0.15
"""Objects rather hide wall that is farther than this from its edges and openings, m."""
FORWARD, BACK = -0.25, 0.30
"""Where the fronts of the two neighbours stand, m along y."""
NEIGHBOUR_LENGTH = 8.0
"""m"""


def default_stations(facade: Facade) -> Stations:
    """Where the scanner stands: opposite the middle, or the quarter points of a facade over 8 m long.

    As far away as 0.8 of the facade's height, at least 8 m, and a little off so that nothing is symmetric.

    Returns
    -------
    stations : tuple of (x, y, z), m
        Facade frame.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> default_stations(Facade(rectangle(0, 0, 6, 10), thickness=0.35))
    ((3.18, -8.0, 1.6),)
    """
    distance = max(8.0, 0.8 * facade.height)
    if facade.length <= LONG:
        return ((0.53 * facade.length, -distance, EYE),)
    return ((0.27 * facade.length, -distance, EYE), (0.76 * facade.length, -1.04 * distance, EYE))


def street_scene(facade: Facade, *, seed: int = 0, stations: Stations = ()) -> Scene:
    """A street before the facade: ground, rooms, two neighbours, a lamp post, a parked car, a small tree.

    Each object stands where it hides most of the wall from the stations, rather in the middle of piers
    than beside edges, while every jamb, every head and every side of the wall stays in sight over more
    than half its length, from one station or another. An object that has no such place is left out.

    Parameters
    ----------
    facade : Facade
    seed : int
        Of the jitter of the places.
    stations : tuple of (x, y, z), m, optional
        Where the scanner will stand; default: :func:`default_stations`.
    """
    rng = np.random.default_rng([seed, 1])
    views = np.array(stations or default_stations(facade), dtype=np.float64)
    wall, worth = _wall_samples(facade)
    edges = _edge_samples(facade)
    ends = np.cumsum([len(wall), *(len(edge) for edge in edges)])
    samples = np.concatenate([wall, *edges])
    objects: list[Body] = []
    hidden = np.zeros((len(views), len(samples)), dtype=np.bool_)
    for candidates in (_trees(facade, rng), _cars(facade, rng), _posts(facade, rng)):
        best, most, before = None, -np.inf, hidden
        for candidate in candidates:
            if any(candidate.contains((x, y, z)) for x, y, z in views):
                continue
            trial = before | _hidden(candidate, views, samples)
            lost = trial.all(axis=0)
            gain = float(worth @ (lost + trial.mean(axis=0))[: len(wall)])
            if gain > most and _in_sight(np.split(lost, ends[:-1])[1:]):
                best, most, hidden = candidate, gain, trial
        objects += [best] if best else []
    return Scene(neighbours=_neighbours(facade, rng), objects=tuple(objects))


def _neighbours(facade: Facade, rng: np.random.Generator) -> tuple[Neighbour, Neighbour]:
    """One neighbour lower and forward, the other taller and set back; the seed says which is where."""
    sides = [(FORWARD, 0.8 * facade.height), (BACK, 1.2 * facade.height)]
    (left, left_height), (right, right_height) = (sides[i] for i in rng.permutation(2))
    return (
        Neighbour(-NEIGHBOUR_LENGTH, 0.0, left, left_height),
        Neighbour(facade.length, facade.length + NEIGHBOUR_LENGTH, right, right_height),
    )


def _trees(facade: Facade, rng: np.random.Generator) -> Iterable[Foliage]:
    """Small trees near one end of the wall, crowns below mid-height."""
    radius = float(np.clip(0.18 * facade.length, 0.6, 1.3))
    top = min(0.45 * facade.height, 4.5)
    flip = rng.random() < 0.5
    for share, distance in _places(rng, np.linspace(-0.02, 0.3, 12), (1.3, 1.8, 2.4)):
        x = facade.length * (1.0 - share if flip else share)
        radii = (radius, 0.8 * radius, 0.9 * radius)
        yield Foliage((x, -distance, top - radii[2]), radii)


def _cars(facade: Facade, rng: np.random.Generator) -> Iterable[Vehicle]:
    """Cars parked along the wall, some of them partly before a neighbour."""
    for x, distance in _places(rng, np.linspace(-1.5, facade.length + 1.5, 24), (1.7, 2.2, 2.8)):
        yield Vehicle(x, -distance - 0.5 * Vehicle(0.0, 0.0).width)


def _posts(facade: Facade, rng: np.random.Generator) -> Iterable[Post]:
    """Lamp posts at the kerb."""
    height = float(np.clip(0.5 * facade.height, 2.5, 6.0))
    for x, distance in _places(rng, np.linspace(0.05, 0.95, 40) * facade.length, (0.8, 1.2, 1.6)):
        yield Post(x, -distance, height=height)


def _places(
    rng: np.random.Generator, along: NDArray[np.float64], distances: tuple[float, ...]
) -> Iterable[tuple[float, float]]:
    """All pairs of a place along the wall, moved a little at random, and a distance from it."""
    step = float(along[1] - along[0])
    for distance in distances:
        for x in along + step * rng.uniform(-0.4, 0.4, len(along)):
            yield float(x), distance


def _wall_samples(facade: Facade) -> tuple[FloatArray, FloatArray]:
    """A grid of points (n, 3) on the wall and what it is worth to hide each: less beside edges."""
    import shapely

    step = max(0.1, 0.01 * max(facade.length, facade.height))
    grids = np.meshgrid(_centres(facade.length, step), _centres(facade.height, step))
    x, z = (grid.ravel() for grid in grids)
    holes = shapely.union_all([shapely.Polygon(opening.outline) for opening in facade.openings])
    surface = shapely.Polygon(facade.outline).difference(holes)
    on_wall = shapely.contains_xy(surface, x, z)
    worth = np.where(shapely.contains_xy(surface.boundary.buffer(RIM), x, z), -0.25, 1.0)
    return np.column_stack([x, np.zeros(len(x)), z])[on_wall], worth[on_wall]


def _centres(size: float, step: float) -> FloatArray:
    """Places about a step apart over `size`, half a step from its ends."""
    count = max(int(size / step), 2)
    return (np.arange(count) + 0.5) * size / count


def _edge_samples(facade: Facade) -> list[FloatArray]:
    """Points (n, 3) along each jamb and head of the openings, and along each side of the wall."""
    edges = []
    for ring in (facade.outline, *(opening.outline for opening in facade.openings)):
        sides = np.roll(ring, -1, axis=0) - ring
        upright = np.abs(sides[:, 1]) > np.abs(sides[:, 0])
        # Rings run counter-clockwise: up the right side, leftwards along the top, down the left side.
        chosen = [
            upright & (sides[:, 1] > 0.0),
            ~upright & (sides[:, 0] < 0.0),
            upright & (sides[:, 1] < 0.0),
        ]
        if ring is facade.outline:
            chosen.append(~upright & (sides[:, 0] > 0.0))
        edges += [_along(ring[some], sides[some]) for some in chosen if some.any()]
    return edges


def _along(starts: FloatArray, sides: FloatArray) -> FloatArray:
    """Twenty points (n, 3) on each of some segments in the plane of the wall."""
    xz = (starts[:, None] + np.linspace(0.0, 1.0, 20)[:, None] * sides[:, None]).reshape(-1, 2)
    return np.insert(xz, 1, 0.0, axis=1)


def _hidden(body: Body, stations: FloatArray, points: FloatArray) -> NDArray[np.bool_]:
    """Which points (n,) a body hides from each of s stations, (s, n); leaves hide if they stop most rays."""
    even = np.full(len(points), 0.5)
    hidden = []
    for station in stations:
        ray = points - station
        length = np.linalg.norm(ray, axis=1)
        hidden.append(body.hits(station, ray / length[:, None], even).distance < length)
    return np.array(hidden)


def _in_sight(edges: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether enough of each edge is left in sight, given which of its points are lost."""
    return all(lost.mean() <= 1.0 - VISIBLE for lost in edges)
