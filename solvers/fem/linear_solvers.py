"""Solvers of the sparse equations, chosen by their number and by what is installed.

MKL PARDISO (package pypardiso, x86-64 only) is the fastest direct solver and keeps its ordering when only
the values change. So does RSLAB, which has wheels for arm64 and macOS as well. SuperLU comes with scipy, is
always there, and needs three times the memory. Algebraic
multigrid (package pyamg) with the rigid-body motions needs the least memory by far and is the way to a
million unknowns. None is trusted: :func:`checked_solve` computes the residual of every answer.
"""

from enum import StrEnum
from importlib.util import find_spec
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError, InputError
from solvers.compiled.pattern import Pattern, whole
from solvers.fem.pardiso import Pardiso, too_large

__all__ = [
    "LARGEST_RESIDUAL",
    "CheckedSolution",
    "LinearSolver",
    "SolverName",
    "checked_solve",
    "choose_solver",
    "make_solver",
    "residual_norm",
]

FloatArray = NDArray[np.float64]

LARGEST_RESIDUAL = 1e-8
"""Relative residual above which a solution is refused."""
ITERATED = 1e-12
"""Relative residual that iterations are ended at: at 1e-8, displacements are off by up to 1e-5."""
MOST_ITERATIONS = 500


class SolverName(StrEnum):
    """What solves the equations; AUTO takes the fastest one that is installed and that the memory allows."""

    AUTO = "auto"
    PARDISO = "pardiso"
    RSLAB = "rslab"
    SUPERLU = "superlu"
    AMG = "amg"


DIRECT_LIMITS = {SolverName.PARDISO: 30_000_000, SolverName.RSLAB: 12_000_000, SolverName.SUPERLU: 6_000_000}
"""Entries of the upper triangle from which multigrid takes over: where PARDISO's factors of a wall outgrow
6 GiB, and where SuperLU, which fills more, is the slower one. RSLAB's lies
between, by its fill: it was measured at 72,210 unknowns only."""
PACKAGES = {
    SolverName.PARDISO: "pypardiso",
    SolverName.RSLAB: "rslab",
    SolverName.SUPERLU: "scipy",
    SolverName.AMG: "pyamg",
}


class LinearSolver(Protocol):
    """Factorises the values of a pattern, then solves with them.

    `refined` is the relative residual at which another solve has nothing to improve.
    """

    name: str
    refined: float

    def factorise(self, values: FloatArray) -> None:
        """Take new values (z,) of the pattern."""

    def solve(self, load: FloatArray) -> FloatArray:
        """Solution (n,) for a right-hand side (n,)."""


class CheckedSolution(NamedTuple):
    """A solution (n,) and the norm of its residual relative to that of the load."""

    solution: FloatArray
    relative_residual: float


def choose_solver(pattern: Pattern, *, positive: bool = False) -> SolverName:
    """The fastest installed solver that the memory allows; multigrid for positive definite matrices only."""
    direct = next(name for name in DIRECT_LIMITS if name is SolverName.SUPERLU or find_spec(PACKAGES[name]))
    large = len(pattern.columns) > DIRECT_LIMITS[direct]
    return SolverName.AMG if positive and pattern.upper and large and find_spec("pyamg") else direct


def make_solver(
    name: SolverName, pattern: Pattern, *, motions: FloatArray | None = None, positive: bool = False
) -> LinearSolver:
    """A solver by its name.

    Parameters
    ----------
    name : SolverName
    pattern : Pattern
    motions : (n, 6) float array, optional
        Rigid-body motions at the free displacements, for multigrid.
    positive : bool
        Whether the matrix is known to be positive definite, as an elastic wall's is.

    Raises
    ------
    InputError
        If its package is not installed.
    """
    if name is SolverName.AUTO:
        name = choose_solver(pattern, positive=positive)
    if find_spec(PACKAGES[name]) is None:
        msg = (
            f"The solver '{name}' needs the package {PACKAGES[name]}, which is not installed: install it, or "
            f"choose another: {', '.join(SolverName)}."
        )
        raise InputError(msg)
    if name is SolverName.PARDISO:
        return Pardiso(pattern, positive=positive)
    if name is SolverName.RSLAB:
        return _Rslab(pattern)
    return _SuperLU(pattern) if name is SolverName.SUPERLU else _Multigrid(pattern, motions)


def checked_solve(
    solver: LinearSolver, pattern: Pattern, values: FloatArray, load: FloatArray
) -> CheckedSolution:
    """Solve, improve once if rounding left something, and refuse what is no solution.

    Raises
    ------
    ConvergenceError
        If the residual is larger than 1e-8 of the load.
    """
    solution = solver.solve(load)
    residual = load - product(pattern, values, solution)
    norm = residual_norm(residual, load)
    if solver.refined < norm < 1.0:
        better = solution + solver.solve(residual)
        improved = residual_norm(load - product(pattern, values, better), load)
        if improved < norm:
            solution, norm = better, improved
    if not norm <= LARGEST_RESIDUAL:
        msg = (
            f"{solver.name} left a residual of {norm:.2g} of the load (at most {LARGEST_RESIDUAL:.0e}): "
            "the wall is not held well enough, or its elements are too distorted."
        )
        raise ConvergenceError(msg)
    return CheckedSolution(solution, norm)


