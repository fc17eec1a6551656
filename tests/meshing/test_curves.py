import numpy as np
import pytest
from curved_walls import CURVED_WALLS, curved_top, elliptic, oculus, pointed
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.meshing.curves import refacet
from fd2fem.model import Facade, Storey, arc_corners, rectangle


@pytest.mark.parametrize("name", CURVED_WALLS)
@pytest.mark.parametrize("size", [0.05, 0.3])
def test_areas_stay(name, size):
    facade = CURVED_WALLS[name]
    anew = refacet(facade, size=size, tolerance=size / 50)
    assert anew.volume == pytest.approx(facade.volume, rel=1e-9)
    for before, after in zip(facade.openings, anew.openings, strict=True):
        assert after.area == pytest.approx(before.area, rel=1e-9)
        assert len(after.arcs) == len(before.arcs)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.2, 2.0), st.floats(0.05, 2.0), st.floats(0.02, 0.5))
def test_chords_are_close_and_short(width, rise, size):
    facade = Facade(rectangle(0, 0, 6, 6), 0.4, (elliptic(1, 2, 1, width, 1, rise, sagitta=0.0001),))
    (opening,) = refacet(facade, size=size, tolerance=size / 50).openings
    (arc,) = opening.arcs
    run = arc_corners(arc, opening.outline)
    assert (len(run) - 1) % 2 == 0
    assert np.linalg.norm(np.diff(run, axis=0), axis=1).max() < 1.05 * size
    radius = np.hypot(*((run - [arc.x, arc.z]) / [arc.a, arc.b]).T)
    middle = np.hypot(*(((run[1:] + run[:-1]) / 2 - [arc.x, arc.z]) / [arc.a, arc.b]).T)
    longest = max(arc.a, arc.b)
    assert np.abs(radius - 1).max() * longest < 1.2 * size / 50
    assert np.abs(middle - 1).max() * longest < 1.2 * size / 50


def test_several_arcs_and_corners_keep_their_order():
    facade = Facade(rectangle(0, 0, 6, 6), 0.4, (pointed(1, 1, 1, 1.4, 1.2), oculus(2, 4, 4, 0.5, 0.7)))
    first, second = refacet(facade, size=0.3, tolerance=0.006).openings
    sharp = {(1.0, 1.0), (2.4, 1.0), (2.4, 2.2), (1.0, 2.2)}
    assert sharp <= {tuple(corner) for corner in first.outline.round(12).tolist()}
    assert first.arcs[0].last == first.arcs[1].first  # the point of the arch
    assert second.arcs[0].whole
    assert len(first.outline) < len(facade.openings[0].outline)


def test_the_outline_of_a_wall():
    facade = curved_top()
    anew = refacet(facade, size=0.5, tolerance=0.01)
    assert len(anew.outline) != len(facade.outline)
    assert anew.wall_area == pytest.approx(facade.wall_area, rel=1e-9)
    assert {(0.0, 0.0), (10.0, 0.0)} <= {tuple(corner) for corner in anew.outline.tolist()}


def test_areas_stay_on_both_sides_of_a_level():
    facade = Facade(
        rectangle(0, 0, 6, 6), 0.4, (elliptic(1, 2, 1, 1.2, 1, 0.6),), storeys=(Storey(2.3, 0.1),)
    )
    assert refacet(facade, size=0.3, tolerance=0.006).volume == pytest.approx(facade.volume, rel=1e-9)


def test_curves_too_close_for_other_chords_stay():
    # 1 mm of wall between two circles: chords of 0.5 m would cross
    facade = Facade(rectangle(0, 0, 6, 4), 0.4, (oculus(1, 2, 2, 0.9, 0.9), oculus(2, 3.803, 2, 0.9, 0.9)))
    anew = refacet(facade, size=0.5, tolerance=0.05)
    assert [len(opening.outline) for opening in anew.openings] == [len(o.outline) for o in facade.openings]
