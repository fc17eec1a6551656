"""What a scanner measured."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points

__all__ = ["PointCloud"]


def _no_points() -> NDArray[np.float64]:
    return np.empty((0, 3))


def _no_values() -> NDArray[np.float64]:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points of one or more scans, in the world frame.

    Attributes
    ----------
    points : (n, 3) float array, m
        World coordinates; survey offsets are kept, z points up.
    source : str
        File name, or generator and seed.
    intensity : (n,) float array, or (0,)
        Return strength between 0 and 1; empty where the file has none.
    scanners : (s, 3) float array, m
        Positions of the scanner, world frame; empty where they are not known.
    """

    points: NDArray[np.float64]
    source: str
    intensity: NDArray[np.float64] = field(default_factory=_no_values)
    scanners: NDArray[np.float64] = field(default_factory=_no_points)

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", as_points("points", self.points, dim=3))
        object.__setattr__(self, "intensity", as_array("intensity", self.intensity, (None,)))
        object.__setattr__(self, "scanners", as_points("scanners", self.scanners, dim=3))
        if len(self.intensity) not in {0, len(self.points)}:
            msg = (
                f"Invalid 'intensity': expected {len(self.points)} values or none, got {len(self.intensity)}."
            )
            raise InputError(msg)

    def __len__(self) -> int:
        return len(self.points)
