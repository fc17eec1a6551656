"""The profile of the ground along a wall, and its parts that bend one way."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.damage.beam_strains import ZoneKind

__all__ = ["Profile", "Zone", "deflection", "profile_zones"]

STRAIGHT = 1e-12
"""Bow between neighbouring stations, relative to the largest settlement, that is rounding."""

SMALLEST_DEFLECTION = 0.2e-3
"""A part that bows by less, m, is no zone of its own: levelling sees no less, and tables are rounded."""

COARSE = 51
"""Stations along a wall between which noise in the last digits hides no bend any more."""

FloatArray = NDArray[np.float64]


class Profile(NamedTuple):
    """Movement of the ground along a wall.

    Attributes
    ----------
    x : (n,) float array, m
        Ascending.
    ux, uz : (n,) float array, m
        Along the wall and upwards.
    """

    x: FloatArray
    ux: FloatArray
    uz: FloatArray


class Zone(NamedTuple):
    """A part of a profile, from `start` to `end`, m, that bends one way."""

    kind: ZoneKind
    start: float
    end: float


def profile_zones(profile: Profile, *, smallest: float = SMALLEST_DEFLECTION) -> list[Zone]:
    """Part a profile where it changes from hogging to sagging.

    Parameters
    ----------
    profile : Profile
        At least two stations; what is straight belongs to the zone that it continues.
    smallest : float, m
        A zone that bows by less is taken into its neighbours, the slightest first: else the last digit of
        a table would part it at every row. Where there are such zones, the stations are thinned first.

    Returns
    -------
    zones : list of Zone
        From left to right.

    Examples
    --------
    >>> x = np.linspace(0.0, 4.0, 401)
    >>> zones = profile_zones(Profile(x, 0 * x, np.cos(np.pi * x / 4)))
    >>> [(kind.value, round(start, 6), round(end, 6)) for kind, start, end in zones]
    [('hogging', 0.0, 2.0), ('sagging', 2.0, 4.0)]
    """
    zones = _bends(profile)
    if min(deflection(profile, zone) for zone in zones) < smallest:
        zones = _bends(_thinned(profile))
    bows = [deflection(profile, zone) for zone in zones]
    while len(zones) > 1 and min(bows) < smallest:
        slightest = int(np.argmin(bows))
        first, last = max(slightest - 1, 0), min(slightest + 1, len(zones) - 1)
        # Kinds alternate: both neighbours bend the same way.
        kind = zones[first if slightest > 0 else last].kind
        merged = Zone(kind, zones[first].start, zones[last].end)
        zones[first : last + 1] = [merged]
        bows[first : last + 1] = [deflection(profile, merged)]
    return zones


def _thinned(profile: Profile) -> Profile:
    """A profile at fewer stations, evenly spaced, whose bends stand out from the noise."""
    if len(profile.x) <= COARSE:
        return profile
    x = np.linspace(profile.x[0], profile.x[-1], COARSE)
    return Profile(x, np.interp(x, profile.x, profile.ux), np.interp(x, profile.x, profile.uz))


def _bends(profile: Profile) -> list[Zone]:
    """Every part that bends one way, however slightly.

    Between the last station that bends one way and the first that bends the other, the inflection lies
    where the curvature, taken linear, is zero.
    """
    x, u = profile.x, profile.uz
    before, after = np.diff(x)[:-1], np.diff(x)[1:]
    bow = u[1:-1] - (u[:-2] * after + u[2:] * before) / (before + after)
    bent = np.flatnonzero(np.abs(bow) > STRAIGHT * np.abs(u).max())
    if len(bent) == 0:
        return [Zone(ZoneKind.STRAIGHT, float(x[0]), float(x[-1]))]
    place, curvature = x[1:-1][bent], -2 * bow[bent] / (before * after)[bent]
    turns = np.flatnonzero(np.sign(curvature[1:]) != np.sign(curvature[:-1]))
    share = curvature[turns] / (curvature[turns] - curvature[turns + 1])
    inflections = place[turns] + share * (place[turns + 1] - place[turns])
    ends = np.concatenate([x[:1], inflections, x[-1:]]).tolist()
    first = curvature[np.concatenate([[0], turns + 1])]
    kinds = [ZoneKind.SAGGING if value > 0.0 else ZoneKind.HOGGING for value in first]
    return [Zone(*zone) for zone in zip(kinds, ends[:-1], ends[1:], strict=True)]


def deflection(profile: Profile, zone: Zone) -> float:
    """Largest distance Δ, m, of a profile from the chord between a zone's ends, the way that the zone bends.

    Examples
    --------
    >>> x = np.array([0.0, 1.0, 2.0])
    >>> profile = Profile(x, 0 * x, np.array([0.0, -0.03, -0.02]))
    >>> round(deflection(profile, Zone(ZoneKind.SAGGING, 0.0, 2.0)), 6)
    0.02
    """
    kind, start, end = zone
    x = np.concatenate([[start], profile.x[(profile.x > start) & (profile.x < end)], [end]])
    u = np.interp(x, profile.x, profile.uz)
    above = u - (u[0] + (u[-1] - u[0]) * (x - start) / (end - start))
    if kind is ZoneKind.STRAIGHT:
        return 0.0
    return max(0.0, float((above if kind is ZoneKind.HOGGING else -above).max()))
