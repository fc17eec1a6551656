"""Rays against surfaces: closed forms, and points put back into the equations of the surfaces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.scans.surfaces import (
    Material,
    box_chord,
    ellipsoid_chord,
    hit_box,
    hit_cylinder,
    hit_plane,
    hit_prism,
    hit_rectangle,
    nearest,
    no_hits,
)

ORIGIN = np.array([0.3, -9.0, 1.6])


def fan(count=4000, seed=5):
    """Random unit vectors towards the street's other side."""
    directions = np.random.default_rng(seed).normal(size=(count, 3)) * [0.4, 0.2, 0.4] + [0.0, 1.0, 0.0]
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def one(*direction):
    return np.array([direction]) / np.linalg.norm(direction)


@given(st.floats(0.1, 100.0), st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
@settings(max_examples=50, deadline=None)
def test_plane_at_a_known_distance(depth, azimuth, elevation):
    direction = one(
        np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)
    )
    hits = hit_plane([0, 0, 0], direction, point=[7, depth, -3], normal=[0, 1, 0], material=Material.WALL)
    # Spherical trigonometry: the ray is slanted by the cosine of both angles.
    slant = np.cos(elevation) * np.cos(azimuth)
    assert hits.distance[0] == pytest.approx(depth / slant, rel=1e-12)
    assert hits.cosine[0] == pytest.approx(slant, rel=1e-12)


def test_plane_behind_or_parallel_is_missed():
    directions = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    hits = hit_plane([0, 0, 0], directions, point=[0, 2, 0], normal=[0, 1, 0], material=Material.WALL)
    assert np.isinf(hits.distance).all()


