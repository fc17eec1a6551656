"""Heights of curved heads that are fitted to points, and round windows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.heads import HeadKind
from fd2fem.model.outlines import Outline, Oval, oval_outline

__all__ = ["Round", "head_rise", "round_outline"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Round:
    """A round window: a circle, or an ellipse with upright and level axes.

    Attributes
    ----------
    x, z : float, m
        Centre.
    half_width, half_height : float, m
        Equal for a circle.
    sigma : float, m
        Standard error of each of the four extreme positions.
    """

    x: float
    z: float
    half_width: float
    half_height: float
    sigma: float


def head_rise(kind: HeadKind, u: FloatArray, *, rise: FloatArray | float, half: float) -> FloatArray:
    """Height of a head above its springing.

    Parameters
    ----------
    kind : HeadKind
    u : float array
        Place along the head, -1 and 1 at the jambs; broadcast against `rise`.
    rise : float array, m
        Height of the crown above the springing.
    half : float, m
        Half of the opening's width.

    Examples
    --------
    >>> head_rise(HeadKind.ARC, np.array([-1.0, 0.0, 0.6]), rise=0.5, half=0.5).round(6).tolist()
    [0.0, 0.5, 0.4]
    """
    rise = np.asarray(rise, dtype=np.float64)
    if kind is HeadKind.ARC:
        radius = (half**2 + rise**2) / (2.0 * rise)
        height = np.sqrt(np.maximum(radius**2 - (u * half) ** 2, 0.0)) - radius + rise
    elif kind is HeadKind.POINTED:
        radius = (half**2 + rise**2) / (2.0 * half)
        height = np.sqrt(np.maximum(radius**2 - (np.abs(u) * half + radius - half) ** 2, 0.0))
    elif kind is HeadKind.ELLIPTICAL:
        height = rise * np.sqrt(np.maximum(1.0 - u**2, 0.0))
    elif kind is HeadKind.GABLED:
        height = rise * (1.0 - np.abs(u))
    else:
        height = rise * np.ones_like(u)
    return np.asarray(height, dtype=np.float64)


def round_outline(window: Round, tolerance: float) -> Outline:
    """Outline of a round window, counter-clockwise, with exactly its area.

    Parameters
    ----------
    window : Round
    tolerance : float, m
        How far the outline may leave the curve.

    Examples
    --------
    >>> from fd2fem.model.checks import signed_area
    >>> outline = round_outline(Round(2.0, 5.0, 0.5, 0.5, 0.003), 0.002)
    >>> bool(abs(signed_area(outline.ring) - np.pi / 4) < 1e-12), len(outline.arcs)
    (True, 4)
    """
    whole = Oval(window.x, window.z, window.half_width, window.half_height, 0.0, 2.0 * np.pi)
    return oval_outline(whole, tolerance=tolerance)
