"""The settings of a reconstruction."""

from dataclasses import dataclass
from math import isfinite

from fd2fem.errors import InputError
from fd2fem.model import HoleKind, Storey
from fd2fem.model.checks import check_positive

__all__ = ["Override", "ReconstructionOptions"]


WIDEST_BAND = 0.5
"""No wall's face is so uneven, m."""


@dataclass(frozen=True)
class Override:
    """The user's verdict on the hole at a place of the wall, which no evidence outweighs.

    Attributes
    ----------
    x, z : float, m
        A point inside the hole, facade frame.
    verdict : HoleKind
        ``"opening"`` or ``"occlusion"``.
    """

    x: float
    z: float
    verdict: HoleKind

    def __post_init__(self) -> None:
        if not (isfinite(self.x) and isfinite(self.z)):
            msg = f"Invalid override: expected a finite place, got x = {self.x}, z = {self.z}."
            raise InputError(msg)


@dataclass(frozen=True)
class ReconstructionOptions:
    """How a facade is read out of a point cloud.

    Attributes
    ----------
    wall : int
        Which of the walls in the scan, from 1: they are ranked by what they span and whether a scanner
        faces them.
    threshold : float or None, m
        Longest triangle edge inside a fully scanned wall; ``None``: from the local point spacing. The
        paper used 0.15 to 0.175 m everywhere.
    min_opening : float, m
        Smallest height and length of an opening (equation 1).
    min_aspect, max_aspect : float
        Smallest and largest height to length ratio of an opening (equation 1).
    min_rectangularity : float
        Smallest share of its rectangle that an opening fills.
    max_shadow : float
        Largest share of an opening that may lie in the shadow of things before the wall.
    max_voxel : float or None, m
        Largest voxel; ``None``: just under half of `min_opening`.
    curve_tolerance : float, m
        Arcs are drawn as chords that leave them by no more than this.
    voxel_tolerance : float, m
        Voxels follow curved and slanted edges in steps of this size.
    wall_band : float or None, m
        Points so close to the wall's face are on the wall; ``None``: four times their scatter,
        between 0.015 and 0.06 m.
    overrides : tuple of Override
        Verdicts of the user's on single holes.
    thickness : float, m
        Of the wall, at the ground; a scan of the outside does not show it.
    storeys : tuple of Storey
        Where the wall's thickness changes further up.
    seed : int
        Of the random choices in the search for the plane.
    """

    wall: int = 1
    threshold: float | None = None
    min_opening: float = 0.4
    min_aspect: float = 0.25
    max_aspect: float = 5.0
    min_rectangularity: float = 0.75
    max_shadow: float = 0.5
    max_voxel: float | None = None
    curve_tolerance: float = 0.002
    voxel_tolerance: float = 0.02
    wall_band: float | None = None
    overrides: tuple[Override, ...] = ()
    thickness: float = 0.35
    storeys: tuple[Storey, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        for name in (
            "min_opening",
            "min_aspect",
            "max_aspect",
            "curve_tolerance",
            "voxel_tolerance",
            "thickness",
        ):
            check_positive(name, getattr(self, name))
        for name in ("threshold", "max_voxel", "wall_band"):
            if getattr(self, name) is not None:
                check_positive(name, getattr(self, name))
        for name, least in (("seed", 0), ("wall", 1)):
            if getattr(self, name) < least:
                msg = f"Invalid '{name}': expected {least} or more, got {getattr(self, name)}."
                raise InputError(msg)
        for name in ("min_rectangularity", "max_shadow"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                msg = f"Invalid '{name}': expected a share between 0 and 1, got {getattr(self, name)}."
                raise InputError(msg)
        self._check_limits()

    def _check_limits(self) -> None:
        """Raise where one length forbids another."""
        half = self.min_opening / 2
        if self.threshold is not None and self.threshold > half:
            msg = (
                f"Invalid 'threshold': {self.threshold} m is more than half of the smallest opening "
                f"({self.min_opening} m), which it would bridge."
            )
            raise InputError(msg)
        if self.max_voxel is not None and self.max_voxel >= half:
            msg = (
                f"Invalid 'max_voxel': {self.max_voxel} m is not less than half of the smallest opening "
                f"({self.min_opening} m)."
            )
            raise InputError(msg)
        if self.wall_band is not None and self.wall_band > WIDEST_BAND:
            msg = (
                f"Invalid 'wall_band': {self.wall_band} m is more than {WIDEST_BAND} m; frames would "
                "count as wall."
            )
            raise InputError(msg)
        if self.min_aspect >= self.max_aspect:
            msg = f"Invalid 'min_aspect': expected less than max_aspect = {self.max_aspect}."
            raise InputError(msg)

    @property
    def voxel_limit(self) -> float:
        """Largest voxel in force, m."""
        return 0.495 * self.min_opening if self.max_voxel is None else self.max_voxel
