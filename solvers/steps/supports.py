"""What the wall stands on: prescribed displacements of its base, and springs that hold the others.

Greenfield movements imposed on the base exaggerate what a wall suffers: a stiff wall bridges a trough.
Springs between ground and base let it.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from fd2fem.model.checks import check_positive
from solvers.fem.connectivity import mesh_parts

__all__ = ["BaseKind", "BaseOptions", "Support", "base_areas", "lifted", "spring_forces", "support_of"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

OPEN = 1e-6
"""Part of its stiffness that an open joint keeps, so that the equations stay regular."""


NEAR = 1e-6
"""Nodes this near to the middle, relative to the length of the base, are in the middle."""


class BaseKind(StrEnum):
    """How the base follows the ground.

    TIED: in all directions. VERTICAL: up and down, and held across the wall; along it, only its middle.
    ELASTIC: by springs. NO_TENSION: by springs that let go where the base lifts off; along the ground, in the
    step after it has. Where it presses, those hold whatever the pressure: there is no law of friction.
    """

    TIED = "tied"
    VERTICAL = "vertical"
    ELASTIC = "elastic"
    NO_TENSION = "no_tension"


@dataclass(frozen=True)
class BaseOptions:
    """The joint between ground and wall.

    Attributes
    ----------
    kind : BaseKind
    normal_stiffness, shear_stiffness : float, Pa/m
        Of the springs per area of base.
    """

    kind: BaseKind = BaseKind.TIED
    normal_stiffness: float = 1e9
    shear_stiffness: float = 1e8

    def __post_init__(self) -> None:
        check_positive("normal_stiffness", self.normal_stiffness)
        check_positive("shear_stiffness", self.shear_stiffness)


@dataclass(frozen=True, eq=False)
class Support:
    """Base of a mesh.

    Attributes
    ----------
    points : (k,) int array
        Of the base.
    prescribed : (3m,) bool array
    springs : (3m,) float array, N/m
        0 where there is none.
    lifts : bool
        Whether the springs let go where the base lifts off the ground.
    """

    points: IntArray
    prescribed: BoolArray
    springs: FloatArray
    lifts: bool


def support_of(mesh: VolumeMesh, points: FloatArray, base: IntArray, *, options: BaseOptions) -> Support:
    """Support of a mesh.

    Parameters
    ----------
    mesh : VolumeMesh
    points : (m, 3) float array, m
        That carry displacements; the mesh's nodes first.
    base : (k,) int array
        Those of the base.
    options : BaseOptions
    """
    prescribed, springs = np.zeros((len(points), 3), dtype=bool), np.zeros((len(points), 3))
    if options.kind is BaseKind.TIED:
        prescribed[base] = True
    elif options.kind is BaseKind.VERTICAL:
        prescribed[base, 1:] = True
        prescribed[_middles(mesh), 0] = True
    else:
        areas = base_areas(mesh)
        along = options.shear_stiffness, options.shear_stiffness, options.normal_stiffness
        springs[: len(areas)] = np.outer(areas, along)
    lifts = options.kind is BaseKind.NO_TENSION
    return Support(points=base, prescribed=prescribed.ravel(), springs=springs.ravel(), lifts=lifts)


def _middles(mesh: VolumeMesh) -> IntArray:
    """Nodes of the base nearest to the middle of the base of each part that stands by itself."""
    part, on_base = mesh_parts(mesh), np.zeros(len(mesh.nodes), dtype=bool)
    on_base[mesh.group_nodes("base")] = True
    middles = []
    for number in range(int(part.max()) + 1):
        nodes = np.unique(mesh.elements[part == number])
        own = nodes[on_base[nodes]]
        x = mesh.nodes[own, 0]
        distance = np.abs(x - (x.min() + x.max()) / 2.0)
        middles.append(own[distance <= distance.min() + NEAR * max(float(np.ptp(x)), 1.0)])
    return np.concatenate(middles)


def base_areas(mesh: VolumeMesh) -> FloatArray:
    """Area (n,), m², of the base that each node stands for.

    Facets with nodes in the middle of their edges give them 16 parts for each 3 of a corner, in proportion to
    the diagonal of their mass matrix (Hinton, Rock & Zienkiewicz 1976): all shares are positive.
    """
    facets = mesh.groups["base"]
    corners = mesh.kind.facet_corners
    ring = mesh.nodes[facets[:, :corners]]
    arms = ring - ring[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(arms[:, 1:-1], arms[:, 2:]).sum(axis=1), axis=1)
    parts = np.where(np.arange(facets.shape[1]) < corners, 3.0, 16.0)
    shares = np.outer(area, parts / parts.sum()).ravel()
    return np.bincount(facets.ravel(), weights=shares, minlength=len(mesh.nodes)).astype(np.float64)


def lifted(support: Support, displacement: FloatArray, ground: FloatArray) -> BoolArray:
    """Which points of the base (k,) have lifted off the ground (k, 3), m, by displacements (m, 3), m."""
    off: BoolArray = displacement[support.points, 2] > ground[:, 2]
    return off & support.lifts


def spring_forces(
    support: Support,
    displacement: FloatArray,
    ground: FloatArray,
    *,
    loose: BoolArray,
    rested_on: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Forces (3m,), N, of the springs on the wall's side of the balance, and their stiffness (3m,), N/m.

    Parameters
    ----------
    support : Support
    displacement : (m, 3) float array, m
    ground : (k, 3) float array, m
        Displacement of the ground under the base's points.
    loose : (k,) bool array
        Points that nothing holds along the ground.
    rested_on : (k, 3) float array, m, optional
        Where the ground is taken to be when it is asked which springs have let go; by default at `ground`. A
        ground that has just sunk would seem to have left the wall everywhere.
    """
    stiffness = support.springs.reshape(-1, 3).copy()
    gap = np.zeros_like(displacement)
    gap[support.points] = displacement[support.points] - ground
    stiffness[support.points[loose], :2] *= OPEN
    off = lifted(support, displacement, ground if rested_on is None else rested_on)
    stiffness[support.points[off], 2] *= OPEN
    return (stiffness * gap).ravel(), stiffness.ravel()
