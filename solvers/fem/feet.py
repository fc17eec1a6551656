"""The feet of a wall, and what the ground does to each: a pier beside a door stands on a foot of its own."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.fem.connectivity import parts
from solvers.fem.elements import HEXAHEDRON_EDGES, Space

__all__ = ["Feet", "foot_forces", "foot_records", "wall_feet"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Feet:
    """The parts of a wall's base that hang together through edges, from left to right.

    Attributes
    ----------
    number : (k,) int array
        Foot of each of the base's points, from 0.
    points : (k, 3) float array, m
        They themselves.
    low, high : (f, 3) float array, m
        The boxes around the feet.
    """

    number: IntArray
    points: FloatArray
    low: FloatArray
    high: FloatArray

    @property
    def middle(self) -> FloatArray:
        """Middle (f, 3), m, of each foot's box, about which its moment is taken."""
        return 0.5 * (self.low + self.high)


def wall_feet(mesh: VolumeMesh, space: Space) -> Feet:
    """Feet of a wall.

    Parameters
    ----------
    mesh : VolumeMesh
        With a group "base".
    space : Space
        Of the mesh.
    """
    facets = mesh.groups["base"]
    ring = facets[:, : mesh.kind.facet_corners]
    edges = np.sort(np.stack([ring, np.roll(ring, -1, axis=1)], axis=-1), axis=-1)
    keys = edges[..., 0] * len(mesh.nodes) + edges[..., 1]
    part = parts(np.unique(keys, return_inverse=True)[1].reshape(keys.shape))
    of_point = np.zeros(len(space.points), dtype=np.intp)
    of_point[facets] = part[:, None]
    if space.connectivity.shape[1] > mesh.elements.shape[1]:  # points in the middle of edges have been added
        added = space.connectivity[:, mesh.elements.shape[1] :]
        of_point[added] = of_point[space.connectivity[:, HEXAHEDRON_EDGES[:, 0]]]
    # From the facets: a node in which two feet touch has the number of one of them.
    boxes = [mesh.nodes[facets[part == one]].reshape(-1, 3) for one in range(int(part.max()) + 1)]
    low, high = np.array([box.min(axis=0) for box in boxes]), np.array([box.max(axis=0) for box in boxes])
    order = np.lexsort((low[:, 1], low[:, 0]))
    return Feet(np.argsort(order)[of_point[space.base]], space.points[space.base], low[order], high[order])


def foot_forces(feet: Feet, forces: FloatArray) -> FloatArray:
    """Force (f, 3), N, of the ground on each foot, from those on the base's points (k, 3), N."""
    total = np.zeros((len(feet.low), 3))
    np.add.at(total, feet.number, forces)
    return total


def foot_records(feet: Feet, forces: FloatArray, *, weight: float) -> tuple[Mapping[str, Any], ...]:
    """What each foot carries, as JSON values.

    Parameters
    ----------
    feet : Feet
    forces : (k, 3) float array, N
        Of the ground on the base's points.
    weight : float, N
        Of the wall.

    Returns
    -------
    records : tuple of mappings
        ``x_m``, the foot's ends along the wall; ``middle_m``, of the box around it; ``reaction_n``;
        ``moment_nm``, r × F about the middle, right-handed: the second, about y, bends the wall in its plane,
        and is positive where the left end of the foot is pressed more than the right; ``share_of_weight``, of
        the upward force in the weight, None for a wall without any.
    """
    arms = feet.points - feet.middle[feet.number]
    force, moment = foot_forces(feet, forces), foot_forces(feet, np.cross(arms, forces))
    return tuple(
        {
            "x_m": [float(low), float(high)],
            "middle_m": middle.tolist(),
            "reaction_n": one.tolist(),
            "moment_nm": turn.tolist(),
            "share_of_weight": float(one[2]) / weight if weight > 0.0 else None,
        }
        for low, high, middle, one, turn in zip(
            feet.low[:, 0], feet.high[:, 0], feet.middle, force, moment, strict=True
        )
    )
