"""Solving K u = f with some displacements prescribed, and checking the answer."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError
from solvers.compiled.elastic import ElasticBody
from solvers.compiled.pattern import Pattern, build_pattern
from solvers.compiled.stiffness import Sums
from solvers.fem.assembly import add_up, internal_force
from solvers.fem.connectivity import rigid_motions
from solvers.fem.linear_solvers import LARGEST_RESIDUAL, SolverName, checked_solve, make_solver, residual_norm

__all__ = ["Equations", "Equilibrium", "assemble", "solve"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of equilibrium of an elastic body.

    Attributes
    ----------
    body : ElasticBody
    pattern : Pattern
        Of the free displacements' stiffness.
    sums : Sums
    force : (3m,) float array, N
    imposed : (3m,) float array, m
        Prescribed displacements, 0 where they are free.
    """

    body: ElasticBody
    pattern: Pattern
    sums: Sums
    force: FloatArray
    imposed: FloatArray


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state of equilibrium.

    Attributes
    ----------
    displacement : (m, 3) float array, m
    reaction : (m, 3) float array, N
        What holds each prescribed displacement; 0 where it is free.
    relative_residual : float
        Norm of the free forces out of balance over the norm of the load; the forces come from the stresses,
        not from the matrix.
    strain_energy : float, J
    round_off : float, N
        What rounding alone may leave of a sum of forces that should cancel.
    solver : str
        Name of the linear solver.
    """

    displacement: FloatArray
    reaction: FloatArray
    relative_residual: float
    strain_energy: float
    round_off: float
    solver: str


def assemble(body: ElasticBody, force: FloatArray, *, prescribed: BoolArray, values: FloatArray) -> Equations:
    """Equations of a body some of whose displacements are prescribed.

    Parameters
    ----------
    body : ElasticBody
    force : (3m,) float array, N
    prescribed : (m, 3) bool array
    values : (m, 3) float array, m
        Read where they are prescribed.
    """
    imposed = np.where(prescribed, values, 0.0).ravel()
    pattern = build_pattern(
        body.connectivity, points=len(body.points), prescribed=prescribed.ravel(), upper=True
    )
    return Equations(body, pattern, add_up(body, pattern, imposed), force, imposed)


def solve(equations: Equations, *, solver: SolverName = SolverName.AUTO) -> Equilibrium:
    """Displacements and reactions.

    Raises
    ------
    InputError
        If the solver that was asked for is not installed.
    ConvergenceError
        If the matrix is singular or too large for the memory, or the relative residual exceeds 1e-8.
    """
    free = equations.pattern.equation >= 0
    u = equations.imposed.copy()
    load = (equations.force - equations.sums.pull)[free]
    name = "none"
    if len(load):
        motions = rigid_motions(equations.body.points)[free]
        linear = make_solver(solver, equations.pattern, motions=motions, positive=True)
        linear.factorise(equations.sums.values)
        u[free] = checked_solve(linear, equations.pattern, equations.sums.values, load).solution
        name = linear.name
    internal, bound = internal_force(equations.body, u.reshape(-1, 3))
    out_of_balance = internal.ravel() - equations.force
    residual = residual_norm(out_of_balance[free], load)
    if not residual <= LARGEST_RESIDUAL:
        msg = (
            f"The stresses leave a relative residual of {residual:.2g} (at most {LARGEST_RESIDUAL:.0e}): "
            "look for nearly flat elements or parts that hang on a single node."
        )
        raise ConvergenceError(msg)
    return Equilibrium(
        displacement=u.reshape(-1, 3),
        reaction=np.where(free, 0.0, out_of_balance).reshape(-1, 3),
        relative_residual=residual,
        strain_energy=0.5 * float(u @ internal.ravel()),
        round_off=10 * np.finfo(float).eps * float(np.linalg.norm(bound)),
        solver=name,
    )
