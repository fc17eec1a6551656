"""Where wall points lie beside curved edges: a distance in which a wall of even density looks even."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.heads import Head, HeadKind, oval_of
from fd2fem.reconstruction.edges import edge_position
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["beside_head", "beside_oval", "sampled_edge"]

FloatArray = NDArray[np.float64]


def beside_head(
    head: Head, xz: FloatArray, *, left: float, right: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where points lie beside a head.

    Parameters
    ----------
    head : Head
        Not an irregular one.
    xz : (n, 2) float array, m
    left, right : float, m
        The opening's jambs.

    Returns
    -------
    inward : (n,) float array, m
        Distance from the head, positive above it, such that equal steps of it are equal areas, as beside
        a straight edge. NaN for points that are not beside the head but beside a jamb or around the apex.
    along : (n,) float array, m
        Place along the head, from its middle.
    foot : (n,) float array
        Place of the nearest point of the head, -1 and 1 at the jambs.
    """
    half = (right - left) / 2.0
    across, up = xz[:, 0] - (left + right) / 2.0, xz[:, 1]
    sign, x = np.sign(across), np.abs(across)
    if head.kind is HeadKind.FLAT:
        inward, foot, along = up - head.crown, x.copy(), x.copy()
    elif head.kind is HeadKind.GABLED:
        length = np.hypot(half, head.rise)
        inward = (x * head.rise + (up - head.springing) * half - half * head.rise) / length
        foot = x - inward * head.rise / length
        along = foot * length / half
    else:
        oval = oval_of(head, half)
        dx, dz = x - oval.x, up - oval.z
        inward, nearest = beside_oval(dx, dz, oval.a, oval.b)
        foot = oval.x + nearest[:, 0]
        along = np.arctan2(dx / oval.a, dz / oval.b) * (oval.a + oval.b) / 2.0
        inward = np.where(dz > 0.0, inward, np.nan)
    inward = np.where((foot >= 0.0) & (foot <= half), inward, np.nan)
    return inward, sign * along, sign * foot / half


def beside_oval(dx: FloatArray, dz: FloatArray, a: float, b: float) -> tuple[FloatArray, FloatArray]:
    """Where points lie beside an ellipse about the origin.

    Scaling by k = sqrt(x²/a² + z²/b²) takes the ellipse to the one through the point; the area between the
    two, per metre of the ellipse, is (k² - 1)/2 times the distance of its tangent from the centre.

    Parameters
    ----------
    dx, dz : (n,) float arrays, m
        The points.
    a, b : float, m
        Half axes.

    Returns
    -------
    outward : (n,) float array, m
        Distance from the ellipse such that equal steps of it are equal areas.
    nearest : (n, 2) float array, m
        The place of the ellipse beside each point.

    Examples
    --------
    >>> outward, nearest = beside_oval(np.array([2.0]), np.array([0.0]), 1.0, 1.0)
    >>> outward.tolist(), nearest.tolist()
    ([1.5], [[1.0, 0.0]])
    """
    k = np.maximum(np.hypot(dx / a, dz / b), 1e-9)
    nearest = np.column_stack([dx, dz]) / k[:, None]
    support = 1.0 / np.hypot(nearest[:, 0] / a**2, nearest[:, 1] / b**2)
    return (k**2 - 1.0) / 2.0 * support, nearest


def sampled_edge(
    inward: FloatArray, along: FloatArray, sampling: Sampling, reach: float
) -> tuple[float, float]:
    """Offset of an edge and its standard error, m, by `edge_position`, for points sampled in a known way."""
    return edge_position(
        inward,
        along,
        spacing=sampling.spacing,
        reach=reach,
        noise=sampling.noise,
        exclusion=sampling.exclusion,
    )
