"""Arcs cut where storeys begin, so that the wall above and below have exactly its parts' areas."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.arcs import Arc, arc_angles, arc_corners, facet_arc

__all__ = ["cut_arcs"]

FloatArray = NDArray[np.float64]

NEAR = 1e-6
"""An arc is not cut closer to its ends than this, m."""
FULL_TURN = 2.0 * np.pi


def cut_arcs(
    ring: FloatArray, arcs: Sequence[Arc], levels: Iterable[float]
) -> tuple[FloatArray, tuple[Arc, ...]]:
    """Corners (k, 2), m, and arcs of an outline whose arcs that pass a level are parted there.

    Each part has corners of its own, which have its area; outlines with nothing to cut stay as they are.

    Examples
    --------
    >>> from fd2fem.model.outlines import Oval, oval_outline
    >>> disc = oval_outline(Oval(0.0, 0.0, 1.0, 1.0, 0.0, 0.0), tolerance=0.01)
    >>> ring, arcs = cut_arcs(disc.ring, disc.arcs, [0.6])
    >>> len(disc.arcs), len(arcs), [round(x, 9) for x, z in ring.tolist() if z == 0.6]
    (4, 6, [0.8, -0.8])
    """
    cuts = {arc.first: _cuts(arc, ring, levels) for arc in arcs}
    if not any(cuts.values()):
        return ring, tuple(arcs)
    by_first = {arc.first: arc for arc in arcs}
    inside = {(arc.first + 1 + k) % len(ring) for arc in arcs for k in range(len(arc_corners(arc, ring)) - 2)}
    corner = start = next(number for number in range(len(ring)) if number not in inside)
    corners: list[FloatArray] = []
    parts: list[tuple[int, int, Arc]] = []
    count = 0
    while count == 0 or corner != start:
        arc = by_first.get(corner)
        pieces = [ring[[corner, corner]]] if arc is None else _pieces(arc, ring, cuts[corner])
        for piece in pieces:
            if arc is not None:
                parts.append((count, count + len(piece) - 1, arc))
            corners.append(piece[:-1])
            count += len(piece) - 1
        corner = (corner + 1) % len(ring) if arc is None else arc.last
    cut = [replace(arc, first=first, last=last % count) for first, last, arc in parts]
    return np.concatenate(corners), tuple(cut)


def _cuts(arc: Arc, ring: FloatArray, levels: Iterable[float]) -> list[tuple[float, float]]:
    """Angles at which an arc passes levels, in its sense, and the levels."""
    start, end = arc_angles(arc, ring)
    low, high = sorted((start, end))
    near = 0.0 if arc.whole else NEAR / min(arc.a, arc.b)
    found = []
    for level in levels:
        sine = (level - arc.z) / arc.b
        if abs(sine) < 1.0:
            rising = np.arcsin(sine)
            turned = [a + FULL_TURN * np.ceil((low - a) / FULL_TURN) for a in (rising, np.pi - rising)]
            found += [(float(a), level) for a in turned if low + near < a < high - near]
    return sorted(found, reverse=end < start)


def _pieces(arc: Arc, ring: FloatArray, cuts: list[tuple[float, float]]) -> list[FloatArray]:
    """Corners of the parts of an arc, the ends of each included."""
    corners = arc_corners(arc, ring)
    if not cuts:
        return [corners]
    start, end = arc_angles(arc, ring)
    step = abs(end - start) / (len(corners) - 1)
    angles = [angle for angle, _ in cuts]
    # A closed curve is opened at its first cut.
    stops = [*angles, angles[0] + (end - start)] if arc.whole else [start, *angles, end]
    pieces = []
    for low, high in pairwise(stops):
        chords = max(2, int(np.ceil(abs(high - low) / step - 1e-9)))
        pieces.append(facet_arc(arc, low, high, count=chords))
    for piece, (_, level) in zip(pieces if arc.whole else pieces[1:], cuts, strict=True):
        piece[0, 1] = level
    if not arc.whole:
        pieces[0][0], pieces[-1][-1] = corners[0], corners[-1]
    return pieces
