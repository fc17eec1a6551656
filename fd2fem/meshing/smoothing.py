"""Moves the inner nodes of quadrilaterals so that the worst of them get better."""

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["corner_quality", "smooth"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
Objective = Callable[[FloatArray], tuple[float, FloatArray]]

ROUNDS = ((0.1, 15), (1e-3, 45))
"""Part of an element's area that the penalty forgives, and steps of the minimiser, in each round."""
MEMORY = 8
"""Steps from which the minimiser learns."""
FIRST_STEP = 0.02
"""First step over that of Newton's method for a spring as stiff as an element is large."""
SUFFICIENT = 1e-4
"""Part of the decrease that the slope promises which a step must bring."""
HALVINGS = 15
"""Times that a step is halved before the minimiser gives up."""


def corner_quality(points: FloatArray, quads: IntArray) -> FloatArray:
    """Scaled Jacobian (q,) of each quadrilateral: the sine of its worst corner, less than 0 if folded."""
    corner = points[quads]
    after, before = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    area = after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]
    length = np.linalg.norm(after, axis=2) * np.linalg.norm(before, axis=2)
    return np.asarray((area / np.maximum(length, np.finfo(float).tiny)).min(axis=1))


def smooth(points: FloatArray, quads: IntArray, *, fixed: BoolArray) -> FloatArray:
    """Points (n, 2), moved but for the `fixed` ones, that minimise a penalty on corners that are not square.

    The penalty is the square of 1 / sin of each corner, and as much of the ratio of its sides, so that bad
    corners count most. It is regularised, and so leads out of folded elements as well.

    References
    ----------
    Knupp, Algebraic mesh quality metrics, SIAM J. Sci. Comput. 23, 2001; Escobar et al., Simultaneous
    untangling and smoothing of tetrahedral meshes, Comput. Methods Appl. Mech. Eng. 192, 2003.
    """
    free = np.flatnonzero(~fixed)
    if not len(free):
        return points
    moved = points.copy()
    edges = points[quads] - np.roll(points[quads], 1, axis=1)
    scale = np.repeat(np.mean(np.sum(edges**2, axis=2), axis=1), 4)
    around = np.bincount(quads.ravel(), scale, len(points)) / np.bincount(
        quads.ravel(), minlength=len(points)
    )
    for forgiven, steps in ROUNDS:

        def objective(place: FloatArray, forgiven: FloatArray = forgiven * scale) -> tuple[float, FloatArray]:
            moved[free] = place
            value, gradient = _penalty(moved, quads, forgiven)
            return value, gradient[free]

        moved[free] = _minimise(objective, moved[free], around[free, None], steps=steps)
    return moved


def _minimise(objective: Objective, x: FloatArray, stiffness: FloatArray, *, steps: int) -> FloatArray:
    """Where the objective is least, by the limited-memory BFGS method with backtracking.

    Numpy's and scipy's own products of vectors as long as these would wait for threads, so they are not used.
    `stiffness` (n, 1), m²: square of the length by which each row of x may move.

    References
    ----------
    Nocedal, Updating quasi-Newton matrices with limited storage, Math. Comput. 35, 1980.
    """
    value, gradient = objective(x)
    pairs: deque[tuple[FloatArray, FloatArray, float]] = deque(maxlen=MEMORY)
    for _ in range(steps):
        direction = -_inverse_hessian(pairs, gradient, stiffness)
        slope = _dot(direction, gradient)
        step = 1.0
        for _ in range(HALVINGS):
            trial, following = objective(x + step * direction)
            if trial <= value + SUFFICIENT * step * slope:
                break
            step /= 2.0
        else:
            break
        moved, change = step * direction, following - gradient
        curvature = _dot(moved, change)
        if curvature > 0.0:
            pairs.append((moved, change, curvature))
        x, value, gradient = x + moved, trial, following
    return x


def _inverse_hessian(
    pairs: deque[tuple[FloatArray, FloatArray, float]], gradient: FloatArray, stiffness: FloatArray
) -> FloatArray:
    """Product of the approximate inverse Hessian, learnt from `pairs` of steps, with the gradient."""
    product, parts, factor = gradient.copy(), [], FIRST_STEP
    for moved, change, curvature in reversed(pairs):
        parts.append(_dot(moved, product) / curvature)
        product -= parts[-1] * change
    if pairs:
        _, change, curvature = pairs[-1]
        factor = curvature / _dot(change, stiffness * change)
    product *= factor * stiffness
    for (moved, change, curvature), part in zip(pairs, reversed(parts), strict=True):
        product += (part - _dot(change, product) / curvature) * moved
    return product


def _dot(a: FloatArray, b: FloatArray) -> float:
    return float(np.sum(a * b))


def _penalty(points: FloatArray, quads: IntArray, forgiven: FloatArray) -> tuple[float, FloatArray]:
    """Penalty of all corners and its gradient (n, 2)."""
    corner = points[quads]
    a = (np.roll(corner, -1, axis=1) - corner).reshape(-1, 2)
    b = (np.roll(corner, 1, axis=1) - corner).reshape(-1, 2)
    aa, bb = np.einsum("ki,ki->k", a, a), np.einsum("ki,ki->k", b, b)
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    root = np.sqrt(area**2 + 4.0 * forgiven**2)
    # Half of area + root, written so that nothing cancels.
    regular = np.where(area > 0.0, 0.5 * (area + root), 2.0 * forgiven**2 / (root - np.minimum(area, 0.0)))
    slope = regular / root
    # The penalty is aa·bb / regular² + (mean / regular)².
    mean = 0.5 * (aa + bb)
    top = aa * bb + mean**2
    value = top / regular**2
    by_area = -2.0 * top / regular**3 * slope
    by_aa, by_bb = (bb + mean) / regular**2, (aa + mean) / regular**2
    by_a = 2.0 * by_aa[:, None] * a + by_area[:, None] * np.column_stack([b[:, 1], -b[:, 0]])
    by_b = 2.0 * by_bb[:, None] * b + by_area[:, None] * np.column_stack([-a[:, 1], a[:, 0]])
    own = quads.ravel()
    after, before = np.roll(quads, -1, axis=1).ravel(), np.roll(quads, 1, axis=1).ravel()
    gradient = np.empty_like(points)
    for axis in (0, 1):
        gradient[:, axis] = (
            np.bincount(after, by_a[:, axis], len(points))
            + np.bincount(before, by_b[:, axis], len(points))
            - np.bincount(own, by_a[:, axis] + by_b[:, axis], len(points))
        )
    return float(value.sum()), gradient