def test_rectangle_hit_only_within_its_sides():
    corner, sides = [0.0, 5.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    targets = np.array([[0.01, 5, 0.01], [1.99, 5, 0.99], [2.01, 5, 0.5], [1, 5, 1.01], [-0.01, 5, 0.5]])
    lengths = np.linalg.norm(targets, axis=1)
    hits = hit_rectangle(
        [0, 0, 0], targets / lengths[:, None], corner=corner, sides=sides, material=Material.WALL
    )
    np.testing.assert_allclose(hits.distance[:2], lengths[:2], rtol=1e-12)
    assert np.isinf(hits.distance[2:]).all()


def test_box_in_front_by_hand():
    # From 9 m before the origin straight at a face 4 m away; 3-4-5 triangle for the slanted ray.
    hits = hit_box([0, -9, 1], one(0, 1, 0), lower=[-1, -5, 0], upper=[1, -3, 2], material=Material.VEHICLE)
    assert hits.distance[0] == pytest.approx(4.0)
    assert hits.cosine[0] == pytest.approx(1.0)
    slanted = hit_box(
        [-3, -9, 1], one(3, 4, 0), lower=[-1, -5, 0], upper=[1, -3, 2], material=Material.VEHICLE
    )
    assert slanted.distance[0] == pytest.approx(5.0)
    assert slanted.cosine[0] == pytest.approx(0.8)


def test_box_hits_lie_on_the_box_and_misses_pass_it():
    lower, upper = np.array([-1.0, -2.0, 0.5]), np.array([1.5, 1.0, 2.5])
    directions = fan()
    hits = hit_box(ORIGIN, directions, lower=lower, upper=upper, material=Material.VEHICLE)
    met = np.isfinite(hits.distance)
    assert 50 < met.sum() < len(met)
    points = ORIGIN + hits.distance[met, None] * directions[met]
    assert (points > lower - 1e-9).all()
    assert (points < upper + 1e-9).all()
    gap = np.minimum(np.abs(points - lower), np.abs(points - upper)).min(axis=1)
    assert gap.max() < 1e-9
    samples = ORIGIN + np.linspace(0, 20, 400)[:, None, None] * directions[~met]
    assert not ((samples > lower) & (samples < upper)).all(axis=2).any()


def test_chord_through_a_box_has_its_diagonal():
    chord = box_chord([-1, -1, -1], one(1, 1, 1), lower=[0, 0, 0], upper=[2, 2, 2])
    assert chord.leave[0] - chord.enter[0] == pytest.approx(2.0 * np.sqrt(3.0))


def test_cylinder_at_a_known_offset():
    # A ray that passes the axis at distance d meets the mantle sqrt(r² - d²) before the nearest point.
    for d in (0.0, 0.1, -0.25, 0.299):
        hits = hit_cylinder(
            [d, -8, 1], one(0, 1, 0), base=(0, -2), radius=0.3, height=3, material=Material.POST
        )
        assert hits.distance[0] == pytest.approx(6.0 - np.sqrt(0.09 - d * d), rel=1e-12)
        assert hits.cosine[0] == pytest.approx(np.sqrt(1.0 - (d / 0.3) ** 2), rel=1e-9)
    missed = hit_cylinder(
        [0.301, -8, 1], one(0, 1, 0), base=(0, -2), radius=0.3, height=3, material=Material.POST
    )
    assert np.isinf(missed.distance[0])


def test_cylinder_ends_at_its_height():
    # From z = 2, the top at 1 m: over it for a level ray, onto the cap for one that falls 1 m in 6 m.
    def cast(slope):
        return hit_cylinder(
            [0, -6, 2], one(0, 1, slope), base=(0, 0), radius=0.5, height=1, material=Material.POST
        )

    assert np.isinf(cast(0.0).distance[0])
    cap = cast(-1.0 / 6.0)
    assert cap.distance[0] == pytest.approx(np.sqrt(37.0))
    assert cap.cosine[0] == pytest.approx(1.0 / np.sqrt(37.0))
    mantle = cast(-0.2)
    assert mantle.distance[0] == pytest.approx(5.5 * np.sqrt(1.04))


def test_ellipsoid_chord_ends_on_the_ellipsoid():
    centre, radii = np.array([0.2, -2.0, 2.0]), np.array([1.5, 0.8, 1.1])
    directions = fan()
    chord = ellipsoid_chord(ORIGIN, directions, centre=centre, radii=radii)
    met = chord.enter < chord.leave
    assert 50 < met.sum() < len(met)
    for along in (chord.enter, chord.leave):
        points = ORIGIN + along[met, None] * directions[met]
        np.testing.assert_allclose((((points - centre) / radii) ** 2).sum(axis=1), 1.0, rtol=1e-9)
    # A ray that misses comes no nearer than 1 in the scaled space.
    offset, step = (ORIGIN - centre) / radii, directions[~met] / radii
    closest = offset - (step @ offset / (step**2).sum(axis=1))[:, None] * step
    assert np.linalg.norm(closest, axis=1).min() >= 1.0


def test_prism_sides_of_a_square_opening():
    ring = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    # From (1, -4, 1): 45 degrees never; a slope of 1/4.06 leaves the right side at depth 0.06.
    directions = np.vstack([one(1, 4.06, 0), one(0, 1, 0), one(0, 4.06, 1), one(1, 4.2, 0)])
    hits = hit_prism([1, -4, 1], directions, ring=ring, depth=0.12, material=Material.REVEAL)
    np.testing.assert_allclose(hits.distance[[0, 2]], np.hypot(1, 4.06), rtol=1e-12)
    assert np.isinf(hits.distance[[1, 3]]).all()  # through the middle, and past the inner edge


def test_nearest_takes_the_smaller_distance_with_its_material():
    far = no_hits(3)._replace(
        distance=np.array([5.0, 5.0, np.inf]), material=np.full(3, Material.WALL, np.uint8)
    )
    near = no_hits(3)._replace(
        distance=np.array([2.0, np.inf, np.inf]), material=np.full(3, Material.POST, np.uint8)
    )
    first = nearest(far, near)
    assert first.distance.tolist() == [2.0, 5.0, np.inf]
    assert first.material.tolist()[:2] == [Material.POST, Material.WALL]
