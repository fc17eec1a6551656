"""Clusters of long triangles against simulated walls whose openings are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import facade_of, wall_points

from fd2fem.errors import ReconstructionError
from fd2fem.model import PointCloud
from fd2fem.reconstruction.boundary import OUTSIDE, find_boundary, length_threshold, triangle_areas
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.scans.sampling import resample

OPTIONS = ReconstructionOptions()
WINDOWS = [(1.0, 1.0, 1.2, 1.6), (2.4, 1.0, 1.2, 1.6), (4.3, 1.0, 1.0, 2.0), (2.0, 3.4, 2.0, 1.0)]
HOUSE = facade_of(6.0, 5.0, WINDOWS)


def found(xz, options=OPTIONS):
    """The boundary of points sorted by x, as the facade's points come."""
    points = SimpleNamespace(xz=xz[np.lexsort((xz[:, 1], xz[:, 0]))])
    return points.xz, find_boundary(points, options=options)


def areas(xz, boundary):
    inner = boundary.hole_of_triangle != OUTSIDE
    return np.bincount(boundary.hole_of_triangle[inner], triangle_areas(xz[boundary.triangles])[inner])


def cluster_at(xz, boundary, box):
    """The cluster with most area in a box (x, z, width, height), and how much of the box that is."""
    centre = xz[boundary.triangles].mean(axis=1) - box[:2]
    inside = ((centre > 0) & (centre < box[2:])).all(axis=1) & (boundary.hole_of_triangle != OUTSIDE)
    area = np.bincount(boundary.hole_of_triangle[inside], triangle_areas(xz[boundary.triangles[inside]]))
    return int(area.argmax()), float(area.max()) / (box[2] * box[3])


def without(xz, *boxes):
    for x, z, width, height in boxes:
        xz = xz[~((xz > [x, z]) & (xz < [x + width, z + height])).all(axis=1)]
    return xz


def scan_lines(length, height, rows, pitch, *, noise, rng):
    lines = []
    for z in rows:
        x = np.arange(rng.uniform(0, pitch), length, pitch)
        lines.append(np.column_stack([x, np.full(len(x), z)]) + rng.normal(0, noise, (len(x), 2)))
    xz = np.concatenate(lines)
    return xz[((xz > 0) & (xz < [length, height])).all(axis=1)]


@pytest.mark.parametrize("pattern", ["random", "grid", "lines"])
@pytest.mark.parametrize("spacing", [0.008, 0.015, 0.04])
def test_each_window_is_one_cluster(pattern, spacing):
    xz, boundary = found(wall_points(HOUSE, spacing, pattern=pattern))
    largest = areas(xz, boundary)
    assert (np.diff(largest) <= 0).all()
    # The triangles reach from sample to sample, up to a spacing wider than the window on every side.
    true = np.array(sorted((w * h for _, _, w, h in WINDOWS), reverse=True))
    assert (largest[:4] > 0.98 * true).all()
    assert (largest[:4] < true + 6.0 * 1.4 * spacing).all()
    assert largest[4:].max(initial=0) < 0.01
    assert not set(boundary.open_clusters) & set(range(4))
    assert boundary.min_opening == OPTIONS.min_opening
    assert boundary.warnings == ()


@pytest.mark.parametrize("rows", [0.025, 0.06])
@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize("upright", [False, True])
def test_scan_lines_far_apart_make_no_false_gaps(rows, noise, upright):
    rng = np.random.default_rng(3)
    size = (5.0, 6.0) if upright else (6.0, 5.0)
    xz = scan_lines(*size, np.arange(0.01, size[1], rows), 0.005, noise=noise, rng=rng)
    xz, boundary = found(without(xz[:, ::-1] if upright else xz, *WINDOWS))
    largest = areas(xz, boundary)
    assert largest[:4] == pytest.approx([2.0, 2.0, 1.92, 1.92], rel=0.1)
    assert largest[4:].max(initial=0) < 0.04


def test_rows_that_grow_apart_upwards():
    rng = np.random.default_rng(4)
    rows = np.cumsum(np.linspace(0.005, 0.06, 155))  # 5 mm at the foot, 60 mm at 5 m
    xz, boundary = found(without(scan_lines(6.0, 5.0, rows, 0.006, noise=0.0005, rng=rng), *WINDOWS))
    largest = areas(xz, boundary)
    assert largest[:4] == pytest.approx([2.0, 2.0, 1.92, 1.92], rel=0.12)
    assert largest[4:].max(initial=0) < 0.04


def test_the_threshold_follows_the_local_spacing():
    # Two stations: 10 mm on the left half, 40 mm on the right one.
    left, right = (wall_points(facade_of(6.0, 5.0, []), spacing, seed=1) for spacing in (0.01, 0.04))
    xz = np.concatenate([left[left[:, 0] < 3.0], right[right[:, 0] > 3.0]])
    xz, boundary = found(without(xz, *WINDOWS))
    x = xz[boundary.triangles, 0].mean(axis=1)
    local = boundary.threshold_of_triangle
    assert local[x < 2.0] == pytest.approx(0.1, rel=0.05)
    # Evenly random points have Delaunay edges of 1.1 spacings, the median.
    assert local[x > 4.2] == pytest.approx(4 * 1.1 * 0.04, rel=0.1)
    sides = np.linalg.norm(np.diff(xz[boundary.triangles[:, [0, 1, 2, 0]]], axis=1), axis=2)
    assert (sides.max(axis=1) > local).all()
    assert areas(xz, boundary)[:4] == pytest.approx([2.0, 2.0, 1.92, 1.92], rel=0.1)


