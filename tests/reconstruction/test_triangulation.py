"""The restricted triangulation against scipy's triangulation of all points."""

import numpy as np
import pytest
import shapely
from scipy.spatial import Delaunay, cKDTree

from fd2fem.errors import ReconstructionError
from fd2fem.reconstruction.triangulation import long_triangles, side_lengths, triangle_areas


def longest(xz, triangles):
    corners = xz[triangles]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


def not_flat(xz, triangles):
    first, second = (xz[triangles[:, k]] - xz[triangles[:, 0]] for k in (1, 2))
    height = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return triangles[height > 1e-10 * longest(xz, triangles) ** 2]


def oracle(xz, length):
    """Long triangles and hull points out of all triangles."""
    triangulation = Delaunay(xz - xz.mean(axis=0))
    triangles = triangulation.simplices
    return not_flat(xz, triangles[longest(xz, triangles) > length]), np.unique(triangulation.convex_hull)


def names(triangles):
    return {tuple(row) for row in np.sort(triangles, axis=1).tolist()}


def hole(xz, rng):
    """Cut a disc and a rectangle out, but never everything."""
    low, extent = xz.min(axis=0), np.ptp(xz, axis=0) + 1e-9
    centre = low + extent * rng.uniform(0, 1, 2)
    outside = np.hypot(*((xz - centre) / extent.max()).T) > rng.uniform(0.05, 0.4)
    corner, size = low + extent * rng.uniform(0, 1, 2), extent * rng.uniform(0.1, 0.6, 2)
    outside &= ~((xz > corner) & (xz < corner + size)).all(axis=1)
    return xz[outside] if outside.sum() > 10 else xz


def random_points(rng):
    return rng.uniform(0, 1, (int(rng.integers(5, 900)), 2)) * rng.uniform(0.3, 3.0, 2)


def clusters(rng):
    centres = rng.uniform(0, 2, (int(rng.integers(2, 7)), 2))
    return np.concatenate([rng.normal(c, rng.uniform(0.001, 0.2), (80, 2)) for c in centres])


def lines_far_apart(rng):
    rows, points = int(rng.integers(2, 30)), int(rng.integers(20, 60))
    x = rng.uniform(0, 1, (rows, points))
    z = np.arange(rows)[:, None] * rng.uniform(0.02, 0.3) + rng.normal(0, 1e-3, (rows, points))
    return np.column_stack([x.ravel(), z.ravel()])


def needle(rng):
    return rng.uniform(0, 1, (200, 2)) * [50.0, rng.uniform(1e-4, 0.05)]


def ring(rng):
    angle, radius = rng.uniform(0, 2 * np.pi, 300), rng.uniform(0.9, 1.0, 300)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def ragged_wall(rng):
    """Dense wall whose border points all but lie on its edges."""
    xz = rng.uniform(0, 1, (800, 2))
    side = rng.integers(0, 4, 120)
    edge = rng.uniform(0, 1, (120, 2))
    edge[side < 2, 0] = side[side < 2] + rng.normal(0, 1e-5, (side < 2).sum())
    edge[side >= 2, 1] = side[side >= 2] - 2 + rng.normal(0, 1e-5, (side >= 2).sum())
    return np.concatenate([xz, edge])


def two_densities(rng):
    dense = rng.uniform(0, 1, (700, 2)) * [0.5, 1.0]
    return np.concatenate([dense, rng.uniform(0, 1, (60, 2)) * [0.5, 1.0] + [0.5, 0.0]])


GENERAL = [random_points, clusters, lines_far_apart, needle, ring, ragged_wall, two_densities]


@pytest.mark.parametrize("make", GENERAL, ids=lambda make: make.__name__)
def test_the_same_triangles_as_out_of_all_points(make):
    left_out = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        xz = hole(make(rng), rng) + rng.uniform(-50, 50, 2)
        spacing = np.sqrt(np.ptp(xz, axis=0).prod() / len(xz))
        length = spacing * rng.uniform(0.7, 12.0)
        long = long_triangles(xz, length)
        triangles, hull = oracle(xz, length)
        assert names(long.corners) == names(triangles), f"seed {seed}"
        assert np.array_equal(long.hull, hull), f"seed {seed}"
        left_out += len(xz) - len(np.unique(long.corners))
    assert left_out > 0


def grid_with_holes(rng):
    """Points of an exact grid: every four neighbours lie on one circle."""
    shape = rng.integers(8, 40, 2)
    xz = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 2)
    return hole(xz.astype(float), rng)


def circles(corners):
    """Centres and radii of circumcircles, from the linear equations of the bisectors."""
    rows = corners[:, 1:] - corners[:, :1]
    offset = np.linalg.solve(rows, (rows**2).sum(axis=2, keepdims=True) / 2.0)[..., 0]
    return corners[:, 0] + offset, np.linalg.norm(offset, axis=1)


