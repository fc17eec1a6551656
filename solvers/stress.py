"""Stresses: at quadrature points, at nodes, principal, and what of them converges with the mesh."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import VolumeMesh
from solvers.assembly import batches, element_gradients, strain_matrix
from solvers.elements import STRESS_ORDER, Space, tabulate

__all__ = [
    "PointStress",
    "StressMeasures",
    "nodal_stress",
    "point_stress",
    "principal_stress",
    "stress_measures",
]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointStress:
    """Stresses at the points of a quadrature rule.

    Attributes
    ----------
    stress : (e, q, 6) float array, Pa
        xx, yy, zz, xy, yz, xz.
    volume : (e, q) float array, m³
        Volume that each point stands for.
    location : (e, q, 3) float array, m
    """

    stress: FloatArray
    volume: FloatArray
    location: FloatArray


@dataclass(frozen=True)
class StressMeasures:
    """σ1 by volume, Pa: its 95th and 99th percentile and its root mean square."""

    p95: float
    p99: float
    rms: float


def point_stress(
    space: Space, elasticity: FloatArray, *, displacement: FloatArray, order: int | None = None
) -> PointStress:
    """Stresses of a displacement field at the points of a quadrature rule.

    Parameters
    ----------
    space : Space
    elasticity : (6, 6) float array, Pa
    displacement : (m, 3) float array, m
        At the space's points.
    order : int, optional
        Degree of the rule; by default that of 2 x 2 x 2 points (4 in a tetrahedron), where the
        stresses are most accurate.

    Returns
    -------
    points : PointStress
    """
    table = tabulate(space.kind, order or STRESS_ORDER[space.kind])
    shape = len(space.connectivity), len(table.weights)
    stress, volume = np.empty((*shape, 6)), np.empty(shape)
    for batch in batches(len(space.connectivity)):
        gradients, volume[batch] = element_gradients(space, table, batch)
        u = displacement[space.connectivity[batch]].reshape(len(gradients), 1, -1, 1)
        stress[batch] = (strain_matrix(gradients) @ u)[..., 0] @ elasticity
    # The mid-edge points follow the mapping, so the displacement functions carry the geometry as well.
    location = table.values @ space.points[space.connectivity]
    return PointStress(stress=stress, volume=volume, location=location)


def nodal_stress(mesh: VolumeMesh, points: PointStress) -> FloatArray:
    """Stresses at the mesh's nodes: extrapolated in each element, then averaged over the elements.

    Parameters
    ----------
    mesh : VolumeMesh
    points : PointStress
        At the points of the default rule.

    Returns
    -------
    stress : (n, 6) float array, Pa
    """
    table = tabulate(mesh.kind, STRESS_ORDER[mesh.kind])
    at_nodes = table.extrapolation @ points.stress
    total = np.zeros((len(mesh.nodes), 6))
    np.add.at(total, mesh.elements, at_nodes)
    count = np.bincount(mesh.elements.ravel(), minlength=len(mesh.nodes))
    return total / count[:, None]


def principal_stress(stress: ArrayLike) -> FloatArray:
    """Principal stresses σ1 ≥ σ2 ≥ σ3.

    Parameters
    ----------
    stress : (..., 6) array-like, Pa
        xx, yy, zz, xy, yz, xz.

    Returns
    -------
    principal : (..., 3) float array, Pa

    Examples
    --------
    Pure shear of 2 Pa pulls and pushes by 2 Pa on the diagonals.

    >>> principal_stress([0, 0, 0, 2, 0, 0]).tolist()
    [2.0, 0.0, -2.0]
    """
    components = np.asarray(stress, dtype=np.float64)
    tensor = components[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*components.shape[:-1], 3, 3)
    return np.asarray(np.linalg.eigvalsh(tensor)[..., ::-1], dtype=np.float64)


def stress_measures(points: PointStress, *, above: float) -> StressMeasures:
    """Percentiles and root mean square of σ1 by volume over the points higher than `above`.

    The largest σ1 grows without end as the elements shrink at a window's corner; these settle. Near the
    base the imposed displacements rule, so points at most as high over it as the wall is thick are left
    out; a wall that has no others keeps them all.

    Parameters
    ----------
    points : PointStress
    above : float, m
        Height z, facade frame.
    """
    inside = points.location[..., 2] > above
    if not inside.any():
        inside[:] = True
    sigma1 = principal_stress(points.stress[inside])[:, 0]
    volume = points.volume[inside]
    p95, p99 = np.percentile(sigma1, [95, 99], weights=volume, method="inverted_cdf")
    rms = np.sqrt(np.average(sigma1**2, weights=volume))
    return StressMeasures(p95=float(p95), p99=float(p99), rms=float(rms))
