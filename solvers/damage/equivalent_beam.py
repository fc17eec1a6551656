"""The limiting tensile strain of a wall by hand: a beam that follows the ground it would stand on.

The wall is a beam without openings, as high as the wall and as long as a part of the ground that hogs or
sags. It takes the movements that the ground would have without it ("greenfield"), so its own stiffness
spares it nothing: the check on the safe side that practice starts from.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive
from solvers.damage.beam_strains import (
    EquivalentBeam,
    ZoneKind,
    bending_strain,
    combined_bending_strain,
    combined_diagonal_strain,
    diagonal_strain,
)
from solvers.damage.classes import DamageClass, rankin_negligible, strain_damage_class, strain_label
from solvers.damage.settlement_profile import Profile, Zone, deflection, profile_zones
from solvers.ground.settlement import Settlement, base_displacement, base_stations

__all__ = [
    "BeamZone",
    "EquivalentBeamCheck",
    "beam_check_to_dict",
    "equivalent_beam_check",
]


@dataclass(frozen=True)
class BeamZone:
    """A part of the wall that the ground bends one way.

    Attributes
    ----------
    kind : ZoneKind
    start, end : float, m
        Along the wall, facade frame.
    deflection : float, m
        Largest distance Δ of the profile from the chord between its ends.
    deflection_ratio : float
        Δ / L, with the zone's length L.
    horizontal_strain : float
        The average over the zone, tension positive.
    bending_strain, diagonal_strain : float
        Of the beam, from the deflection ratio.
    combined_bending_strain, combined_diagonal_strain : float
        With the horizontal strain.
    """

    kind: ZoneKind
    start: float
    end: float
    deflection: float
    deflection_ratio: float
    horizontal_strain: float
    bending_strain: float
    diagonal_strain: float
    combined_bending_strain: float
    combined_diagonal_strain: float

    @property
    def tensile_strain(self) -> float:
        """The larger of the two combined strains."""
        return max(self.combined_bending_strain, self.combined_diagonal_strain)


@dataclass(frozen=True)
class EquivalentBeamCheck:
    """What the equivalent beam says about a wall.

    Attributes
    ----------
    zones : tuple of BeamZone
        From left to right.
    governing : int
        Index of the zone with the largest tensile strain.
    tensile_strain : float
        That strain.
    damage_class : DamageClass
        By Boscardin & Cording's limits; `SEVERE` means severe to very severe.
    max_settlement : float, m
        Downwards.
    max_slope : float
        Magnitude.
    max_horizontal_strain : float
        The largest somewhere along the wall, which the average of a zone levels out.
    rankin_negligible : bool
        Whether the first screen by settlement and slope alone lets the wall pass.
    height, poisson, e_over_g : float
        Of the beam; height in m.
    """

    zones: tuple[BeamZone, ...]
    governing: int
    tensile_strain: float
    damage_class: DamageClass
    max_settlement: float
    max_slope: float
    max_horizontal_strain: float
    rankin_negligible: bool
    height: float
    poisson: float
    e_over_g: float


def equivalent_beam_check(
    settlement: Settlement,
    *,
    extent: tuple[float, float],
    height: float,
    poisson: float = 0.3,
    e_over_g: float = 2.6,
) -> EquivalentBeamCheck:
    """Damage of a wall by the limiting tensile strain of an equivalent beam.

    Parameters
    ----------
    settlement : Settlement
    extent : (float, float), m
        Ends of the wall. A zone's strains average over it: of a wall that reaches far out of a trough give
        only the part that the trough moves.
    height : float, m
        Of the wall.
    poisson : float
    e_over_g : float
        E / G; 2.6 for an isotropic wall with ν = 0.3, larger for one whose openings weaken it in shear.

    Returns
    -------
    check : EquivalentBeamCheck

    Raises
    ------
    InputError
        If the settlement is not of a plausible size or does not cover the wall, or the beam's measures are
        not positive or ν not between -1 and 0.5.
    """
    check_positive("height", height)
    check_positive("e_over_g", e_over_g)
    if not -1.0 < poisson < 0.5:
        msg = f"Invalid 'poisson': expected a number between -1 and 0.5, got {poisson}."
        raise InputError(msg)
    x = base_stations(settlement, extent=extent)
    moved = base_displacement(settlement, x, extent=extent)
    profile = Profile(x, moved[:, 0], moved[:, 2])
    zones = tuple(
        _beam_zone(profile, zone, height=height, poisson=poisson, e_over_g=e_over_g)
        for zone in profile_zones(profile)
    )
    strains = [zone.tensile_strain for zone in zones]
    settled = max(0.0, float(-profile.uz.min()))
    slope = float(np.abs(np.diff(profile.uz) / np.diff(x)).max())
    return EquivalentBeamCheck(
        zones=zones,
        governing=int(np.argmax(strains)),
        tensile_strain=max(strains),
        damage_class=strain_damage_class(max(strains)),
        max_settlement=settled,
        max_slope=slope,
        max_horizontal_strain=float((np.diff(profile.ux) / np.diff(x)).max()),
        rankin_negligible=rankin_negligible(settled, slope),
        height=height,
        poisson=poisson,
        e_over_g=e_over_g,
    )


def _beam_zone(profile: Profile, zone: Zone, *, height: float, poisson: float, e_over_g: float) -> BeamZone:
    """The strains of one zone."""
    kind, start, end = zone
    length = end - start
    bow = deflection(profile, zone)
    ends = np.interp([start, end], profile.x, profile.ux)
    horizontal = float(ends[1] - ends[0]) / length
    beam = EquivalentBeam(kind, length=length, height=height, e_over_g=e_over_g)
    bending, diagonal = bending_strain(bow / length, beam), diagonal_strain(bow / length, beam)
    return BeamZone(
        kind=kind,
        start=start,
        end=end,
        deflection=bow,
        deflection_ratio=bow / length,
        horizontal_strain=horizontal,
        bending_strain=bending,
        diagonal_strain=diagonal,
        combined_bending_strain=combined_bending_strain(bending, horizontal),
        combined_diagonal_strain=combined_diagonal_strain(diagonal, horizontal, poisson=poisson),
    )


def beam_check_to_dict(check: EquivalentBeamCheck) -> dict[str, Any]:
    """A check as JSON values, with the class in words beside its number."""
    return asdict(check) | {
        "zones": [asdict(zone) | {"kind": zone.kind.value} for zone in check.zones],
        "damage_class": int(check.damage_class),
        "damage_label": strain_label(check.damage_class),
    }
