"""The facade frame: x along the wall to the right, y into the wall, z up, seen from outside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points

__all__ = ["FacadeFrame", "FacadePoints"]


@dataclass(frozen=True, eq=False)
class FacadeFrame:
    """Where the facade stands in the world: world = origin + x·X + y·Y + z·Z.

    Attributes
    ----------
    origin : (3,) float array, m
        Lower left corner of the wall's front face, world frame.
    axes : (3, 3) float array
        Rows X (right), Y (into the wall), Z (up): orthonormal, determinant +1.
    """

    origin: NDArray[np.float64]
    axes: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", as_array("origin", self.origin, (3,)))
        object.__setattr__(self, "axes", as_array("axes", self.axes, (3, 3)))
        if np.abs(self.axes @ self.axes.T - np.eye(3)).max() > 1e-9 or np.linalg.det(self.axes) < 0:
            msg = "Invalid 'axes': expected three orthonormal rows, right-handed."
            raise InputError(msg)

    @classmethod
    def identity(cls) -> "FacadeFrame":
        """The frame of a drawing: the facade frame is the world."""
        return cls(np.zeros(3), np.eye(3))

    def to_facade(self, world: ArrayLike) -> NDArray[np.float64]:
        """Facade coordinates (n, 3), m, of world points (n, 3), m."""
        return (as_points("world", world, dim=3) - self.origin) @ self.axes.T

    def to_world(self, local: ArrayLike) -> NDArray[np.float64]:
        """World coordinates (n, 3), m, of facade points (n, 3), m."""
        return as_points("local", local, dim=3) @ self.axes + self.origin

    def moved(self, x: float, z: float) -> "FacadeFrame":
        """The same axes with the origin moved by `x` along the wall and `z` up, m."""
        return FacadeFrame(self.origin + x * self.axes[0] + z * self.axes[2], self.axes)


@dataclass(frozen=True, eq=False)
class FacadePoints:
    """The points of a scan in the facade frame, sorted by where they lie.

    Attributes
    ----------
    xz : (n, 2) float array, m
        Points on the wall.
    depth : (n,) float array, m
        Their distance to the wall's plane, positive into the wall.
    front, behind : (·, 3) float arrays, m
        Points before and behind the wall.
    scanners : (s, 3) float array, m
        Positions of the scanner, facade frame.
    frame : FacadeFrame
        The frame of all of these.
    rms : float, m
        Root mean square distance of the wall's points to its plane.
    spacing : float, m
        Typical distance between neighbours on the wall.
    ground : float or None, m
        Level of the pavement at the wall's foot; ``None`` where the scan does not show it.
    outside_by : str
        What told the outside from the inside.
    warnings : tuple of str
        What the user should know of the choice of the wall.
    """

    xz: NDArray[np.float64]
    depth: NDArray[np.float64]
    front: NDArray[np.float64]
    behind: NDArray[np.float64]
    scanners: NDArray[np.float64]
    frame: FacadeFrame
    rms: float
    spacing: float
    ground: float | None
    outside_by: str
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "xz", as_points("xz", self.xz, dim=2))
        object.__setattr__(self, "depth", as_array("depth", self.depth, (len(self.xz),)))
        for name in ("front", "behind", "scanners"):
            object.__setattr__(self, name, as_points(name, getattr(self, name), dim=3))
