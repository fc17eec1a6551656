"""Elastic constants."""

import numpy as np
import pytest

from fd2fem.errors import InputError
from solvers.materials import Material, elasticity_matrix, lame_parameters


def test_lame_parameters_of_masonry():
    # By hand: G = 3480 / 2.32 = 1500 MPa, λ = 3480 * 0.16 / (1.16 * 0.68) = 705.882 MPa.
    lame = lame_parameters(Material())
    assert lame.shear == pytest.approx(1.5e9)
    assert lame.first == pytest.approx(705.8823529e6)


def test_elasticity_matrix_inverts_hookes_compliance():
    E, nu = 3.48e9, 0.16
    compliance = np.diag([1 / E] * 3 + [2 * (1 + nu) / E] * 3)
    compliance[:3, :3] += -nu / E * (1 - np.eye(3))
    assert np.allclose(elasticity_matrix(Material()) @ compliance, np.eye(6), atol=1e-14)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"young": 0.0}, "Invalid 'young': expected a positive number, got 0.0"),
        ({"young": float("nan")}, "Invalid 'young'"),
        ({"poisson": 0.5}, "under 0.5 .incompressible., got 0.5"),
        ({"poisson": -0.1}, "Invalid 'poisson'"),
        ({"poisson": float("nan")}, "Invalid 'poisson'"),
        ({"density": 0.0}, "Invalid 'density': expected a positive number"),
    ],
)
def test_material_refuses(values, message):
    with pytest.raises(InputError, match=message):
        Material(**values)
