"""Openings that are no rectangles: arched, pointed and gabled heads, round windows."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.model import Side
from fd2fem.model.heads import Head, HeadKind, head_outline
from fd2fem.reconstruction.completion import Draft
from fd2fem.reconstruction.curves import Round, round_outline
from fd2fem.reconstruction.heads import fit_head
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.rays import is_hidden
from fd2fem.reconstruction.rounds import fit_round
from fd2fem.reconstruction.sampling import Sampling, points_in_box
from fd2fem.reconstruction.strips import Place, View, edge_beside, sampling_at, seen_place

__all__ = ["fit_tops"]

FloatArray = NDArray[np.float64]
Hidden = Callable[[FloatArray], NDArray[np.bool_]]

ABOVE = 8.0
"""Wall around an opening that is looked at, in point spacings."""
JAMB = 8.0
"""A jamb is read from its points where it is so many point spacings long."""
TALL = 1.3
"""In an opening that is so much higher than wide, nothing below its middle belongs to the head."""
ROUND = 0.93
"""An opening that fills more of its rectangle is not round: a circle fills π/4, a gap in the points more."""


def fit_tops(view: View, drafts: Sequence[Draft], *, options: ReconstructionOptions) -> list[Draft]:
    """Give the openings their outlines where those are no rectangles.

    Parameters
    ----------
    view : View
    drafts : sequence of Draft
    options : ReconstructionOptions
    """
    return [_shaped(view, draft, options) if draft.seen(Side.TOP) else draft for draft in drafts]


def _shaped(view: View, draft: Draft, options: ReconstructionOptions) -> Draft:
    """One opening with the shape that its points show."""
    hole = draft.hole
    low, high = hole.low, hole.high
    sampling = sampling_at(view, np.array([low[0] + hole.width / 2.0, high[1]]))
    wall = _around(view, low, high, sampling)
    if not draft.door and not hole.unseen and hole.evidence["rectangularity"] < ROUND:
        # Its outline runs through the first points of the wall, half a spacing outside of the edge.
        extent = (
            hole.loop.min(axis=0) + sampling.spacing / 2.0,
            hole.loop.max(axis=0) - sampling.spacing / 2.0,
        )
        window = fit_round(wall, low=extent[0], high=extent[1], sampling=sampling, hidden=_hidden(view))
        if window is not None:
            return _round(draft, window, options)
    return _headed(view, draft, wall, sampling, options)


def _around(view: View, low: FloatArray, high: FloatArray, sampling: Sampling) -> FloatArray:
    """The wall's points (n, 2) around a rectangle, those on its face only."""
    margin = ABOVE * sampling.spacing
    near = points_in_box(view.points, low - margin, high + margin)
    near = near[np.abs(view.points.depth[near]) < max(2.0 * view.points.rms, 1e-4)]
    return view.points.xz[near]


def _hidden(view: View) -> Hidden:
    """Tells which places on the wall lie in shadow."""
    return lambda places: is_hidden(view.shadows, places)


def _round(draft: Draft, window: Round, options: ReconstructionOptions) -> Draft:
    """A round window."""
    position = {
        Side.LEFT: window.x - window.half_width,
        Side.RIGHT: window.x + window.half_width,
        Side.BOTTOM: window.z - window.half_height,
        Side.TOP: window.z + window.half_height,
    }
    outline = round_outline(window, options.curve_tolerance)
    shape = "circle" if window.half_width == window.half_height else "ellipse"
    return replace(
        draft, position=position, sigma=dict.fromkeys(Side, window.sigma), outline=outline, shape=shape
    )


def _headed(
    view: View, draft: Draft, wall: FloatArray, sampling: Sampling, options: ReconstructionOptions
) -> Draft:
    """An opening with straight jambs and the head that its points show."""
    hole = draft.hole
    # Jambs that were fitted over the full height are too close together where the head is an arch.
    jambs = (float(hole.low[0]), float(hole.high[0]))
    head = _head(view, wall, jambs, draft, sampling)
    if head.kind is HeadKind.FLAT:
        return draft
    position, sigma = dict(draft.position), dict(draft.sigma)
    place = seen_place(draft.number, hole)
    place = Place(draft.number, place.low, np.array([place.high[0], head.springing]))
    for side, rough in zip((Side.LEFT, Side.RIGHT), jambs, strict=True):
        if draft.seen(side) and head.springing - hole.z > JAMB * sampling.spacing:
            position[side], sigma[side] = edge_beside(view, place, side, rough)
        elif draft.seen(side):
            position[side], sigma[side] = rough, sampling.spacing
    left, right = position[Side.LEFT], position[Side.RIGHT]
    head = _head(view, wall, (left, right), draft, sampling)
    if head.kind is HeadKind.FLAT or head.springing <= position[Side.BOTTOM]:
        return draft
    outline = head_outline(head, left, right, position[Side.BOTTOM], options.curve_tolerance)
    if not shapely.Polygon(outline.ring).is_valid:
        return draft
    position[Side.TOP], sigma[Side.TOP] = head.crown, head.sigma
    return replace(draft, position=position, sigma=sigma, outline=outline, shape=head.kind.value)


def _head(view: View, wall: FloatArray, jambs: tuple[float, float], draft: Draft, sampling: Sampling) -> Head:
    """The head between two jambs."""
    width, height = jambs[1] - jambs[0], draft.hole.height
    middle = draft.hole.z + (height / 2.0 if height > TALL * width else 0.0)
    left, right = jambs
    return fit_head(wall, left=left, right=right, middle=middle, sampling=sampling, hidden=_hidden(view))
