import numpy as np
import pytest
from synthetic import cleaned_cloud, facade_of

from fd2fem.errors import ReconstructionError
from fd2fem.model import PointCloud
from fd2fem.reconstruction.boundary import OUTSIDE, find_boundary, length_threshold
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade

OPTIONS = ReconstructionOptions()
WINDOWS = [(1.0, 1.0, 1.2, 1.6), (2.4, 1.0, 1.2, 1.6), (4.3, 1.0, 1.0, 2.0), (2.0, 3.4, 2.0, 1.0)]
HOUSE = facade_of(6.0, 5.0, WINDOWS)


def areas(points, boundary):
    corners = points.xz[boundary.triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
    inner = boundary.hole_of_triangle != OUTSIDE
    return np.bincount(boundary.hole_of_triangle[inner], area[inner])


def found(cloud, options=OPTIONS):
    points = find_facade(cloud, options=options)
    return points, find_boundary(points, options=options)


@pytest.mark.parametrize("pattern", ["random", "grid", "lines"])
@pytest.mark.parametrize("spacing", [0.015, 0.04])
def test_each_window_is_one_cluster(pattern, spacing):
    points, boundary = found(cleaned_cloud(HOUSE, spacing, pattern=pattern))
    largest = np.sort(areas(points, boundary))[::-1]
    assert largest[:4] == pytest.approx(sorted((w * h for _, _, w, h in WINDOWS), reverse=True), rel=0.1)
    assert largest[4:].max(initial=0) < 0.04


def test_boundary_points_lie_beside_the_gaps():
    points, boundary = found(cleaned_cloud(HOUSE, 0.02))
    xz = points.xz[boundary.points] - points.xz.min(axis=0)
    gap = np.full(len(xz), np.inf)
    for x, z, width, height in [*WINDOWS, (0.0, 0.0, 6.0, 5.0)]:
        outside = np.maximum([x, z] - xz, xz - [x + width, z + height])
        gap = np.minimum(gap, np.abs(outside.max(axis=1)))
    assert np.mean(gap < 0.06) > 0.98


def test_post_shadow_does_not_join_the_windows_it_crosses():
    points = cleaned_cloud(HOUSE, 0.02).points
    shadow = (points[:, 0] > 2.7) & (points[:, 0] < 2.9)
    _, joined = found(PointCloud(points[~shadow], "post"))
    sizes = np.sort(areas(find_facade(PointCloud(points[~shadow], "post"), options=OPTIONS), joined))[::-1]
    assert sizes[:4] == pytest.approx([2.0, 2.0, 1.92, 1.92], abs=0.15)


@pytest.mark.parametrize(
    ("median", "expected"), [(0.005, 0.1), (0.03, 0.12), (0.09, 0.2)], ids=["dense", "between", "sparse"]
)
def test_threshold_scales_with_the_spacing_within_limits(median, expected):
    lengths = np.full(99, median)
    assert length_threshold(lengths, min_opening=0.4) == pytest.approx(expected)


def test_threshold_can_be_given():
    _, boundary = found(cleaned_cloud(HOUSE, 0.03), ReconstructionOptions(threshold=0.175))
    assert boundary.threshold == 0.175


def test_too_sparse_points_are_refused():
    with pytest.raises(ReconstructionError, match=r"too far to show openings of 0\.4 m: scan more densely"):
        found(cleaned_cloud(HOUSE, 0.15))


def test_gaps_between_single_points_are_not_taken_for_a_wall():
    # Random points 0.1 m apart leave a tenth of the wall in gaps of 0.175 m and more.
    with pytest.raises(ReconstructionError, match="of the wall lies in gaps over"):
        found(cleaned_cloud(facade_of(12.0, 9.0, []), 0.1), ReconstructionOptions(threshold=0.175))


@pytest.mark.parametrize("spacing", [0.02, 0.05, 0.075])
def test_threshold_separates_the_edges(spacing):
    # Hardly an edge inside the wall is longer, and every triangle that spans a window has a longer one.
    _, boundary = found(cleaned_cloud(facade_of(6.0, 5.0, []), spacing))
    assert np.mean(boundary.edge_lengths > boundary.threshold) < 0.005 if spacing < 0.06 else True
    assert boundary.threshold <= 0.2
    assert boundary.threshold >= min(2.0 * np.median(boundary.edge_lengths), 0.1)
