"""The shapes of an opening's head, and the outlines of openings that have them.

Every head is symmetrical about the opening's middle, so it is described by its right half: a piece of an
ellipse (a circle for arcs and pointed heads) or a straight line from the springing to the crown.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fd2fem.errors import InputError
from fd2fem.model.checks import ONE_CORNER, check_positive
from fd2fem.model.outlines import Outline, Oval, curved_outline

__all__ = ["Head", "HeadKind", "head_outline", "oval_of"]


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
    sigma: float = 0.0
    profile: tuple[tuple[float, float], ...] = ()

    @property
    def rise(self) -> float:
        """Height of the crown above the springing, m."""
        return self.crown - self.springing


def oval_of(head: Head, half: float) -> Oval:
    """The right half of a curved head, x from the opening's middle.

    Parameters
    ----------
    head : Head
        An arc, which rises by at most `half`, an elliptical or a pointed one, which rises by at least that.
    half : float, m
        Half of the opening's width.

    Examples
    --------
    >>> oval_of(Head(HeadKind.ARC, springing=2.0, crown=2.5), 0.5).z
    2.0
    """
    rise = head.rise
    if head.kind is HeadKind.ARC:
        radius = (half**2 + rise**2) / (2.0 * rise)
        start = float(np.arcsin(np.clip(1.0 - rise / radius, -1.0, 1.0)))
        return Oval(0.0, head.crown - radius, radius, radius, start, np.pi / 2.0)
    if head.kind is HeadKind.POINTED:
        radius = (half**2 + rise**2) / (2.0 * half)
        return Oval(half - radius, head.springing, radius, radius, 0.0, float(np.arccos(1.0 - half / radius)))
    return Oval(0.0, head.springing, half, rise, 0.0, np.pi / 2.0)


def head_outline(head: Head, left: float, right: float, bottom: float, tolerance: float) -> Outline:
    """Outline of a whole opening: sill, jambs and head, with exactly its area.

    Parameters
    ----------
    head : Head
    left, right, bottom : float, m
        The straight edges.
    tolerance : float, m
        How far the outline may leave a curve.

    Returns
    -------
    Outline
        From the lower left corner.

    Raises
    ------
    InputError
        If the edges cross or meet.

    Examples
    --------
    >>> round_headed = Head(HeadKind.ARC, springing=1.5, crown=2.0)
    >>> outline = head_outline(round_headed, 0.0, 1.0, 0.0, 0.002)
    >>> from fd2fem.model.checks import signed_area
    >>> bool(abs(signed_area(outline.ring) - 1.5 - np.pi / 8) < 1e-12), len(outline.arcs)
    (True, 2)
    """
    check_positive("tolerance", tolerance)
    if min(right - left, head.crown - bottom) <= ONE_CORNER:
        edges = f"left {left:.3f}, right {right:.3f}, bottom {bottom:.3f}, top {head.crown:.3f} m"
        msg = f"The edges of an opening cross or meet: {edges}."
        raise InputError(msg)
    sill = [(left, bottom), (right, bottom)]
    if head.kind is HeadKind.IRREGULAR:
        return Outline(np.array([*sill, *head.profile]))
    if head.kind is HeadKind.FLAT or head.rise <= ONE_CORNER:
        return Outline(np.array([*sill, (right, head.crown), (left, head.crown)]))
    standing = replace(head, springing=max(head.springing, bottom))
    middle, springing = (left + right) / 2.0, standing.springing
    corners = [*sill, (right, springing), (middle, head.crown), (left, springing)]
    if head.kind is HeadKind.GABLED:
        return curved_outline(corners, {}, tolerance=tolerance)
    half = oval_of(standing, (right - left) / 2.0)
    rising = replace(half, x=middle + half.x)
    falling = replace(half, x=middle - half.x, start=np.pi - half.end, end=np.pi - half.start)
    return curved_outline(corners, {2: rising, 3: falling}, tolerance=tolerance)
