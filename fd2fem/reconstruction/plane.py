"""The facade's plane in a raw scan, and which points lie on it.

The search tries vertical planes through pairs of points that stand above others, so that the pavement makes
no proposals. The points are thinned to cells first, and a cell counts with the square root of its points:
less than by points, for these crowd near the scanner, but more than by area, for glass returns few of its
rays and must not outweigh the wall around it. The plane that comes out is refined by least squares.
"""

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from fd2fem.errors import ReconstructionError
from fd2fem.model import FacadeFrame, FacadePoints, PointCloud
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["NOTHING_TELLS", "find_facade", "point_spacing", "thin_points"]

FloatArray = NDArray[np.float64]

THINNING = 0.05
"""Edge of the cells that stand for the points in the search, m."""
PLAN_CELL = 0.10
"""Edge of the plan grid, m."""
UPRIGHT = 3
"""A plan cell with points at so many heights belongs to something that stands."""
HYPOTHESES = 1500
"""Pairs of points tried; with a tenth of the points on the wall, fifteen pairs lie on it."""
SAMPLE = 15_000
"""Cells that the hypotheses are scored on."""
NEAR_PLANE = 0.03
"""Distance from the plane, m, at which a point stops to speak for it."""
IN_FRONT = 0.5
"""A parallel plane up to so far before the best one, m, with half of its points, is the wall's face."""
MAX_LEAN = np.radians(10.0)
"""A plane that leans more is not a wall."""
GAP = 0.5
"""Parts of a wall further apart than this belong to different walls, m."""
MIN_WALL = 1.0
"""Smallest length and height of a wall, m."""
MIN_POINTS = 30
"""Fewest points that show a wall, or the pavement before it."""
DUPLICATE = 1e-4
"""Points on the wall closer than this are one, m: a triangulation cannot use them apart."""
NOTHING_TELLS = "nothing in the scan: y points as in a drawing"
NEAR_ORIGIN = 500.0
"""A wall nearer to the world's origin was probably scanned from there, m."""


def thin_points(points: FloatArray, cell: float) -> NDArray[np.intp]:
    """Indices of one point in each occupied cell of a cubic grid.

    Parameters
    ----------
    points : (n, d) float array, m
    cell : float, m

    Examples
    --------
    >>> thin_points(np.array([[0.0, 0.0], [0.1, 0.1], [1.5, 0.0]]), 1.0).tolist()
    [0, 2]
    """
    return np.sort(_cells(points, cell)[0])


