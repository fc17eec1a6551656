"""The records between a scan and a facade: what figures 4 to 10 of the paper show."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.checks import as_array, as_points, as_ring
from fd2fem.model.facade import Facade
from fd2fem.model.frame import FacadePoints
from fd2fem.model.rays import RayMap
from fd2fem.model.spacing import SpacingGrid

__all__ = [
    "Boundary",
    "BoundaryLine",
    "CellState",
    "Hole",
    "HoleKind",
    "QuadTree",
    "Reconstruction",
    "Side",
    "VoxelModel",
]


class HoleKind(StrEnum):
    """What a gap in the points is."""

    OPENING = "opening"
    OCCLUSION = "occlusion"


class Side(StrEnum):
    """Which edge of an opening or of the wall."""

    LEFT = "left"
    RIGHT = "right"
    BOTTOM = "bottom"
    TOP = "top"

    @property
    def vertical(self) -> bool:
        """Whether the edge runs upwards."""
        return self in {Side.LEFT, Side.RIGHT}


class CellState(IntEnum):
    """What is in a voxel."""

    EMPTY = 0
    FULL = 1
    PARTIAL = 2


@dataclass(frozen=True, eq=False)
class Boundary:
    """Boundary points by the Delaunay criterion (step 1.1).

    Attributes
    ----------
    threshold : float, m
        Longest edge expected inside a fully scanned wall: the median over it.
    points : (b,) int array
        Sorted indices of the boundary points into the wall's points.
    triangles : (t, 3) int array
        The triangles with an edge longer than the threshold where they lie; indices into the wall's points.
    hole_of_triangle : (t,) int array
        The cluster that each of them belongs to, from 0, the largest first; -1 along the border of the
        triangulation.
    outer : (h,) int array
        Sorted indices of the points on the border of the triangulation and of its long triangles there.
    edge_lengths : (e,) float array, m
        The distribution that the thresholds come from: edges of triangles over patches all over the wall.
    threshold_of_triangle : (t,) float array, m
        The threshold where each triangle lies; by default the same everywhere.
    border_length : (c,) float array, m
        How much of each cluster's outline lies on the border of the triangulation or on the triangles along
        it: 0 for a hole within the wall; a door's or a notch's width. By default all 0.
    min_opening : float, m
        Smallest opening that the points can show: that of the options, or more where they are too sparse.
        0 if unknown.
    spacing : SpacingGrid or None
        The local point spacing, where it was measured.
    warnings : tuple of str
        What the user should know of the density of the points.
    """

    threshold: float
    points: NDArray[np.intp]
    triangles: NDArray[np.intp]
    hole_of_triangle: NDArray[np.intp]
    outer: NDArray[np.intp]
    edge_lengths: NDArray[np.float64]
    threshold_of_triangle: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    border_length: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    min_opening: float = 0.0
    spacing: SpacingGrid | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.triangles)
        clusters = int(np.max(self.hole_of_triangle, initial=-1)) + 1
        local = self.threshold_of_triangle if len(self.threshold_of_triangle) else [self.threshold] * count
        border = self.border_length if len(self.border_length) else [0.0] * clusters
        for name, values, shape, dtype in (
            ("points", self.points, (None,), np.intp),
            ("triangles", self.triangles, (None, 3), np.intp),
            ("hole_of_triangle", self.hole_of_triangle, (count,), np.intp),
            ("outer", self.outer, (None,), np.intp),
            ("edge_lengths", self.edge_lengths, (None,), np.float64),
            ("threshold_of_triangle", local, (count,), np.float64),
            ("border_length", border, (clusters,), np.float64),
        ):
            object.__setattr__(self, name, as_array(name, values, shape, dtype=dtype))

    @property
    def open_clusters(self) -> NDArray[np.intp]:
        """Numbers of the clusters that are open to the outside: doors at the foot, notches of the outline.

        Their share of the border is wider than the threshold, so that one gap between points does not count.
        """
        return np.flatnonzero(self.border_length > self.threshold)


@dataclass(frozen=True, eq=False)
class Hole:
    """A gap in the points and the verdict on it (step 1.2).

    Attributes
    ----------
    loop : (k, 2) float array, m
        Outline of its largest piece, facade frame, counter-clockwise, not closed.
    points : (b,) int array
        Indices of its boundary points into the wall's points.
    kind : HoleKind
    reason : str
        One sentence.
    x, z, width, height : float, m
        The rectangle between the peaks of its coordinate histograms.
    area : float, m²
        Area of the gap itself, all pieces.
    confidence : float
        Of the verdict, between 0 and 1.
    evidence : mapping
        The figures behind the verdict; JSON values.
    unseen : mapping of Side to (float, float), m
        Edges that lie in shadow: the interval that each may lie in.
    """

    loop: NDArray[np.float64]
    points: NDArray[np.intp]
    kind: HoleKind
    reason: str
    x: float
    z: float
    width: float
    height: float
    area: float
    confidence: float
    evidence: Mapping[str, Any] = field(default_factory=dict)
    unseen: Mapping[Side, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "loop", as_ring("loop", self.loop))
        object.__setattr__(self, "points", as_array("points", self.points, (None,), dtype=np.intp))
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))
        object.__setattr__(self, "unseen", MappingProxyType(dict(self.unseen)))

    @property
    def low(self) -> NDArray[np.float64]:
        """Lower left corner (2,) of the rectangle, m."""
        return np.array([self.x, self.z])

    @property
    def high(self) -> NDArray[np.float64]:
        """Upper right corner (2,) of the rectangle, m."""
        return np.array([self.x + self.width, self.z + self.height])


@dataclass(frozen=True, eq=False)
class QuadTree:
    """The leaves of the quadtree over the wall's bounding box (step 2, figure 7).

    Attributes
    ----------
    lower, upper : (c, 2) float arrays, m
        Corners of each leaf.
    state : (c,) int array
        `CellState` of each leaf.
    depth : int
        Level of the smallest leaves; the root is 0.
    index : (c, 2) int array
        Column and row of each leaf on the grid of the smallest ones.
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    state: NDArray[np.intp]
    depth: int
    index: NDArray[np.intp]

    def __post_init__(self) -> None:
        object.__setattr__(self, "lower", as_points("lower", self.lower, dim=2))
        object.__setattr__(self, "upper", as_points("upper", self.upper, dim=2))
        object.__setattr__(self, "state", as_array("state", self.state, (len(self.lower),), dtype=np.intp))
        object.__setattr__(self, "index", as_array("index", self.index, (len(self.lower), 2), dtype=np.intp))


