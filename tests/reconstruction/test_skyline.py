import numpy as np
import pytest
import shapely

from fd2fem.model import rectangle
from fd2fem.reconstruction.sampling import Sampling
from fd2fem.reconstruction.skyline import fit_outline

RECTANGLE = [(0, 0), (12, 0), (12, 9), (0, 9)]
WALLS = {
    "rectangle": RECTANGLE,
    "gable": [(0, 0), (10, 0), (10, 8), (5, 12), (0, 8)],
    "low gable": [(0, 0), (15, 0), (15, 8), (7.5, 9.5), (0, 8)],
    "stepped parapet": [
        *[(0, 0), (12, 0), (12, 8), (9, 8), (9, 9), (7.5, 9), (7.5, 10)],
        *[(4.5, 10), (4.5, 9), (3, 9), (3, 8), (0, 8)],
    ],
    "annex": [(0, 0), (14, 0), (14, 4), (10, 4), (10, 10), (0, 10)],
    "leaning ends": [(0, 0), (13, 0), (12, 9), (0.8, 9)],
    "sloping top": [(0, 0), (12, 0), (12, 8.5), (0, 9)],
    "passage at the corner": [(0, 3.584), (8.91, 3.584), (8.91, 0), (17.347, 0), (17.347, 9.8), (0, 9.8)],
    "mansard": [(0, 0), (12, 0), (12, 8), (10.5, 11), (1.5, 11), (0, 8)],
}


def scan(corners, spacing, pattern, rng, *, strays=0.003):
    """Points on a wall with windows, sorted by x, and the windows' outlines."""
    outline = shapely.Polygon(corners)
    low, high = np.array(outline.bounds[:2]) - 1.0, np.array(outline.bounds[2:]) + 1.0
    if pattern == "random":
        xz = rng.uniform(low, high, (int((high - low).prod() / spacing**2), 2))
    else:
        pitch = np.array({"grid": (1.0, 1.0), "rows": (1 / 1.4, 1.4)}[pattern]) * spacing
        x, z = (np.arange(*span) for span in zip(low + rng.uniform(0.0, pitch), high, pitch, strict=True))
        xz = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
        xz = xz + rng.normal(0.0, 0.001, xz.shape)
    windows = [
        rectangle(x, z, 1.1, 1.5)
        for x in np.arange(1.2, high[0] - 2.5, 2.5)
        for z in np.arange(0.9, high[1] - 2.8, 3.0)
        if outline.contains(shapely.box(x, z, x + 1.1, z + 1.5))
    ]
    keep = shapely.contains_xy(outline, xz)
    for window in windows:
        keep &= ~((xz > window.min(axis=0)) & (xz < window.max(axis=0))).all(axis=1)
    xz = xz[keep | (rng.uniform(size=len(xz)) < strays)]
    return xz[np.argsort(xz[:, 0])], windows


def nothing_hidden(xz):
    return np.zeros(len(xz), dtype=bool)


def fitted(xz, windows, spacing, **options):
    options = {"hidden": nothing_hidden, **options}
    return fit_outline(xz, sampling=Sampling(spacing, 0.001, 0.0), gaps=windows, **options)


def distance(ring, corners):
    return shapely.Polygon(ring).exterior.hausdorff_distance(shapely.Polygon(corners).exterior)


@pytest.mark.parametrize("pattern", ["random", "grid", "rows"])
@pytest.mark.parametrize("spacing", [0.02, 0.05])
@pytest.mark.parametrize("wall", WALLS)
def test_known_walls(wall, spacing, pattern):
    fit = fitted(*scan(WALLS[wall], spacing, pattern, np.random.default_rng(4)), spacing)
    assert len(fit.ring) == len(WALLS[wall]) == len(fit.kinds) == len(fit.sigma)
    assert fit.rectangular is (wall == "rectangle")
    # Rows 1.4 spacings apart say where an edge is to within half of that; even points far better.
    assert distance(fit.ring, WALLS[wall]) < (0.25 if pattern == "random" else 0.8) * spacing
    true = shapely.Polygon(WALLS[wall]).area
    assert shapely.Polygon(fit.ring).area == pytest.approx(true, rel=0.001 if pattern == "random" else 0.005)


def test_straight_edges_are_exactly_straight():
    fit = fitted(*scan(WALLS["stepped parapet"], 0.02, "random", np.random.default_rng(5)), 0.02)
    side = np.abs(np.roll(fit.ring, -1, axis=0) - fit.ring)
    assert side.min(axis=1).max() == 0.0


