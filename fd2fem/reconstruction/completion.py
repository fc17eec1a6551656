"""Edges of openings that lie in shadow, taken from what lines up with them.

Facades repeat: sills and heads run through a row, jambs through a column, and windows of a row are equally
wide. An edge that was not seen takes the place that its like have, if that lies in the interval that the
shadow leaves; else the middle of the interval, whose standard error is its length over √12.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fd2fem.model import Hole, Side
from fd2fem.model.outlines import Outline

__all__ = ["Draft", "complete_edges"]

IN_LINE = 0.1
"""Edges are in line that differ by less, m."""
BEYOND = 0.05
"""The end of a shadow is known to so much, m."""
COMPLETED_SIGMA = 0.02
"""Standard error of an edge that was taken from two others or more, m, at the least; the double from one."""
ALONGSIDE = 0.5
"""Openings stand side by side that have so much of the lower one's height in common."""

OPPOSITE = {
    Side.LEFT: Side.RIGHT,
    Side.RIGHT: Side.LEFT,
    Side.BOTTOM: Side.TOP,
    Side.TOP: Side.BOTTOM,
}


@dataclass(frozen=True, eq=False)
class Draft:
    """An opening in the making.

    Attributes
    ----------
    number : int
        Of its hole.
    hole : Hole
    position, sigma : mapping of Side to float, m
        Of each edge; a door's bottom is the ground.
    door : bool
    notes : mapping of Side to str
        How an edge that was not seen was completed.
    shape : str
        ``"rectangle"``, or what its head is.
    outline : Outline or None
        Of an opening that is no rectangle.
    """

    number: int
    hole: Hole
    position: Mapping[Side, float]
    sigma: Mapping[Side, float]
    door: bool
    notes: Mapping[Side, str] = field(default_factory=dict)
    shape: str = "rectangle"
    outline: Outline | None = None

    def seen(self, side: Side) -> bool:
        """Whether an edge was seen; the ground under a door was not."""
        return side not in self.hole.unseen and not (self.door and side is Side.BOTTOM)


def complete_edges(drafts: Sequence[Draft]) -> list[Draft]:
    """Give the edges in shadow a place.

    Parameters
    ----------
    drafts : sequence of Draft

    Returns
    -------
    list of Draft
        A door whose foot is hidden becomes a window where windows in line with it have a sill.
    """
    completed = []
    for draft in drafts:
        changed = draft
        for side in draft.hole.unseen:
            changed = _complete(changed, side, drafts)
        completed.append(changed)
    return completed


def _complete(draft: Draft, side: Side, drafts: Sequence[Draft]) -> Draft:
    """A draft with one unseen edge put in its place."""
    low, high = draft.hole.unseen[side]
    found = np.empty(0)
    for witnesses in _witnesses(draft, side, drafts):
        places = np.array(witnesses)
        found = places[(places > low - BEYOND) & (places < high + BEYOND)]
        if len(found):
            break
    door = draft.door
    if len(found):
        place = float(np.median(found))
        sigma = max(float(np.std(found)), COMPLETED_SIGMA * (1.0 if len(found) > 1 else 2.0))
        note = f"hidden; taken from {len(found)} opening{'s' * (len(found) > 1)} in line with it"
        door = door and side is not Side.BOTTOM
    elif door and side is Side.BOTTOM:
        place, sigma = draft.position[side], (high - low) / np.sqrt(12.0)
        note = "hidden; it may be a window, not a door"
    else:
        place, sigma = (low + high) / 2.0, (high - low) / np.sqrt(12.0)
        note = f"hidden; somewhere on {high - low:.2f} m"
    if not _keeps_order(draft, side, place):
        return draft
    return replace(
        draft,
        position={**draft.position, side: place},
        sigma={**draft.sigma, side: float(sigma)},
        door=door,
        notes={**draft.notes, side: note},
    )


def _keeps_order(draft: Draft, side: Side, place: float) -> bool:
    """Whether an edge stays on its side of the opposite one."""
    other = draft.position[OPPOSITE[side]]
    return place < other if side in {Side.LEFT, Side.BOTTOM} else place > other


def _witnesses(draft: Draft, side: Side, drafts: Sequence[Draft]) -> Iterator[list[float]]:
    """Where others say that an opening has an edge that it does not show, the better witnesses first."""
    opposite = OPPOSITE[side]
    others = [other for other in drafts if other is not draft and other.seen(side)]
    like = [other for other in others if draft.seen(opposite) and other.seen(opposite)]
    yield [
        other.position[side]
        for other in like
        if abs(other.position[opposite] - draft.position[opposite]) < IN_LINE
    ]
    if not side.vertical:
        yield [other.position[side] for other in others if _overlap(draft, other, Side.BOTTOM) > ALONGSIDE]
    # As wide as the others of its row, as high as those of its column.
    sign = 1.0 if side in {Side.RIGHT, Side.TOP} else -1.0
    yield [
        draft.position[opposite] + sign * abs(other.position[side] - other.position[opposite])
        for other in like
        if _aligned(draft, other, across=side.vertical)
    ]
    if side.vertical:
        yield [other.position[side] for other in others if _overlap(draft, other, Side.LEFT) > 0.0]


def _aligned(one: Draft, other: Draft, *, across: bool) -> bool:
    """Whether two openings stand in one row (their heads are in line), or in one column (their jambs are)."""
    sides = (Side.TOP,) if across else (Side.LEFT, Side.RIGHT)
    return all(abs(one.position[side] - other.position[side]) < IN_LINE for side in sides)


def _overlap(one: Draft, other: Draft, start: Side) -> float:
    """Share of the smaller of two openings' extents, upwards or along the wall, that they have in common."""
    end = OPPOSITE[start]
    common = min(one.position[end], other.position[end]) - max(one.position[start], other.position[start])
    sizes = [draft.position[end] - draft.position[start] for draft in (one, other)]
    return common / max(min(sizes), 1e-9)
