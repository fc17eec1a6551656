import numpy as np
import pytest
from synthetic import cleaned_cloud, facade_of

from fd2fem.model import HoleKind, PointCloud
from fd2fem.reconstruction.boundary import find_boundary
from fd2fem.reconstruction.holes import classify_holes, equation_1, histogram_peaks, ray_evidence
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade

OPTIONS = ReconstructionOptions()


def holes_of(cloud, options=OPTIONS):
    points = find_facade(cloud, options=options)
    return points, classify_holes(points, find_boundary(points, options=options), options=options)


@pytest.mark.parametrize(
    ("height", "length", "reason"),
    [
        (0.4, 0.4, ""),
        (5.0, 1.0, ""),
        (0.5, 2.0, ""),
        (0.39, 1.0, "height 0.39 m is under"),
        (1.0, 0.39, "length 0.39 m is under"),
        (0.49, 2.0, "is under 0.25"),
        (5.1, 1.0, "is over 5.00"),
    ],
)
def test_equation_1_at_its_limits(height, length, reason):
    verdict = equation_1(height, length, options=OPTIONS)
    assert verdict == reason if not reason else reason in verdict


def test_peaks_ignore_a_bulge():
    rng = np.random.default_rng(0)
    jambs = np.concatenate([rng.normal(1.0, 0.01, 80), rng.normal(2.2, 0.01, 80)])
    bulge = rng.uniform(0.4, 1.0, 15)
    values = np.concatenate([jambs, bulge])
    low, high = histogram_peaks(values, np.ones(len(values)), centre=1.6, width=0.04)
    assert (low, high) == pytest.approx((1.0, 2.2), abs=0.01)


def test_openings_and_occlusions_by_size():
    # A window, a slot too narrow, a band too long, and a door down to the ground.
    house = facade_of(
        8.0, 6.0, [(1.0, 1.0, 1.0, 1.5), (3.0, 1.0, 0.3, 2.0), (1.0, 4.0, 4.0, 0.6), (5.5, 0.0, 1.1, 2.2)]
    )
    _, holes = holes_of(cleaned_cloud(house, 0.02))
    found = sorted((hole.width, hole.height, hole.kind) for hole in holes)
    truth = [(0.3, 2.0, "occlusion"), (1.0, 1.5, "opening"), (1.1, 2.2, "opening"), (4.0, 0.6, "occlusion")]
    assert [kind for *_, kind in found] == [kind for *_, kind in truth]
    for (*size, _), (*true_size, _) in zip(found, truth, strict=True):
        # Histograms give the character of a hole; its lines give the exact sizes later.
        assert size == pytest.approx(true_size, abs=0.15)


def test_ragged_hole_is_an_occlusion():
    points = cleaned_cloud(facade_of(6.0, 5.0, []), 0.02).points
    # A triangle fills half of its rectangle.
    away = points[:, [0, 2]] - [2.0, 1.5]
    inside = (away > 0).all(axis=1) & (away.sum(axis=1) < 2.0)
    _, holes = holes_of(PointCloud(points[~inside], "triangle"))
    assert [hole.kind for hole in holes] == [HoleKind.OCCLUSION]
    assert "rectangle" in holes[0].reason


def panel_scene(*, scanner):
    """A wall scanned from (3, -10, 1.6) with a 0.6 x 0.75 m panel 5 m before it: a window-shaped shadow."""
    station = np.array([3.0, -10.0, 1.6])
    wall = cleaned_cloud(facade_of(6.0, 5.0, [(0.8, 1.0, 1.0, 1.5)]), 0.02).points
    grid = np.stack(np.meshgrid(np.arange(3.4, 4.0, 0.01), np.arange(1.8, 2.55, 0.01)), -1).reshape(-1, 2)
    panel = np.insert(grid, 1, -5.0, axis=1)
    # By similar triangles the shadow is twice the panel, from the station's foot point.
    low, high = (
        station[[0, 2]] + 2 * (np.array([3.4, 1.8]) - station[[0, 2]]),
        station[[0, 2]] + 2 * (np.array([4.0, 2.55]) - station[[0, 2]]),
    )
    hidden = ((wall[:, [0, 2]] > low) & (wall[:, [0, 2]] < high)).all(axis=1)
    points = np.concatenate([wall[~hidden], panel])
    return PointCloud(points, "panel", scanners=station[None] if scanner else np.empty((0, 3))), low, high


def test_window_shaped_shadow_is_filled_when_the_scanner_is_known():
    cloud, low, high = panel_scene(scanner=True)
    points, holes = holes_of(cloud)
    shadow = next(hole for hole in holes if hole.kind is HoleKind.OCCLUSION)
    corner = np.array([shadow.x, shadow.z]) + points.frame.origin[[0, 2]]
    assert corner == pytest.approx(low, abs=0.04)
    assert [shadow.width, shadow.height] == pytest.approx(high - low, abs=0.06)
    assert "shadow" in shadow.reason
    assert [hole.kind for hole in holes].count(HoleKind.OPENING) == 1


def test_without_the_scanner_equation_1_alone_decides():
    cloud, _, _ = panel_scene(scanner=False)
    _, holes = holes_of(cloud)
    assert all(hole.kind is HoleKind.OPENING for hole in holes)
    assert all(hole.evidence["scanners"] == 0 for hole in holes)


def test_rays_cross_the_wall_where_similar_triangles_say():
    cloud, low, high = panel_scene(scanner=True)
    points = find_facade(cloud, options=OPTIONS)
    shadow = ray_evidence(points).shadow[0] + points.frame.origin[[0, 2]]
    assert shadow.min(axis=0) == pytest.approx(low, abs=0.02)
    assert shadow.max(axis=0) == pytest.approx(high, abs=0.04)


def test_low_sill_is_a_window_and_a_missing_foot_a_door():
    house = facade_of(6.0, 5.0, [(1.0, 0.25, 1.2, 2.0), (3.5, 0.0, 1.2, 2.0)])
    points, holes = holes_of(cleaned_cloud(house, 0.02))
    bottoms = sorted(hole.z - points.xz[:, 1].min() for hole in holes)
    assert bottoms == pytest.approx([0.0, 0.25], abs=0.03)
