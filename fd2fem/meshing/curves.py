"""Arcs of a facade in as many chords as the elements need; its area stays the same."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Arc, Facade, arc_angles, arc_corners, facet_arc

__all__ = ["refacet"]

FloatArray = NDArray[np.float64]

ON_LEVEL = 1e-6
"""An arc passes a level if it reaches further than this, m, to either side."""
MOST_TURN = 0.5
"""Two neighbouring chords differ in direction by at most this, radians."""


def refacet(facade: Facade, *, size: float, tolerance: float) -> Facade:
    """The facade with its arcs in chords about `size` long, as close to the curve as `tolerance`, both m.

    An arc that passes a storey's level stays as it is: its area would be kept, but not on either side.
    """
    levels = [storey.z for storey in facade.storeys]
    outline, arcs = _refacet_ring(facade.outline, facade.arcs, levels, size=size, tolerance=tolerance)
    openings = []
    for opening in facade.openings:
        ring, own = _refacet_ring(opening.outline, opening.arcs, levels, size=size, tolerance=tolerance)
        openings.append(replace(opening, outline=ring, arcs=own))
    try:
        return replace(facade, outline=outline, arcs=arcs, openings=tuple(openings))
    except InputError:
        # Lines nearer to each other than the tolerance would cross or touch.
        return facade


def _refacet_ring(
    ring: FloatArray, arcs: Sequence[Arc], levels: Sequence[float], *, size: float, tolerance: float
) -> tuple[FloatArray, tuple[Arc, ...]]:
    """A ring and its arcs anew."""
    if not arcs:
        return ring, ()
    ordered = sorted(arcs, key=lambda arc: arc.first)
    corners: list[FloatArray] = []
    renumbered = []
    for arc, following in zip(ordered, [*ordered[1:], ordered[0]], strict=True):
        run = arc_corners(arc, ring)
        z = run[:, 1]
        if not any(z.min() + ON_LEVEL < level < z.max() - ON_LEVEL for level in levels):
            run = _chords(arc, ring, run, size=size, tolerance=tolerance)
        first = sum(len(part) for part in corners)
        renumbered.append((arc, first, first + len(run) - 1))
        plain = (following.first - arc.last) % len(ring) if len(arcs) > 1 or not arc.whole else 0
        between = ring[(arc.last + 1 + np.arange(max(plain - 1, 0))) % len(ring)]
        corners += [run[:-1], *([run[-1:], between] if plain else [])]
    anew = np.vstack(corners)
    return anew, tuple(replace(a, first=i % len(anew), last=j % len(anew)) for a, i, j in renumbered)


def _chords(arc: Arc, ring: FloatArray, run: FloatArray, *, size: float, tolerance: float) -> FloatArray:
    """Corners of an arc, ends included: an even number of chords."""
    start, end = arc_angles(arc, ring)
    turn, radius = abs(end - start), max(arc.a, arc.b)
    step = min(size / radius, np.sqrt(8.0 * tolerance / radius), MOST_TURN)
    count = 2 * max(1, int(np.ceil(turn / step / 2.0)))
    corners = facet_arc(arc, start, end, count=count)
    if not arc.whole:
        corners[[0, -1]] = run[[0, -1]]
        return corners
    step = turn / count
    centre = np.array([arc.x, arc.z])
    out = np.sqrt(step / np.sin(step)) * np.array([arc.a, arc.b])
    angle = np.linspace(start, end, count + 1)
    return np.asarray(centre + out * np.column_stack([np.cos(angle), np.sin(angle)]))
