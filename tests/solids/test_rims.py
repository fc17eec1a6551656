"""Edges of a wall: arcs fitted to their corners, idle corners gone."""

import arched_walls as walls
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.model import Arc, Facade, facet_arc, rectangle
from fd2fem.model.outlines import Oval, curved_outline
from fd2fem.solids.rim_edges import rim_edges
from fd2fem.solids.rims import wall_extent, wall_rims

angles = st.floats(0.0, 6.28)


def sector(oval):
    """Area between a curve and its centre."""
    return 0.5 * oval.a * oval.b * (oval.end - oval.start)


@given(angles, st.floats(0.2, 4.0), st.floats(0.3, 3.0), st.floats(0.3, 3.0), st.integers(2, 40))
def test_facets_become_their_arc_again(start, sweep, a, b, count):
    arc = Arc(0, count, 1.0, 2.0, a, b)
    ring = np.vstack([facet_arc(arc, start, start + sweep, count=count), [[1.0, 2.0]]])
    curve, *straight = rim_edges(ring, (arc,))
    assert [edge.oval for edge in straight] == [None, None]
    found = (curve.oval.x, curve.oval.z, curve.oval.a, curve.oval.b)
    assert found == pytest.approx((1.0, 2.0, a, b), abs=1e-9)
    assert curve.oval.end - curve.oval.start == pytest.approx(sweep, abs=1e-8)


@given(st.floats(0.3, 2.0), st.floats(0.05, 1.0), st.integers(0, 2**32 - 1))
def test_rounded_arcs_pass_their_ends_with_their_area(half, part, seed):
    """The corners are off by up to 0.1 micrometres; the arc then meets its ends and keeps the area."""
    rise = half * part
    radius = (half**2 + rise**2) / (2 * rise)
    start = np.arcsin(1 - rise / radius)
    oval = Oval(0.0, rise - radius, radius, radius, start, np.pi - start)
    outline = curved_outline([(-half, -1), (half, -1), (half, 0), (-half, 0)], {2: oval}, tolerance=1e-3)
    ring = outline.ring + np.random.default_rng(seed).uniform(-1e-7, 1e-7, outline.ring.shape)
    edges = rim_edges(ring, outline.arcs)
    (curve,) = [edge for edge in edges if edge.oval is not None]
    for end, angle in ((curve.start, curve.oval.start), (curve.end, curve.oval.end)):
        on = (curve.oval.x + curve.oval.a * np.cos(angle), curve.oval.z + curve.oval.b * np.sin(angle))
        assert end == pytest.approx(on, abs=2e-9)
    (x0, z0), (x1, z1) = curve.start, curve.end
    cx, cz = curve.oval.x, curve.oval.z
    segment = sector(curve.oval) - 0.5 * ((x0 - cx) * (z1 - cz) - (x1 - cx) * (z0 - cz))
    first, last = outline.arcs[0].first, outline.arcs[-1].last
    corners = ring[first : last + 1] if last else np.vstack([ring[first:], ring[:1]])
    x, z = (corners - corners[0]).T
    assert segment == pytest.approx(0.5 * np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z), abs=2e-9)


def test_parts_of_one_circle_are_one_edge():
    facade = walls.arched()
    assert len(facade.openings[0].arcs) > 1
    rims = wall_rims(facade)
    counts = sorted(len(rim) for rim in rims.holes)
    assert counts == [1, 1, 1, 4, 4, 4, 5, 5]
    assert sum(edge.oval is not None for rim in rims.holes for edge in rim) == 3 + 2 + 2 + 1


def test_extent_counts_curves():
    """A top of 1.5 m radius on 3 m, its corners 1 mm outside of the curve at the most."""
    facade = walls.curved_gable()
    assert wall_extent(facade).tolist() == pytest.approx([4.0, 0.4, 4.5], abs=1e-12)
    coarse = facet_arc(Arc(2, 5, 2.0, 3.0, 2.0, 2.0), 0.0, np.pi, count=3)
    ring = np.vstack([[(0.0, 0.0), (4.0, 0.0)], coarse])
    drum = Facade(ring, 0.3, arcs=(Arc(2, 5, 2.0, 3.0, 2.0, 2.0),))
    assert drum.height == pytest.approx(coarse[:, 1].max())
    assert wall_extent(drum).tolist() == pytest.approx([4.0, 0.3, 5.0], abs=1e-12)
    assert wall_extent(Facade(rectangle(0, 0, 4, 3), 0.3)).tolist() == [4.0, 0.3, 3.0]
