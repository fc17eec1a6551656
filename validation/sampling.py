"""Displacements of two models at the same physical points, and what a rigid motion leaves of them.

Two meshes never share their nodes, and their walls differ by millimetres: the fields are compared at
points, never by node number.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, Response, VolumeMesh
from fd2fem.model.checks import as_array, as_points

__all__ = [
    "CommonDisplacements",
    "NoCommonWallError",
    "common_displacements",
    "interpolate",
    "without_rigid_motion",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

INSIDE = 1e-6
"""How far outside an element, in natural coordinates, a point still counts as inside."""

NEWTON_STEPS = 12
"""Steps that invert the map of a hexahedron; a parallelepiped needs one."""

LEAST_SHARE = 0.5
"""Share of the reference's volume that must lie inside the candidate."""

HEX_CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
    dtype=np.float64,
)
"""Natural coordinates of a hexahedron's nodes in VTK's order."""

HEX_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
)
"""Corners beside the midside nodes 8 to 19 of a quadratic hexahedron in VTK's order."""

TETRA_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
"""Corners beside the midside nodes 4 to 9 of a quadratic tetrahedron in VTK's order."""


@dataclass(frozen=True, eq=False)
class CommonDisplacements:
    """Displacements of both models at points that lie in both.

    Attributes
    ----------
    points : (q, 3) float array, m
        One per element of the reference, at its centre; facade frame.
    weights : (q,) float array, m³
        Volumes of those elements, so that sums are integrals over the common wall.
    candidate, reference : (q, 3) float arrays, m
    share : float
        Share of the reference's volume that the points stand for.
    """

    points: FloatArray
    weights: FloatArray
    candidate: FloatArray
    reference: FloatArray
    share: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", as_points("points", self.points, dim=3))
        n = len(self.points)
        object.__setattr__(self, "weights", as_array("weights", self.weights, (n,)))
        for name in ("candidate", "reference"):
            object.__setattr__(self, name, as_array(name, getattr(self, name), (n, 3)))


class NoCommonWallError(InputError):
    """Too little of one model lies where the other is for their fields to be compared."""


def common_displacements(candidate: Response, reference: Response) -> CommonDisplacements:
    """Evaluate both displacement fields at the reference's element centres that lie in the candidate.

    Each model is taken in its own facade frame; both fields by the shape functions of their elements.

    Raises
    ------
    NoCommonWallError
        If less than half of the reference's volume lies inside the candidate.
    InputError
        If one of the reference's elements is folded.
    """
    points, weights, expected = _at_centres(reference)
    found, inside = interpolate(candidate.mesh, candidate.displacement, points)
    share = float(weights[inside].sum() / weights.sum())
    if not share >= LEAST_SHARE:
        msg = (
            f"Only {100.0 * share:.0f} % of the reference's volume lies inside the candidate: "
            "check that both are in metres and show the same facade."
        )
        raise NoCommonWallError(msg)
    return CommonDisplacements(points[inside], weights[inside], found, expected[inside], share)


def without_rigid_motion(points: ArrayLike, displacement: ArrayLike, *, weights: ArrayLike) -> FloatArray:
    """Take the best-fitting rigid motion out of a displacement field.

    The motion t + ω × x is fitted by weighted least squares, with the small rotation of linear
    analysis: it is a projection, so a difference of two fields may be taken before or after.

    Parameters
    ----------
    points, displacement : (q, 3) array-like, m
    weights : (q,) array-like, m³

    Returns
    -------
    deformation : (q, 3) float array, m

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> turned = np.cross([0.0, 0.002, 0.0], points) + [0.01, 0, -0.03]
    >>> bool(np.abs(without_rigid_motion(points, turned, weights=np.ones(4))).max() < 1e-15)
    True
    """
    x = as_points("points", points, dim=3)
    u = as_array("displacement", displacement, (len(x), 3))
    w = as_array("weights", weights, (len(x),))
    arm = x - np.average(x, axis=0, weights=w)
    arm /= np.abs(arm).max() or 1.0
    rotations = [np.cross(axis, arm) for axis in np.eye(3)]
    translations = [np.broadcast_to(axis, arm.shape) for axis in np.eye(3)]
    motions = np.stack([*translations, *rotations], axis=-1)
    root = np.sqrt(w)[:, None]
    fit = np.linalg.lstsq((root[..., None] * motions).reshape(-1, 6), (root * u).ravel(), rcond=None)[0]
    deformation: FloatArray = u - motions @ fit
    return deformation


def interpolate(
    mesh: VolumeMesh, field: FloatArray, points: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Evaluate a field given at the nodes where the points lie in the mesh.

    Quadratic elements are taken to have straight edges, as those of a plane-faced wall have.

    Parameters
    ----------
    mesh : VolumeMesh
    field : (n, 3) float array
        At the nodes.
    points : (p, 3) float array, m

    Returns
    -------
    values : (q, 3) float array
        At the points that lie in the mesh, in their order.
    inside : (p,) bool array
        Which these are.
    """
    point, element = _near(mesh, points)
    corners = mesh.nodes[mesh.elements[element, : _corners(mesh.kind)]]
    natural, excess = _natural(mesh.kind, corners, points[point])
    order = np.lexsort((excess, point))
    best = order[np.unique(point[order], return_index=True)[1]]
    best = best[excess[best] <= INSIDE]
    inside = np.zeros(len(points), dtype=bool)
    inside[point[best]] = True
    shape = _shape(mesh.kind, natural[best])
    return np.einsum("pi,pij->pj", shape, field[mesh.elements[element[best]]]), inside


def _near(mesh: VolumeMesh, points: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs of a point and an element whose bounding box holds it."""
    import shapely

    corners = mesh.nodes[mesh.elements]
    low, high = corners.min(axis=1), corners.max(axis=1)
    pad = INSIDE * (high - low)
    low, high = low - pad, high + pad
    tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 2], high[:, 0], high[:, 2]))
    point, element = tree.query(shapely.points(points[:, 0], points[:, 2]))
    y = points[point, 1]
    holds = (low[element, 1] <= y) & (y <= high[element, 1])
    return point[holds], element[holds]


