"""Stresses: at quadrature points, at nodes, principal, and what of them converges with the mesh."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers.compiled.elastic import element_stresses
from solvers.compiled.jit import in_chunks
from solvers.fem.assembly import elastic_body
from solvers.fem.elements import HEXAHEDRON_EDGES, STRESS_ORDER, Space, tabulate
from solvers.fem.rules import space_rule
from solvers.materials import Material

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
    space: Space, material: Material, *, displacement: FloatArray, order: int | None = None
) -> PointStress:
    """Stresses of a displacement field at the points of a quadrature rule.

    Parameters
    ----------
    space : Space
    material : Material
    displacement : (m, 3) float array, m
        At the space's points.
    order : int, optional
        Degree of the rule; by default that of 2 x 2 x 2 points (4 in a tetrahedron), where the
        stresses are most accurate.

    Returns
    -------
    points : PointStress

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    body = elastic_body(space, material)
    rule = space_rule(space, order or STRESS_ORDER[space.kind])
    shape = len(space.connectivity), len(rule.weights)
    stress, volume = np.empty((*shape, 6)), np.empty(shape)

    def elements(part: slice) -> None:
        element_stresses(body, rule, part.start, displacement, stress[part], volume[part])

    for _ in in_chunks(len(stress), elements):
        pass
    # The mid-edge points follow the mapping, so the displacement functions carry the geometry as well.
    location = rule.values @ space.points[space.connectivity]
    return PointStress(stress=stress, volume=volume, location=location)


def nodal_stress(mesh: VolumeMesh, points: PointStress) -> FloatArray:
    """Stresses at the mesh's nodes: extrapolated in each element, then averaged over the elements.

    The nodes in the middle of the edges of a 20-node hexahedron take the mean of those at its ends: the
    2 x 2 x 2 points tell no more than what varies linearly along an edge.

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
    stress: FloatArray = total / count[:, None]
    if mesh.kind is ElementKind.HEXAHEDRON20:
        stress[mesh.elements[:, 8:]] = stress[mesh.elements[:, HEXAHEDRON_EDGES]].mean(axis=2)
    return stress


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