def residual_norm(residual: FloatArray, load: FloatArray) -> float:
    """Norm of a residual relative to that of the load; a load of nothing counts as the smallest number."""
    return float(np.linalg.norm(residual) / max(float(np.linalg.norm(load)), np.finfo(float).tiny))


def product(pattern: Pattern, values: FloatArray, vector: FloatArray) -> FloatArray:
    """Matrix times vector (n,), also where only the upper triangle is kept."""
    matrix = pattern.matrix(values)
    result: FloatArray = matrix @ vector
    if pattern.upper:
        result += matrix.T @ vector - values[pattern.starts[:-1]] * vector
    return result


class _Rslab:
    """RSLAB's LDLᵀ, for what is not symmetric its LU; orders the unknowns once."""

    name = "RSLAB"
    refined = 1e-13

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern
        self._order: Any = None
        self._factors: Any = None

    def factorise(self, values: FloatArray) -> None:
        import rslab

        matrix = self._pattern.matrix(values)
        if self._pattern.upper:
            # Rows of the upper triangle are columns of the lower one, which it takes as they are.
            matrix = matrix.T
        try:
            if self._order is None:
                self._order = rslab.analyze(matrix, path="ldlt" if self._pattern.upper else "lu")
            self._factors = self._order.factor(matrix)
        except MemoryError as error:
            raise ConvergenceError(too_large(self._pattern.unknowns)) from error
        except RuntimeError as error:
            msg = (
                f"The stiffness of {self._pattern.unknowns} unknowns is singular (RSLAB: {error}): "
                "the wall is not held well enough, or its elements are too distorted."
            )
            raise ConvergenceError(msg) from error

    def solve(self, load: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve(load), dtype=np.float64)


class _SuperLU:
    """scipy's SuperLU in symmetric mode."""

    name = "scipy SuperLU"
    refined = 1e-13

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern
        self._factors: Any = None

    def factorise(self, values: FloatArray) -> None:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        unknowns = self._pattern.unknowns
        matrix = csc_array(whole(self._pattern, values))
        try:
            self._factors = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            msg = (
                f"The stiffness of {unknowns} unknowns cannot be factorised ({error}): "
                "the wall is not held well enough, or its elements are too distorted."
            )
            raise ConvergenceError(msg) from error
        except MemoryError as error:
            msg = too_large(unknowns)
            raise ConvergenceError(msg) from error

    def solve(self, load: FloatArray) -> FloatArray:
        solution: FloatArray = self._factors.solve(load)
        return solution


class _Multigrid:
    """Conjugate gradients, preconditioned by smoothed aggregation that knows the rigid-body motions.

    The preconditioner is single precision, which halves its memory and changes the path to the solution, not
    the solution: the residuals of the iteration are double precision.
    """

    name = "pyamg smoothed aggregation + CG"
    refined = LARGEST_RESIDUAL

    def __init__(self, pattern: Pattern, motions: FloatArray | None) -> None:
        self._pattern, self._motions = pattern, motions
        self._values = np.zeros(0)
        self._levels: Any = None

    def factorise(self, values: FloatArray) -> None:
        from pyamg import smoothed_aggregation_solver

        self._values = values
        motions = None if self._motions is None else self._motions.astype(np.float32)
        self._levels = smoothed_aggregation_solver(
            whole(self._pattern, values, np.float32), B=motions, max_coarse=500, coarse_solver="splu"
        )

    def solve(self, load: FloatArray) -> FloatArray:
        from scipy.sparse.linalg import LinearOperator, cg

        cycle = self._levels.aspreconditioner()

        def improve(residual: FloatArray) -> FloatArray:
            # Scaled, so that small residuals do not vanish in single precision.
            scale = float(np.abs(residual).max()) or 1.0
            correction = cycle.matvec((residual / scale).astype(np.float32))
            return scale * np.asarray(correction, dtype=np.float64)

        def multiply(vector: FloatArray) -> FloatArray:
            return product(self._pattern, self._values, vector)

        shape = (len(load), len(load))
        # Where it does not converge, the residual will tell.
        solution, _ = cg(
            LinearOperator(shape, matvec=multiply, dtype=np.float64),
            load,
            rtol=ITERATED,
            maxiter=MOST_ITERATIONS,
            M=LinearOperator(shape, matvec=improve, dtype=np.float64),
        )
        return np.asarray(solution, dtype=np.float64)
