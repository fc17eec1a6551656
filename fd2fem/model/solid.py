"""The boundary representation in the words of ANSYS: keypoints, lines, areas, volumes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points

__all__ = ["SolidModel", "WallCells"]

Ids = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class SolidModel:
    """A conformal solid of plane-faced volumes (Appendix A of the paper).

    Keypoints, lines and areas are shared between neighbours. Signed ids count from 1, so that a
    minus sign can say "the other way round".

    Attributes
    ----------
    keypoints : (p, 3) float array, m
    lines : (l, 2) int array
        Start and end keypoint of each line, from 0.
    areas : tuple of tuple of int
        Loop of each area: signed line ids, head to tail, right-handed about the outward normal of
        the first volume that lists it.
    patches : (a, 4) int array
        Keypoints, from 0, at the corners of each area's rectangle, in the sense of its loop.
    volumes : tuple of tuple of int
        Signed area ids of each volume: + where the loop's normal points out of it.
    """

    keypoints: NDArray[np.float64]
    lines: NDArray[np.intp]
    areas: tuple[Ids, ...]
    patches: NDArray[np.intp]
    volumes: tuple[Ids, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "keypoints", as_points("keypoints", self.keypoints, dim=3))
        object.__setattr__(self, "lines", as_array("lines", self.lines, (None, 2), dtype=np.intp))
        object.__setattr__(
            self, "patches", as_array("patches", self.patches, (len(self.areas), 4), dtype=np.intp)
        )


@dataclass(frozen=True, eq=False)
class WallCells:
    """A wall divided, seen from outside, into convex quadrilaterals that meet along whole edges.

    What voxels are for a wall of level and upright edges, these are where edges are slanted or curved.

    Attributes
    ----------
    points : (n, 2) float array, m
        x, z; every one is a corner.
    corners : (c, 4) int array
        Of each cell, counter-clockwise in x, z.
    thickness : (c,) float array, m
        Extent of each cell in y, from 0; one number where all are equal.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.intp]
    thickness: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", as_points("points", self.points, dim=2))
        object.__setattr__(self, "corners", as_array("corners", self.corners, (None, 4), dtype=np.intp))
        thickness = np.broadcast_to(self.thickness, len(self.corners))
        object.__setattr__(self, "thickness", as_array("thickness", thickness, (len(self.corners),)))
        if len(self.corners) and not (self.corners.min() >= 0 and self.corners.max() < len(self.points)):
            msg = f"Invalid 'corners': they name points that are not among the {len(self.points)}."
            raise InputError(msg)
        if (self.thickness <= 0.0).any():
            msg = "Invalid 'thickness': expected positive numbers."
            raise InputError(msg)

    @property
    def volume(self) -> float:
        """Volume of the cells, m³."""
        diagonals = self.points[self.corners[:, 2:]] - self.points[self.corners[:, :2]]
        first, second = diagonals[:, 0], diagonals[:, 1]
        area = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        return float(np.sum(area * self.thickness))
