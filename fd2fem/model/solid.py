"""The boundary representation in the words of ANSYS: keypoints, lines, areas, volumes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.checks import as_array, as_points

__all__ = ["SolidModel"]

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
