"""Principal stresses and what is made of them."""

import numpy as np
import pytest
from exported_meshes import hexahedra20
from hypothesis import given, settings
from hypothesis import strategies as st

from solvers.fem.stress import PointStress, nodal_stress, principal_stress, stress_measures

COMPONENT = st.floats(-1e7, 1e7)


@pytest.mark.parametrize(
    ("stress", "expected"),
    [
        ([1, 2, 3, 0, 0, 0], [3, 2, 1]),
        # Plane stress in x and z, Mohr's circle: centre 30, radius √(30² + 40²) = 50.
        ([60, 0, 0, 0, 0, 40], [80, 0, -20]),
        ([0, 60, 0, 40, 0, 0], [80, 0, -20]),
        ([0, 0, 60, 0, 40, 0], [80, 0, -20]),
        # Equal shear on all planes: 2τ along the space diagonal, -τ twice across it.
        ([0, 0, 0, 5, 5, 5], [10, -5, -5]),
    ],
)
def test_principal_stress_by_hand(stress, expected):
    assert np.allclose(principal_stress(stress), expected, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(st.tuples(*[COMPONENT] * 6))
def test_principal_stress_keeps_the_invariants(stress):
    xx, yy, zz, xy, yz, xz = stress
    s1, s2, s3 = principal_stress(stress)
    scale = max(1.0, *map(abs, stress))
    assert s1 >= s2 >= s3
    assert s1 + s2 + s3 == pytest.approx(xx + yy + zz, abs=1e-9 * scale)
    assert s1 * s2 + s2 * s3 + s3 * s1 == pytest.approx(
        xx * yy + yy * zz + zz * xx - xy**2 - yz**2 - xz**2, abs=1e-9 * scale**2
    )


def _uniaxial(values, heights, volumes):
    count = len(values)
    stress, location = np.zeros((count, 1, 6)), np.zeros((count, 1, 3))
    stress[:, 0, 0] = values
    location[:, 0, 2] = heights
    return PointStress(stress=stress, volume=np.reshape(volumes, (count, 1)).astype(float), location=location)


def test_measures_weigh_by_volume():
    # σ1 of 1 to 4 Pa on 90, 4, 4 and 2 % of the volume: 95 % of it lies at 3 Pa or less, 99 % at 4.
    measures = stress_measures(_uniaxial([1, 2, 3, 4], [1, 1, 1, 1], [90, 4, 4, 2]), above=0.5)
    assert measures.p95 == 3.0
    assert measures.p99 == 4.0
    assert measures.rms == pytest.approx(np.sqrt((90 * 1 + 4 * 4 + 4 * 9 + 2 * 16) / 100))


def test_measures_leave_the_base_out():
    assert stress_measures(_uniaxial([9, 2], [0.1, 1.0], [1, 1]), above=0.5).rms == 2.0


def test_measures_of_a_low_wall_keep_all():
    assert stress_measures(_uniaxial([3, 3], [0.1, 0.2], [1, 1]), above=0.5).p95 == 3.0


def test_compression_counts_as_sigma1_of_zero():
    assert stress_measures(_uniaxial([-5.0], [1.0], [1.0]), above=0.0).p99 == 0.0


def test_nodes_average_their_elements(grid):
    # Two bricks with uniform stress of 1 and 3 Pa: 2 Pa on the shared facet.
    mesh = grid([0, 1, 2], [0, 1], [0, 1])
    stress = np.zeros((2, 8, 6))
    stress[0, :, 2], stress[1, :, 2] = 1.0, 3.0
    points = PointStress(stress=stress, volume=np.full((2, 8), 0.125), location=np.zeros((2, 8, 3)))
    assert np.allclose(nodal_stress(mesh, points)[:, 2], 1.0 + mesh.nodes[:, 0])


def test_middles_of_edges_take_the_mean_of_their_ends(grid):
    mesh = hexahedra20(grid([0, 1, 2], [0, 1], [0, 1]))
    stress = np.zeros((2, 8, 6))
    stress[0, :, 2], stress[1, :, 2] = 1.0, 3.0
    points = PointStress(stress=stress, volume=np.full((2, 8), 0.125), location=np.zeros((2, 8, 3)))
    assert np.allclose(nodal_stress(mesh, points)[:, 2], 1.0 + mesh.nodes[:, 0])