def _cells(points: FloatArray, cell: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Index of the first point in each occupied cell, and how many points each holds."""
    cells = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    key = np.zeros(len(cells), dtype=np.int64)
    for axis in range(cells.shape[1]):
        key = key * (int(cells[:, axis].max()) + 1) + cells[:, axis]
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    return first, count


def point_spacing(xz: FloatArray) -> float:
    """Typical distance between neighbours, m: 1/√density, from the eighth neighbours of a sample.

    Parameters
    ----------
    xz : (n, 2) float array, m
        At least nine points.
    """
    # Picked along x, so that the order of the points does not matter.
    sample = xz[np.argsort(xz[:, 0], kind="stable")[:: max(1, len(xz) // 2000)]]
    distance = cKDTree(xz).query(sample, k=9)[0][:, 8]
    return float(np.median(distance) * np.sqrt(np.pi / 8.0))


def find_facade(cloud: PointCloud, *, options: ReconstructionOptions) -> FacadePoints:
    """Find the dominant wall of a scan and sort the points by it.

    Parameters
    ----------
    cloud : PointCloud
        May hold ground, rooms, neighbours and street objects.
    options : ReconstructionOptions

    Returns
    -------
    FacadePoints
        In a frame whose origin lies on the wall's plane; the boundary lines move it to the corner.

    Raises
    ------
    ReconstructionError
        If no vertical plane of at least 1 x 1 m stands out.
    """
    centre = np.median(cloud.points, axis=0)
    points = cloud.points - centre
    first, count = _cells(points, THINNING)
    thin, weight = points[first], np.sqrt(count)
    on_plane, normal = _refine_plane(thin, weight, *_search_plane(thin, weight, options.seed))
    depth = (thin - on_plane) @ normal
    sign, outside_by = _inward_sign(thin, depth, normal, on_plane, centre)
    if len(cloud.scanners):
        toward = np.median((cloud.scanners - centre - on_plane) @ normal)
        sign, outside_by = (-1.0 if toward > 0 else 1.0), "the scanner's position"
    shift = _face_before(thin, weight, sign * depth, normal)
    if shift:
        on_plane, normal = _refine_plane(thin, weight, on_plane + sign * shift * normal, normal)
    frame = _settle(cloud.points, FacadeFrame(centre + on_plane, _axes(sign * normal)))
    return _sort_points(cloud, frame, outside_by, options)


def _settle(points: FloatArray, frame: FacadeFrame) -> FacadeFrame:
    """The frame of the least-squares plane through all points of the wall.

    The search sees a sample that depends on the order of the points; this fit does not.
    """
    for _ in range(4):
        local = frame.to_facade(points)
        near = np.flatnonzero(np.abs(local[:, 1]) < NEAR_PLANE)
        if len(near) < MIN_POINTS:
            break
        wall = local[near[_largest_part(local[near][:, [0, 2]])]]
        middle = np.median(wall[:, 1])
        scatter = 1.4826 * float(np.median(np.abs(wall[:, 1] - middle)))
        wall = wall[np.abs(wall[:, 1] - middle) < max(3.0 * scatter, 1e-4)]
        on_plane = wall.mean(axis=0)
        normal = np.linalg.eigh(np.cov((wall - on_plane).T))[1][:, 0]
        inward = (normal * np.sign(normal[1])) @ frame.axes
        frame = FacadeFrame(frame.to_world(on_plane[None])[0], _axes(inward))
    return frame


def _search_plane(points: FloatArray, weight: FloatArray, seed: int) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of the vertical plane that most of the weight lies near."""
    plan = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / PLAN_CELL).astype(np.int64)
    column = np.unique(plan[:, 0] * (plan[:, 1].max() + 1) + plan[:, 1], return_inverse=True)[1].ravel()
    standing = np.flatnonzero(np.bincount(column)[column] >= UPRIGHT)
    rng = np.random.default_rng(seed)
    if len(standing) < MIN_POINTS:
        msg = "No wall found: no points stand above others; check that z points up and the units are right."
        raise ReconstructionError(msg)
    first, second = points[rng.choice(standing, (2, HYPOTHESES))]
    along = (second - first)[:, :2]
    span = np.hypot(along[:, 0], along[:, 1])
    usable = span > MIN_WALL / 2
    if not usable.any():
        msg = f"No wall found: what stands upright is less than {MIN_WALL} m long; check the units."
        raise ReconstructionError(msg)
    first, along, span = first[usable], along[usable], span[usable]
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / span[:, None]
    offsets = np.einsum("ij,ij->i", normals, first[:, :2])
    order = rng.permutation(standing)
    # A tenth of the sample tells which hypotheses deserve the whole of it.
    rough = _scores(points[order[: SAMPLE // 10]], weight[order[: SAMPLE // 10]], normals, offsets)
    short = np.argsort(-rough, kind="stable")[: HYPOTHESES // 15]
    where, worth = points[order[:SAMPLE]], weight[order[:SAMPLE]]
    fine = _scores(where, worth, normals[short], offsets[short])
    best, most = int(short[0]), 0.0
    for number in short[np.argsort(-fine, kind="stable")].tolist():
        distance = where[:, :2] @ normals[number] - offsets[number]
        value = _spread(where, worth, np.abs(distance) < NEAR_PLANE, normals[number])
        if value > most:
            best, most = number, value
    return first[best], np.append(normals[best], 0.0)


def _spread(points: FloatArray, weight: FloatArray, near: NDArray[np.bool_], normal: FloatArray) -> float:
    """Weight of the largest connected part of a plane, times the area that it spans with its openings.

    By its points alone, a strip of a blank neighbour could outweigh a wall that is mostly windows.
    """
    if near.sum() < MIN_POINTS:
        return 0.0
    flat = np.column_stack([points[near][:, :2] @ [-normal[1], normal[0]], points[near][:, 2]])
    part = _largest_part(flat)
    hull = shapely.convex_hull(shapely.linestrings(flat[part]))
    return float(weight[near][part].sum() * shapely.area(hull))


def _scores(points: FloatArray, weight: FloatArray, normals: FloatArray, offsets: FloatArray) -> FloatArray:
    """Weight near each vertical plane, less of it the farther from the plane (MSAC)."""
    distance = normals[:, :1] * points[:, 0] + normals[:, 1:] * points[:, 1] - offsets[:, None]
    near: FloatArray = np.maximum(0.0, 1.0 - (distance / NEAR_PLANE) ** 2)
    score: FloatArray = np.einsum("ij,j->i", near, weight)
    return score


def _refine_plane(
    points: FloatArray, weight: FloatArray, on_plane: FloatArray, normal: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of the least-squares plane through the points near a first guess."""
    for _ in range(8):
        distance = (points - on_plane) @ normal
        near = np.abs(distance) < NEAR_PLANE
        if near.sum() < 3:
            break
        scatter = 1.4826 * np.median(np.abs(distance[near] - np.median(distance[near])))
        near &= np.abs(distance - np.median(distance[near])) < max(4.0 * scatter, 0.1 * NEAR_PLANE)
        chosen, share = points[near], weight[near] / weight[near].sum()
        on_plane = share @ chosen
        away = chosen - on_plane
        candidate = np.linalg.eigh((away * share[:, None]).T @ away)[1][:, 0]
        if abs(candidate[2]) > np.sin(MAX_LEAN):
            msg = (
                f"No wall found: the best plane leans by more than {np.degrees(MAX_LEAN):.0f} degrees; "
                "check that z points up."
            )
            raise ReconstructionError(msg)
        normal = candidate * np.sign(candidate @ normal)
    return on_plane, normal


def _face_before(points: FloatArray, weight: FloatArray, depth: FloatArray, normal: FloatArray) -> float:
    """Depth (negative, m) of a parallel plane before the best one that is rather the wall's face, or 0.

    Where openings take up most of a wall, blinds and frames can hold more points than the wall itself.
    """
    along = points @ np.array([-normal[1], normal[0], 0.0])
    near = np.abs(depth) < NEAR_PLANE
    low, high = np.percentile(along[near], [2, 98])
    beside = (along > low) & (along < high) & (points[:, 2] > np.percentile(points[near, 2], 10))
    edges = np.arange(-IN_FRONT - 0.01, NEAR_PLANE + 0.02, 0.02)
    count, _ = np.histogram(depth[beside], edges, weights=weight[beside])
    pair = count[:-1] + count[1:]
    front = np.flatnonzero((pair > 0.5 * pair.max()) & (edges[1:-1] < -1.5 * NEAR_PLANE))
    return float(edges[front[0] + 1]) if len(front) else 0.0


def _inward_sign(
    points: FloatArray, depth: FloatArray, normal: FloatArray, on_plane: FloatArray, centre: FloatArray
) -> tuple[float, str]:
    """+1 where `normal` points into the wall, -1 where out of it, and what told so."""
    foot = np.percentile(points[np.abs(depth) < NEAR_PLANE][:, 2], 1)
    away = np.abs(depth)
    street = (np.abs(points[:, 2] - foot) < 0.4) & (away > 0.5) & (away < 10.0)
    reveals = (points[:, 2] > foot + 1.0) & (away > 0.06) & (away < 0.5)
    # The pavement lies outside; reveals, frames and glass lie inside.
    for votes, inside, name in (
        (depth[street], -1.0, "the pavement before the wall"),
        (depth[reveals], 1.0, "reveals and frames behind its face"),
    ):
        balance = np.sign(votes).mean() if len(votes) > 20 else 0.0
        if abs(balance) > 0.3:
            return float(np.sign(balance) * inside), name
    to_origin = float(-(centre + on_plane) @ normal)
    if abs(to_origin) > 0.5 and np.linalg.norm(centre) < NEAR_ORIGIN:
        return (-1.0 if to_origin > 0 else 1.0), "the origin of the coordinates, taken for the scanner"
    # Nothing tells the sides apart: as in a drawing, y points away from the viewer.
    inward = normal[1] > 0 if abs(normal[1]) > 1e-6 else normal[0] > 0
    return (1.0 if inward else -1.0), NOTHING_TELLS


def _axes(inward: FloatArray) -> FloatArray:
    """Rows X (right, level), Y (into the wall), Z (up the wall)."""
    right = np.cross(inward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.array([right, inward, np.cross(right, inward)])


def _sort_points(
    cloud: PointCloud, frame: FacadeFrame, outside_by: str, options: ReconstructionOptions
) -> FacadePoints:
    """Sort all points into on the wall, in front of it and behind it."""
    local = frame.to_facade(cloud.points)
    depth = local[:, 1]
    near = np.abs(depth) < NEAR_PLANE
    scatter = 1.4826 * float(np.median(np.abs(depth[near] - np.median(depth[near]))))
    band = float(np.clip(4.0 * scatter, 0.015, 0.06)) if options.wall_band is None else options.wall_band
    on_wall = np.flatnonzero(np.abs(depth) < band)
    on_wall = on_wall[_largest_part(local[on_wall][:, [0, 2]])]
    _check_wall(local, on_wall, band)
    ground = _ground_level(local, on_wall)
    if ground is not None:
        # Where the pavement meets the plane, its points lie in the band and would join the wall.
        clear = ground + max(3.0 * scatter, 0.02)
        on_wall = on_wall[local[on_wall, 2] > clear]
    on_wall = on_wall[thin_points(local[on_wall][:, [0, 2]], DUPLICATE)]
    xz = local[on_wall][:, [0, 2]]
    return FacadePoints(
        xz=xz,
        depth=depth[on_wall],
        front=local[depth < -band],
        behind=local[depth > band],
        scanners=frame.to_facade(cloud.scanners),
        frame=frame,
        rms=float(np.sqrt(np.mean(depth[on_wall] ** 2))),
        spacing=point_spacing(xz),
        ground=ground,
        outside_by=outside_by,
    )


def _largest_part(xz: FloatArray) -> NDArray[np.intp]:
    """Indices of the points of the largest connected part, parts being `GAP` apart."""
    cells = np.floor((xz - xz.min(axis=0)) / GAP).astype(np.int64)
    image = np.zeros(cells.max(axis=0) + 1, dtype=bool)
    image[cells[:, 0], cells[:, 1]] = True
    label, count = ndimage.label(image, structure=np.ones((3, 3)))
    size = ndimage.sum_labels(image, label, np.arange(1, count + 1))
    return np.flatnonzero(label[cells[:, 0], cells[:, 1]] == 1 + int(np.argmax(size)))


def _check_wall(local: FloatArray, on_wall: NDArray[np.intp], band: float) -> None:
    """Raise unless the chosen points make a wall: large enough, and denser than the space beside it."""
    xz = local[on_wall][:, [0, 2]]
    low, high = xz.min(axis=0), xz.max(axis=0)
    if len(on_wall) < MIN_POINTS or (high - low).min() < MIN_WALL:
        msg = (
            f"No wall found: the largest vertical plane holds {len(on_wall)} of {len(local)} points on "
            f"{high[0] - low[0]:.2f} x {high[1] - low[1]:.2f} m, expected at least {MIN_POINTS} points "
            f"on {MIN_WALL} x {MIN_WALL} m; check the units and that z points up."
        )
        raise ReconstructionError(msg)
    within = ((local[:, [0, 2]] >= low) & (local[:, [0, 2]] <= high)).all(axis=1)
    beside = np.abs(local[within, 1])
    beside = (beside > band) & (beside < 3.0 * band)
    if beside.sum() > len(on_wall):
        msg = "No wall found: no vertical plane is denser than the space beside it."
        raise ReconstructionError(msg)


def _ground_level(local: FloatArray, on_wall: NDArray[np.intp]) -> float | None:
    """Level of the pavement at the wall's foot, m, or ``None`` where the scan does not show it."""
    left, right = np.percentile(local[on_wall, 0], [1, 99])
    foot = local[on_wall, 2].min()
    street = local[(local[:, 1] < -0.1) & (local[:, 1] > -3.0) & (local[:, 0] > left) & (local[:, 0] < right)]
    street = street[np.abs(street[:, 2] - foot) < 1.0]
    if len(street) < MIN_POINTS:
        return None
    street = street[thin_points(street[:, :2], PLAN_CELL)]
    level = np.median(street[:, 2])
    flat = street[np.abs(street[:, 2] - level) < 0.15]
    # Cars and bushes stand on it, so it must hold most of the plan cells to count as the pavement.
    if len(flat) < 0.5 * len(street) or len(flat) < MIN_POINTS:
        return None
    # A pavement falls away from the wall: its level at the wall is that of a plane fitted to it.
    table = np.column_stack([np.ones(len(flat)), flat[:, 1]])
    for _ in range(3):
        fit, *_ = np.linalg.lstsq(table, flat[:, 2], rcond=None)
        off = np.abs(flat[:, 2] - table @ fit)
        keep = off <= max(3.0 * 1.4826 * float(np.median(off)), 0.005)
        flat, table = flat[keep], table[keep]
    return float(fit[0])
