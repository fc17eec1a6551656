"""The strain of a wall's bays, the measure of deformation that damage is classed by.

The strain in an element that a crack runs through grows without end as the elements shrink. What damage is
classed by is the strain of a bay, over a length of some metres (Boscardin & Cording 1989; Son & Cording
2005).
"""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh

__all__ = ["bay_strain"]

FloatArray = NDArray[np.float64]


def bay_strain(mesh: VolumeMesh, displacement: FloatArray) -> float:
    """Largest principal tensile strain of the bays of a wall, in its plane.

    The wall is divided into bays, nearly square and about as long as its shorter side. In each, the
    displacement that varies linearly and fits its nodes' best gives one strain.

    Parameters
    ----------
    mesh : VolumeMesh
    displacement : (n, 3) float array, m

    Returns
    -------
    strain : float
        At least 0.
    """
    plan, moved = mesh.nodes[:, [0, 2]], displacement[:, [0, 2]]
    low, sides = plan.min(axis=0), np.ptp(plan, axis=0)
    counts = np.maximum(1, np.round(sides / sides.min())).astype(int)
    place = (plan - low) / sides * counts
    largest = 0.0
    for column in range(counts[0]):
        for row in range(counts[1]):
            inside = (np.abs(place - [column + 0.5, row + 0.5]) <= 0.5 + 1e-9).all(axis=1)
            largest = max(largest, _fitted_strain(plan[inside], moved[inside]))
    return largest


def _fitted_strain(points: FloatArray, moved: FloatArray) -> float:
    """First principal strain of the linear displacement that fits best; 0 where points lie in a line."""
    if len(points) < 3:
        return 0.0
    terms = np.column_stack([np.ones(len(points)), points - points.mean(axis=0)])
    fit, _, rank, _ = np.linalg.lstsq(terms, moved, rcond=None)
    if rank < 3:
        return 0.0
    (exx, wx), (uz, ezz) = fit[1:]
    return float(0.5 * (exx + ezz) + np.hypot(0.5 * (exx - ezz), 0.5 * (wx + uz)))