def sides_between_circles(xz, triangles, length):
    """Sides over a length that no other choice among points on one circle would leave out."""
    centres, _ = circles(xz[triangles])
    found = {}
    for triangle, centre in zip(triangles, centres, strict=True):
        for k in range(3):
            found.setdefault(tuple(sorted(np.delete(triangle, k).tolist())), []).append(centre)
    return {
        side
        for side, both in found.items()
        if np.linalg.norm(xz[side[0]] - xz[side[1]]) > length
        and (len(both) == 1 or np.linalg.norm(both[0] - both[1]) > 1e-7)
    }


@pytest.mark.parametrize("turn", [0.0, 0.3], ids=["level", "turned"])
def test_exact_grids_are_covered_by_delaunay_triangles(turn):
    # Which diagonal is drawn between points on one circle is open; everything else is not.
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for seed in range(60):
        rng = np.random.default_rng(seed)
        xz = grid_with_holes(rng) @ rotation
        length = rng.uniform(1.5, 5.0)
        long = long_triangles(xz, length)
        triangles, hull = oracle(xz, length)
        # Rounding decides which points of a turned row lie on the hull.
        ours, theirs = (shapely.MultiPoint(xz[points]).convex_hull for points in (long.hull, hull))
        assert ours.symmetric_difference(theirs).area < 1e-9
        corners = not_flat(xz, long.corners)
        centres, radii = circles(xz[corners])
        nearest, _ = cKDTree(xz).query(centres)
        assert (nearest > radii - 1e-7).all(), f"seed {seed}: a point lies in a circumcircle"
        pieces = shapely.polygons(xz[corners])
        assert shapely.union_all(pieces).area == pytest.approx(shapely.area(pieces).sum()), "they overlap"
        ours = sides_between_circles(xz, corners, length)
        assert ours >= sides_between_circles(xz, triangles, length), f"seed {seed}: a long side is missing"


def test_a_large_wall():
    rng = np.random.default_rng(5)
    xz = rng.uniform(0, 1, (100_000, 2)) * [12.0, 8.0]
    for low, high in (([1, 1], [2, 3]), ([2.14, 1], [3.1, 3]), ([6, 0], [7, 2.4]), ([10, 6.5], [12, 8])):
        xz = xz[~((xz > low) & (xz < high)).all(axis=1)]
    long = long_triangles(xz, 0.15)
    triangles, hull = oracle(xz, 0.15)
    assert names(long.corners) == names(triangles)
    assert np.array_equal(long.hull, hull)
    # The four holes and next to nothing else; the last one is a notch that the hull cuts.
    assert triangle_areas(xz[long.corners]).sum() == pytest.approx(2.0 + 1.92 + 2.4 + 1.5, abs=0.35)


def test_neighbours_share_the_side_opposite_to_the_corner():
    rng = np.random.default_rng(1)
    xz = hole(rng.uniform(0, 1, (3000, 2)), rng)
    long = long_triangles(xz, 0.06)
    where = np.argwhere(long.neighbours >= 0)
    assert len(where) > 10
    for triangle, side in where:
        shared = set(np.delete(long.corners[triangle], side))
        assert shared < set(long.corners[long.neighbours[triangle, side]])
    lengths = side_lengths(xz, long.corners)
    # A long side without a neighbour can only lie on the hull.
    assert (long.on_hull | (long.neighbours >= 0) | (lengths <= 0.06)).all()
    hull = shapely.MultiPoint(xz).convex_hull.exterior
    for triangle, side in np.argwhere(long.on_hull):
        middle = xz[np.delete(long.corners[triangle], side)].mean(axis=0)
        assert hull.distance(shapely.Point(middle)) < 1e-9


def test_triangles_run_counter_clockwise():
    xz = np.random.default_rng(2).uniform(0, 1, (400, 2))
    corners = xz[long_triangles(xz, 0.08).corners]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()


def test_subset_renumbers_the_neighbours():
    xz = np.random.default_rng(3).uniform(0, 1, (400, 2))
    long = long_triangles(xz, 0.05)
    chosen = np.arange(len(long.corners)) % 3 > 0
    part = long.subset(chosen)
    assert len(part.corners) == chosen.sum()
    for triangle, side in np.argwhere(part.neighbours >= 0):
        shared = set(np.delete(part.corners[triangle], side))
        assert shared < set(part.corners[part.neighbours[triangle, side]])


@pytest.mark.parametrize(
    "xz",
    [np.column_stack([np.arange(50.0), np.zeros(50)]), np.array([[0.0, 0.0], [1.0, 1.0]])],
    ids=["one line", "two points"],
)
def test_points_on_one_line_are_refused(xz):
    with pytest.raises(ReconstructionError, match="they may lie on one line"):
        long_triangles(xz, 0.1)


def test_survey_coordinates_give_the_same_triangles():
    xz = np.random.default_rng(4).uniform(0, 1, (5000, 2)).round(4)
    xz = np.unique(xz, axis=0)
    far = xz + np.array([700_000.0, 100.0])
    assert names(long_triangles(far, 0.05).corners) == names(long_triangles(xz, 0.05).corners)
