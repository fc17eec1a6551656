import numpy as np
import pytest

from fd2fem.reconstruction.thinning import chunks, coordinate_hash, occupied_cells, take_sample
from fd2fem.reconstruction.wall_points import point_spacing, sort_points


def cloud(count, seed=0):
    return np.random.default_rng(seed).uniform(0, 10, (count, 3))


def test_hash_is_even_on_round_coordinates():
    # Millimetres, as files write them: the low bits of the numbers are alike.
    axes = np.meshgrid(np.arange(50) * 0.001, np.arange(40) * 0.001, np.arange(10) * 0.001)
    keys = coordinate_hash(np.stack(axes, axis=-1).reshape(-1, 3))
    assert len(np.unique(keys)) == 20_000
    # Sixteen equal parts of the range: each count is binomial, 1250 ± 34.
    count = np.bincount((keys >> np.uint64(60)).astype(int), minlength=16)
    assert np.abs(count - 1250).max() < 5 * 34
    low = np.bincount((keys & np.uint64(15)).astype(int), minlength=16)
    assert np.abs(low - 1250).max() < 5 * 34


def test_every_coordinate_reaches_the_hash():
    point = np.array([[1.0, 2.0, 3.0]])
    for axis in range(3):
        other = point.copy()
        other[0, axis] += 1e-9
        changed = int(coordinate_hash(point)[0]) ^ int(coordinate_hash(other)[0])
        # About half of the 64 bits flip.
        assert 12 < bin(changed).count("1") < 52


def test_sample_does_not_depend_on_the_order():
    points = cloud(30_000)
    one = take_sample(points, 5000)
    other = take_sample(np.random.default_rng(1).permutation(points), 5000)
    assert (one.points == other.points).all()
    assert len(one.points) == pytest.approx(5000, abs=5 * np.sqrt(5000))
    assert one.share == len(one.points) / 30_000
    # Any first part of it is a sample, too.
    assert one.points[:1000].mean(axis=0) + one.centre == pytest.approx([5, 5, 5], abs=0.5)


def test_small_cloud_is_taken_whole():
    points = cloud(500)
    sample = take_sample(points, 5000)
    assert sample.share == 1.0
    assert np.sort(sample.points[:, 0] + sample.centre[0]) == pytest.approx(np.sort(points[:, 0]))


def test_chunks_cover_all_points():
    assert np.concatenate([np.arange(part.start, part.stop) for part in chunks(1_200_000)]).tolist() == list(
        range(1_200_000)
    )


def test_cells_count_their_points():
    first, count = occupied_cells(np.array([[0.9, 0.0], [0.2, 0.0], [2.5, 0.0], [0.1, 0.0]]), 1.0)
    assert first.tolist() == [0, 2]
    assert count.tolist() == [3, 1]


@pytest.mark.parametrize("copies", [200, 30_000])
def test_sorting_drops_points_in_one_place(copies):
    rng = np.random.default_rng(2)
    xz = rng.uniform(0, 5, (40_000, 2)).round(3)
    xz = xz[np.unique((xz * 1000).round().astype(int), axis=0, return_index=True)[1]]
    # Squares are counted from the least coordinates: the corner puts the points into their middles.
    twice = np.concatenate([[[-5e-5, -5e-5]], xz, xz[:copies] + 2e-5])
    order = sort_points(rng.permutation(twice))
    assert len(order) == len(xz) + 1


def test_sorting_is_by_x_and_then_by_z():
    x, z = np.meshgrid(np.arange(30) * 0.1, np.arange(20) * 0.1)
    xz = np.random.default_rng(3).permutation(np.column_stack([x.ravel(), z.ravel()]))
    done = xz[sort_points(xz)]
    assert done.tolist() == sorted(xz.tolist())


def test_spacing_does_not_depend_on_the_order():
    xz = cloud(20_000)[:, :2]
    assert point_spacing(xz[sort_points(xz)]) == pytest.approx(point_spacing(xz), rel=1e-12)
    # 200 points per m².
    assert point_spacing(xz) == pytest.approx(1.0 / np.sqrt(200.0), rel=0.06)


def test_spacing_of_a_few_points():
    xz = np.array([[i, j] for i in range(3) for j in range(3)], dtype=float)
    # The eighth neighbour of all nine: between √2 (of the middle) and 2√2 (of the corners).
    assert np.sqrt(2) <= point_spacing(xz) / np.sqrt(np.pi / 8) <= 2.0001 * np.sqrt(2)
