"""How a load is applied in steps, what is remembered from one to the next, and what each step found."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive
from solvers.compiled.cracking import Motion, PointFields
from solvers.steps.wall_model import WallModel

__all__ = ["LoadStep", "Snapshot", "StepMode", "SteppingOptions", "at_rest"]

FloatArray = NDArray[np.float64]


class StepMode(StrEnum):
    """How the softening enters a step.

    IMPLEX extrapolates the tensile strength from the last step, so that each step is one of perfect
    plasticity and converges (Oliver, Huespe & Cante 2008); the error is controlled by the step's size.
    IMPLICIT lets it soften within the step: exact, but past a snap-back there is no solution to find.
    """

    IMPLEX = "implex"
    IMPLICIT = "implicit"


@dataclass(frozen=True)
class SteppingOptions:
    """Steps of the settlement, after the self-weight.

    Attributes
    ----------
    steps : int
        Equal ones to begin with; they are cut where needed and grow back.
    mode : StepMode
    tolerance : float
        Largest force out of balance, relative to the reactions. Iterations go on down to a hundredth of it
        while they come nearer fast; where masonry is torn they creep, and this is enough.
    max_iterations : int
        Of Newton's method in a step, before it is cut in two. A crack that runs through a wall takes some
        40, in however small a step.
    smallest : float
        Smallest step, relative to an equal one, before the analysis gives up.
    largest_change : float
        By which the extrapolated tensile strength may exceed the true one, relative to the whole strength,
        at a point that was cracked before; above it, an IMPLEX step is repeated in two.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    steps: int = 50
    mode: StepMode = StepMode.IMPLEX
    tolerance: float = 1e-4
    max_iterations: int = 60
    smallest: float = 1e-3
    largest_change: float = 0.1

    def __post_init__(self) -> None:
        for name in ("tolerance", "smallest", "largest_change"):
            check_positive(name, getattr(self, name))
        for name, least in (("steps", 1), ("max_iterations", 2)):
            if getattr(self, name) < least:
                msg = f"Invalid '{name}': expected at least {least}, got {getattr(self, name)}."
                raise InputError(msg)


@dataclass(frozen=True)
class LoadStep:
    """What a step found.

    Attributes
    ----------
    share : float
        Of the settlement that is applied; 0: the self-weight.
    iterations : int
    residual : float
        Norm of the forces out of balance over that of the forces of the ground.
    reaction : tuple of three floats, N
    max_displacement : float, m
    max_principal_stress : float, Pa
        At an integration point.
    max_crack_opening : float, m
    strain_energy, dissipated_energy : float, J
    plastic_energy : float, J
        Part of the dissipated energy that the cone took; the rest went into cracks.
    external_work : float, J
        Of the weight and of the ground on the wall. What strain energy and dissipated energy do not account
        for was set free by cracks that ran at once, as motion; or is the error of too large steps.
    strength_error : float
        Largest excess of the extrapolated tensile strength over the true one, relative to the whole.
    """

    share: float
    iterations: int
    residual: float
    reaction: tuple[float, float, float]
    max_displacement: float
    max_principal_stress: float
    max_crack_opening: float
    strain_energy: float
    dissipated_energy: float
    plastic_energy: float
    external_work: float
    strength_error: float


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A state of equilibrium, from which the analysis can go on.

    Attributes
    ----------
    motion : Motion
    fields : PointFields
    kappa_before : (e, q) float array
        `fields.kappa` one step earlier.
    dissipated : (e,) float array, J
        Energy that each element has taken.
    force : (3m,) float array, N
        Weight, and what the ground does to the wall.
    size : float
        Share of the load in the last step.
    next_size : float
        Share to try next.
    history : tuple of LoadStep
        All steps so far, the self-weight first.
    """

    motion: Motion
    fields: PointFields
    kappa_before: FloatArray
    dissipated: FloatArray
    force: FloatArray
    size: float
    next_size: float
    history: tuple[LoadStep, ...]

    @property
    def share(self) -> float:
        """Of the settlement that is applied."""
        return self.history[-1].share


def at_rest(model: WallModel) -> Snapshot:
    """The wall before it is loaded."""
    count, points = model.volumes.shape
    motion = Motion(
        np.zeros((len(model.body.points), 3)), np.zeros((count, 3 * model.body.rule.modes.shape[2]))
    )
    fields = PointFields(
        inelastic=np.zeros((count, points, 6)),
        crack=np.zeros((count, points, 6)),
        kappa=np.zeros((count, points)),
        cone=np.zeros((count, points)),
        stress=np.zeros((count, points, 6)),
    )
    return Snapshot(
        motion=motion,
        fields=fields,
        kappa_before=np.zeros((count, points)),
        dissipated=np.zeros(count),
        force=np.zeros(len(model.weight)),
        size=0.0,
        next_size=0.0,
        history=(),
    )
