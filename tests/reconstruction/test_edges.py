"""The position of an edge from walls that were sampled in every way that scans are, with the edge at 0."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from fd2fem.reconstruction.edge_columns import column_share
from fd2fem.reconstruction.edges import edge_position, exclusion_distance

LENGTH, SEEDS = 1.5, 50


def generators(count=SEEDS):
    return map(np.random.default_rng, range(1000, 1000 + count))


def lattice(rng, across, along, *, turn=0.0, depth=0.5, length=LENGTH):
    size = depth + length
    steps = [np.arange(-size, size, step) + rng.uniform(0, step) for step in (across, along)]
    points = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2)
    return points @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]


def station(rng, step, *, jamb, depth=0.5, length=LENGTH):
    """Rays of equal steps in azimuth and elevation from 10 m, to a jamb's or a head's surroundings.

    Columns are vertical lines on the wall, rows hyperbolas.
    """
    x0, z0 = rng.uniform(-4, 4), rng.uniform(0, 7)
    wide, high = (depth, length) if jamb else (length, depth)
    azimuth = np.arange(np.arctan(x0 / 10), np.arctan((x0 + wide) / 10), step / 10) + rng.uniform(
        0, step / 10
    )
    x = 10 * np.tan(azimuth)
    steepest = np.arctan2(z0 + high, 10)
    elevation = np.arange(np.arctan2(z0, 15), steepest, step / 10) + rng.uniform(0, step / 10)
    z = np.hypot(10, x)[:, None] * np.tan(elevation)
    points = np.column_stack([np.repeat(x, len(elevation)) - x0, z.ravel() - z0])
    return points if jamb else points[:, ::-1]


def random_points(rng, spacing, *, depth=0.5, length=LENGTH):
    count = rng.poisson(depth * length / spacing**2)
    return rng.uniform(0, [depth, length], (count, 2))


def thinned(rng, points, smallest):
    """Random sequential adsorption: points in random order, each unless a kept one is too close."""
    points = points[rng.permutation(len(points))]
    free = np.ones(len(points), dtype=bool)
    for number, near in enumerate(cKDTree(points).query_ball_point(points, smallest)):
        if free[number]:
            free[near] = False
            free[number] = True
        # A point that is not free keeps no other away.
    return points[free]


def one_per_cell(rng, points, size):
    """One point, the first, of each cell of a grid."""
    points = points[rng.permutation(len(points))]
    cell = np.floor((points + rng.uniform(0, size, 2)) / size).astype(int)
    return points[np.unique(cell, axis=0, return_index=True)[1]]


def mean_of_cell(rng, points, size):
    cell = np.floor((points + rng.uniform(0, size, 2)) / size).astype(int)
    _, number = np.unique(cell, axis=0, return_inverse=True)
    number = number.ravel()
    return np.column_stack([np.bincount(number, axis) / np.bincount(number) for axis in points.T])


def on_wall(points, *, depth=0.5, length=LENGTH):
    """Cut at the edge: before any re-sampling, as an opening does."""
    return points[(points > 0).all(axis=1) & (points < [depth, length]).all(axis=1)]


SAMPLINGS = {
    "random": lambda rng: random_points(rng, 0.02),
    "random, sparse": lambda rng: random_points(rng, 0.075, depth=0.9),
    "grid": lambda rng: lattice(rng, 0.02, 0.02),
    "grid, slightly turned": lambda rng: lattice(rng, 0.02, 0.02, turn=0.02),
    "grid, turned": lambda rng: lattice(rng, 0.02, 0.02, turn=rng.uniform(0.1, 0.7)),
    "columns along the edge": lambda rng: lattice(rng, 0.025, 0.005),
    "rows across the edge": lambda rng: lattice(rng, 0.005, 0.025),
    "station, jamb": lambda rng: station(rng, 0.02, jamb=True),
    "station, head": lambda rng: station(rng, 0.02, jamb=False),
    "two stations, jamb": lambda rng: np.vstack([station(rng, 0.03, jamb=True) for _ in range(2)]),
    "three stations, head": lambda rng: np.vstack([station(rng, 0.03, jamb=False) for _ in range(3)]),
    "every second point": lambda rng: rng.permutation(lattice(rng, 0.014, 0.014))[::2],
    "first of each cell": lambda rng: one_per_cell(rng, random_points(rng, 0.006), 0.02),
    "mean of each cell": lambda rng: mean_of_cell(rng, on_wall(lattice(rng, 0.005, 0.005), depth=0.25), 0.02),
}
RESAMPLED = {
    "random to 20 mm": (0.02, lambda rng: random_points(rng, 0.007, depth=0.24)),
    "grid to 50 mm": (0.05, lambda rng: lattice(rng, 0.02, 0.02, depth=0.6)),
    "columns to 50 mm": (0.05, lambda rng: lattice(rng, 0.025, 0.01, depth=0.6)),
    "coarse random to 75 mm": (0.075, lambda rng: random_points(rng, 0.05, depth=0.9)),
    "dense random to 75 mm": (0.075, lambda rng: random_points(rng, 0.022, depth=0.9)),
    "station's head to 75 mm": (0.075, lambda rng: station(rng, 0.025, jamb=False, depth=0.9)),
}


def sample(name, rng):
    """Points on the wall, and the smallest distance that they were re-sampled to."""
    if name in SAMPLINGS:
        return on_wall(SAMPLINGS[name](rng)), 0.0
    smallest, source = RESAMPLED[name]
    return thinned(rng, on_wall(source(rng), depth=12 * smallest), smallest), smallest


def locate(points, rng, *, smallest=0.0, noise=0.0, told=None):
    """Error, sigma and spacing where the first guess is off by up to a spacing and a half."""
    inside = np.count_nonzero((points[:, 0] > 0.1) & (points[:, 0] < 0.25)) / (0.15 * LENGTH)
    spacing = 1.0 / np.sqrt(inside)
    guess = rng.uniform(-1.5, 1.5) * spacing
    inward = points[:, 0] + rng.normal(0, noise, len(points)) - guess if noise else points[:, 0] - guess
    reach = min(max(8 * spacing, 0.1), points[:, 0].max() - guess)
    near = inward > -3 * spacing
    offset, sigma = edge_position(
        inward[near],
        points[near, 1],
        spacing=spacing,
        reach=reach,
        noise=noise if told is None else told,
        exclusion=smallest,
    )
    return offset + guess, sigma, spacing


@cache
def trials(name):
    found = []
    for rng in generators():
        points, smallest = sample(name, rng)
        found.append(locate(points, rng, smallest=smallest))
    return np.array(found).T


@pytest.mark.parametrize("name", [*SAMPLINGS, *RESAMPLED])
def test_position_has_no_bias_and_an_honest_sigma(name):
    error, sigma, spacing = trials(name)
    # A twentieth of the spacing, and two and a half standard errors of the mean of the trials.
    assert abs(error.mean()) < 0.05 * spacing.mean() + 2.5 * error.std() / np.sqrt(SEEDS)
    # 95 %, less two and a half standard deviations of a share of 50; even errors between columns give 100 %.
    assert np.mean(np.abs(error) < 1.96 * sigma) >= 0.87
    # Not by being large, except where a fiftieth of the spacing is what the crowding leaves in doubt, and
    # where the means of cells are taken for columns of a scan.
    share = 0.25 if "cell" in name else 0.03
    assert np.sqrt(np.mean(sigma**2)) < max(2.2 * error.std(), share * spacing.mean())


@pytest.mark.parametrize(
    ("name", "largest"),
    [
        ("random", 0.001),
        ("random to 20 mm", 0.001),
        ("dense random to 75 mm", 0.006),
        ("station, head", 0.003),
    ],
)
def test_position_is_precise(name, largest):
    error, _, _ = trials(name)
    assert error.std() < largest


@pytest.mark.parametrize("pitch", [0.02, 0.05])
def test_columns_along_the_edge_say_no_more_than_their_distance(pitch):
    # The edge lies anywhere between the outermost column and the next one that is not there.
    found = np.array([locate(on_wall(lattice(rng, pitch, pitch)), rng) for rng in generators()])
    assert found[:, 1] == pytest.approx(pitch / np.sqrt(12), rel=0.1)
    assert np.abs(found[:, 0]).max() < 0.55 * pitch


@pytest.mark.parametrize(("spacing", "noise"), [(0.005, 0.002), (0.005, 0.003), (0.02, 0.002)])
def test_noise_that_throws_points_over_the_edge_does_not_move_it(spacing, noise):
    # Of hundreds of points beside the edge the outermost lies 3 standard deviations outside of it.
    found = []
    for rng in generators(20):
        found.append(locate(on_wall(random_points(rng, spacing)), rng, noise=noise)[:2])
    error, sigma = np.array(found).T
    assert abs(error.mean()) < 0.25 * noise
    assert np.mean(np.abs(error) < 1.96 * sigma) >= 0.85


def test_columns_that_noise_hides_count_in_sigma():
    # 5 mm apart with 2 mm of noise: no gap shows, but the edge is no better known than to ±2.5 mm.
    found = []
    for rng in generators(20):
        found.append(locate(on_wall(lattice(rng, 0.005, 0.005)), rng, noise=0.002)[:2])
    error, sigma = np.array(found).T
    assert np.abs(error).max() < 0.004
    assert np.all(np.abs(error) < 1.96 * sigma)


@pytest.mark.parametrize("name", ["random", "grid", "station, head", "dense random to 75 mm"])
def test_strays_in_the_opening_do_not_move_the_edge(name):
    found = []
    for rng in generators():
        points, smallest = sample(name, rng)
        spacing = 0.09 if smallest else 0.02
        count = rng.poisson(0.02 * np.count_nonzero(points[:, 0] < 4 * spacing))
        strays = rng.uniform([-4 * spacing, 0], [0, LENGTH], (count, 2))
        found.append(locate(np.vstack([points, strays]), rng, smallest=smallest))
    error, _, spacing = np.array(found).T
    kept = np.clip(error, -0.6 * spacing, 0.6 * spacing)
    assert abs(kept.mean()) < 0.05 * spacing.mean() + 2.5 * kept.std() / np.sqrt(SEEDS)
    assert np.quantile(np.abs(error), 0.9) < 0.6 * spacing.mean()


def test_points_on_the_reveal_move_the_edge_by_little():
    found = []
    for rng in generators():
        points = on_wall(random_points(rng, 0.02))
        reveal = np.column_stack([rng.normal(0, 0.001, 10), rng.uniform(0, LENGTH, 10)])
        found.append(locate(np.vstack([points, reveal]), rng, told=0.001)[0])
    assert np.abs(found).max() < 0.003


@pytest.mark.parametrize("hidden", [0.4, 0.7])
@pytest.mark.parametrize("name", ["random", "grid"])
def test_hidden_part_of_an_edge_does_not_count(name, hidden):
    found = []
    for rng in generators():
        points, _ = sample(name, rng)
        start = rng.uniform(0, (1 - hidden) * LENGTH)
        behind = (points[:, 1] > start) & (points[:, 1] < start + hidden * LENGTH) & (points[:, 0] < 0.06)
        found.append(locate(points[~behind], rng)[:2])
    error, sigma = np.array(found).T
    assert np.abs(error).max() < 0.6 * 0.02
    assert np.mean(np.abs(error) < 1.96 * sigma) >= 0.87


def test_order_of_the_points_does_not_matter():
    rng = np.random.default_rng(5)
    inward, along = on_wall(random_points(rng, 0.02)).T
    order = rng.permutation(len(inward))
    options = {"spacing": 0.02, "reach": 0.16, "noise": 0.002}
    assert edge_position(inward, along, **options) == edge_position(inward[order], along[order], **options)


@pytest.mark.parametrize("count", [0, 1, 4, 7])
def test_too_few_points_tell_nothing(count):
    inward = np.linspace(0.0, 0.1, count)
    assert edge_position(inward, inward, spacing=0.05, reach=0.4) == (0.0, 0.05)


@pytest.mark.parametrize("exclusion", [0.0, 0.04])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_odd_points_give_numbers(noise, exclusion):
    rng = np.random.default_rng(2)
    for _ in range(200):
        count = rng.integers(8, 40)
        inward = rng.choice([rng.uniform(-0.1, 0.5, count), np.full(count, 0.02), np.repeat(0.05, count)])
        reach = rng.choice([0.06, 0.15, 0.4])
        found = edge_position(
            inward, inward[::-1], spacing=0.05, reach=reach, noise=noise, exclusion=exclusion
        )
        assert np.isfinite(found).all()
        assert found[1] > 0


@pytest.mark.parametrize("crowding", [0.0, 2.0])
def test_column_share_is_that_of_simulated_columns(crowding):
    # Columns 1 apart with 3 points each in the mean, the outermost (1 + crowding) times as many; the edge is
    # anywhere in the gap before it, so that the distance to the first point varies by 1/12 and more.
    rng, mean = np.random.default_rng(0), 3.0
    empty = np.zeros(200_000)
    rate = np.exp(-mean * (1 + crowding))
    empty = rng.geometric(1 - rate, len(empty)) - 1
    variance = (rng.uniform(0, 1, len(empty)) + empty).var()
    clumping = (mean / 2) / np.tanh(mean / 2)
    assert column_share(clumping, 10**9, crowding) == pytest.approx(1 / 12 / variance, rel=0.05)


def wall(name, rng, noise):
    """A wall of 3 x 2.5 m with an opening, sorted by x."""
    size = {"depth": 3.0, "length": 2.5}
    points = {
        "random": lambda: random_points(rng, 0.02, **size),
        "grid": lambda: lattice(rng, 0.02, 0.02, turn=0.1, **size),
        "lines": lambda: lattice(rng, 0.025, 0.005, **size),
        "station": lambda: station(rng, 0.02, jamb=True, **size),
        "two stations": lambda: np.vstack([station(rng, 0.03, jamb=True, **size) for _ in range(2)]),
    }[name]()
    points = on_wall(points, **size)
    points = points[~((points > 0.8) & (points < [1.7, 2.1])).all(axis=1)]
    points = points + rng.normal(0, noise, points.shape) if noise else points
    return points[np.argsort(points[:, 0])]


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.003])
@pytest.mark.parametrize("name", ["random", "grid", "lines", "station", "two stations"])
def test_scans_as_measured_have_no_smallest_distance(name, noise):
    assert exclusion_distance(wall(name, np.random.default_rng(4), noise)) == 0.0


@pytest.mark.parametrize(
    ("name", "smallest"), [("random", 0.05), ("grid", 0.075), ("station", 0.05), ("two stations", 0.075)]
)
def test_smallest_distance_of_a_re_sampled_scan_is_found(name, smallest):
    rng = np.random.default_rng(4)
    points = thinned(rng, wall(name, rng, 0.002), smallest)
    assert exclusion_distance(points[np.argsort(points[:, 0])]) == pytest.approx(smallest, rel=0.05)