@pytest.mark.parametrize("pattern", ["random", "S50", "rows", "columns"])
@pytest.mark.parametrize("pier", [0.12, 0.14])
def test_a_thin_pier_keeps_two_windows_apart(pattern, pier):
    pair = [(1.0, 1.0, 1.0, 1.8), (2.0 + pier, 1.0, 1.0, 1.8)]
    rng = np.random.default_rng(8)
    dense = rng.uniform(0, 1, (200_000, 2)) * [4.2, 4.0]
    xz = {
        "random": dense[:: int(200_000 * 0.05**2 / 16.8)],
        "S50": resample(PointCloud(np.insert(dense, 1, 0, axis=1), "wall"), 0.05).points[:, ::2],
        "rows": scan_lines(4.2, 4.0, np.arange(0.01, 4.0, 0.05), 0.01, noise=0.001, rng=rng),
        "columns": scan_lines(4.0, 4.2, np.arange(0.01, 4.2, 0.05), 0.01, noise=0.001, rng=rng)[:, ::-1],
    }[pattern]
    xz, boundary = found(without(xz, *pair))
    (first, share), (second, other) = (cluster_at(xz, boundary, np.array(box)) for box in pair)
    assert first != second
    assert share == pytest.approx(1.0, abs=0.1)
    assert other == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_papers_sparsest_resampling_shows_every_window(seed):
    windows = [(0.8, 0.9, 0.9, 0.9), (2.4, 0.8, 0.9, 1.6), (4.2, 0.9, 1.0, 1.4), (1.4, 3.1, 1.2, 1.1)]
    dense = wall_points(facade_of(6.0, 5.0, windows), 0.012, seed=seed)
    thinned = resample(PointCloud(np.insert(dense, 1, 0.0, axis=1), "wall"), 0.075, seed=seed)
    xz, boundary = found(thinned.points[:, [0, 2]])
    clusters = [cluster_at(xz, boundary, np.array(box)) for box in windows]
    assert len({cluster for cluster, _ in clusters}) == 4
    assert all(share > 0.85 for _, share in clusters)
    assert areas(xz, boundary)[4:].max(initial=0) < 0.04
    assert boundary.warnings == ()


def test_boundary_points_lie_beside_the_gaps():
    xz, boundary = found(wall_points(HOUSE, 0.02))
    beside = xz[boundary.points]
    gap = np.full(len(beside), np.inf)
    for x, z, width, height in [*WINDOWS, (0.0, 0.0, 6.0, 5.0)]:
        outside = np.maximum([x, z] - beside, beside - [x + width, z + height])
        gap = np.minimum(gap, np.abs(outside.max(axis=1)))
    assert np.mean(gap < 0.06) > 0.98


def test_post_shadow_does_not_join_the_windows_it_crosses():
    dense = wall_points(HOUSE, 0.02)
    xz, boundary = found(dense[(dense[:, 0] < 2.7) | (dense[:, 0] > 2.9)])
    clusters = [cluster_at(xz, boundary, np.array(box))[0] for box in WINDOWS]
    assert len(set(clusters)) == 4
    assert areas(xz, boundary)[clusters] == pytest.approx([1.92, 1.92, 2.0, 2.0], abs=0.15)


def test_doors_do_not_join_along_the_foot_and_are_open():
    doors = [(0.8, 0.0, 1.0, 2.2), (2.2, 0.0, 1.0, 2.2), (4.0, 0.0, 1.4, 2.4)]
    xz, boundary = found(wall_points(facade_of(6.0, 5.0, [*doors, (2.0, 3.4, 2.0, 1.0)]), 0.02))
    clusters = [cluster_at(xz, boundary, np.array(box))[0] for box in doors]
    assert len(set(clusters)) == 3
    assert set(boundary.open_clusters) == set(clusters)
    # They are open over their whole width.
    assert boundary.border_length[clusters] == pytest.approx([1.0, 1.0, 1.4], abs=0.2)


def test_notches_of_the_outline_are_clusters_and_open():
    # A stepped parapet: the wall is 5 m high in the middle and 4 m at its ends.
    notches = [(-1.0, 4.0, 2.5, 2.0), (4.0, 4.0, 2.1, 2.0)]
    xz, boundary = found(without(wall_points(facade_of(6.0, 5.0, WINDOWS[:3]), 0.025), *notches))
    inside = [(0.0, 4.0, 1.5, 1.0), (4.0, 4.0, 2.0, 1.0)]
    clusters = [cluster_at(xz, boundary, np.array(box))[0] for box in inside]
    assert set(boundary.open_clusters) == set(clusters)
    # The hull cuts off half of each notch, and a strip as wide as the threshold along it is border.
    whole = np.array([1.5 * 1.0, 2.0 * 1.0]) / 2
    strip = 0.1 * np.hypot([1.5, 2.0], 1.0)
    assert (areas(xz, boundary)[clusters] < 1.05 * whole).all()
    assert (areas(xz, boundary)[clusters] > 0.95 * (whole - strip)).all()


