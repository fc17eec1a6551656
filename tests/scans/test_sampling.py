"""Random re-sampling: the definition of a maximal set, and the density at which random discs jam."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.sampling import Density, resample, resample_to


def square(count, *, side=1.0, seed=3, offset=(0.0, 0.0, 0.0)):
    rng = np.random.default_rng(seed)
    points = np.column_stack([side * rng.random(count), np.zeros(count), side * rng.random(count)])
    station = rng.integers(-1, 1, count)
    return PointCloud(
        points + offset,
        "square",
        intensity=rng.random(count),
        scanners=[[1, -5, 1]],
        station=station,
        no_returns=7,
    )


def check_maximal(points, kept, spacing):
    """No two kept points closer than the spacing, and every other point within it of a kept one."""
    tree = cKDTree(kept)
    if len(kept) > 1:
        assert tree.query(kept, k=2)[0][:, 1].min() >= spacing * (1.0 - 1e-9)
    assert tree.query(points)[0].max() < spacing


@given(st.integers(1, 300), st.floats(0.01, 3.0), st.integers(0, 2**31))
@settings(max_examples=60, deadline=None)
def test_any_cloud_becomes_a_maximal_set(count, spacing, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    cloud = PointCloud(points, "random")
    check_maximal(points, resample(cloud, spacing, seed=seed).points, spacing)


def test_points_at_just_the_spacing_stay():
    line = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    assert len(resample(PointCloud(line, "line"), 1.0, seed=0)) == 5


def test_duplicates_leave_one():
    assert len(resample(PointCloud(np.ones((9, 3)), "one place"), 0.01)) == 1


def test_dense_wall_jams_at_the_known_coverage():
    # Discs dropped at random on a plane jam when they cover 0.5470 of it; after n tries they lack c / sqrt(n)
    # of that (Feder 1980, J. Theor. Biol. 87, 237), so with four times the tries half as much is lacking.
    def coverage(count):
        kept = resample(square(count, seed=count), 0.02, seed=4).points
        inner = ((kept[:, [0, 2]] > 0.05) & (kept[:, [0, 2]] < 0.95)).all(axis=1)  # away from the border
        return inner.sum() * np.pi * 0.01**2 / 0.9**2

    assert 2.0 * coverage(400_000) - coverage(100_000) == pytest.approx(0.547, rel=0.02)


def test_as_many_points_as_one_by_one():
    # The textbook's way: walk through the points in random order, keep each that is far from all kept ones.
    def one_by_one(points, spacing, seed):
        kept = np.empty((0, 3))
        for point in np.random.default_rng(seed).permutation(points):
            if not len(kept) or np.linalg.norm(kept - point, axis=1).min() >= spacing:
                kept = np.vstack([kept, point])
        return len(kept)

    cloud = square(2500)
    expected = np.mean([one_by_one(cloud.points, 0.05, seed) for seed in range(8)])
    counts = [len(resample(cloud, 0.05, seed=seed)) for seed in range(8)]
    assert np.mean(counts) == pytest.approx(expected, rel=0.02)


def test_points_keep_their_order_intensity_and_source():
    cloud = square(2000)
    kept = resample(cloud, 0.05, seed=9)
    rows = [int(np.flatnonzero((cloud.points == point).all(axis=1))[0]) for point in kept.points]
    assert rows == sorted(rows)
    np.testing.assert_array_equal(kept.intensity, cloud.intensity[rows])
    np.testing.assert_array_equal(kept.scanners, cloud.scanners)
    np.testing.assert_array_equal(kept.station, cloud.station[rows])
    assert kept.no_returns == 7
    assert kept.source == "square, re-sampled at 50 mm, seed 9"


def test_same_seed_same_points():
    cloud = square(3000)
    first, again, other = (resample(cloud, 0.05, seed=seed).points for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert len(other) != len(first) or not np.array_equal(other, first)


def test_survey_coordinates_select_the_same_points():
    cloud, far = square(5000), square(5000, offset=(692_000.0, 5_334_000.0, 512.0))
    near_rows = resample(cloud, 0.05, seed=1).points
    far_rows = resample(far, 0.05, seed=1).points - [692_000.0, 5_334_000.0, 512.0]
    # Metres near 5e6 keep 1e-9 m.
    np.testing.assert_allclose(far_rows, near_rows, atol=1e-8)


def test_selection_is_random_not_biased_to_a_corner():
    kept = resample(square(50_000), 0.03, seed=2).points
    # About 800 points, of standard deviation 0.29/sqrt(800) = 0.01 in their mean at most.
    np.testing.assert_allclose(kept[:, [0, 2]].mean(axis=0), 0.5, atol=0.03)


@pytest.mark.parametrize(
    ("density", "spacing"), [("NS00", 0.0), ("S20", 0.02), ("S50", 0.05), ("S75", 0.075)]
)
def test_densities_of_the_paper(density, spacing):
    assert Density(density).spacing == spacing
    cloud = square(4000)
    kept = resample_to(cloud, Density(density), seed=1)
    if spacing == 0.0:
        assert kept is cloud
    else:
        check_maximal(cloud.points, kept.points, spacing)


def test_no_points_stay_no_points():
    assert len(resample(PointCloud(np.empty((0, 3)), "empty"), 0.02)) == 0


@pytest.mark.parametrize("spacing", [0.0, -0.02, np.nan, np.inf])
def test_bad_spacing_is_refused(spacing):
    with pytest.raises(InputError, match=r"Invalid 'spacing': expected a positive number, got"):
        resample(square(10), spacing)
