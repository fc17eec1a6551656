"""Arcs parted at the levels of storeys, held against areas in closed form."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.model import Facade, Opening, OpeningKind, Storey, rectangle
from fd2fem.model.arc_cuts import cut_arcs
from fd2fem.model.checks import signed_area
from fd2fem.model.outlines import Oval, curved_outline, oval_outline


def above(h):
    """Area of the part of the unit disc above h."""
    return np.arccos(h) - h * np.sqrt(1.0 - h * h)


def area_between(ring, low, high):
    return shapely.Polygon(ring).intersection(shapely.box(-9, low, 9, high)).area


@given(st.floats(-0.999, 0.999), st.floats(0.3, 2.0), st.floats(0.3, 2.0), st.sampled_from([1e-3, 0.01, 0.1]))
def test_ellipses_have_their_area_on_either_side(h, a, b, tolerance):
    disc = oval_outline(Oval(0.5, 1.0, a, b, 0.0, 0.0), tolerance=tolerance)
    ring, arcs = cut_arcs(disc.ring, disc.arcs, [1.0 + b * h])
    assert area_between(ring, 1.0 + b * h, 9.0) == pytest.approx(a * b * above(h), rel=1e-9, abs=1e-12)
    assert signed_area(ring) == pytest.approx(np.pi * a * b, rel=1e-12)
    Opening(1, OpeningKind.WINDOW, ring, arcs=arcs)  # the arcs fit their corners


def test_two_levels_through_a_head():
    head = curved_outline([(-1, 0), (1, 0)], {1: Oval(0, 0, 1, 1, 0, np.pi)}, tolerance=0.02)
    ring, arcs = cut_arcs(head.ring, head.arcs, [0.3, 0.8])
    assert len(arcs) == 2 * 3
    bounds = [0.0, 0.3, 0.8, 1.0]
    for low, high in pairwise(bounds):
        assert area_between(ring, low, high) == pytest.approx(above(low) - above(high), rel=1e-9)
    again, same = cut_arcs(ring, arcs, [0.3, 0.8])
    assert again is ring
    assert same == arcs


def test_levels_elsewhere_leave_all_as_it_is():
    disc = oval_outline(Oval(0.0, 1.0, 0.5, 0.5, 0.0, 0.0), tolerance=0.01)
    # Level with the centre, the disc has a corner already; at its top and beside it, nothing to cut.
    for level in (0.2, 1.0, 1.5, 1.7):
        ring, arcs = cut_arcs(disc.ring, disc.arcs, [level])
        assert ring is disc.ring
        assert arcs == disc.arcs
    square = rectangle(0, 0, 1, 1)
    assert cut_arcs(square, (), [0.5])[0] is square


def test_facades_part_their_arcs():
    disc = oval_outline(Oval(2.0, 3.0, 1.0, 1.0, 0.0, 0.0), tolerance=0.05)
    window = Opening(1, OpeningKind.WINDOW, disc.ring, arcs=disc.arcs)
    facade = Facade(rectangle(0, 0, 4, 6), 0.5, (window,), storeys=(Storey(3.6, 0.3),))
    volume = 0.5 * (4 * 3.6 - (np.pi - above(0.6))) + 0.3 * (4 * 2.4 - above(0.6))
    assert facade.volume == pytest.approx(volume, rel=1e-12)
    assert len(facade.openings[0].arcs) == 6
    levels = facade.openings[0].outline[:, 1]
    assert np.count_nonzero(levels == 3.6) == 2  # to the last digit
    assert facade.openings[0].evidence == window.evidence


def test_a_curved_top_is_parted_too():
    top = curved_outline([(0, 0), (2, 0), (2, 2), (0, 2)], {2: Oval(1, 2, 1, 1, 0, np.pi)}, tolerance=0.05)
    facade = Facade(top.ring, 0.5, arcs=top.arcs, storeys=(Storey(2.5, 0.4),))
    assert facade.volume == pytest.approx(0.5 * (4 + np.pi / 2 - above(0.5)) + 0.4 * above(0.5), rel=1e-12)
