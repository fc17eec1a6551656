"""The local spacing against patterns whose spacing is known."""

import numpy as np
import pytest

from fd2fem.errors import ReconstructionError
from fd2fem.model.spacing import SpacingGrid
from fd2fem.reconstruction.spacing import local_spacing


def grid_points(length, height, dx, dz):
    x, z = np.meshgrid(np.arange(dx / 2, length, dx), np.arange(dz / 2, height, dz), indexing="ij")
    return np.column_stack([x.ravel(), z.ravel()])


def random_points(length, height, spacing, seed=0):
    rng = np.random.default_rng(seed)
    xz = rng.uniform(0, 1, (round(length * height / spacing**2), 2)) * [length, height]
    return xz[np.argsort(xz[:, 0])]


@pytest.mark.parametrize("pitch", [0.005, 0.03, 0.2])
def test_a_square_grid(pitch):
    grid = local_spacing(grid_points(4.0, 3.0, pitch, pitch))
    assert grid.spacing == pytest.approx(pitch, rel=1e-6)
    # Two sides of each triangle are the pitch, one is the diagonal.
    assert grid.edge == pytest.approx(pitch, rel=1e-6)


@pytest.mark.parametrize(("dx", "dz"), [(0.005, 0.06), (0.05, 0.01), (0.002, 0.05)])
def test_scan_lines(dx, dz):
    grid = local_spacing(grid_points(3.0, 3.0, dx, dz))
    assert grid.spacing_at([[1.5, 1.5]]) == pytest.approx(np.sqrt(dx * dz), rel=0.02)
    # Two of a triangle's sides cross from line to line.
    assert grid.edge_at([[1.5, 1.5]]) == pytest.approx(max(dx, dz), rel=0.02)


def test_random_points():
    grid = local_spacing(random_points(6.0, 5.0, 0.02))
    assert grid.spacing.mean() == pytest.approx(0.02, rel=0.05)
    # A Delaunay edge of a Poisson process has a mean of 32/(9 pi) spacings (Miles 1970).
    assert grid.edge_lengths.mean() == pytest.approx(32 / (9 * np.pi) * 0.02, rel=0.05)
    assert np.ptp(grid.edge) < 0.3 * grid.edge.mean()


def test_the_spacing_changes_over_the_wall():
    left, right = random_points(4.0, 4.0, 0.01, seed=1), random_points(4.0, 4.0, 0.05, seed=2)
    grid = local_spacing(np.concatenate([left, right + np.array([4.0, 0.0])]))
    assert grid.spacing_at([[1.0, 2.0], [7.0, 2.0]]) == pytest.approx([0.01, 0.05], rel=0.1)


def test_holes_do_not_count():
    xz = random_points(6.0, 5.0, 0.02)
    holed = xz[~(((xz % 1.5) > 0.3).all(axis=1))]  # nearly two thirds of the wall
    assert local_spacing(holed).spacing_at([[3.0, 2.5], [0.75, 0.75]]) == pytest.approx(0.02, rel=0.15)


def test_the_order_of_the_points_does_not_matter():
    xz = random_points(3.0, 3.0, 0.03)
    shuffled = np.random.default_rng(1).permutation(xz)
    assert local_spacing(shuffled).edge == pytest.approx(local_spacing(xz).edge, rel=1e-12)


def test_a_wall_without_area_is_refused():
    with pytest.raises(ReconstructionError, match="they may lie on one line"):
        local_spacing(np.column_stack([np.linspace(0, 3, 300), np.zeros(300)]))


def test_between_the_centres_of_cells_values_run_linearly():
    x, z = np.meshgrid(np.arange(4.0), np.arange(3.0), indexing="ij")
    values = 0.01 + 0.002 * x + 0.003 * z
    grid = SpacingGrid([10.0, -5.0], 2.0, values, 2.0 * values, [])
    places = np.random.default_rng(0).uniform([1.0, 1.0], [7.0, 5.0], (50, 2))
    expected = 0.01 + 0.002 * (places[:, 0] / 2 - 0.5) + 0.003 * (places[:, 1] / 2 - 0.5)
    places += np.array([10.0, -5.0])
    assert grid.edge_at(places) == pytest.approx(expected, rel=1e-12)
    assert grid.spacing_at(places) == pytest.approx(2.0 * expected, rel=1e-12)
    # Beyond the outermost centres they stay.
    assert grid.edge_at([[-99.0, -99.0], [99.0, 99.0]]) == pytest.approx([0.01, 0.022])


def test_cells_are_numbered_row_after_row():
    grid = SpacingGrid([0.0, 0.0], 1.0, np.ones((3, 2)), np.ones((3, 2)), [])
    assert grid.cell_of([[0.5, 0.5], [0.5, 1.5], [2.5, 0.5], [9.0, -9.0]]).tolist() == [0, 1, 4, 4]
