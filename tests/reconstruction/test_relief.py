import numpy as np
import pytest

from fd2fem.model.frame import OutOfPlane
from fd2fem.reconstruction.relief import depth_behind, fit_relief

RNG = np.random.default_rng(0)


def face(depth, count=20_000, noise=0.003):
    x, z = RNG.uniform(0, 8, count), RNG.uniform(0, 6, count)
    return np.column_stack([x, depth(x, z) + RNG.normal(0, noise, count), z])


def test_bow_in_both_directions_is_found():
    def depth(x, z):
        return 0.05 * np.sin(np.pi * x / 8) * np.sin(np.pi * z / 6)

    local = face(depth)
    relief = fit_relief(local)
    x, z = np.meshgrid(np.linspace(0.1, 7.9, 40), np.linspace(0.1, 5.9, 30))
    true = np.column_stack([x.ravel(), depth(x, z).ravel(), z.ravel()])
    # Thirty points a value, 3 mm of noise: half a millimetre.
    assert np.abs(depth_behind(relief, true)).max() < 0.002


def test_stray_points_do_not_pull_the_face():
    local = face(lambda x, _: 0.0 * x)
    local[::10, 1] += 0.1
    assert np.nanmax(np.abs(fit_relief(local).values)) < 0.003


def test_depth_between_values_is_bilinear_and_clamped_outside():
    relief = OutOfPlane(np.array([1.0, 2.0]), 0.5, np.array([[0.0, 0.2], [0.4, 1.0]]))
    local = np.array([[1.25, 0.0, 2.25], [0.0, 0.0, 0.0], [9.0, 0.5, 9.0]])
    assert depth_behind(relief, local) == pytest.approx([-0.4, 0.0, -0.5])


def test_where_the_face_was_not_seen_the_nearest_value_counts():
    relief = OutOfPlane(np.zeros(2), 1.0, np.array([[0.1, np.nan], [0.3, np.nan]]))
    assert depth_behind(relief, np.array([[0.5, 0.0, 1.0], [1.0, 0.0, 0.5]])) == pytest.approx([-0.2, -0.3])


def test_order_does_not_matter_where_all_points_count():
    local = face(lambda x, _: 0.01 * np.sin(x))
    one, other = fit_relief(local), fit_relief(local[::-1])
    assert one.values == pytest.approx(other.values, abs=1e-9, nan_ok=True)
