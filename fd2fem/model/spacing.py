"""How far apart the points of a scan lie, which changes over a wall."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model.checks import as_array, as_points, check_positive

__all__ = ["SpacingGrid"]


@dataclass(frozen=True, eq=False)
class SpacingGrid:
    """Distances between neighbouring points over a wall, on a coarse grid.

    Attributes
    ----------
    origin : (2,) float array, m
        Lower left corner of the grid, facade frame.
    cell : float, m
        Edge of its square cells.
    edge : (columns, rows) float array, m
        Typical edge of the Delaunay triangles in the middle of each cell: the median, or half of the edge
        that one in five exceeds where that is more, as on scan lines far apart.
    spacing : (columns, rows) float array, m
        1/√density there, where the wall shows.
    edge_lengths : (e,) float array, m
        All edges behind them.
    """

    origin: NDArray[np.float64]
    cell: float
    edge: NDArray[np.float64]
    spacing: NDArray[np.float64]
    edge_lengths: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", as_array("origin", self.origin, (2,)))
        check_positive("cell", self.cell)
        object.__setattr__(self, "edge", as_array("edge", self.edge, (None, None)))
        object.__setattr__(self, "spacing", as_array("spacing", self.spacing, self.edge.shape))
        object.__setattr__(self, "edge_lengths", as_array("edge_lengths", self.edge_lengths, (None,)))

    def edge_at(self, xz: ArrayLike) -> NDArray[np.float64]:
        """Typical Delaunay edge (m,), m, at places (m, 2), m, of the facade frame.

        Examples
        --------
        >>> grid = SpacingGrid([0, 0], 1.0, [[0.01], [0.03]], [[0.01], [0.03]], [])
        >>> grid.edge_at([[0.5, 0.2], [1.0, 0.5], [9.0, 0.5]]).round(3).tolist()
        [0.01, 0.02, 0.03]
        """
        return self.interpolate(self.edge, xz)

    def spacing_at(self, xz: ArrayLike) -> NDArray[np.float64]:
        """1/√density (m,), m, at places (m, 2), m, of the facade frame."""
        return self.interpolate(self.spacing, xz)

    def cell_of(self, xz: ArrayLike) -> NDArray[np.intp]:
        """Number (m,) of the cell in the flattened grid that each of (m, 2) places, m, lies in or next to."""
        place = (as_points("xz", xz, dim=2) - self.origin) / self.cell
        index = np.clip(place.astype(np.intp), 0, np.array(self.edge.shape) - 1)
        number: NDArray[np.intp] = index[:, 0] * self.edge.shape[1] + index[:, 1]
        return number

    def interpolate(self, values: NDArray[np.float64], xz: ArrayLike) -> NDArray[np.float64]:
        """A value (m,) for each of (m, 2) places, m: linear between the cells' centres, constant beyond."""
        last = np.array(values.shape) - 1
        place = np.clip((as_points("xz", xz, dim=2) - self.origin) / self.cell - 0.5, 0.0, last)
        low = np.minimum(place.astype(np.intp), np.maximum(last - 1, 0))
        high = np.minimum(low + 1, last)
        right, up = (place - low).T
        result: NDArray[np.float64] = (1.0 - right) * (
            (1.0 - up) * values[low[:, 0], low[:, 1]] + up * values[low[:, 0], high[:, 1]]
        ) + right * ((1.0 - up) * values[high[:, 0], low[:, 1]] + up * values[high[:, 0], high[:, 1]])
        return result
