"""Outlines with curved edges: their areas have closed forms, and check_arcs accepts their arcs."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model.arcs import check_arcs
from fd2fem.model.checks import signed_area
from fd2fem.model.heads import Head, HeadKind, head_outline
from fd2fem.model.outlines import Oval, curved_outline, oval_outline

SIZES = st.floats(0.3, 4.0)


def segment(half, rise):
    """Area between a chord of 2 x half and the circle that rises above it (textbook)."""
    radius = (half**2 + rise**2) / (2.0 * rise)
    angle = 4.0 * np.arctan(rise / half)
    return radius**2 / 2.0 * (angle - np.sin(angle))


def area_above_jambs(kind, half, rise):
    if kind is HeadKind.ARC:
        return segment(half, rise)
    if kind is HeadKind.ELLIPTICAL:
        return np.pi / 2.0 * half * rise
    if kind is HeadKind.GABLED:
        return half * rise
    # Each half of a pointed head is a sector about the other side less a triangle.
    radius = (half**2 + rise**2) / (2.0 * half)
    angle = np.arctan2(rise, radius - half)
    return radius**2 * angle - (radius - half) * rise


def rise_of(kind, share, half):
    """A rise that the kind can have, for a share from 0 to 1 of its range."""
    low, high = {HeadKind.ARC: (0.1, 1.0), HeadKind.POINTED: (1.0, 3.0)}.get(kind, (0.1, 3.0))
    return half * (low + share * (high - low))


CURVED = [HeadKind.ARC, HeadKind.ELLIPTICAL, HeadKind.POINTED, HeadKind.GABLED]


@pytest.mark.parametrize("kind", CURVED)
@settings(max_examples=30, deadline=None)
@given(SIZES, st.just(0.0) | st.floats(0.01, 3.0), st.floats(0.0, 1.0), st.floats(1e-4, 0.05))
def test_heads_have_the_area_of_the_closed_form(kind, width, jamb, share, tolerance):
    half = width / 2.0
    rise = rise_of(kind, share, half)
    head = Head(kind, springing=0.7 + jamb, crown=0.7 + jamb + rise)
    outline = head_outline(head, 0.4, 0.4 + width, 0.7, tolerance)
    exact = width * jamb + area_above_jambs(kind, half, rise)
    assert signed_area(outline.ring) == pytest.approx(exact, rel=1e-11)
    assert check_arcs("ring", outline.ring, outline.arcs) == outline.arcs
    assert shapely.Polygon(outline.ring).is_valid
    # The bounding rectangle is that of the shape.
    assert outline.ring.min(axis=0) == pytest.approx([0.4, 0.7], abs=1e-12)
    assert outline.ring.max(axis=0) == pytest.approx([0.4 + width, 0.7 + jamb + rise], abs=1e-12)
    assert len(outline.arcs) == (0 if kind is HeadKind.GABLED else 2)


@settings(max_examples=30, deadline=None)
@given(st.floats(-50, 50), SIZES, SIZES, st.floats(1e-4, 0.05))
def test_whole_ellipses(x, a, b, tolerance):
    outline = oval_outline(Oval(x, 2.0, a, b, 0.0, 0.0), tolerance=tolerance)
    assert signed_area(outline.ring) == pytest.approx(np.pi * a * b, rel=1e-12)
    assert np.ptp(outline.ring, axis=0) == pytest.approx([2 * a, 2 * b], rel=1e-12)
    assert check_arcs("ring", outline.ring, outline.arcs) == outline.arcs
    curve = np.linspace(0.0, 2.0 * np.pi, 5001)
    true = shapely.LinearRing(np.column_stack([x + a * np.cos(curve), 2.0 + b * np.sin(curve)]))
    assert shapely.LinearRing(outline.ring).hausdorff_distance(true) < tolerance + 2e-6


def test_a_curve_that_turns_clockwise_bites_into_its_outline():
    # A square with half a disc cut out of its upper edge.
    corners = [[0, 0], [4, 0], [4, 4], [3, 4], [1, 4], [0, 4]]
    bite = Oval(2.0, 4.0, 1.0, 1.0, 0.0, -np.pi)
    outline = curved_outline(corners, {3: bite}, tolerance=0.001)
    assert signed_area(outline.ring) == pytest.approx(16 - np.pi / 2, rel=1e-12)
    assert check_arcs("ring", outline.ring, outline.arcs) == outline.arcs


def test_an_outline_drawn_clockwise_is_turned_round():
    outline = curved_outline([[2, 0], [0, 0]], {1: Oval(1.0, 0.0, 1.0, 1.0, np.pi, 0.0)}, tolerance=0.001)
    assert signed_area(outline.ring) == pytest.approx(np.pi / 2, rel=1e-12)
    assert check_arcs("ring", outline.ring, outline.arcs) == outline.arcs
    assert {tuple(outline.ring[arc.first]) for arc in outline.arcs} == {(2.0, 0.0), (1.0, 1.0)}


def test_edges_of_no_length_are_left_out():
    # The jambs of a lunette: a round head that stands on its sill.
    outline = head_outline(Head(HeadKind.ARC, 1.0, 1.5), 0.0, 1.0, 1.0, 0.001)
    assert np.hypot(*(outline.ring - np.roll(outline.ring, 1, axis=0)).T).min() > 0.01
    assert signed_area(outline.ring) == pytest.approx(np.pi / 8, rel=1e-12)


def test_a_curve_that_just_passes_an_extreme_gets_no_sliver():
    end = np.pi / 2 + 0.005
    corners = [[0.0, 0.0], [1.0, 0.0], [np.cos(end), np.sin(end)]]
    outline = curved_outline(corners, {1: Oval(0.0, 0.0, 1.0, 1.0, 0.0, end)}, tolerance=0.001)
    assert len(outline.arcs) == 1
    assert signed_area(outline.ring) == pytest.approx(end / 2, rel=1e-12)


def test_moved_outlines_keep_their_arcs():
    outline = head_outline(Head(HeadKind.POINTED, 1.0, 2.0), 0.0, 1.0, 0.0, 0.001).moved(3.0, -0.5)
    assert check_arcs("ring", outline.ring, outline.arcs) == outline.arcs
    assert outline.ring[0].tolist() == [3.0, -0.5]


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan])
def test_tolerance_that_is_none(tolerance):
    with pytest.raises(InputError, match="Invalid 'tolerance'"):
        oval_outline(Oval(0, 0, 1, 1, 0, 0), tolerance=tolerance)


def test_a_curve_of_a_mistaken_size_has_no_endless_corners():
    outline = oval_outline(Oval(0.0, 0.0, 1e9, 1e9, 0.0, 0.0), tolerance=0.001)
    assert len(outline.ring) <= 40_000
    assert signed_area(outline.ring) == pytest.approx(np.pi * 1e18, rel=1e-9)
