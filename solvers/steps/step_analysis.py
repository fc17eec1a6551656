"""An analysis in steps, ready to run."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.fem.elements import Space
from solvers.fem.feet import Feet
from solvers.masonry import MasonryLaw
from solvers.options import AnalysisOptions
from solvers.steps.wall_model import Tangent

__all__ = ["StepAnalysis"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StepAnalysis:
    """A wall, its equations, and the ground that will move under it.

    Attributes
    ----------
    mesh : VolumeMesh
    options : AnalysisOptions
    law : MasonryLaw
    space : Space
    tangent : Tangent
    feet : Feet
        Of the wall.
    settled : (k, 3) float array, m
        Displacement of the ground under the base's points when all of the settlement is applied.
    warnings : tuple of str
    """

    mesh: VolumeMesh
    options: AnalysisOptions
    law: MasonryLaw
    space: Space
    tangent: Tangent
    feet: Feet
    settled: FloatArray
    warnings: tuple[str, ...]
