"""Which side of a wall is its outside."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.errors import InputError
from fd2fem.reconstruction.walls import NEAR_PLANE, Wall

__all__ = ["NOTHING_TELLS", "away_from_scanners", "inward_sign"]

FloatArray = NDArray[np.float64]

FARTHEST = 500.0
"""No terrestrial scanner stands farther from the wall, m."""
NEAR_ORIGIN = 500.0
"""A wall nearer to the world's origin was probably scanned from there, m."""
NOTHING_TELLS = "nothing in the scan: y points as in a drawing"
STRIP = 8.0
"""The pavement is looked for so close to the wall, m."""
CLEAR = 0.3
"""The majorities of the votes, each from -1 to 1, have to add up to this."""
PATCH = 0.25
"""Edge of the cells that are wall or opening, m."""
VOTES = 20
"""Fewer points than this tell nothing."""
ENDS = 0.5
"""Walls that run back from the ends of this one start within so much of them, m."""


def away_from_scanners(scanners: FloatArray, wall: Wall) -> float:
    """+1 where the wall's normal points away from the scanners (s, 3), -1 where to them.

    Raises
    ------
    InputError
        If a scanner stands in the wall, too far from it, or two stand on both sides.
    """
    distance = (scanners - wall.on_plane) @ wall.normal
    if np.abs(distance).min() < 0.1 or np.abs(distance).max() > FARTHEST:
        worst = np.abs(distance).max() if np.abs(distance).max() > FARTHEST else np.abs(distance).min()
        msg = (
            f"A scanner's position is {worst:.3g} m from the wall's plane, expected 0.1 to {FARTHEST:g} m: "
            "give it in the coordinates of the scan."
        )
        raise InputError(msg)
    if distance.min() < 0.0 < distance.max():
        msg = "The scanners' positions lie on both sides of the wall: give only those outside."
        raise InputError(msg)
    return -1.0 if distance[0] > 0 else 1.0


def inward_sign(points: FloatArray, wall: Wall, centre: FloatArray) -> tuple[float, str]:
    """+1 where the wall's normal points into it, -1 where out of it, and what told so.

    Parameters
    ----------
    points : (k, 3) float array, m
        Of the scan, relative to `centre`.
    wall : Wall
    centre : (3,) float array, m
        World frame.
    """
    depth = (points - wall.on_plane) @ wall.normal
    along, up, away = points @ wall.right, points[:, 2], np.abs(depth)
    near = away < NEAR_PLANE
    before = (along > wall.low[0]) & (along < wall.high[0])
    foot = np.percentile(up[near], 1) if near.any() else wall.low[1]
    upper = (up > foot + 1.0) & (up < wall.high[1])
    street = before & (np.abs(up - foot) < 0.4) & (away > 0.1) & (away < STRIP)
    close = np.flatnonzero(before & upper & (away > 0.06) & (away < 0.5))
    solid = _is_solid(along[near], up[near], along[close], up[close])
    ends = (np.abs(along - wall.low[0]) < ENDS) | (np.abs(along - wall.high[0]) < ENDS)
    sides = ends & upper & (away > 1.0) & (away < 8.0)
    # The pavement and what is fixed to the wall lie outside; nothing can be seen in the wall itself.
    # Reveals, frames and glass in its openings, and the rest of the building, lie inside.
    votes = [
        (-_balance(depth[street]), "the pavement before the wall"),
        (-_balance(depth[close[solid]]), "what is fixed to the wall's face"),
        (_balance(depth[close[~solid]]), "reveals and frames behind its face"),
        (_balance(depth[sides]), "the walls that run back from its ends"),
    ]
    total = sum(vote for vote, _ in votes)
    if abs(total) > CLEAR:
        return float(np.sign(total)), max(votes, key=lambda vote: vote[0] * np.sign(total))[1]
    to_origin = float(-(centre + wall.on_plane) @ wall.normal)
    if abs(to_origin) > 0.5 and np.linalg.norm(centre) < NEAR_ORIGIN:
        return (-1.0 if to_origin > 0 else 1.0), "the origin of the coordinates, taken for the scanner"
    # Nothing tells the sides apart: as in a drawing, y points away from the viewer.
    inward = wall.normal[1] > 0 if abs(wall.normal[1]) > 1e-6 else wall.normal[0] > 0
    return (1.0 if inward else -1.0), NOTHING_TELLS


def _balance(depth: FloatArray) -> float:
    """Majority of points behind a plane over those before it, -1 to 1; 0 where too few tell."""
    return float(np.sign(depth).mean()) if len(depth) > VOTES else 0.0


def _is_solid(along: FloatArray, up: FloatArray, x: FloatArray, z: FloatArray) -> NDArray[np.bool_]:
    """Whether places (x, z) lie in the midst of wall, given the places of its points."""
    if len(along) == 0 or len(x) == 0:
        return np.zeros(len(x), dtype=bool)
    low = min(along.min(), x.min()), min(up.min(), z.min())
    shape = (
        int((max(along.max(), x.max()) - low[0]) / PATCH) + 1,
        int((max(up.max(), z.max()) - low[1]) / PATCH) + 1,
    )

    def number(first: FloatArray, second: FloatArray) -> NDArray[np.intp]:
        column, row = ((first - low[0]) / PATCH).astype(np.intp), ((second - low[1]) / PATCH).astype(np.intp)
        flat: NDArray[np.intp] = column * shape[1] + row
        return flat

    count = np.bincount(number(along, up), minlength=shape[0] * shape[1])
    held = count > 0.5 * np.median(count[count > 0])
    midst: NDArray[np.bool_] = ndimage.binary_erosion(held.reshape(shape), np.ones((3, 3)))
    return midst.ravel()[number(x, z)]
