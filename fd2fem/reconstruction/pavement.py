"""The pavement before a wall: a plane that may fall away from the wall and rise along it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.reconstruction.thinning import thin_points
from fd2fem.reconstruction.walls import MIN_POINTS

__all__ = ["Pavement", "find_pavement"]

FloatArray = NDArray[np.float64]

PLAN_CELL = 0.10
"""Edge of the plan grid, m."""
STRIP = 3.0
"""Width of the pavement that tells its level at the wall, m."""
NARROWEST = 0.5
"""A narrower strip is a ledge of the wall, m."""
EVEN = 0.15
"""A pavement leaves its plane by less than this, m."""
STEEPEST = 0.15
"""A pavement rises less than this along the wall, m/m."""
UNEVEN, SLOPE = 0.01, 0.03
"""Standard deviations of a pavement from its plane, m, and of the slopes that pavements have, m/m."""
NEAR = 0.03
"""Distance from a plane at which a point stops to speak for it, m."""
TRIES = 60
"""Planes that are tried."""
CLEAR = 0.02
"""The wall begins so far above the pavement, m."""


@dataclass(frozen=True)
class Pavement:
    """Level z of the pavement at the wall's face at `x` = 0, m, and its rise along the wall, m/m."""

    level: float
    slope: float

    def level_at(self, x: float) -> float:
        """Level at a place along the wall, m."""
        return self.level + self.slope * x

    def clear_of(self, local: FloatArray, scatter: float) -> NDArray[np.bool_]:
        """Which points (m, 3), m, lie so far above it that they belong to a wall, given their scatter, m.

        Where the pavement meets the wall's plane, its own points lie on that plane.
        """
        return self.above(local) > max(3.0 * scatter, CLEAR)

    def above(self, local: FloatArray) -> FloatArray:
        """How far points (m, 3), m, lie above it, (m,) m."""
        height: FloatArray = local[:, 2] - (self.level + self.slope * local[:, 0])
        return height


def find_pavement(local: FloatArray, box: tuple[FloatArray, FloatArray]) -> Pavement | None:
    """Level of the pavement along the wall's foot, or ``None`` where the scan does not show it.

    Parameters
    ----------
    local : (k, 3) float array, m
        Of the scan, facade frame.
    box : two (2,) float arrays, m
        Lower and upper corner of the wall.
    """
    (left, foot), (right, _) = box
    x, y, z = local.T
    before = (y < -0.1) & (y > -STRIP) & (x > left) & (x < right) & (np.abs(z - foot) < 1.0)
    street = local[before]
    if len(street) < MIN_POINTS:
        return None
    everything, street = street, street[thin_points(street[:, :2], PLAN_CELL)]
    middle = 0.5 * (left + right)
    # The part of the wall whose pavement is in sight may be too short to tell a slope along it.
    sloped = np.ptp(street[:, 0]) >= 0.5 * (right - left)

    def terms(points: FloatArray) -> FloatArray:
        along = points[:, 0] - middle if sloped else np.zeros(len(points))
        return np.column_stack([np.ones(len(points)), along, points[:, 1]])

    table = terms(street)
    fit = _flat_fit(table, street[:, 2])
    off = np.abs(street[:, 2] - table @ fit)
    flat = off < EVEN
    # Cars and bushes stand on it, so it must hold most of the plan cells to count as the pavement.
    if flat.sum() < max(0.5 * len(street), MIN_POINTS) or abs(fit[1]) > STEEPEST:
        return None
    # A string course has a level top, too, but a narrow one.
    if np.percentile(-street[flat, 1], 90) < NARROWEST:
        return None
    # Which points the cells kept depends on how the axes lie; that all of them say does not.
    table, level = terms(everything), everything[:, 2]
    keep = np.abs(level - table @ fit) < NEAR
    table, level = table[keep], level[keep]
    for _ in range(3):
        fit = _least_squares(table, level)
        off = np.abs(level - table @ fit)
        keep = off <= max(3.0 * 1.4826 * float(np.median(off)), 0.005)
        table, level = table[keep], level[keep]
    # A pavement falls away from the wall: its level at the wall is that of its plane.
    return Pavement(float(fit[0] - fit[1] * middle), float(fit[1]))


def _flat_fit(table: FloatArray, level: FloatArray) -> FloatArray:
    """Coefficients of the plane that most points lie near: level ones and those through three points."""
    rng = np.random.default_rng(0)
    flat = np.zeros((TRIES, 3))
    flat[:, 0] = np.quantile(level, np.linspace(0.0, 1.0, TRIES))
    triples = rng.integers(0, len(level), (TRIES, 3))
    sloped = np.array([np.linalg.lstsq(table[triple], level[triple], rcond=None)[0] for triple in triples])
    sloped = sloped[(np.abs(sloped[:, 1:]) < STEEPEST).all(axis=1)]
    fits = np.concatenate([flat, sloped])
    near = (np.abs(level - fits @ table.T) < NEAR).sum(axis=1)
    # Of planes with as many points, the first, which is a level one.
    return _least_squares(*_beside(table, level, fits[int(np.argmax(near))]))


def _beside(table: FloatArray, level: FloatArray, fit: FloatArray) -> tuple[FloatArray, FloatArray]:
    near = np.abs(level - table @ fit) < NEAR
    return table[near], level[near]


def _least_squares(table: FloatArray, level: FloatArray) -> FloatArray:
    """Coefficients of the plane of least squares; what the points do not show of its slopes is taken as 0."""
    prior = np.diag([0.0, UNEVEN / SLOPE, UNEVEN / SLOPE])
    fit: FloatArray = np.linalg.lstsq(
        np.concatenate([table, prior]), np.concatenate([level, np.zeros(3)]), rcond=None
    )[0]
    return fit
