"""The linear solve and its checks."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from fd2fem.errors import ConvergenceError
from solvers.equilibrium import solve_prescribed


def _chain(stiffnesses):
    """Points in a row, joined by springs that act the same along x, y and z."""
    n = len(stiffnesses) + 1
    K = np.zeros((n, n))
    for i, k in enumerate(stiffnesses):
        K[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    return csr_array(np.kron(K, np.eye(3)))


def test_two_springs_by_hand():
    # 2 N/m and 3 N/m in a row, the first end moved by 0.1 m, 6 N along z at the last.
    force = np.zeros(9)
    force[8] = 6.0
    state = solve_prescribed(_chain([2.0, 3.0]), force, points=np.array([0]), values=np.array([[0.1, 0, 0]]))
    assert np.allclose(state.displacement, [[0.1, 0, 0], [0.1, 0, 3.0], [0.1, 0, 5.0]])
    assert np.allclose(state.reaction, [[0, 0, -6.0]])
    assert state.strain_energy == pytest.approx(0.5 * 2 * 3.0**2 + 0.5 * 3 * 2.0**2)
    assert state.relative_residual < 1e-14
    # |K||u| along x: 0.4, 1, 0.6 N; along z: 6, 6 + 9 + 15, 9 + 15 N.
    assert state.round_off == pytest.approx(10 * 2**-52 * np.linalg.norm([0.4, 1.0, 0.6, 6.0, 30.0, 24.0]))


def test_no_load_no_displacement():
    state = solve_prescribed(_chain([2.0]), np.zeros(6), points=np.array([0]), values=np.zeros((1, 3)))
    assert not state.displacement.any()
    assert state.relative_residual == 0.0


def test_everything_prescribed():
    state = solve_prescribed(_chain([2.0]), np.zeros(6), points=np.array([0, 1]), values=np.eye(3)[:2])
    assert np.allclose(state.reaction, [[2, -2, 0], [-2, 2, 0]])


def test_a_loose_point_is_refused():
    with pytest.raises(ConvergenceError, match="9 unknowns cannot be factorised"):
        solve_prescribed(_chain([2.0, 0.0, 0.0]), np.ones(12), points=np.array([0]), values=np.zeros((1, 3)))


def test_a_residual_is_refused(monkeypatch):
    monkeypatch.setattr("solvers.equilibrium._factorise_and_solve", lambda _, load: 1.001 * load)
    with pytest.raises(ConvergenceError, match=r"relative residual of 0\.001"):
        solve_prescribed(_chain([1.0]), np.ones(6), points=np.array([0]), values=np.zeros((1, 3)))


def test_not_a_number_is_refused(monkeypatch):
    monkeypatch.setattr("solvers.equilibrium._factorise_and_solve", lambda _, load: np.nan * load)
    with pytest.raises(ConvergenceError, match="relative residual of nan"):
        solve_prescribed(_chain([1.0]), np.ones(6), points=np.array([0]), values=np.zeros((1, 3)))
