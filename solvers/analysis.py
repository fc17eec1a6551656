"""The analysis of a wall, by the way that its options ask for."""

from collections.abc import Callable
from pathlib import Path

from fd2fem.model import Response, VolumeMesh
from solvers.fem import elasticity
from solvers.options import AnalysisOptions
from solvers.steps.masonry_analysis import analyse_steps
from solvers.steps.wall_state import WallState

__all__ = ["analyse"]


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
        return elasticity.analyse(mesh, options=options)
    return analyse_steps(mesh, options=options, state=state, on_step=on_step)
