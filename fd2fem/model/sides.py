"""The names of a wall's surfaces, and which of them a piece of its outline or of an opening's rim bears."""

from collections.abc import Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model.checks import as_points
from fd2fem.model.facade import Facade

__all__ = ["GROUPS", "Group", "edge_groups", "side_groups"]

FloatArray = NDArray[np.float64]

FACING = 0.25
"""A surface faces up, or down, if its normal rises more than this (15°), else sideways."""
ON_GROUND = 1e-5
"""An edge this close to the ground, m, stands on it."""


class Group(StrEnum):
    """Named surfaces of a wall.

    BASE stands on the ground at z = 0. FRONT is y = 0, BACK the faces away from it, also where the wall
    gets thinner storey by storey. TOP faces up by more than 15° on the wall's outline (gables and steps
    too), LEFT and RIGHT are the outline's other sides, towards -x and +x. REVEALS are the jambs, heads and
    sills of the openings. LEDGES are level and face up or down at the back, where the thickness changes.
    The undersides of projections are in none.
    """

    BASE = "base"
    FRONT = "front"
    BACK = "back"
    LEFT = "left"
    RIGHT = "right"
    TOP = "top"
    REVEALS = "reveals"
    LEDGES = "ledges"


GROUPS: tuple[str, ...] = tuple(group.value for group in Group)
"""Names of the facet groups of a facade's mesh."""


def edge_groups(facade: Facade, start: ArrayLike, end: ArrayLike) -> tuple[Group | None, ...]:
    """The group of each straight piece of the wall's outer edge or of an opening's rim.

    Parameters
    ----------
    facade : Facade
    start, end : (k, 2) array-like, m
        Ends of each piece in x, z, with the wall on its left.

    Returns
    -------
    tuple of Group or None
        None for the undersides of projections.

    Examples
    --------
    >>> from fd2fem.model.opening import rectangle
    >>> wall = rectangle(0, 0, 4, 3)
    >>> [str(group) for group in edge_groups(Facade(wall, 0.35), wall, np.roll(wall, -1, axis=0))]
    ['base', 'right', 'top', 'left']
    """
    first, second = as_points("start", start, dim=2), as_points("end", end, dim=2)
    along = second - first
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    rims = [opening.outline for opening in facade.openings]
    return side_groups((first + second) / 2.0, outward, outlines=[facade.outline], rims=rims)


def side_groups(
    centre: ArrayLike, outward: ArrayLike, *, outlines: Sequence[FloatArray], rims: Sequence[FloatArray]
) -> tuple[Group | None, ...]:
    """The group of each piece of a wall's sides, seen from the front: that of `edge_groups`.

    Parameters
    ----------
    centre, outward : (k, 2) array-like, m and -
        Where each piece is, in x, z, and its outward unit normal.
    outlines, rims : sequences of (n, 2) arrays, m
        Rings of the wall, with its doors filled, and of its openings.
    """
    import shapely

    places, normals = as_points("centre", centre, dim=2), as_points("outward", outward, dim=2)
    points = shapely.points(places)
    outer = np.ones(len(places), dtype=bool)
    if rims:
        to_wall, to_rim = (
            shapely.distance(points, shapely.union_all([shapely.LinearRing(ring) for ring in rings]))
            for rings in (outlines, rims)
        )
        outer = to_wall < to_rim
    on_ground = places[:, 1] < min(ring[:, 1].min() for ring in outlines) + ON_GROUND
    groups: list[Group | None] = []
    for is_outer, (x, z), grounded in zip(outer.tolist(), normals.tolist(), on_ground.tolist(), strict=True):
        if not is_outer:
            groups.append(Group.REVEALS)
        elif z < -FACING:
            groups.append(Group.BASE if grounded else None)
        elif z > FACING:
            groups.append(Group.TOP)
        else:
            groups.append(Group.LEFT if x < 0.0 else Group.RIGHT)
    return tuple(groups)
