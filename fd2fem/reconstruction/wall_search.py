"""The search for walls: which vertical planes of a raw scan could be the one to reconstruct.

The search tries vertical planes through pairs of points that stand above others, so that the pavement makes
no proposals. The points are thinned to cells first, and a cell counts with the square root of its points:
less than by points, for these crowd near the scanner, but more than by area, for glass returns few of its
rays and must not outweigh the wall around it. The best plane is refined by least squares, which lets it lean,
its points are taken out, and the search goes on with the rest. The planes that come out are then compared by
what they span.
"""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.reconstruction.walls import (
    MIN_POINTS,
    MIN_WALL,
    NEAR_PLANE,
    Cells,
    Wall,
    is_dense,
    measure_wall,
    robust_scatter,
    same_wall,
    stands_before,
)

__all__ = ["refine_plane", "search_walls"]

FloatArray = NDArray[np.float64]

PLAN_CELL = 0.10
"""Edge of the plan grid, m."""
UPRIGHT = 3
"""A plan cell with points at so many levels, :data:`PLAN_CELL` apart, belongs to something that stands."""
HYPOTHESES = 1500
"""Pairs of points tried; with a tenth of the points on the wall, fifteen pairs lie on it."""
NEARBY = 200
"""Half of the pairs are taken from so many neighbours in plan: few of them straddle two walls."""
SAMPLE = 15_000
"""Cells that the hypotheses are scored on."""
PLANES = 12
"""Planes that are compared by what they span."""
MAX_LEAN = np.radians(10.0)
"""A plane that leans more is not a wall."""
SPAN = 0.1
"""A plane that spans a smaller share of what the best one does is not listed."""


def search_walls(cells: Cells, scanners: FloatArray, seed: int) -> tuple[Wall, ...]:
    """Find the walls of a scan, the best one first.

    What stands before the best one takes its place: a room's back wall, seen through a large opening, can
    span as much. Planes that lie in a better one's depth and extent (frames, blinds) are no walls of
    their own.

    Parameters
    ----------
    cells : Cells
    scanners : (s, 3) float array, m
    seed : int

    Raises
    ------
    ReconstructionError
        If nothing stands upright, or only planes that lean too much.
    """
    found = _planes(cells, scanners, seed)
    found.sort(key=lambda wall: -wall.value)
    best = found[0]
    for wall in found[1:]:
        if stands_before(wall, best, scanners):
            best = wall
    walls = [best]
    for wall in found:
        large = (wall.high - wall.low).min() >= MIN_WALL and wall.span >= SPAN * best.span
        if large and is_dense(wall, cells) and not any(same_wall(wall, other) for other in walls):
            walls.append(wall)
    return tuple(walls)


def _planes(cells: Cells, scanners: FloatArray, seed: int) -> list[Wall]:
    """The planes with the most weight, each without the points of those before it."""
    rng = np.random.default_rng(seed)
    standing = _standing(cells.points)
    normals, places = _hypotheses(cells.points[standing], rng)
    chosen = rng.permutation(standing)[:SAMPLE]
    points, hits = cells.points[chosen], cells.count[chosen] * (len(standing) / len(chosen))
    left = np.sqrt(hits)
    # A part of the sample tells which plane comes next.
    some = slice(SAMPLE // 5)
    scores = _closeness(points[some], normals, places)
    found, leaning = [], 0
    for _ in range(PLANES):
        number = int(np.argmax(scores @ left[some].astype(np.float32)))
        on_plane, normal = refine_plane(points, left, places[number], normals[number])
        near = np.flatnonzero((np.abs((points - on_plane) @ normal) < NEAR_PLANE) & (left > 0.0))
        if len(near) == 0:
            break
        if abs(normal[2]) > np.sin(MAX_LEAN):
            leaning += 1
        else:
            wall, part = measure_wall(points[near], hits[near], (on_plane, normal), scanners)
            found.append(wall)
            # Another wall may stand in the same plane, farther along.
            near = near[part]
        left[near] = 0.0
    if not found:
        why = (
            f"the best plane leans by more than {np.degrees(MAX_LEAN):.0f} degrees; check that z points up."
            if leaning
            else "no plane holds points; check that z points up and the units are right."
        )
        msg = f"No wall found: {why}"
        raise ReconstructionError(msg)
    return found


def _standing(points: FloatArray) -> NDArray[np.intp]:
    """Indices of the points in plan cells that hold points at several levels, in the order of the cells."""
    cells = np.floor((points - points.min(axis=0)) / PLAN_CELL).astype(np.int64)
    column = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]
    order = np.argsort(column, kind="stable")
    starts = np.flatnonzero(np.diff(column[order], prepend=-1))
    number = np.cumsum(np.diff(column[order], prepend=-1) > 0) - 1
    # Sorted by hand: np.unique takes three times as long.
    level = np.sort(number * (cells[:, 2].max() + 1) + cells[order, 2])
    levels = level[np.diff(level, prepend=-1) > 0] // (cells[:, 2].max() + 1)
    standing: NDArray[np.intp] = order[np.bincount(levels, minlength=len(starts))[number] >= UPRIGHT]
    if len(standing) < MIN_POINTS:
        msg = "No wall found: no points stand above others; check that z points up and the units are right."
        raise ReconstructionError(msg)
    return standing


def _hypotheses(points: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Normals (h, 3) of vertical planes through pairs of points, and a point (h, 3) on each."""
    first, second = rng.integers(len(points), size=(2, HYPOTHESES))
    half = HYPOTHESES // 2
    # The points run through the plan column by column, so that neighbours in a column are near in plan.
    second[:half] = (first[:half] + rng.integers(1, NEARBY, size=half)) % len(points)
    along = (points[second] - points[first])[:, :2]
    span = np.hypot(along[:, 0], along[:, 1])
    usable = span > MIN_WALL / 2
    if not usable.any():
        msg = f"No wall found: what stands upright is less than {MIN_WALL} m long; check the units."
        raise ReconstructionError(msg)
    along = along[usable] / span[usable, None]
    return np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))]), points[first][usable]


def _closeness(points: FloatArray, normals: FloatArray, places: FloatArray) -> NDArray[np.float32]:
    """How near points (k, 3) are to each of h planes, (h, k): 1 on the plane, 0 beyond (MSAC)."""
    offsets = np.einsum("ij,ij->i", normals, places)
    distance = (normals @ points.T - offsets[:, None]).astype(np.float32)
    distance /= np.float32(NEAR_PLANE)
    np.multiply(distance, distance, out=distance)
    np.subtract(1.0, distance, out=distance)
    near: NDArray[np.float32] = np.maximum(distance, 0.0, out=distance)
    return near


def refine_plane(
    points: FloatArray, weight: FloatArray, on_plane: FloatArray, normal: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of the least-squares plane through the points near a first guess."""
    last = np.empty(0, dtype=np.intp)
    for _ in range(8):
        distance = points @ normal - on_plane @ normal
        near = np.flatnonzero((np.abs(distance) < NEAR_PLANE) & (weight > 0.0))
        if len(near) < 3:
            break
        scatter = robust_scatter(distance[near])
        middle = np.median(distance[near])
        near = near[np.abs(distance[near] - middle) < max(4.0 * scatter, 0.1 * NEAR_PLANE)]
        if np.array_equal(near, last):
            break
        last = near
        chosen, share = points[near], weight[near] / weight[near].sum()
        on_plane = share @ chosen
        away = chosen - on_plane
        candidate = np.linalg.eigh((away * share[:, None]).T @ away)[1][:, 0]
        normal = candidate if candidate @ normal >= 0.0 else -candidate
    return on_plane, normal
