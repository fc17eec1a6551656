"""The solve with prescribed displacements, and its checks: two cubes in a row as springs by hand."""

import numpy as np
import pytest
from elastic_states import hold

from fd2fem.errors import ConvergenceError
from solvers.fem import equilibrium
from solvers.fem.assembly import elastic_body
from solvers.fem.elements import ElementType, displacement_space
from solvers.fem.equilibrium import assemble, solve
from solvers.fem.linear_solvers import CheckedSolution, SolverName
from solvers.materials import Material

# Without lateral strain, a cube of 1 m is a spring of 3 N/m along its axis.
MATERIAL = Material(young=3.0, poisson=0.0)


@pytest.fixture
def column(grid):
    """Two cubes, one upon the other."""
    return displacement_space(grid([0, 1], [0, 1], [0, 1, 2]), ElementType.INCOMPATIBLE)


def _top(space, total):
    """A vertical force, N, spread over the corners of the top."""
    force = np.zeros((len(space.points), 3))
    force[space.points[:, 2] == 2.0, 2] = total / 4
    return force.ravel()


@pytest.mark.parametrize("solver", [SolverName.PARDISO, SolverName.SUPERLU, SolverName.AMG])
def test_two_springs_by_hand(column, solver):
    pytest.importorskip({"pardiso": "pypardiso", "amg": "pyamg"}.get(solver, "scipy"))
    moved = np.tile([0.1, 0.0, -0.5], (4, 1))
    state = hold(column, MATERIAL, _top(column, 6.0), points=column.base, values=moved, solver=solver)
    z = column.points[:, 2:]
    assert np.allclose(state.displacement, np.hstack([0.1 + 0 * z, 0 * z, -0.5 + 2.0 * z]), atol=1e-9)
    assert np.allclose(state.reaction.sum(axis=0), [0, 0, -6.0], atol=1e-9)
    assert np.array_equal(np.flatnonzero(np.abs(state.reaction).max(axis=1) > 1e-9), column.base)
    # Two springs of 3 N/m, 2 m longer each.
    assert state.strain_energy == pytest.approx(2 * 0.5 * 3 * 2.0**2)
    assert state.relative_residual < 1e-10
    assert state.round_off == pytest.approx(10 * 2**-52 * 40, rel=1.0)
    assert state.solver != "none"


def test_some_components_of_a_point_are_prescribed(column):
    """On rollers, the column is pulled up by 6 N and turns about nothing."""
    prescribed = np.zeros((len(column.points), 3), dtype=bool)
    prescribed[column.base, 2] = True
    corner, beside = (
        np.flatnonzero((column.points == place).all(axis=1))[0] for place in ([0] * 3, [1, 0, 0])
    )
    prescribed[corner, :2] = prescribed[beside, 1] = True
    body = elastic_body(column, Material(young=3.0, poisson=0.25))
    equations = assemble(body, _top(column, 6.0), prescribed=prescribed, values=np.full((12, 3), 0.5))
    state = solve(equations)
    # Uniaxial stress of 6 Pa: strains 2 along and -0.5 across.
    expected = 0.5 + column.points * [-0.5, -0.5, 2.0]
    assert np.allclose(state.displacement, expected, atol=1e-12)
    assert np.allclose(state.reaction[~prescribed], 0.0)
    assert np.allclose(state.reaction[column.base], [0, 0, -1.5], atol=1e-12)


def test_no_load_no_displacement(column):
    state = hold(column, MATERIAL, np.zeros(36), points=column.base, values=np.zeros((4, 3)))
    assert not state.displacement.any()
    assert state.relative_residual == 0.0


def test_everything_prescribed(column):
    moved = column.points * [0, 0, 2.0]
    state = hold(column, MATERIAL, np.zeros(36), points=np.arange(12), values=moved)
    assert np.allclose(state.reaction[:, 2], 6.0 / 4 * np.sign(column.points[:, 2] - 1))
    assert state.solver == "none"


def test_a_loose_body_is_refused(column):
    with pytest.raises(ConvergenceError, match="not held well enough"):
        hold(column, MATERIAL, _top(column, 1.0), points=column.base[:1], values=np.zeros((1, 3)))


@pytest.mark.parametrize("factor", [1.001, np.nan])
def test_a_solution_that_the_stresses_contradict_is_refused(column, monkeypatch, factor):
    monkeypatch.setattr(
        equilibrium,
        "checked_solve",
        lambda solver, _pattern, _values, load: CheckedSolution(factor * solver.solve(load), 0.0),
    )
    with pytest.raises(ConvergenceError, match=r"relative residual of (0\.001|nan)"):
        hold(column, MATERIAL, _top(column, 1.0), points=column.base, values=np.zeros((4, 3)))


def test_the_solver_gets_what_it_needs(column, monkeypatch):
    """Multigrid without the rigid-body motions converges badly; Cholesky needs to be promised."""
    seen = {}

    def recorded(name, _pattern, **options):
        seen.update(options, name=name)
        raise ConvergenceError

    monkeypatch.setattr(equilibrium, "make_solver", recorded)
    prescribed = np.zeros((12, 3), dtype=bool)
    prescribed[column.base] = True
    body = elastic_body(column, MATERIAL)
    equations = assemble(body, np.zeros(36), prescribed=prescribed, values=np.zeros((12, 3)))
    with pytest.raises(ConvergenceError):
        solve(equations, solver=SolverName.AMG)
    assert seen["name"] is SolverName.AMG
    assert seen["positive"]
    assert seen["motions"].shape == (24, 6)
