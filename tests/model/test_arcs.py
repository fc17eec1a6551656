from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import Arc, Facade, Opening, OpeningKind, arc_angles, arc_corners, facet_arc, rectangle
from fd2fem.model.checks import signed_area

ROUND = Arc(0, 0, 2.0, 3.0, 0.5, 0.5)


def round_headed(count=12):
    """A window 1 m wide with a round head: springing at z = 3, crown at 3.5."""
    head = facet_arc(ROUND, 0.0, np.pi, count=count)
    ring = np.concatenate([[[1.5, 2.0], [2.5, 2.0]], head])
    return Opening(1, OpeningKind.WINDOW, ring, arcs=(replace(ROUND, first=2, last=2 + count),))


@given(
    a=st.floats(0.1, 3.0),
    b=st.floats(0.1, 3.0),
    start=st.floats(-3.0, 3.0),
    sweep=st.floats(0.05, 6.0),
    count=st.integers(4, 40),
    clockwise=st.booleans(),
)
def test_facets_have_the_area_of_the_sector(a, b, start, sweep, count, clockwise):
    end = start - sweep if clockwise else start + sweep
    corners = facet_arc(Arc(0, 0, 1.0, -2.0, a, b), start, end, count=count)
    # A sector of an ellipse between the angles t covers a·b·t/2.
    sector = signed_area(np.concatenate([[[1.0, -2.0]], corners]))
    assert sector == pytest.approx(a * b * (end - start) / 2.0, rel=1e-9)
    ends = np.array([[1 + a * np.cos(t), b * np.sin(t) - 2.0] for t in (start, end)])
    assert corners[[0, -1]] == pytest.approx(ends)


@pytest.mark.parametrize(("end", "count"), [(1.0, 1), (6.0, 2)])
def test_too_few_chords(end, count):
    with pytest.raises(InputError, match="at least 2 chords, of at most 120 degrees"):
        facet_arc(ROUND, 0.0, end, count=count)


def test_an_opening_with_a_round_head_has_its_true_area():
    assert round_headed().area == pytest.approx(1.0 + np.pi * 0.25 / 2.0, rel=1e-12)


def test_corners_and_angles_of_an_arc_that_passes_the_end_of_the_list():
    opening = round_headed()
    ring = np.roll(opening.outline, -6, axis=0)  # corner 6 is now the first
    arc = Arc(2 - 6 + len(ring), 14 - 6, 2.0, 3.0, 0.5, 0.5)
    turned = replace(opening, outline=ring, arcs=(arc,))
    assert np.array_equal(arc_corners(arc, ring), opening.outline[2:15])
    assert arc_angles(arc, ring) == pytest.approx((0.0, np.pi))
    assert turned.area == pytest.approx(opening.area)


def test_a_whole_circle():
    count = 24
    scale = np.sqrt(2 * np.pi / count / np.sin(2 * np.pi / count))
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.column_stack([2.0 + 0.5 * scale * np.cos(angle), 3.0 + 0.5 * scale * np.sin(angle)])
    window = Opening(1, OpeningKind.WINDOW, ring, arcs=(ROUND,))
    assert window.arcs[0].whole
    assert window.area == pytest.approx(np.pi / 4)
    start, end = arc_angles(ROUND, ring)
    assert end - start == pytest.approx(2 * np.pi)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"last": 15}, "corners 2 to 15 of an outline of 15 corners"),
        ({"z": 3.01}, "its ends do not lie on the curve"),
        ({"a": 0.51}, "its ends do not lie on the curve"),
        # The right jamb as half a circle.
        ({"x": 2.5, "z": 2.5, "first": 1, "last": 2}, "bound another area than the curve"),
        # Right springing and a corner that is no longer on the curve.
        ({"last": 8}, "its ends do not lie on the curve"),
    ],
)
def test_an_arc_that_does_not_fit_its_corners_is_refused(change, message):
    opening = round_headed()
    with pytest.raises(InputError, match=message):
        replace(opening, arcs=(replace(opening.arcs[0], **change),))


def test_corners_on_the_curve_bound_less_than_the_curve():
    # Plain chords: the polygon of the circle's points is too small.
    angle = np.linspace(0.0, np.pi, 13)
    ring = np.concatenate(
        [[[1.5, 2.0], [2.5, 2.0]], np.column_stack([2.0 + 0.5 * np.cos(angle), 3.0 + 0.5 * np.sin(angle)])]
    )
    with pytest.raises(InputError, match="bound another area than the curve"):
        Opening(1, OpeningKind.WINDOW, ring, arcs=(replace(ROUND, first=2, last=14),))


def test_arcs_that_overlap_are_refused():
    opening = round_headed()
    with pytest.raises(InputError, match="arc 2 of 'outline of opening 1': it overlaps another"):
        replace(opening, arcs=(opening.arcs[0], opening.arcs[0]))


def test_a_clockwise_outline_with_arcs_is_refused():
    opening = round_headed()
    with pytest.raises(InputError, match="with arcs it must run counter-clockwise"):
        replace(opening, outline=opening.outline[::-1])


def test_a_curved_gable():
    head = facet_arc(Arc(0, 0, 2.0, 3.0, 2.0, 1.0), 0.0, np.pi, count=20)
    outline = np.concatenate([[[0.0, 0.0], [4.0, 0.0]], head])
    facade = Facade(outline, 0.3, arcs=(Arc(2, 22, 2.0, 3.0, 2.0, 1.0),))
    assert facade.wall_area == pytest.approx(12.0 + np.pi * 2.0 / 2.0)
    assert facade.volume == pytest.approx(0.3 * (12.0 + np.pi))


def test_half_axes_are_positive():
    with pytest.raises(InputError, match="'b'"):
        Arc(0, 1, 0.0, 0.0, 1.0, 0.0)


def test_arcs_of_a_facade_without_any():
    assert Facade(rectangle(0, 0, 1, 1), 0.3).arcs == ()
