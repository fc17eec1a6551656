"""The facade frame: x along the wall to the right, y into the wall, z up, seen from outside."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array, as_points

__all__ = ["Attachment", "FacadeFrame", "FacadePoints", "OutOfPlane", "WallCandidate"]


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
class OutOfPlane:
    """How far the wall's face lies behind its plane: a map on a square grid.

    Attributes
    ----------
    low : (2,) float array, m
        x and z of the first value.
    cell : float, m
        Distance between two values.
    values : (nx, nz) float array, m
        At low + cell·(i, j), positive into the wall; NaN where the scan does not show the face.
    """

    low: NDArray[np.float64]
    cell: float
    values: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "low", as_array("low", self.low, (2,)))
        values = np.array(self.values, dtype=np.float64)
        if values.ndim != 2 or np.isinf(values).any() or np.isnan(values).all():
            msg = "Invalid 'values': expected a map of numbers, NaN where the face was not seen."
            raise InputError(msg)
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @classmethod
    def flat(cls) -> "OutOfPlane":
        """A face that lies in its plane."""
        return cls(np.zeros(2), 1.0, np.zeros((1, 1)))


@dataclass(frozen=True)
class Attachment:
    """Something fixed to the wall's face that stands out from it.

    Attributes
    ----------
    kind : str
        ``"downpipe"``, ``"cornice"`` (string courses too), ``"balcony"``, ``"bay"`` or ``"other"``.
    x, z : float, m
        Lower left corner of its box, facade frame.
    width, height : float, m
        Of its box.
    projection : float, m
        How far it reaches before the face.
    """

    kind: str
    x: float
    z: float
    width: float
    height: float
    projection: float


@dataclass(frozen=True, eq=False)
class WallCandidate:
    """One of the walls that a scan shows.

    Attributes
    ----------
    number : int
        From 1, in the order in which they would be chosen.
    length, height : float, m
        Of what the scan shows of it.
    centre : (3,) float array, m
        World frame.
    facing : float, degrees
        Where its outside looks, clockwise from the world's y axis (north).
    points : int
        Of the scan on it, estimated from a sample.
    chosen : bool
        Whether it is the one that was reconstructed.
    """

    number: int
    length: float
    height: float
    centre: NDArray[np.float64]
    facing: float
    points: int
    chosen: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", as_array("centre", self.centre, (3,)))


@dataclass(frozen=True, eq=False)
class FacadePoints:
    """The points of a scan in the facade frame, sorted by where they lie.

    Attributes
    ----------
    xz : (n, 2) float array, m
        Points on the wall, in ascending order of x, and of z where x is the same.
    depth : (n,) float array, m
        Their distance to the wall's face, positive into the wall.
    front, behind : (·, 3) float arrays, m
        A sample of the points before and behind the wall, for figures.
    scanners : (s, 3) float array, m
        Positions of the scanner, facade frame.
    frame : FacadeFrame
        The frame of all of these.
    rms : float, m
        Root mean square distance of the wall's points to its face.
    spacing : float, m
        Typical distance between neighbours on the wall.
    ground : float or None, m
        Level of the pavement at the foot of the wall's middle; ``None`` where the scan does not show it.
    outside_by : str
        What told the outside from the inside.
    warnings : tuple of str
        What the user should know of the choice of the wall.
    relief : OutOfPlane
        Where the face bulges out of the plane.
    band : float, m
        Points so close to the face are on the wall.
    ground_slope : float
        Rise of the pavement along x, m/m.
    attachments : tuple of Attachment
        What is fixed to the wall and stands out from it.
    walls : tuple of WallCandidate
        All walls of the scan, the best one first.
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
    relief: OutOfPlane = field(default_factory=OutOfPlane.flat)
    band: float = 0.015
    ground_slope: float = 0.0
    attachments: tuple[Attachment, ...] = ()
    walls: tuple[WallCandidate, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "xz", as_points("xz", self.xz, dim=2))
        object.__setattr__(self, "depth", as_array("depth", self.depth, (len(self.xz),)))
        for name in ("front", "behind", "scanners"):
            object.__setattr__(self, name, as_points(name, getattr(self, name), dim=3))

    def moved(self, x: float, z: float) -> "FacadePoints":
        """The same points with the frame's origin moved by `x` along the wall and `z` up, m."""
        away = np.array([x, 0.0, z])
        return replace(
            self,
            xz=self.xz - away[::2],
            front=self.front - away,
            behind=self.behind - away,
            scanners=self.scanners - away,
            frame=self.frame.moved(x, z),
            ground=None if self.ground is None else self.ground - z,
            relief=replace(self.relief, low=self.relief.low - away[::2]),
            attachments=tuple(replace(each, x=each.x - x, z=each.z - z) for each in self.attachments),
        )
