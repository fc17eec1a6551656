"""The analysis of a wall, by the way that its options ask for."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fd2fem.errors import ConvergenceError
from fd2fem.model import Response, VolumeMesh
from solvers.fem import elasticity
from solvers.options import AnalysisOptions
from solvers.steps.masonry_analysis import analyse_steps
from solvers.steps.wall_state import WallState

__all__ = ["analyse"]

LARGEST_MOVE = 0.2
"""Largest displacement of a wall relative to its size; that of the ground is at most half of it."""


def analyse(
    mesh: VolumeMesh,
    *,
    options: AnalysisOptions | None = None,
    state: Path | None = None,
    on_step: Callable[[WallState], None] | None = None,
) -> Response:
    """Response of a wall to its own weight and then to the settlement of the ground.

    An elastic wall that is tied to the ground takes one solve; all else is followed in steps.

    Parameters
    ----------
    mesh : VolumeMesh
        With a group "base".
    options : AnalysisOptions, optional
        By default the elastic material and the settlement of the paper's Building 1.
    state : Path, optional
        File that each step is written to, and from which a stopped analysis goes on with the same answer.
    on_step : callable, optional
        Called with the state of the wall after each step.

    Returns
    -------
    response : Response

    Raises
    ------
    InputError
        If the mesh has no base, a part of it is loose, an element is folded, the settlement is not of a
        plausible size or does not cover the base, or the file at `state` belongs to something else.
    ConvergenceError
        If no equilibrium is found.
    """
    options = options or AnalysisOptions()
    if options.linear:
        response = elasticity.analyse(mesh, options=options)
    else:
        response = analyse_steps(mesh, options=options, state=state, on_step=on_step)
    _check_size(response)
    return response


def _check_size(response: Response) -> None:
    """Refuse displacements that no analysis by small ones can mean."""
    size = float(np.ptp(response.mesh.nodes, axis=0).max())
    if not response.max_displacement <= LARGEST_MOVE * size:
        msg = (
            f"The wall would move by {response.max_displacement:.3g} m, but is {size:.3g} m large: it falls, "
            "or Young's modulus, the density or the springs of the base were given in another unit."
        )
        raise ConvergenceError(msg)