@dataclass(frozen=True, eq=False)
class BoundaryLine:
    """A straight edge of an opening (figure 8).

    Attributes
    ----------
    start, end : (2,) float arrays, m
        The least-squares line through the boundary points of its voxel group.
    points : (b,) int array
        Indices of these points into the wall's points.
    side : Side
    hole : int
        Index of the hole.
    position : float, m
        x of a vertical edge, z of a horizontal one, freed from the bias of the sampling.
    sigma : float, m
        Standard error of the position.
    """

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    points: NDArray[np.intp]
    side: Side
    hole: int
    position: float
    sigma: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", as_array("start", self.start, (2,)))
        object.__setattr__(self, "end", as_array("end", self.end, (2,)))
        object.__setattr__(self, "points", as_array("points", self.points, (None,), dtype=np.intp))


@dataclass(frozen=True, eq=False)
class VoxelModel:
    """The facade as rectangular voxels, re-divided along the boundary lines (figures 9 and 10).

    Attributes
    ----------
    lower, upper : (v, 2) float arrays, m
        Corners of each voxel in x and z; they do not overlap and cover the bounding box.
    state : (v,) int array
        `CellState.FULL` or `CellState.EMPTY`.
    thickness : (v,) float array, m
        Extent of each voxel in y, from 0; one number where all are equal.
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    state: NDArray[np.intp]
    thickness: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "lower", as_points("lower", self.lower, dim=2))
        object.__setattr__(self, "upper", as_points("upper", self.upper, dim=2))
        object.__setattr__(self, "state", as_array("state", self.state, (len(self.lower),), dtype=np.intp))
        thickness = np.broadcast_to(self.thickness, len(self.lower))
        object.__setattr__(self, "thickness", as_array("thickness", thickness, (len(self.lower),)))

    @property
    def volume(self) -> float:
        """Volume of the full voxels, m³."""
        full = self.state == CellState.FULL
        sides = self.upper[full] - self.lower[full]
        return float(np.sum(self.thickness[full] * sides[:, 0] * sides[:, 1]))


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """Everything from the sorted points to the facade, for whoever wants to look inside."""

    points: FacadePoints
    boundary: Boundary
    rays: RayMap
    holes: tuple[Hole, ...]
    quadtree: QuadTree
    lines: tuple[BoundaryLine, ...]
    voxels: VoxelModel
    facade: Facade
