"""What the steps of an analysis have shown on the way, which its last state alone does not tell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.fem.feet import Feet, foot_forces
from solvers.steps.step_record import raised_stress
from solvers.steps.stepping import Snapshot
from solvers.steps.wall_model import WallModel

__all__ = ["Course", "followed", "ground_forces"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Course:
    """The way to a state.

    Attributes
    ----------
    largest_stress : (e,) float array, Pa
        Largest σ1 in each element so far, at its integration points.
    feet : (s, f, 3) float array, N
        Force of the ground on each foot of the wall after each step, the self-weight first.
    """

    largest_stress: FloatArray
    feet: FloatArray


def followed(course: Course | None, snapshot: Snapshot, model: WallModel, feet: Feet) -> Course:
    """The course up to a snapshot; `course`: that up to the one before, None if it is the first.

    The stresses of masonry are never beyond its tensile strength but by rounding; see `step_record`.
    """
    stress = snapshot.fields.stress
    before = np.full(len(stress), -np.inf) if course is None else course.largest_stress
    forces = foot_forces(feet, ground_forces(snapshot, model))[None]
    return Course(
        largest_stress=raised_stress(before, stress),
        feet=forces if course is None else np.concatenate([course.feet, forces]),
    )


def ground_forces(snapshot: Snapshot, model: WallModel) -> FloatArray:
    """Forces (k, 3), N, of the ground on the base's points."""
    held = (snapshot.force - model.weight).reshape(-1, 3)
    forces: FloatArray = held[model.support.points]
    return forces