def test_the_ragged_slope_of_a_gable_is_no_hole():
    wall = wall_points(facade_of(6.0, 6.0, WINDOWS), 0.03, seed=2)
    gable = wall[wall[:, 1] < 6.0 - np.abs(wall[:, 0] - 3.0) / 2.0]
    xz, boundary = found(gable)
    sizes = areas(xz, boundary)
    assert sizes[:4] == pytest.approx([2.0, 2.0, 1.92, 1.92], rel=0.1)
    assert sizes[4:].max(initial=0) < 0.04
    assert not set(boundary.open_clusters) & set(range(4))


@pytest.mark.parametrize(
    ("edge", "expected"),
    [(0.005, 0.1), (0.03, 0.12), (0.09, 0.2), (0.15, 0.27)],
    ids=["dense", "between", "sparse", "sparser"],
)
def test_threshold_scales_with_the_spacing_within_limits(edge, expected):
    assert length_threshold(np.array([edge]), min_opening=0.4) == pytest.approx(expected)


def test_threshold_can_be_given():
    _, boundary = found(wall_points(HOUSE, 0.03), ReconstructionOptions(threshold=0.175))
    assert boundary.threshold == 0.175
    assert boundary.threshold_of_triangle == pytest.approx(0.175)


def test_sparse_points_show_large_windows_with_a_warning():
    # A grid of 0.12 m, as thinned clouds of whole buildings have.
    windows = [(1.0, 1.0, 1.5, 2.0), (4.0, 1.0, 1.5, 2.0), (7.0, 1.0, 1.5, 2.0)]
    wall = wall_points(facade_of(10.0, 5.0, windows), 0.12, pattern="grid")
    xz, boundary = found(wall + np.random.default_rng(0).normal(0, 0.01, wall.shape))
    assert len({cluster_at(xz, boundary, np.array(box))[0] for box in windows}) == 3
    assert areas(xz, boundary)[3:].max(initial=0) < 0.1
    # It takes 1.8 edges to tell a gap, and two such thresholds across an opening.
    assert boundary.min_opening == pytest.approx(2 * 1.8 * 0.124, rel=0.1)
    assert "too far to show openings of 0.4 m: those under 0.4" in boundary.warnings[0]


def test_a_part_that_is_too_sparse_is_told():
    wall = wall_points(facade_of(8.0, 6.0, []), 0.02, seed=5)
    top = wall_points(facade_of(8.0, 6.0, []), 0.12, seed=6)
    _, boundary = found(np.concatenate([wall[wall[:, 1] < 4.0], top[top[:, 1] > 4.0]]))
    assert boundary.min_opening == 0.4
    assert boundary.warnings[0].endswith("m may be missing there.")
    share = int(boundary.warnings[0].split(" %")[0].removeprefix("On "))
    assert 15 <= share <= 50  # the upper third


def test_too_sparse_points_are_refused():
    with pytest.raises(ReconstructionError, match=r"too far to show openings of 0\.4 m: scan more densely"):
        found(wall_points(facade_of(20.0, 15.0, []), 0.4))


def test_gaps_between_single_points_are_not_taken_for_a_wall():
    # Random points 0.1 m apart leave a tenth of the wall in gaps of 0.175 m and more.
    with pytest.raises(ReconstructionError, match="of the wall lies in gaps over"):
        found(wall_points(facade_of(12.0, 9.0, []), 0.1), ReconstructionOptions(threshold=0.175))


def test_points_on_one_line_are_refused():
    with pytest.raises(ReconstructionError, match="they may lie on one line"):
        found(np.column_stack([np.linspace(0, 5, 400), np.linspace(0, 3, 400)]))


def test_the_order_of_the_points_does_not_matter():
    xz = wall_points(HOUSE, 0.03, seed=9)
    points, boundary = found(xz)
    shuffled = SimpleNamespace(xz=np.random.default_rng(0).permutation(xz))
    again = find_boundary(shuffled, options=OPTIONS)
    assert again.threshold == pytest.approx(boundary.threshold, rel=1e-12)
    first, second = (
        {tuple(sorted(map(tuple, corners))) for corners in cloud[found_in.triangles].tolist()}
        for cloud, found_in in ((points, boundary), (shuffled.xz, again))
    )
    assert first == second


@pytest.mark.parametrize("spacing", [0.02, 0.05, 0.075])
def test_threshold_separates_the_edges(spacing):
    # Hardly an edge inside the wall is longer: one in forty where half an opening is the limit.
    _, boundary = found(wall_points(facade_of(6.0, 5.0, []), spacing))
    assert np.mean(boundary.edge_lengths > boundary.threshold) < 0.025
    assert 0.1 <= boundary.threshold <= 0.25
    assert boundary.threshold >= min(2.0 * np.median(boundary.edge_lengths), 0.1)
