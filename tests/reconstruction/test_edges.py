import numpy as np
import pytest

from fd2fem.reconstruction.edges import edge_position

LENGTH, DEPTH = 1.5, 0.5


def sample(pattern, spacing, rng):
    if pattern == "random":
        count = rng.poisson(LENGTH * DEPTH / spacing**2)
        return rng.uniform(0, DEPTH, count), rng.uniform(0, LENGTH, count)
    pitch = {"grid": (spacing, spacing), "columns": (2 * spacing, spacing / 2)}[pattern]
    start = rng.uniform(0, pitch)
    columns, rows = np.meshgrid(np.arange(start[0], DEPTH, pitch[0]), np.arange(start[1], LENGTH, pitch[1]))
    return columns.ravel(), rows.ravel()


def errors(pattern, spacing, *, strays=0, trials=200):
    rng = np.random.default_rng(7)
    found = []
    for _ in range(trials):
        inward, along = sample(pattern, spacing, rng)
        inward = np.append(inward, rng.uniform(-0.3, 0, strays))
        along = np.append(along, rng.uniform(0, LENGTH, strays))
        guess = rng.uniform(0.2, 0.8) * spacing
        offset, sigma = edge_position(inward - guess, along, spacing=spacing, reach=max(8 * spacing, 0.1))
        found.append((offset + guess, sigma))
    return np.array(found).T


@pytest.mark.parametrize("spacing", [0.01, 0.02, 0.05])
@pytest.mark.parametrize("pattern", ["random", "grid"])
def test_position_has_no_bias(pattern, spacing):
    error, _ = errors(pattern, spacing)
    # Three standard errors of the mean of 200 trials, and a tenth of the half spacing that it takes away.
    assert abs(error.mean()) < 3 * error.std() / np.sqrt(len(error)) + 0.05 * spacing


@pytest.mark.parametrize("spacing", [0.02, 0.05])
def test_scatter_is_at_the_floor_of_the_sampling(spacing):
    # A grid says where an edge is to within one pitch: pitch/sqrt(12).
    error, sigma = errors("grid", spacing)
    assert error.std() == pytest.approx(spacing / np.sqrt(12), rel=0.1)
    assert sigma.mean() == pytest.approx(spacing / np.sqrt(12), rel=0.2)


@pytest.mark.parametrize("pattern", ["random", "columns"])
def test_sigma_is_honest(pattern):
    error, sigma = errors(pattern, 0.02)
    assert np.mean(np.abs(error) < 1.96 * sigma) >= 0.85
    # Not by being large: the errors in units of sigma scatter by about 1.
    assert 0.6 < np.std(error / sigma) < 1.5


def test_stray_points_do_not_move_the_edge():
    clean, _ = errors("random", 0.02)
    stray, _ = errors("random", 0.02, strays=3)
    assert abs(stray.mean() - clean.mean()) < 0.001


def test_hidden_part_of_an_edge_does_not_count():
    rng = np.random.default_rng(3)
    inward, along = sample("random", 0.02, rng)
    seen = (along > 0.6) | (inward > 0.2)
    offset, _ = edge_position(inward[seen], along[seen], spacing=0.02, reach=0.16)
    assert abs(offset) < 0.006
