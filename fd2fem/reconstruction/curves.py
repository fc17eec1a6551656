"""The shapes of an opening's head, and of round windows, and how to draw them.

Every head is symmetrical about the opening's middle, so it is described by its right half: a piece of an
ellipse (a circle for arcs and pointed heads) or a straight line from the springing to the crown.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive

__all__ = ["Head", "HeadKind", "Oval", "Round", "head_outline", "head_rise", "oval_of", "round_outline"]

FloatArray = NDArray[np.float64]


class HeadKind(StrEnum):
    """Shape of an opening's upper edge."""

    FLAT = "flat"
    ARC = "arc"
    ELLIPTICAL = "elliptical"
    POINTED = "pointed"
    GABLED = "gabled"
    IRREGULAR = "irregular"


@dataclass(frozen=True)
class Head:
    """The upper edge of an opening.

    Attributes
    ----------
    kind : HeadKind
        Flat; an arc of a circle, segmental to round; half an ellipse (three-centred arches too); two arcs
        about centres at the springing that meet in a point; two straight slopes; none of these.
    springing, crown : float, m
        Heights where the jambs end and of the highest point; equal for a flat head.
    sigma : float, m
        Standard error of the crown.
    profile : tuple of (x, z) pairs, m
        An irregular head from the right jamb to the left; empty for the others.
    """

    kind: HeadKind
    springing: float
    crown: float
    sigma: float
    profile: tuple[tuple[float, float], ...] = ()

    @property
    def rise(self) -> float:
        """Height of the crown above the springing, m."""
        return self.crown - self.springing


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


@dataclass(frozen=True)
class Oval:
    """The piece of an ellipse that makes the right half of a head; x from the opening's middle.

    A point at the angle `start` lies at the springing, one at `end` at the crown.
    """

    x: float
    z: float
    a: float
    b: float
    start: float
    end: float


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


def oval_of(head: Head, half: float) -> Oval:
    """The ellipse that a curved head is a piece of; `half` is half of the opening's width, m."""
    rise = head.rise
    if head.kind is HeadKind.ARC:
        radius = (half**2 + rise**2) / (2.0 * rise)
        return Oval(
            0.0, head.crown - radius, radius, radius, np.arcsin(np.clip(1 - rise / radius, -1, 1)), np.pi / 2
        )
    if head.kind is HeadKind.POINTED:
        radius = (half**2 + rise**2) / (2.0 * half)
        return Oval(half - radius, head.springing, radius, radius, 0.0, np.arccos(1 - half / radius))
    return Oval(0.0, head.springing, half, rise, 0.0, np.pi / 2)


def _area_above_springing(head: Head, half: float) -> float:
    """Exact area between a head and the line through its springings, m²."""
    if head.kind is HeadKind.ELLIPTICAL:
        return float(np.pi / 2.0 * half * head.rise)
    if head.kind is HeadKind.GABLED:
        return half * head.rise
    oval = oval_of(head, half)

    def under_circle(t: float) -> float:
        return (
            float(t * np.sqrt(max(oval.a**2 - t**2, 0.0)) + oval.a**2 * np.arcsin(min(t / oval.a, 1.0))) / 2
        )

    from_centre, to = -oval.x, half - oval.x
    return 2.0 * (under_circle(to) - under_circle(from_centre)) - 2.0 * half * (head.springing - oval.z)


