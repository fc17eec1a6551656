"""Solving K u = f with some displacements prescribed, and checking the answer."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError

if TYPE_CHECKING:
    from scipy.sparse import csr_array, csr_matrix

__all__ = ["Equilibrium", "solve_prescribed"]

LARGEST_RESIDUAL = 1e-8
"""Relative residual above which a solution is refused."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state of equilibrium.

    Attributes
    ----------
    displacement : (m, 3) float array, m
    reaction : (k, 3) float array, N
        What holds each prescribed point.
    relative_residual : float
        Norm of the free forces out of balance over the norm of the load.
    strain_energy : float, J
    round_off : float, N
        What rounding alone may leave of a sum of forces that should cancel.
    """

    displacement: FloatArray
    reaction: FloatArray
    relative_residual: float
    strain_energy: float
    round_off: float


def solve_prescribed(
    stiffness: "csr_array", force: FloatArray, *, points: NDArray[np.intp], values: FloatArray
) -> Equilibrium:
    """Displacements of a body whose given points move in a given way.

    Parameters
    ----------
    stiffness : (3m, 3m) sparse array, N/m
    force : (3m,) float array, N
    points : (k,) int array
        Points with prescribed displacement, each once.
    values : (k, 3) float array, m

    Returns
    -------
    state : Equilibrium

    Raises
    ------
    ConvergenceError
        If the matrix is singular or too large for the memory, or the relative residual exceeds 1e-8.
    """
    fixed = (3 * np.asarray(points)[:, None] + np.arange(3)).ravel()
    is_free = np.ones(len(force), dtype=bool)
    is_free[fixed] = False
    free = np.flatnonzero(is_free)
    u = np.zeros(len(force))
    u[fixed] = np.asarray(values).ravel()
    load = (force - stiffness @ u)[free]
    if len(free):
        u[free] = _factorise_and_solve(stiffness[free][:, free], load)
    internal = stiffness @ u
    out_of_balance = internal - force
    scale = float(np.linalg.norm(load))
    residual = float(np.linalg.norm(out_of_balance[free])) / scale if scale > 0.0 else 0.0
    if not residual <= LARGEST_RESIDUAL:
        msg = (
            f"The linear solve left a relative residual of {residual:.2g} (at most {LARGEST_RESIDUAL:.0e}): "
            "look for nearly flat elements or parts that hang on a single node."
        )
        raise ConvergenceError(msg)
    return Equilibrium(
        displacement=u.reshape(-1, 3),
        reaction=out_of_balance[fixed].reshape(-1, 3),
        relative_residual=residual,
        strain_energy=0.5 * float(u @ internal),
        round_off=10 * np.finfo(float).eps * float(np.linalg.norm(abs(stiffness) @ np.abs(u))),
    )


def _factorise_and_solve(matrix: "csr_matrix", load: FloatArray) -> FloatArray:
    """SuperLU in its mode for symmetric matrices: 2.5 times faster than its default ordering."""
    from scipy.sparse.linalg import splu

    try:
        factor = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        msg = f"The stiffness matrix of {len(load)} unknowns cannot be factorised ({error})."
        raise ConvergenceError(msg) from error
    except MemoryError as error:
        msg = f"Not enough memory to factorise {len(load)} unknowns: choose larger elements."
        raise ConvergenceError(msg) from error
    solution: FloatArray = factor.solve(load)
    return solution
