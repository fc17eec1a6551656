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


def _no_station() -> NDArray[np.int32]:
    return np.empty(0, dtype=np.int32)


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
    station : (n,) int array, or (0,)
        Index into `scanners` of the one that measured each point, -1 where that is not known; empty
        where it is known of no point.
    no_returns : int
        Rays of which the files say that nothing came back; they are no points.
    """

    points: NDArray[np.float64]
    source: str
    intensity: NDArray[np.float64] = field(default_factory=_no_values)
    scanners: NDArray[np.float64] = field(default_factory=_no_points)
    station: NDArray[np.int32] = field(default_factory=_no_station)
    no_returns: int = 0

    def __post_init__(self) -> None:
        # Scans are large: an array that nobody can change any more needs no copy.
        if not _is_fixed(self.points, 2):
            object.__setattr__(self, "points", as_points("points", self.points, dim=3))
        if not _is_fixed(self.intensity, 1):
            object.__setattr__(self, "intensity", as_array("intensity", self.intensity, (None,)))
        object.__setattr__(self, "scanners", as_points("scanners", self.scanners, dim=3))
        object.__setattr__(self, "station", as_array("station", self.station, (None,), dtype=np.int32))
        for name in ("intensity", "station"):
            length = len(getattr(self, name))
            if length not in {0, len(self.points)}:
                msg = f"Invalid '{name}': expected {len(self.points)} values or none, got {length}."
                raise InputError(msg)
        low, high = (self.station.min(), self.station.max()) if len(self.station) else (-1, -1)
        if low < -1 or high >= len(self.scanners):
            msg = (
                f"Invalid 'station': expected -1 to {len(self.scanners) - 1}, as there are "
                f"{len(self.scanners)} scanners, got {low} to {high}."
            )
            raise InputError(msg)

    def __len__(self) -> int:
        return len(self.points)


def _is_fixed(array: object, dim: int) -> bool:
    """Whether `array` is already what the checks make of it: finite, float64, read-only, no view."""
    return (
        isinstance(array, np.ndarray)
        and array.dtype == np.float64
        and array.ndim == dim
        and array.shape[1:] in {(), (3,)}
        and array.flags.owndata
        and not array.flags.writeable
        and bool(np.isfinite(array).all())
    )
