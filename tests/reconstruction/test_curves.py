import numpy as np
import pytest
import shapely

from fd2fem.errors import InputError
from fd2fem.model.heads import Head, HeadKind, head_outline
from fd2fem.reconstruction.beside_curves import beside_head
from fd2fem.reconstruction.curves import Round, head_rise, round_outline

SHAPES = [
    (HeadKind.ARC, 0.1),
    (HeadKind.ARC, 0.5),
    (HeadKind.ELLIPTICAL, 0.3),
    (HeadKind.ELLIPTICAL, 0.8),
    (HeadKind.POINTED, 0.6),
    (HeadKind.POINTED, 1.2),
    (HeadKind.GABLED, 0.4),
]


def head(kind, rise):
    return Head(kind, springing=1.5, crown=1.5 + rise, sigma=0.003)


def test_rises_by_hand():
    # A semicircle of 1 m has the Pythagorean triple 3-4-5 at 0.3 m from its middle.
    assert head_rise(HeadKind.ARC, np.array([0.6]), rise=0.5, half=0.5) == pytest.approx(0.4)
    # An equilateral pointed arch of 1 m width: both arcs have a radius of 1 m.
    assert head_rise(HeadKind.POINTED, np.array([0.0]), rise=np.sqrt(0.75), half=0.5) == pytest.approx(
        np.sqrt(0.75)
    )
    assert head_rise(HeadKind.ELLIPTICAL, np.array([0.8]), rise=0.3, half=0.5) == pytest.approx(0.18)
    assert head_rise(HeadKind.GABLED, np.array([0.5]), rise=0.4, half=0.5) == pytest.approx(0.2)


@pytest.mark.parametrize(("kind", "rise"), SHAPES)
def test_outline_has_the_true_area_and_keeps_to_the_curve(kind, rise):
    ring = head_outline(head(kind, rise), 0.0, 1.0, 0.0, 0.002).ring
    u = np.linspace(-1.0, 1.0, 20_001)
    height = head_rise(kind, u, rise=rise, half=0.5)
    polygon = shapely.Polygon(ring)
    assert polygon.is_valid
    assert polygon.exterior.is_ccw
    assert polygon.area == pytest.approx(1.5 + np.trapezoid(height, 0.5 * u), abs=1e-5)
    curve = shapely.LineString(np.column_stack([0.5 + 0.5 * u, 1.5 + height]))
    drawn = shapely.LineString(ring[2:] if ring[1, 1] else ring[1:])
    assert shapely.LineString(drawn.coords[1:]).hausdorff_distance(curve) < 0.0021
    assert ring[:, 1].max() == pytest.approx(1.5 + rise, abs=1e-12)
    assert set(ring[[0, 1], 0]) == {0.0, 1.0}


def test_semicircle_and_round_window_have_the_textbook_area():
    ring = head_outline(head(HeadKind.ARC, 0.5), 0.0, 1.0, 0.0, 0.002).ring
    assert shapely.Polygon(ring).area == pytest.approx(1.5 + np.pi / 8, rel=1e-12)
    window = round_outline(Round(3.0, 4.0, 0.6, 0.3, 0.003), 0.002).ring
    assert shapely.Polygon(window).area == pytest.approx(np.pi * 0.18, rel=1e-12)
    assert shapely.Polygon(window).centroid.coords[0] == pytest.approx((3.0, 4.0))


@pytest.mark.parametrize("kind", [HeadKind.ARC, HeadKind.ELLIPTICAL, HeadKind.POINTED, HeadKind.GABLED])
def test_even_points_lie_evenly_beside_a_head(kind):
    # Of points spread evenly, as many lie in each layer of 20 mm: 1 % of a few thousand is chance.
    shape = head(kind, 0.6 if kind is HeadKind.POINTED else 0.4)
    xz = np.random.default_rng(3).uniform([-0.5, 1.0], [1.5, 3.0], (2_000_000, 2))
    inward, _, foot = beside_head(shape, xz, left=0.0, right=1.0)
    near = np.abs(foot) < 0.9
    counts, _ = np.histogram(inward[near], np.arange(0.0, 0.11, 0.02))
    assert counts.std() / counts.mean() < (0.02 if kind is not HeadKind.GABLED else 0.03)


def test_points_on_the_head_lie_at_no_distance():
    u = np.linspace(-0.95, 0.95, 51)
    for kind, rise in SHAPES:
        xz = np.column_stack([0.5 + 0.5 * u, 1.5 + head_rise(kind, u, rise=rise, half=0.5)])
        inward, _, foot = beside_head(head(kind, rise), xz, left=0.0, right=1.0)
        np.testing.assert_allclose(inward, 0.0, atol=1e-9)
        np.testing.assert_allclose(foot, u, atol=1e-9)


def test_edges_that_cross_are_refused():
    with pytest.raises(InputError, match="edges of an opening cross"):
        head_outline(head(HeadKind.ARC, 0.5), 1.0, 0.0, 0.0, 0.002)