def test_sigma_is_honest():
    rng = np.random.default_rng(6)
    scores = []
    for _ in range(12):
        fit = fitted(*scan(RECTANGLE, 0.05, "random", rng), 0.05)
        errors = np.array([fit.ring[0, 1], fit.ring[1, 0] - 12.0, fit.ring[2, 1] - 9.0, fit.ring[0, 0]])
        scores += list(errors / fit.sigma)
    assert np.mean(np.abs(scores) < 1.96) > 0.8
    assert np.std(scores) > 0.4


def test_given_ground_is_kept():
    xz, windows = scan(RECTANGLE, 0.05, "random", np.random.default_rng(7))
    fit = fitted(xz, windows, 0.05, ground=-0.12)
    assert fit.ring[:2, 1].tolist() == [-0.12, -0.12]


@pytest.mark.parametrize("spacing", [0.02, 0.05, 0.075])
def test_what_is_no_step(spacing):
    """Chimneys, cornice ends, strays and ragged edges leave a rectangle."""
    rng = np.random.default_rng(8)
    xz, windows = scan(RECTANGLE, spacing, "random", rng, strays=0.01)
    chimney = rng.uniform([4.0, 9.0], [4.3, 9.8], (int(0.24 / spacing**2), 2))
    cornice = rng.uniform([-0.25, 8.7], [0.0, 9.0], (int(0.075 / spacing**2), 2))
    # Crumbling bricks: a tenth of the edge is up to 0.06 m short.
    crumbled = (xz[:, 1] > 8.94) & (np.sin(40.0 * xz[:, 0]) > 0.95)
    xz = np.vstack([xz[~crumbled], chimney, cornice])
    fit = fitted(xz[np.argsort(xz[:, 0])], windows, spacing)
    assert fit.rectangular
    assert distance(fit.ring, RECTANGLE) < 0.3 * spacing


HIDDEN = {
    "tree before the top": lambda xz: (xz[:, 0] > 3.0) & (xz[:, 0] < 7.0) & (xz[:, 1] > 7.0),
    "tree before the right end": lambda xz: np.hypot(xz[:, 0] - 12.0, xz[:, 1] - 5.0) < 2.0,
    "car at the left corner": lambda xz: (xz[:, 0] < 4.0) & (xz[:, 1] < 1.5),
}


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("what", HIDDEN)
def test_what_hides_the_wall_is_no_end_of_it(what, known):
    xz, windows = scan(RECTANGLE, 0.02, "random", np.random.default_rng(9))
    shadow = HIDDEN[what]
    fit = fitted(xz[~shadow(xz)], windows, 0.02, hidden=shadow if known else None)
    assert fit.rectangular
    assert distance(fit.ring, RECTANGLE) < 0.006


def test_missing_corner_that_was_seen_to_be_missing():
    corners = [(4, 0), (12, 0), (12, 9), (0, 9), (0, 1.5), (4, 1.5)]
    fit = fitted(*scan(corners, 0.02, "random", np.random.default_rng(10)), 0.02)
    assert fit.kinds.count("notch") == 2
    assert distance(fit.ring, corners) < 0.006


def test_curved_gable_becomes_a_polyline():
    angle = np.linspace(0.0, np.pi, 60)
    corners = [(0, 0), (10, 0), *zip(5 + 5 * np.cos(angle), 8 + 2.5 * np.sin(angle), strict=True)]
    fit = fitted(*scan(corners, 0.02, "random", np.random.default_rng(11)), 0.02)
    assert distance(fit.ring, corners) < 0.25
    assert shapely.Polygon(fit.ring).area == pytest.approx(shapely.Polygon(corners).area, rel=0.005)


def test_order_and_place_of_the_points_do_not_matter():
    xz, windows = scan(WALLS["gable"], 0.05, "random", np.random.default_rng(12))
    first = fitted(xz, windows, 0.05)
    shuffled = np.random.default_rng(1).permutation(xz)
    shuffled = shuffled[np.argsort(shuffled[:, 0])]
    np.testing.assert_allclose(fitted(shuffled, windows, 0.05).ring, first.ring, atol=1e-9)
    away = np.array([31.7, -4.3])
    moved = fitted(xz + away, [window + away for window in windows], 0.05)
    np.testing.assert_allclose(moved.ring - away, first.ring, atol=1e-3)
