"""Every linear solver against dense algebra, and what is refused."""

import numpy as np
import pytest

from fd2fem.errors import ConvergenceError, InputError
from solvers.compiled.pattern import build_pattern
from solvers.fem import linear_solvers
from solvers.fem.assembly import add_up, elastic_body
from solvers.fem.connectivity import rigid_motions
from solvers.fem.elements import ElementType, displacement_space
from solvers.fem.linear_solvers import SolverName, checked_solve, choose_solver, make_solver, product
from solvers.materials import Material

DIRECT = [SolverName.PARDISO, SolverName.RSLAB, SolverName.SUPERLU]
SOLVERS = [*DIRECT, SolverName.AMG]


@pytest.fixture(autouse=True)
def _installed(request):
    """MKL, RSLAB and pyamg have no wheels on some systems."""
    name = request.node.callspec.params.get("name") if hasattr(request.node, "callspec") else None
    if name is not None:
        pytest.importorskip(linear_solvers.PACKAGES[name])


def _wall(grid, *, held=(0, 1, 2)):
    """Pattern, values and free rigid motions of a small wall, the given components of its base prescribed."""
    mesh = grid(np.arange(4), [0, 0.4], np.arange(4), warp=0.03)
    space = displacement_space(mesh, ElementType.INCOMPATIBLE)
    prescribed = np.zeros((len(space.points), 3), dtype=bool)
    prescribed[np.ix_(space.base, held)] = True
    prescribed = prescribed.ravel()
    pattern = build_pattern(space.connectivity, points=len(space.points), prescribed=prescribed, upper=True)
    values = add_up(elastic_body(space, Material()), pattern, np.zeros(space.unknowns)).values
    return pattern, values, rigid_motions(space.points)[~prescribed]


def _dense(pattern, values):
    upper = pattern.matrix(values).toarray()
    return upper + np.triu(upper, k=1).T


@pytest.mark.parametrize("held", [(0, 1, 2), (1, 2)], ids=["all", "two"])
@pytest.mark.parametrize("name", SOLVERS)
def test_solution_is_that_of_dense_algebra(grid, name, held):
    pattern, values, motions = _wall(grid, held=held)
    if len(held) == 2:
        # Springs along x.
        values[pattern.diagonal] += np.where(pattern.equation[pattern.equation >= 0] % 3 == 0, 1e8, 0.0)
    load = np.random.default_rng(5).normal(size=pattern.unknowns)
    solver = make_solver(name, pattern, motions=motions, positive=True)
    for factor in (1.0, 3.0):  # The second time, the order of the equations is used again.
        solver.factorise(factor * values)
        found = checked_solve(solver, pattern, factor * values, load)
        expected = np.linalg.solve(factor * _dense(pattern, values), load)
        assert np.abs(found.solution - expected).max() < 1e-9 * np.abs(expected).max()
        residual = load - factor * _dense(pattern, values) @ found.solution
        assert np.linalg.norm(residual) < 1e-10 * np.linalg.norm(load)
        assert found.relative_residual < 1e-10


