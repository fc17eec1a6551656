"""Heated bodies against closed forms."""

import numpy as np
import pytest

from fd2fem.errors import InputError
from solvers.fem.assembly import stiffness
from solvers.fem.elements import displacement_space
from solvers.fem.stress import point_stress
from solvers.fem.thermal_loads import held_stress, thermal_forces
from solvers.materials import Material

MATERIAL, ALPHA = Material(young=2e9, poisson=0.2), 1e-5


@pytest.fixture
def space(make_mesh):
    return displacement_space(make_mesh([0, 0.4, 1], [0, 0.3], [0, 0.5, 0.8], warp=0.02))


def _assert_free(space, temperature, moved):
    """The forces are those that hold the displacements, and no stress is left."""
    force = thermal_forces(space, MATERIAL, temperature, expansion=ALPHA)
    assert stiffness(space, MATERIAL) @ moved.ravel() == pytest.approx(force, abs=1e-10 * np.abs(force).max())
    stress = point_stress(space, MATERIAL, displacement=moved).stress
    heated = held_stress(space, MATERIAL, temperature, expansion=ALPHA)
    assert stress + heated == pytest.approx(np.zeros_like(stress), abs=1e-10 * np.abs(heated).max())


def test_a_free_body_expands_without_stress(space):
    _assert_free(space, np.full(len(space.points), 10.0), ALPHA * 10.0 * space.points)


def test_a_linear_temperature_leaves_no_stress(make_mesh):
    # T = 3 x: u = alpha (3 (x² - y² - z²) / 2, 3 x y, 3 x z), which bricks and straight tetrahedra hold.
    space = displacement_space(make_mesh([0, 0.4, 1], [0, 0.3], [0, 0.5, 0.8]))
    x, y, z = space.points.T
    moved = 3 * ALPHA * np.column_stack([(x**2 - y**2 - z**2) / 2, x * y, x * z])
    _assert_free(space, 3 * x, moved)


def test_a_held_body_is_pressed(space):
    # By hand: -E alpha T / (1 - 2 nu) = -2e9 x 1e-5 x 10 / 0.6.
    heated = held_stress(space, MATERIAL, np.full(len(space.points), 10.0), expansion=ALPHA)
    assert heated[..., :3] == pytest.approx(np.full((*heated.shape[:2], 3), -1e6 / 3.0))
    assert not heated[..., 3:].any()


def test_temperatures_are_those_of_the_points(space):
    with pytest.raises(InputError, match="temperature"):
        thermal_forces(space, MATERIAL, [1.0, 2.0], expansion=ALPHA)
