"""The facade's plane in a raw scan, its frame, and which points lie on it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fd2fem.errors import InputError, ReconstructionError
from fd2fem.model import FacadeFrame, FacadePoints, PointCloud
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.wall_search import (
    MIN_POINTS,
    MIN_WALL,
    NEAR_PLANE,
    PLAN_CELL,
    THINNING,
    face_before,
    largest_part,
    occupied_cells,
    refine_plane,
    robust_scatter,
    search_plane,
    thin_points,
)

__all__ = ["NOTHING_TELLS", "find_facade", "point_spacing"]

FloatArray = NDArray[np.float64]

RIVAL = 0.5
"""Another wall that spans a larger share of the chosen one's is worth a word."""
STEP_BACK = 0.4
"""A wall may go on so far out of its plane, m."""
FARTHEST = 500.0
"""No terrestrial scanner stands farther from the wall, m."""
DUPLICATE = 1e-4
"""Points on the wall closer than this are one, m: a triangulation cannot use them apart."""
NOTHING_TELLS = "nothing in the scan: y points as in a drawing"
NEAR_ORIGIN = 500.0
"""A wall nearer to the world's origin was probably scanned from there, m."""


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
    if len(cloud) < MIN_POINTS:
        msg = f"No wall found: the scan has {len(cloud)} points, expected at least {MIN_POINTS}."
        raise ReconstructionError(msg)
    centre = np.median(cloud.points, axis=0)
    points = cloud.points - centre
    scanners = cloud.scanners - centre
    first, count = occupied_cells(points, THINNING)
    thin, weight = points[first], np.sqrt(count)
    on_plane, normal, rival = search_plane(thin, count, scanners, options.seed)
    on_plane, normal = refine_plane(thin, weight, on_plane, normal)
    depth = (thin - on_plane) @ normal
    if len(scanners):
        sign, outside_by = _away_from(scanners, on_plane, normal), "the scanner's position"
    else:
        sign, outside_by = _inward_sign(thin, depth, normal, on_plane, centre)
    shift = face_before(thin, weight, sign * depth, normal)
    if shift:
        on_plane, normal = refine_plane(thin, weight, on_plane + sign * shift * normal, normal)
    frame = _settle(cloud.points, FacadeFrame(centre + on_plane, _axes(sign * normal)))
    sorted_points = _sort_points(cloud, frame, outside_by, options)
    return replace(sorted_points, warnings=_warnings(sorted_points, rival))


def _away_from(scanners: FloatArray, on_plane: FloatArray, normal: FloatArray) -> float:
    """+1 where the normal points away from the scanners, -1 where to them."""
    distance = (scanners - on_plane) @ normal
    if np.abs(distance).min() < 0.1 or np.abs(distance).max() > FARTHEST:
        worst = np.abs(distance).max() if np.abs(distance).max() > FARTHEST else np.abs(distance).min()
        msg = (
            f"A scanner's position is {worst:.6g} m from the wall's plane, expected 0.1 to {FARTHEST:g} m: "
            "give it in the coordinates of the scan."
        )
        raise InputError(msg)
    if distance.min() < 0.0 < distance.max():
        msg = "The scanners' positions lie on both sides of the wall: give only those outside."
        raise InputError(msg)
    return -1.0 if distance[0] > 0 else 1.0


def _warnings(points: FacadePoints, rival: float) -> tuple[str, ...]:
    """What may be wrong with the choice of the wall."""
    warnings = []
    if points.outside_by == NOTHING_TELLS:
        warnings.append(
            "Nothing in the scan tells the outside of the wall: if the facade comes out mirrored, "
            "give the scanner's position."
        )
    if rival > RIVAL:
        warnings.append(
            f"Another wall spans {100 * rival:.0f} % as much as the one that was taken; if it is the one you "
            "want, cut the scan to it or give the scanner's position before it."
        )
    (left, bottom), (right, top) = points.xz.min(axis=0), points.xz.max(axis=0)
    for side in (points.front, points.behind):
        beyond = side[(np.abs(side[:, 1]) < STEP_BACK) & (side[:, 0] > left) & (side[:, 0] < right)]
        beyond = beyond[(beyond[:, 2] > top + 0.2) | (beyond[:, 2] < bottom - 0.2)]
        area = len(thin_points(beyond[:, [0, 2]], 0.2)) * 0.2**2 if len(beyond) else 0.0
        if area > 1.0:
            warnings.append(
                f"{area:.0f} m² of what may be the same wall go on above or below it, "
                f"{np.median(beyond[:, 1]):+.2f} m out of its plane; they were left out."
            )
    return tuple(warnings)


def _settle(points: FloatArray, frame: FacadeFrame) -> FacadeFrame:
    """The frame of the least-squares plane through all points of the wall.

    The search sees a sample that depends on the order of the points; this fit does not.
    """
    for _ in range(4):
        local = frame.to_facade(points)
        near = np.flatnonzero(np.abs(local[:, 1]) < NEAR_PLANE)
        if len(near) < MIN_POINTS:
            break
        wall = local[near[largest_part(local[near][:, [0, 2]])]]
        middle = np.median(wall[:, 1])
        scatter = robust_scatter(wall[:, 1])
        wall = wall[np.abs(wall[:, 1] - middle) < max(3.0 * scatter, 1e-4)]
        on_plane = wall.mean(axis=0)
        normal = np.linalg.eigh(np.cov((wall - on_plane).T))[1][:, 0]
        inward = (normal * np.sign(normal[1])) @ frame.axes
        frame = FacadeFrame(frame.to_world(on_plane[None])[0], _axes(inward))
    return frame


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
    scatter = robust_scatter(depth[np.abs(depth) < NEAR_PLANE])
    band = float(np.clip(4.0 * scatter, 0.015, 0.06)) if options.wall_band is None else options.wall_band
    on_wall = np.flatnonzero(np.abs(depth) < band)
    on_wall = on_wall[largest_part(local[on_wall][:, [0, 2]])]
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
    # The space beside is twice as wide as the band: an even cloud holds twice as many points there.
    if beside.sum() > 1.5 * len(on_wall):
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