@pytest.mark.parametrize("name", DIRECT)
def test_matrices_that_are_not_symmetric(grid, name):
    pattern, _, _ = _wall(grid)
    whole = build_pattern(
        np.arange(pattern.unknowns // 3)[None],
        points=pattern.unknowns // 3,
        prescribed=np.zeros(pattern.unknowns, dtype=bool),
        upper=False,
    )
    rng = np.random.default_rng(6)
    matrix = rng.normal(size=(whole.unknowns,) * 2) + 20 * np.eye(whole.unknowns)
    load = rng.normal(size=whole.unknowns)
    solver = make_solver(name, whole)
    solver.factorise(matrix.ravel())
    found = checked_solve(solver, whole, matrix.ravel(), load)
    assert np.allclose(found.solution, np.linalg.solve(matrix, load), rtol=1e-9)
    assert np.allclose(product(whole, matrix.ravel(), load), matrix @ load)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_wall_that_nothing_holds_is_refused(grid, name):
    pattern, values, motions = _wall(grid, held=())
    load = np.random.default_rng(7).normal(size=pattern.unknowns)
    with pytest.raises(ConvergenceError, match=r"the wall is not held well enough|singular"):
        solver = make_solver(name, pattern, motions=motions, positive=True)
        solver.factorise(values)
        checked_solve(solver, pattern, values, load)


@pytest.mark.parametrize("name", DIRECT)
def test_a_stiffness_that_pushes_is_refused_where_it_must_not(grid, name):
    """A negative pivot: a positive definite matrix was promised to Cholesky; the others solve it."""
    pattern, values, _ = _wall(grid)
    values[pattern.diagonal[7]] = -values[pattern.diagonal[7]]
    load = np.ones(pattern.unknowns)
    for positive in (True, False):
        solver = make_solver(name, pattern, positive=positive)
        if positive and name is SolverName.PARDISO:
            with pytest.raises(ConvergenceError, match="singular"):
                solver.factorise(values)
            continue
        solver.factorise(values)
        found = checked_solve(solver, pattern, values, load)
        assert np.allclose(_dense(pattern, values) @ found.solution, load, atol=1e-8)


def test_cholesky_gives_way_to_a_matrix_that_is_not_positive_definite(grid):
    pytest.importorskip("pypardiso")
    pattern, values, _ = _wall(grid)
    pushing = values.copy()
    pushing[pattern.diagonal[7]] *= -1.0
    load = np.ones(pattern.unknowns)
    solver = make_solver(SolverName.PARDISO, pattern)
    for stiffness in (values, pushing, values, 2.0 * pushing):
        solver.factorise(stiffness)
        found = checked_solve(solver, pattern, stiffness, load)
        expected = np.linalg.solve(_dense(pattern, stiffness), load)
        assert np.abs(found.solution - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("pivot", [1.0, -1.0], ids=["positive", "indefinite"])
@pytest.mark.parametrize("name", [SolverName.PARDISO, SolverName.RSLAB])
def test_every_run_finds_the_same_digits(grid, name, pivot):
    mesh = grid(np.linspace(0, 10, 31), [0, 0.2, 0.4], np.linspace(0, 10, 31), warp=0.03)
    space = displacement_space(mesh, ElementType.HEXAHEDRON8)
    prescribed = np.zeros((len(space.points), 3), dtype=bool)
    prescribed[space.base] = True
    pattern = build_pattern(
        space.connectivity, points=len(space.points), prescribed=prescribed.ravel(), upper=True
    )
    values = add_up(elastic_body(space, Material()), pattern, np.zeros(space.unknowns)).values
    values[pattern.diagonal[7]] *= pivot
    found = []
    for shift in range(3):
        # Elsewhere in memory: sums of several numbers at a time begin where an array is aligned.
        moved = np.empty(len(values) + shift)[shift:]
        moved[:] = values
        solver = make_solver(name, pattern)
        for _ in range(2):
            solver.factorise(moved)
            found.append(solver.solve(np.ones(pattern.unknowns)))
    assert all(np.array_equal(solution, found[0]) for solution in found)


class _Wrong:
    """A solver whose solutions are too large by a part `error`."""

    name = "wrong solver"
    refined = 1e-13

    def __init__(self, error):
        self.error, self.factor = error, None

    def factorise(self, values):
        self.factor = 1.0 / values[0]

    def solve(self, load):
        return (1.0 + self.error) * self.factor * load


@pytest.mark.parametrize(
    ("error", "residual"), [(0.0, 0.0), (1e-5, 1e-10), (0.3, None), (2.0, None), (np.nan, None)]
)
def test_a_residual_is_improved_once_or_refused(error, residual):
    # A chain of one point: the residual of a solution too large by e is e, and e² after one improvement.
    held = np.array([True] * 3 + [False] * 3)
    pattern = build_pattern(np.array([[0, 1]]), points=2, prescribed=held, upper=True)
    values = np.zeros(len(pattern.columns))
    values[pattern.diagonal] = 4.0
    solver = _Wrong(error)
    solver.factorise(values)
    if residual is None:
        with pytest.raises(ConvergenceError, match=r"wrong solver left a residual of (0\.09|2|nan) of"):
            checked_solve(solver, pattern, values, np.ones(3))
    else:
        found = checked_solve(solver, pattern, values, np.ones(3))
        assert found.relative_residual == pytest.approx(residual, rel=1e-3, abs=1e-15)
        assert np.allclose(found.solution, 0.25)


def test_choice_by_size_and_by_what_is_installed(grid, monkeypatch):
    pattern, _, _ = _wall(grid)
    installed = {"pypardiso", "rslab", "pyamg"}
    monkeypatch.setattr(
        linear_solvers, "find_spec", lambda package: package if package in installed else None
    )
    assert choose_solver(pattern, positive=True) is SolverName.PARDISO
    monkeypatch.setattr(linear_solvers, "DIRECT_LIMITS", dict.fromkeys(DIRECT, 10))
    assert choose_solver(pattern, positive=True) is SolverName.AMG
    # Multigrid is for positive definite matrices.
    assert choose_solver(pattern) is SolverName.PARDISO
    installed.discard("pypardiso")
    assert choose_solver(pattern, positive=True) is SolverName.AMG
    assert choose_solver(pattern) is SolverName.RSLAB
    installed.discard("rslab")
    assert choose_solver(pattern) is SolverName.SUPERLU
    assert choose_solver(pattern, positive=True) is SolverName.AMG
    installed.discard("pyamg")
    assert choose_solver(pattern, positive=True) is SolverName.SUPERLU
    with pytest.raises(InputError, match="'amg' needs the package pyamg, which is not installed: install it"):
        make_solver(SolverName.AMG, pattern)


def test_memory_that_runs_out_is_said(grid, monkeypatch):
    pattern, values, _ = _wall(grid)

    def splu(*_, **__):
        raise MemoryError

    monkeypatch.setattr("scipy.sparse.linalg.splu", splu)
    with pytest.raises(ConvergenceError, match="Not enough memory to factorise"):
        make_solver(SolverName.SUPERLU, pattern).factorise(values)


def test_a_missing_mkl_is_said(grid, monkeypatch):
    pypardiso = pytest.importorskip("pypardiso")

    def missing(**_):
        raise ImportError

    monkeypatch.setattr(pypardiso, "PyPardisoSolver", missing)
    pattern, _, _ = _wall(grid)
    with pytest.raises(InputError, match="MKL, which pypardiso needs, cannot be loaded"):
        make_solver(SolverName.PARDISO, pattern)
