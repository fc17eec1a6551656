"""States of equilibrium for tests, in one call."""

import numpy as np
from numpy.typing import NDArray

from solvers.fem.assembly import elastic_body
from solvers.fem.elements import Space
from solvers.fem.equilibrium import Equilibrium, assemble, solve
from solvers.fem.linear_solvers import SolverName
from solvers.materials import Material


def hold(
    space: Space,
    material: Material,
    force: NDArray[np.float64],
    *,
    points: NDArray[np.intp],
    values: NDArray[np.float64],
    solver: SolverName = SolverName.AUTO,
) -> Equilibrium:
    """Solve for a body whose given points (k,) move by the given values (k, 3)."""
    prescribed, moved = np.zeros((len(space.points), 3), dtype=bool), np.zeros((len(space.points), 3))
    prescribed[points], moved[points] = True, values
    equations = assemble(elastic_body(space, material), force, prescribed=prescribed, values=moved)
    return solve(equations, solver=solver)