def head_outline(head: Head, left: float, right: float, bottom: float, tolerance: float) -> FloatArray:
    """Outline of a whole opening: sill, jambs and head.

    The corners lie so far outside of a curve that the polygon has the opening's true area.

    Parameters
    ----------
    head : Head
    left, right, bottom : float, m
        The straight edges.
    tolerance : float, m
        How far the outline may leave the curve.

    Returns
    -------
    (k, 2) float array, m
        Counter-clockwise from the lower left.

    Raises
    ------
    InputError
        If the edges cross.

    Examples
    --------
    >>> round_headed = Head(HeadKind.ARC, springing=1.5, crown=2.0, sigma=0.003)
    >>> ring = head_outline(round_headed, 0.0, 1.0, 0.0, 0.002)
    >>> from fd2fem.model.checks import signed_area
    >>> abs(signed_area(ring) - 1.5 - np.pi / 8) < 1e-5
    True
    """
    check_positive("tolerance", tolerance)
    if right <= left or head.crown <= bottom:
        msg = f"The edges of an opening cross: left {left:.3f}, right {right:.3f}, bottom {bottom:.3f}, " + (
            f"top {head.crown:.3f} m."
        )
        raise InputError(msg)
    sill = np.array([[left, bottom], [right, bottom]])
    if head.kind is HeadKind.IRREGULAR:
        return np.concatenate([sill, np.array(head.profile)])
    springing = max(head.springing, bottom)
    if head.kind is HeadKind.FLAT:
        return np.concatenate([sill, [[right, head.crown], [left, head.crown]]])
    standing = Head(head.kind, springing, head.crown, head.sigma)
    corners = _head_corners(standing, (right - left) / 2.0, tolerance)
    middle = (left + right) / 2.0
    # The right half runs from the springing to the crown; its mirror image leads down again.
    x = middle + np.concatenate([corners[:, 0], -corners[-2::-1, 0]])
    z = np.concatenate([corners[:, 1], corners[-2::-1, 1]])
    x[0], x[-1] = right, left
    ring = np.concatenate([sill, np.column_stack([x, z])])
    kept: FloatArray = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-9]
    return kept


def _head_corners(head: Head, half: float, tolerance: float) -> FloatArray:
    """Corners of the right half, springing first, crown last; x from the middle."""
    ends = np.array([[half, head.springing], [0.0, head.crown]])
    if head.kind is HeadKind.GABLED:
        return ends
    oval = oval_of(head, half)
    chords = max(2, _chords(oval.end - oval.start, max(oval.a, oval.b), tolerance))
    angle = np.linspace(oval.start, oval.end, chords + 1)
    corners = np.column_stack([oval.x + oval.a * np.cos(angle), oval.z + oval.b * np.sin(angle)])
    corners[[0, -1]] = ends
    x, z = corners.T
    # Raising the corners between by as much as the chords cut off keeps springing and crown in place.
    lost = _area_above_springing(head, half) / 2.0 - float(np.sum((x[:-1] - x[1:]) * (z[:-1] + z[1:])) / 2.0)
    lost += half * head.springing
    normal = np.column_stack([np.cos(angle) / oval.a, np.sin(angle) / oval.b])[1:-1]
    normal /= np.hypot(*normal.T)[:, None]
    side = corners[2:] - corners[:-2]
    gain = float(np.sum(normal[:, 0] * side[:, 1] - normal[:, 1] * side[:, 0]) / 2.0)
    corners[1:-1] += lost / gain * normal
    return corners


def _chords(sweep: float, radius: float, tolerance: float) -> int:
    """How many chords keep within a tolerance of an arc."""
    step = 2.0 * np.arccos(max(1.0 - tolerance / radius, 0.5))
    return int(np.ceil(abs(sweep) / step - 1e-9))


def round_outline(window: Round, tolerance: float) -> FloatArray:
    """Outline of a round window, counter-clockwise, with exactly its area.

    Parameters
    ----------
    window : Round
    tolerance : float, m
        How far the outline may leave the curve.

    Returns
    -------
    (k, 2) float array, m

    Examples
    --------
    >>> from fd2fem.model.checks import signed_area
    >>> ring = round_outline(Round(2.0, 5.0, 0.5, 0.5, 0.003), 0.002)
    >>> abs(signed_area(ring) - np.pi / 4) < 1e-12
    True
    """
    check_positive("tolerance", tolerance)
    quarter = max(2, _chords(np.pi / 2.0, max(window.half_width, window.half_height), tolerance))
    count = 4 * quarter
    angle = 2.0 * np.pi * np.arange(count) / count
    # A polygon of n corners on a circle covers n/(2π)·sin(2π/n) of it.
    scale = np.sqrt(2.0 * np.pi / count / np.sin(2.0 * np.pi / count))
    return np.column_stack(
        [
            window.x + scale * window.half_width * np.cos(angle),
            window.z + scale * window.half_height * np.sin(angle),
        ]
    )
