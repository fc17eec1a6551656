"""The facade: what a reconstruction finds and a drawing states."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model.arc_cuts import cut_arcs
from fd2fem.model.arcs import Arc, check_arcs
from fd2fem.model.checks import as_points, check_positive, signed_area
from fd2fem.model.frame import FacadeFrame
from fd2fem.model.opening import FilledHole, Opening, check_openings, outline_with_arcs

__all__ = ["Band", "Facade", "Storey"]

TOUCH = 1e-6
"""Two edges closer than this, m, are taken to touch."""
STRAIGHT = 1e-9
"""An edge is level or upright if its ends differ by less than this, m: by rounding alone."""


@dataclass(frozen=True)
class Storey:
    """From the height `z` up, m, the wall is `thickness` thick, m, until the next storey begins."""

    z: float
    thickness: float

    def __post_init__(self) -> None:
        check_positive("z of a storey", self.z)
        check_positive("thickness of a storey", self.thickness)


@dataclass(frozen=True)
class Band:
    """A level strip of the wall of one thickness: `low` to `high`, m; `thickness`, m."""

    low: float
    high: float
    thickness: float


@dataclass(frozen=True, eq=False)
class Facade:
    """A wall with its openings, in the facade frame.

    The front is flush; where the thickness changes with the storeys, the back steps. Arcs that pass the level
    of a storey are parted there, so that each storey has the area that lies inside the curve.

    Attributes
    ----------
    outline : (k, 2) float array, m
        Outer edge of the wall, counter-clockwise, not closed; its bounding box starts at (0, 0).
    thickness : float, m
        At the ground, and all the way up unless `storeys` says otherwise.
    openings : tuple of Opening
    filled_holes : tuple of FilledHole
    frame : FacadeFrame
        Where the facade stands in the world.
    record : mapping
        How it came about: points, options, timings, warnings; JSON values.
    arcs : tuple of Arc
        Which corners of the outline stand for a curved edge.
    storeys : tuple of Storey
        Where the thickness changes, from below; those that do not change it are left out.

    Raises
    ------
    InputError
        If an opening leaves the wall, overlaps or touches another one, or leaves no wall; if an arc does
        not fit its corners; if the storeys do not rise or lie above the wall.
    """

    outline: NDArray[np.float64]
    thickness: float
    openings: tuple[Opening, ...] = ()
    filled_holes: tuple[FilledHole, ...] = ()
    frame: FacadeFrame = field(default_factory=FacadeFrame.identity)
    record: Mapping[str, Any] = field(default_factory=dict)
    arcs: tuple[Arc, ...] = ()
    storeys: tuple[Storey, ...] = ()

    def __post_init__(self) -> None:
        arcs = tuple(self.arcs)
        object.__setattr__(self, "outline", outline_with_arcs("outline", self.outline, arcs))
        object.__setattr__(self, "arcs", check_arcs("outline", self.outline, arcs))
        object.__setattr__(self, "storeys", tuple(self.storeys))
        object.__setattr__(self, "thickness", check_positive("thickness", self.thickness))
        object.__setattr__(self, "openings", tuple(self.openings))
        object.__setattr__(self, "filled_holes", tuple(self.filled_holes))
        object.__setattr__(self, "record", MappingProxyType(dict(self.record)))
        if np.abs(self.outline.min(axis=0)).max() > TOUCH:
            low = self.outline.min(axis=0)
            msg = (
                f"Invalid 'outline': its lower left corner is ({low[0]:.6g}, {low[1]:.6g}), expected (0, 0)."
            )
            raise InputError(msg)
        _check_storeys(self.storeys, self.height)
        object.__setattr__(self, "storeys", _changes(self.thickness, self.storeys))
        levels = [storey.z for storey in self.storeys]
        ring, arcs = cut_arcs(self.outline, self.arcs, levels)
        object.__setattr__(self, "outline", as_points("outline", ring, dim=2))
        object.__setattr__(self, "arcs", arcs)
        object.__setattr__(self, "openings", tuple(_cut(opening, levels) for opening in self.openings))
        check_openings(self.outline, self.openings)

    @property
    def length(self) -> float:
        """Extent along the wall, m."""
        return float(np.ptp(self.outline[:, 0]))

    @property
    def height(self) -> float:
        """Extent upwards, m."""
        return float(np.ptp(self.outline[:, 1]))

    @property
    def opening_area(self) -> float:
        """Sum of the openings' areas, m²."""
        return float(sum(opening.area for opening in self.openings))

    @property
    def wall_area(self) -> float:
        """Area of the wall without its openings, m²."""
        return signed_area(self.outline) - self.opening_area

    @property
    def rectilinear(self) -> bool:
        """Whether all edges are level or upright."""
        rings = (self.outline, *(opening.outline for opening in self.openings))
        return all(bool((np.abs(np.roll(r, -1, axis=0) - r).min(axis=1) < STRAIGHT).all()) for r in rings)

    @property
    def bands(self) -> tuple[Band, ...]:
        """Strips of one thickness each, from the ground up."""
        bottoms = [0.0, *(storey.z for storey in self.storeys)]
        thicknesses = [self.thickness, *(storey.thickness for storey in self.storeys)]
        tops = [*bottoms[1:], self.height]
        return tuple(Band(*values) for values in zip(bottoms, tops, thicknesses, strict=True))

    @property
    def volume(self) -> float:
        """Volume of the wall without its openings, m³."""
        if not self.storeys:
            return self.wall_area * self.thickness
        import shapely

        wall = shapely.Polygon(self.outline).difference(
            shapely.union_all([shapely.Polygon(opening.outline) for opening in self.openings])
        )
        left, right = -1.0, self.length + 1.0
        return float(
            sum(
                wall.intersection(shapely.box(left, b.low, right, b.high)).area * b.thickness
                for b in self.bands
            )
        )


def _check_storeys(storeys: tuple[Storey, ...], height: float) -> None:
    """Raise unless the storeys begin one above the other, within the wall."""
    below = 0.0
    for storey in storeys:
        if not below + TOUCH < storey.z < height - TOUCH:
            msg = (
                f"The storey from z = {storey.z:g} m must begin above z = {below:g} and below the wall's top "
                f"at {height:g} m: list storeys from below."
            )
            raise InputError(msg)
        below = storey.z


def _changes(thickness: float, storeys: tuple[Storey, ...]) -> tuple[Storey, ...]:
    """The storeys whose thickness is not that of the wall below, which is `thickness` at the ground."""
    below = [thickness, *(storey.thickness for storey in storeys)]
    return tuple(storey for storey, before in zip(storeys, below, strict=False) if storey.thickness != before)


def _cut(opening: Opening, levels: list[float]) -> Opening:
    """The opening with its arcs cut at levels."""
    ring, arcs = cut_arcs(opening.outline, opening.arcs, levels)
    return opening if ring is opening.outline else replace(opening, outline=ring, arcs=arcs)
