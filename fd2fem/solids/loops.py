"""Loops of a solid: their keypoints, and the areas and volumes that they bound."""

from itertools import chain

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import SolidModel

__all__ = ["flat", "loop_ends", "solid_volumes", "vector_areas"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


def flat(groups: tuple[tuple[int, ...], ...]) -> tuple[IntArray, IntArray]:
    """All ids one after the other, and the index of the group of each.

    Examples
    --------
    >>> [part.tolist() for part in flat(((7, -8), (9,)))]
    [[7, -8, 9], [0, 0, 1]]
    """
    sizes = list(map(len, groups))
    values = np.fromiter(chain.from_iterable(groups), dtype=np.intp, count=sum(sizes))
    return values, np.repeat(np.arange(len(groups)), sizes)


def loop_ends(solid: SolidModel) -> tuple[IntArray, IntArray, IntArray]:
    """Start and end keypoint of every line as the loops run, and the index of its area; from 0."""
    signed, area = flat(solid.areas)
    ends = solid.lines[np.abs(signed) - 1]
    forward = signed > 0
    return np.where(forward, ends[:, 0], ends[:, 1]), np.where(forward, ends[:, 1], ends[:, 0]), area


def vector_areas(solid: SolidModel) -> FloatArray:
    """Vector (a, 3), m², of each area: its size, along the normal about which its loop is right-handed."""
    start, end, area = loop_ends(solid)
    origin = solid.keypoints[solid.patches[:, 0]][area]
    triangles = 0.5 * np.cross(solid.keypoints[start] - origin, solid.keypoints[end] - origin)
    sums = [np.bincount(area, weights=triangles[:, k], minlength=len(solid.areas)) for k in range(3)]
    return np.column_stack(sums)


def solid_volumes(solid: SolidModel) -> FloatArray:
    """Volume (v,), m³, of each volume of a solid, by the divergence theorem.

    A plane area with the vector A contributes p·A/3, p being any point on it. A volume is positive
    when the normals of its areas, with their signs, point outwards.

    Examples
    --------
    >>> from fd2fem.model import VoxelModel
    >>> from fd2fem.solids import solid_from_voxels
    >>> solid_volumes(solid_from_voxels(VoxelModel([[0, 0]], [[2, 3]], [1], 0.5))).round(12).tolist()
    [3.0]
    """
    listed, volume = flat(solid.volumes)
    area = np.abs(listed) - 1
    # Measured from a keypoint of the volume itself, lest a far-off origin cost digits.
    _, first = np.unique(volume, return_index=True)
    origin = solid.keypoints[solid.patches[area[first], 0]][volume]
    arms = solid.keypoints[solid.patches[area, 0]] - origin
    flux = np.sign(listed) * np.einsum("ij,ij->i", arms, vector_areas(solid)[area]) / 3.0
    return np.bincount(volume, weights=flux, minlength=len(solid.volumes)).astype(np.float64)
