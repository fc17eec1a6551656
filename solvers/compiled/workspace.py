"""Arrays that the state of a point is computed in."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled

__all__ = ["COLUMN", "ROW", "Workspace", "new_workspace"]

FloatArray = NDArray[np.float64]

ROW = np.array([0, 1, 2, 0, 1, 0])
COLUMN = np.array([0, 1, 2, 1, 2, 2])
"""Tensor indices of the six components."""


class Workspace(NamedTuple):
    """Arrays that `update_point` writes to, made once per thread.

    `stress` (6,), Pa; `tangent` (6, 6), Pa; `inelastic` (6,), the new inelastic strain; `g` (4,), the
    multipliers of the cone and of the three planes; the others are scratch.
    """

    stress: FloatArray
    tangent: FloatArray
    inelastic: FloatArray
    g: FloatArray
    tensor: FloatArray
    axes: FloatArray
    values: FloatArray
    trial: FloatArray
    principal: FloatArray
    modes: FloatArray
    stiffness: FloatArray


@compiled
def new_workspace() -> Workspace:
    """Workspace for one thread."""
    return Workspace(
        np.zeros(6),
        np.zeros((6, 6)),
        np.zeros(6),
        np.zeros(4),
        np.zeros((3, 3)),
        np.zeros((3, 3)),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
        np.zeros((3, 6)),
        np.zeros((3, 3)),
    )
