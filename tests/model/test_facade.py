from operator import setitem

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import (
    EdgeSigma,
    Facade,
    FilledHole,
    Opening,
    OpeningKind,
    Storey,
    number_by_rows,
    rectangle,
)

WINDOW, DOOR = OpeningKind.WINDOW, OpeningKind.DOOR


def _window(x, z, width, height, number=1):
    return Opening(number, WINDOW, rectangle(x, z, width, height))


def _door(x, z, width, height, number=1):
    return Opening(number, DOOR, rectangle(x, z, width, height))


def _facade(*openings):
    return Facade(rectangle(0, 0, 5, 6), 0.35, openings)


def test_sizes_and_areas_by_hand():
    facade = _facade(_door(0.5, 0, 1, 2), _window(3, 2, 1.5, 1.2, 2))
    assert (facade.length, facade.height, facade.thickness) == (5.0, 6.0, 0.35)
    assert facade.opening_area == pytest.approx(1 * 2 + 1.5 * 1.2)
    assert facade.wall_area == pytest.approx(30 - 3.8)


def test_opening_measures_its_bounding_rectangle_and_its_own_area():
    # A rectangle of 2 x 1 m under a triangle 1 m high: 2 + 1 m².
    opening = Opening(1, WINDOW, [[1, 1], [3, 1], [3, 2], [2, 3], [1, 2]])
    assert (opening.x, opening.z, opening.width, opening.height) == (1, 1, 2, 2)
    assert opening.area == pytest.approx(3.0)


def test_gable_wall():
    # 5 x 4 m and a triangle 2 m high on top: 20 + 5 m².
    facade = Facade([[0, 0], [5, 0], [5, 4], [2.5, 6], [0, 4]], 0.4)
    assert (facade.length, facade.height) == (5.0, 6.0)
    assert facade.wall_area == pytest.approx(25.0)


def test_a_clockwise_outline_is_turned_round():
    facade = Facade(rectangle(0, 0, 5, 6)[::-1], 0.35, (Opening(1, WINDOW, rectangle(1, 1, 1, 1)[::-1]),))
    assert facade.wall_area == pytest.approx(29.0)


@pytest.mark.parametrize(
    ("openings", "message"),
    [
        ([_window(4.5, 1, 1, 1)], r"opening 1 \(window, 1.000 x 1.000 m at x = 4.500.*does not lie inside"),
        ([_window(6, 1, 1, 1)], "does not lie inside the wall"),
        ([_window(1, -0.5, 1, 1)], "does not lie inside the wall"),
        ([_window(0, 1, 1, 1)], "touches the edge of the wall"),
        ([_window(1, 5, 1, 1)], "touches the edge of the wall"),
        ([_window(1, 0, 1, 1)], "touches the edge of the wall"),
        ([_door(0, 0, 1, 2)], "touches the edge of the wall"),
        ([_door(0.5, 0, 4.5, 2)], "touches the edge of the wall"),
        ([_door(1, 0, 1, 6)], "touches the edge of the wall"),
        ([_door(1, 0.1, 1, 2)], r"opening 1 \(door.*does not reach the ground at z = 0: call it a window"),
        ([_window(1, 1, 1, 1), _window(1.5, 1.5, 1, 1, 2)], "openings 1 and 2 touch or overlap"),
        ([_window(1, 1, 1, 1), _window(2, 1, 1, 1, 2)], "openings 1 and 2 touch or overlap"),
        ([_window(1, 1, 1, 1), _window(2, 2, 1, 1, 2)], "openings 1 and 2 touch or overlap"),  # at a corner
        ([_window(1, 1, 3, 3), _window(2, 2, 1, 1, 2)], "openings 1 and 2 touch or overlap"),  # one in one
        ([_door(1, 0, 1, 2, 7), _door(1.9, 0, 1, 2, 9)], "openings 7 and 9 touch or overlap"),
    ],
)
def test_openings_that_leave_no_sound_wall_are_refused(openings, message):
    with pytest.raises(InputError, match=message):
        _facade(*openings)


@pytest.mark.parametrize("gap", [2e-6, 1e-3])
def test_a_sliver_of_wall_is_a_wall(gap):
    facade = _facade(_window(gap, 1, 1, 1), _window(1 + 2 * gap, 1, 1, 1, 2), _door(3, 0, 2 - gap, 1, 3))
    assert len(facade.openings) == 3


@pytest.mark.parametrize(
    ("outline", "thickness", "message"),
    [
        (rectangle(1, 0, 5, 6), 0.35, r"lower left corner is \(1, 0\), expected \(0, 0\)"),
        (rectangle(0, -0.1, 5, 6), 0.35, r"lower left corner is \(0, -0.1\)"),
        (rectangle(0, 0, 5, 6), 0.0, "Invalid 'thickness'"),
        (rectangle(0, 0, 5, 6), -1.0, "Invalid 'thickness'"),
        (rectangle(0, 0, 5, 0), 0.35, "Invalid 'outline'"),
        ([[0, 0], [5, 6], [5, 0], [0, 6]], 0.35, "does not cross itself"),
    ],
)
def test_a_wall_that_is_none_is_refused(outline, thickness, message):
    with pytest.raises(InputError, match=message):
        Facade(outline, thickness)