def _natural(kind: ElementKind, corners: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Natural coordinates (p, 3) of points in their elements, and how far outside (p,) they lie."""
    natural = np.full(points.shape, _centre(kind)[0])
    with np.errstate(divide="ignore", invalid="ignore"):  # a folded element yields no place: excess NaN
        for _ in range(NEWTON_STEPS):
            place, jacobian = _map(kind, corners, natural)
            step = _solve(jacobian, points - place)
            natural = np.clip(natural + step, -2.0, 2.0)
            if not (np.abs(step) > 1e-12).any():
                break
        # The last step says how well the map is inverted, in the same unit as the excess.
        last = np.abs(_solve(jacobian, points - _map(kind, corners, natural)[0])).max(axis=1)
    if kind is ElementKind.TETRA10:
        excess = np.maximum(-natural.min(axis=1), natural.sum(axis=1) - 1.0)
    else:
        excess = np.abs(natural).max(axis=1) - 1.0
    return natural, np.maximum(excess, np.where(last <= INSIDE, -1.0, np.inf))


def _solve(jacobian: FloatArray, right: FloatArray) -> FloatArray:
    """Solve (p, 3, 3) systems by Cramer's rule; NaN or infinity where one is singular."""
    a, b, c = (jacobian[..., k] for k in range(3))
    minors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    solution: FloatArray = np.einsum("pkj,pj->pk", minors, right) / np.sum(a * minors[:, 0], axis=1)[:, None]
    return solution


def _corners(kind: ElementKind) -> int:
    """Number of an element's corners, which come first among its nodes."""
    return 4 if kind is ElementKind.TETRA10 else 8


def _centre(kind: ElementKind) -> FloatArray:
    """Natural coordinates (1, 3) of an element's centre."""
    return np.full((1, 3), 0.25 if kind is ElementKind.TETRA10 else 0.0)


def _map(kind: ElementKind, corners: FloatArray, natural: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places (p, 3) of natural coordinates and the map's derivative (p, 3, 3), natural last."""
    if kind is ElementKind.TETRA10:
        sides = np.moveaxis(corners[:, 1:4] - corners[:, :1], 1, 2)
        return corners[:, 0] + np.einsum("pjk,pk->pj", sides, natural), sides
    factors = 1.0 + natural[:, None] * HEX_CORNERS
    pairs = np.stack([factors[..., i] * factors[..., j] for i, j in ((1, 2), (0, 2), (0, 1))], axis=-1)
    place = np.einsum("pi,pij->pj", factors.prod(axis=2) / 8.0, corners)
    return place, np.einsum("pik,pij->pjk", HEX_CORNERS * pairs / 8.0, corners)


def _shape(kind: ElementKind, natural: FloatArray) -> FloatArray:
    """Shape functions (p, 8), (p, 20) or (p, 10) at natural coordinates (p, 3)."""
    if kind is ElementKind.TETRA10:
        bary = np.column_stack([1.0 - natural.sum(axis=1), natural])
        middle = 4.0 * bary[:, TETRA_EDGES[:, 0]] * bary[:, TETRA_EDGES[:, 1]]
        return np.hstack([bary * (2.0 * bary - 1.0), middle])
    trilinear: FloatArray = (1.0 + natural[:, None] * HEX_CORNERS).prod(axis=2) / 8.0
    if kind is ElementKind.HEXAHEDRON:
        return trilinear
    # On the reference edge between two corners their trilinear functions are (1 - t)/2 and (1 + t)/2 with
    # the same two factors across, so that of the middle, (1 - t²) times these factors, is 2 (1 + t) times
    # the first one; each corner gives half of it back along its three edges.
    start, end = HEX_EDGES.T
    along = (natural @ (HEX_CORNERS[end] - HEX_CORNERS[start]).T) / 2.0
    middle = 2.0 * (1.0 + along) * trilinear[:, start]
    at_corner = (HEX_EDGES[:, :, None] == np.arange(8)).any(axis=1)
    return np.hstack([trilinear - 0.5 * middle @ at_corner, middle])


def _at_centres(response: Response) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centres (e, 3) of the elements, their volumes (e,) and displacements (e, 3) there."""
    mesh = response.mesh
    natural = np.repeat(_centre(mesh.kind), len(mesh.elements), axis=0)
    place, jacobian = _map(mesh.kind, mesh.nodes[mesh.elements[:, : _corners(mesh.kind)]], natural)
    volume = np.linalg.det(jacobian) * (1.0 / 6.0 if mesh.kind is ElementKind.TETRA10 else 8.0)
    if not (volume > 0.0).all():
        msg = (
            f"{int((volume <= 0.0).sum())} of the reference's {len(volume)} elements "
            "have no positive volume: mesh it again."
        )
        raise InputError(msg)
    values = np.einsum("pi,pij->pj", _shape(mesh.kind, natural), response.displacement[mesh.elements])
    return place, volume, values
