"""What the rays of a scan say of the places where no wall was seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.checks import as_array

__all__ = ["RayMap"]


@dataclass(frozen=True, eq=False)
class RayMap:
    """Rasters over the wall's face: where the rays to all points that are not on the wall cross it.

    A raster's first index runs along the wall, its second upwards; (0, 0) is the cell whose lower left corner
    is `low`.

    Attributes
    ----------
    low : (2,) float array, m
        Lower left corner of the rasters, facade frame.
    cell : float, m
        Edge of the cells: a few point spacings, so that a cell of seen wall holds points.
    wall : (nx, nz) int array
        Points on the wall.
    shadow : (s, nx, nz) int array
        For each station, points before the wall that hide a cell from it.
    through : (nx, nz) int array
        Points behind the face whose rays passed a cell. One whose station is not known counts for each
        station from which it can have been seen.
    inside : (nx, nz) int array
        Points shortly behind the face of a cell, as seen square to the wall: reveals, frames, glass, blinds.
    recess : (nx, nz) float array, m
        Sum of the depths of those.
    before : (nx, nz) int array
        Points shortly before the face of a cell, as seen square to the wall: whatever is attached to it.
    """

    low: NDArray[np.float64]
    cell: float
    wall: NDArray[np.intp]
    shadow: NDArray[np.intp]
    through: NDArray[np.intp]
    inside: NDArray[np.intp]
    recess: NDArray[np.float64]
    before: NDArray[np.intp]

    def __post_init__(self) -> None:
        object.__setattr__(self, "low", as_array("low", self.low, (2,)))
        object.__setattr__(self, "wall", as_array("wall", self.wall, (None, None), dtype=np.intp))
        shape = self.wall.shape
        object.__setattr__(self, "shadow", as_array("shadow", self.shadow, (None, *shape), dtype=np.intp))
        object.__setattr__(self, "recess", as_array("recess", self.recess, shape))
        for name in ("through", "inside", "before"):
            object.__setattr__(self, name, as_array(name, getattr(self, name), shape, dtype=np.intp))

    @property
    def stations(self) -> int:
        """Number of stations whose position is known."""
        return len(self.shadow)