def test_numbering_runs_by_rows_from_the_left():
    # Sills of one row may differ by up to 0.1 m from one to the next.
    boxes = [(3, 4.08), (1, 4.0), (4, 1.05), (2, 1.0), (0.5, 0.0)]
    numbered = number_by_rows(_window(x, z, 0.5, 0.5) for x, z in boxes)
    assert [(opening.id, opening.x) for opening in numbered] == [(1, 0.5), (2, 2), (3, 4), (4, 1), (5, 3)]


@given(order=st.permutations(range(6)))
@settings(max_examples=20, deadline=None)
def test_numbering_does_not_depend_on_the_order_given(order):
    boxes = [_window(0.5 + 1.5 * (i % 3), 1.0 + 2.0 * (i // 3), 1, 1, i + 10) for i in range(6)]
    numbered = number_by_rows(boxes[i] for i in order)
    assert [(round(o.x, 9), round(o.z, 9)) for o in numbered] == [(b.x, b.z) for b in boxes]
    assert [opening.id for opening in numbered] == [1, 2, 3, 4, 5, 6]


def test_numbering_keeps_what_an_opening_knows():
    opening = Opening(
        9, DOOR, rectangle(1, 0, 1, 2), 0.8, {"shadow": 0.1}, EdgeSigma(left=0.002, right=0.003)
    )
    (numbered,) = number_by_rows([opening])
    assert (numbered.id, numbered.kind, numbered.confidence, numbered.sigma) == (1, DOOR, 0.8, opening.sigma)
    assert dict(numbered.evidence) == {"shadow": 0.1}


@pytest.mark.parametrize(
    "change",
    [
        lambda facade: setitem(facade.outline, (0, 0), 1.0),
        lambda facade: setitem(facade.openings[0].outline, (0, 0), 1.0),
        lambda facade: setitem(facade.frame.origin, 0, 1.0),
        lambda facade: setitem(facade.record, "points", 1),
        lambda facade: setitem(facade.openings[0].evidence, "shadow", 1),
        lambda facade: setattr(facade, "thickness", 1.0),
        lambda facade: setattr(facade.openings[0], "kind", DOOR),
    ],
)
def test_a_facade_cannot_be_changed(change):
    facade = _facade(_window(1, 1, 1, 1))
    with pytest.raises((ValueError, TypeError, AttributeError), match=r"read-only|assign"):
        change(facade)


def test_records_copy_what_they_are_given():
    ring, evidence = rectangle(1, 1, 1, 1), {"shadow": 0.5}
    opening = Opening(1, WINDOW, ring, evidence=evidence)
    ring[0] = 7.0
    evidence["shadow"] = 0.0
    assert (opening.x, opening.evidence["shadow"]) == (1.0, 0.5)


def test_area_of_a_filled_hole():
    assert FilledHole([[0, 0], [2, 0], [0, 1]], "a shadow").area == pytest.approx(1.0)
    with pytest.raises(InputError, match="outline of a filled hole"):
        FilledHole(np.zeros((2, 2)), "nothing")


def test_a_wall_that_gets_thinner_storey_by_storey():
    # 5 x 6 m: 0.5 m thick up to 2 m, 0.35 m up to 4 m, 0.24 m above; 1 x 2 m of window half in each upper.
    window = Opening(1, WINDOW, rectangle(2, 3, 1, 2))
    facade = Facade(rectangle(0, 0, 5, 6), 0.5, (window,), storeys=(Storey(2, 0.35), Storey(4, 0.24)))
    assert [(band.low, band.high, band.thickness) for band in facade.bands] == [
        (0.0, 2, 0.5),
        (2, 4, 0.35),
        (4, 6.0, 0.24),
    ]
    assert facade.volume == pytest.approx(10 * 0.5 + 9 * 0.35 + 9 * 0.24)


def test_a_wall_of_one_thickness_is_one_band():
    facade = _facade(_window(1, 1, 1, 1))
    assert [(band.low, band.high, band.thickness) for band in facade.bands] == [(0.0, 6.0, 0.35)]
    assert facade.volume == pytest.approx(29 * 0.35)


@pytest.mark.parametrize("heights", [(4, 2), (2, 2), (6,), (7,)])
def test_storeys_rise_within_the_wall(heights):
    with pytest.raises(InputError, match=r"must begin above z = .* list storeys from below"):
        Facade(rectangle(0, 0, 5, 6), 0.5, storeys=tuple(Storey(z, 0.3) for z in heights))


@pytest.mark.parametrize(("z", "thickness"), [(0, 0.3), (-1, 0.3), (2, 0), (2, float("nan"))])
def test_a_storey_needs_a_height_and_a_thickness(z, thickness):
    with pytest.raises(InputError, match="of a storey"):
        Storey(z, thickness)
