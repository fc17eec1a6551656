import numpy as np
import pytest
from scipy.optimize import check_grad

from fd2fem.meshing.smoothing import _penalty, corner_quality, smooth


def grid(count):
    """A square of `count` by `count` quadrilaterals: points, quads and which points are on its edge."""
    x, z = (
        axis.ravel() for axis in np.meshgrid(np.arange(count + 1.0), np.arange(count + 1.0), indexing="ij")
    )
    k = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    quads = np.stack([k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]], axis=-1).reshape(-1, 4)
    edge = (x == 0) | (x == count) | (z == 0) | (z == count)
    return np.column_stack([x, z]), quads, edge


@pytest.mark.parametrize("noise", [0.1, 0.4, 1.5])
def test_a_shaken_grid_becomes_square_again(noise):
    # at 1.5 almost all quadrilaterals are folded
    points, quads, edge = grid(8)
    shaken = points + np.where(edge[:, None], 0.0, np.random.default_rng(1).normal(0.0, noise, points.shape))
    moved = smooth(shaken, quads, fixed=edge)
    np.testing.assert_array_equal(moved[edge], points[edge])
    assert corner_quality(moved, quads).min() > 0.85
    assert corner_quality(shaken, quads).min() < corner_quality(moved, quads).min()


def test_quality_by_hand():
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [3, 1]], dtype=float)
    quads = np.array([[0, 1, 2, 3], [1, 4, 5, 2], [0, 3, 2, 1]])
    # a square, a parallelogram of 45 degrees, and the square the wrong way round
    assert corner_quality(points, quads) == pytest.approx([1.0, np.sqrt(0.5), -1.0])


def test_the_gradient_is_that_of_the_penalty():
    points, quads, _ = grid(3)
    shaken = points + np.random.default_rng(2).normal(0.0, 0.3, points.shape)
    forgiven = np.full(4 * len(quads), 0.1)
    error = check_grad(
        lambda flat: _penalty(flat.reshape(-1, 2), quads, forgiven)[0],
        lambda flat: _penalty(flat.reshape(-1, 2), quads, forgiven)[1].ravel(),
        shaken.ravel(),
    )
    assert error < 1e-4 * np.linalg.norm(_penalty(shaken, quads, forgiven)[1])


def test_nothing_to_move():
    points, quads, _ = grid(1)
    assert smooth(points, quads, fixed=np.ones(4, dtype=bool)) is points
