"""Round windows: openings whose lower edge is as curved as their upper one."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.heads import HeadKind
from fd2fem.reconstruction.beside_curves import beside_oval, sampled_edge
from fd2fem.reconstruction.curves import Round
from fd2fem.reconstruction.head_columns import Hidden
from fd2fem.reconstruction.heads import fit_head
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["fit_round"]

FloatArray = NDArray[np.float64]

CURVED = frozenset({HeadKind.ARC, HeadKind.ELLIPTICAL, HeadKind.POINTED})
"""What half of a round window may be taken for."""
STRAIGHT = 0.4
"""Share of a round window's height that may look like straight jambs."""
REACH = 6.0
"""Depth of wall, in spacings, that positions are read from."""
ROUNDS = 4
"""So often is the window moved to where the points beside it say that it is."""
SAME = 0.03
"""Half axes that differ by a smaller share, or by less than three standard errors, are a circle's."""


def fit_round(
    wall_xz: FloatArray,
    *,
    low: FloatArray,
    high: FloatArray,
    sampling: Sampling,
    hidden: Hidden | None = None,
) -> Round | None:
    """Decide whether an opening is round and fit it.

    Parameters
    ----------
    wall_xz : (n, 2) float array, m
        The wall's points around the opening, as far around as the wall is whole, best by eight spacings.
    low, high : (2,) float arrays, m
        Its rough rectangle.
    sampling : Sampling
    hidden : function or None
        Tells for places (k, 2) on the wall whether something hid them from the scanner.

    Returns
    -------
    Round or None
        None unless upper and lower corners hold wall points and hardly any of the jambs is straight.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> wall = rng.uniform(0, 2, (10_000, 2))
    >>> wall = wall[np.hypot(*(wall - 1).T) > 0.5]
    >>> sampling = Sampling(spacing=0.02, noise=0.0, exclusion=0.0)
    >>> window = fit_round(wall, low=np.array([0.5, 0.5]), high=np.array([1.5, 1.5]), sampling=sampling)
    >>> abs(window.half_width - 0.5) < 0.005, window.half_width == window.half_height
    (True, True)
    """
    ends = _curved_ends(wall_xz, low, high, sampling, hidden)
    if ends is None:
        return None
    window = Round(
        x=float(low[0] + high[0]) / 2.0,
        z=(ends[0] + ends[1]) / 2.0,
        half_width=float(high[0] - low[0]) / 2.0,
        half_height=(ends[1] - ends[0]) / 2.0,
        sigma=sampling.spacing,
    )
    for _ in range(ROUNDS):
        window = _moved(window, wall_xz, sampling, circle=False)
    unlike = abs(window.half_width - window.half_height)
    if unlike < max(3.0 * np.sqrt(2.0) * window.sigma, SAME * window.half_width):
        radius = (window.half_width + window.half_height) / 2.0
        window = replace(window, half_width=radius, half_height=radius)
        window = _moved(window, wall_xz, sampling, circle=True)
    return window


def _curved_ends(
    wall_xz: FloatArray, low: FloatArray, high: FloatArray, sampling: Sampling, hidden: Hidden | None
) -> tuple[float, float] | None:
    """Heights of the lowest and the highest point, if both ends are curved and nearly meet."""
    middle = float(low[1] + high[1]) / 2.0
    left, right = float(low[0]), float(high[0])
    upper = fit_head(wall_xz, left=left, right=right, middle=middle, sampling=sampling, hidden=hidden)
    if upper.kind not in CURVED:
        return None
    mirror = np.array([1.0, -1.0])
    lower = fit_head(
        wall_xz * mirror,
        left=left,
        right=right,
        middle=-middle,
        sampling=sampling,
        hidden=None if hidden is None else lambda xz: hidden(xz * mirror),
    )
    straight = upper.springing + lower.springing
    if lower.kind not in CURVED or straight > STRAIGHT * (upper.crown + lower.crown):
        return None
    return -lower.crown, upper.crown


def _moved(window: Round, wall_xz: FloatArray, sampling: Sampling, *, circle: bool) -> Round:
    """Move centre and half axes to where the points beside four quarters of the edge say that they are."""
    spacing = sampling.spacing
    a, b = window.half_width, window.half_height
    dx, dz = wall_xz[:, 0] - window.x, wall_xz[:, 1] - window.z
    inward, _ = beside_oval(dx, dz, a, b)
    angle = np.arctan2(dz / b, dx / a)
    reach = max(REACH * spacing, 0.1)
    rows, offsets, sigmas = [], [], []
    for centre in np.arange(4) * np.pi / 2.0:
        turned = (angle - centre + np.pi) % (2.0 * np.pi) - np.pi
        near = (np.abs(turned) < np.pi / 4.0) & (inward > -4.0 * spacing) & (inward < reach)
        offset, sigma = sampled_edge(inward[near], turned[near] * (a + b) / 2.0, sampling, reach)
        rows.append(_sensitivity(a, b, centre, circle=circle))
        offsets.append(offset)
        sigmas.append(sigma)
    matrix, weight = np.array(rows), 1.0 / np.array(sigmas) ** 2
    covariance = np.linalg.inv(matrix.T @ (weight[:, None] * matrix))
    change = covariance @ (matrix.T @ (weight * offsets))
    extreme = covariance[0, 0] + covariance[1, 1] + covariance[2:, 2:].trace()
    return Round(
        x=float(window.x + change[0]),
        z=float(window.z + change[1]),
        half_width=float(a + change[2]),
        half_height=float(b + change[-1]),
        sigma=float(np.sqrt(extreme / 2.0)),
    )


def _sensitivity(a: float, b: float, centre: float, *, circle: bool) -> list[float]:
    """How far a quarter of the edge moves outward, in the mean, per metre of x, z and the half axes."""
    t = centre + np.linspace(-np.pi / 4.0, np.pi / 4.0, 33)
    normal = np.column_stack([np.cos(t) / a, np.sin(t) / b])
    normal /= np.hypot(*normal.T)[:, None]
    length = np.hypot(a * np.sin(t), b * np.cos(t))
    length /= length.sum()
    in_x, in_z = length @ normal
    of_a, of_b = length @ (normal * np.column_stack([np.cos(t), np.sin(t)]))
    return [in_x, in_z, of_a + of_b] if circle else [in_x, in_z, of_a, of_b]
