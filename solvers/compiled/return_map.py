"""Return map of Drucker-Prager with a softening Rankine cut-off, at one point, compiled by numba.

The law and its notation are those of :mod:`solvers.masonry`. In principal axes, the trial stress is brought
back to the surfaces that it violates: to the tensile planes alone, to the cone alone, or to both. The cone's
corrector is radial, hence exact after any corrector of the planes, so each case leaves one unknown:
x, the sum of the tensile multipliers.

References
----------
E. A. de Souza Neto, D. Peric, D. R. J. Owen, "Computational Methods for Plasticity", 2008, ch. 8, app. A.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled

__all__ = [
    "APEX",
    "CONE",
    "PLANES",
    "PointLaw",
    "Softening",
    "principal_return",
    "strength",
    "strength_slope",
]

FloatArray = NDArray[np.float64]

CONE, APEX = 1, 16
"""Bits of the active set: the cone; its apex."""
PLANES = 14
"""Bits 2, 4 and 8 of the active set: the tensile planes of the three principal stresses."""
TINY = 1e-12
"""Yield functions are met within this part of the tensile strength."""
ROOT3 = float(np.sqrt(3.0))


class PointLaw(NamedTuple):
    """Constants of the law, in Pa where they have a unit.

    `alpha`, `cone` (k) and `eta` of the cone; `hardening` dk per multiplier of the cone, and the value
    `least_cone` that softening ends at; `shear` G, `bulk` K, `lame` λ.
    """

    alpha: float
    cone: float
    eta: float
    hardening: float
    least_cone: float
    shear: float
    bulk: float
    lame: float


class Softening(NamedTuple):
    """Tensile strength of a point, now at `kappa`.

    ft(kappa) = strength · max(exp(-kappa / ductility), floor), Pa.
    """

    strength: float
    ductility: float
    floor: float
    kappa: float


@compiled
def strength(soft: Softening, x: float) -> float:
    """Tensile strength after further tensile multipliers of the sum x, Pa."""
    return float(soft.strength * max(np.exp(-(soft.kappa + x) / soft.ductility), soft.floor))


@compiled
def strength_slope(soft: Softening, x: float) -> float:
    """Derivative of `strength`."""
    decay = np.exp(-(soft.kappa + x) / soft.ductility)
    return float(-soft.strength * decay / soft.ductility) if decay > soft.floor else 0.0


@compiled
def _largest_root(total: float, stiffness: float, planes: int, soft: Softening) -> float:
    """Largest root of total - stiffness x = planes · ft(x); Newton from the right, which is monotone."""
    x = max(total / stiffness, 0.0)
    for _ in range(60):
        slope = -stiffness - planes * strength_slope(soft, x)
        if slope >= 0.0:
            break
        step = (total - stiffness * x - planes * strength(soft, x)) / slope
        if step <= 1e-15 * x:
            break
        x -= step
    return max(x, 0.0)


@compiled
def _cone_value(stress: FloatArray, law: PointLaw) -> float:
    """The cone's yield function alpha I1 + sqrt(J2) - k."""
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    j2 = 0.5 * ((stress[0] - mean) ** 2 + (stress[1] - mean) ** 2 + (stress[2] - mean) ** 2)
    return float(3.0 * law.alpha * mean + np.sqrt(j2) - law.cone)


@compiled
def _to_planes(trial: FloatArray, law: PointLaw, soft: Softening, stress: FloatArray, g: FloatArray) -> int:
    """Back to the tensile planes alone: as many of them as it takes. Returns the active set."""
    total, planes, x, left = 0.0, 0, 0.0, 0.0
    for planes in range(1, 4):
        total += trial[planes - 1]
        x = _largest_root(total, planes * law.lame + 2.0 * law.shear, planes, soft)
        left = strength(soft, x)
        if planes == 3 or trial[planes] - law.lame * x <= left + TINY * soft.strength:
            break
    for i in range(3):
        stress[i] = left if i < planes else trial[i] - law.lame * x
        g[i + 1] = (trial[i] - left - law.lame * x) / (2.0 * law.shear) if i < planes else 0.0
    return (2, 6, 14)[planes - 1]


@compiled
def _to_cone(trial: FloatArray, law: PointLaw, stress: FloatArray, g: FloatArray) -> int:
    """Back to the cone alone, or to its apex. Returns the active set."""
    mean = (trial[0] + trial[1] + trial[2]) / 3.0
    root_j2 = np.sqrt(0.5 * ((trial[0] - mean) ** 2 + (trial[1] - mean) ** 2 + (trial[2] - mean) ** 2))
    g[0] = _cone_value(trial, law) / _cone_stiffness(law)
    shrink = 1.0 - law.shear * g[0] / root_j2 if root_j2 > 0.0 else -1.0
    if shrink < 0.0:
        for i in range(3):
            stress[i] = law.cone / (3.0 * law.alpha)
        return APEX | CONE
    for i in range(3):
        stress[i] = mean - 3.0 * law.bulk * law.eta * g[0] + shrink * (trial[i] - mean)
    return CONE


@compiled
def _cone_stiffness(law: PointLaw) -> float:
    """How fast the cone's yield function falls with its multiplier."""
    return law.shear + 9.0 * law.bulk * law.alpha * law.eta + law.hardening


@compiled
def _on_face(x: float, trial: FloatArray, law: PointLaw, stress: FloatArray, g: FloatArray) -> float:
    """Stress after the first plane's multiplier x and then the cone's; returns its first principal value."""
    mean = (trial[0] + trial[1] + trial[2]) / 3.0 - law.bulk * x
    first = 2.0 * law.shear * x / 3.0
    for i in range(3):
        stress[i] = trial[i] - (trial[0] + trial[1] + trial[2]) / 3.0 + (first if i else -2.0 * first) + mean
    root_j2 = np.sqrt(0.5 * ((stress[0] - mean) ** 2 + (stress[1] - mean) ** 2 + (stress[2] - mean) ** 2))
    g[0] = max(0.0, _cone_value(stress, law) / _cone_stiffness(law))
    g[1] = x
    shrink = 1.0 - law.shear * g[0] / root_j2 if root_j2 > 0.0 else 0.0
    for i in range(3):
        stress[i] = mean - 3.0 * law.bulk * law.eta * g[0] + shrink * (stress[i] - mean)
    return float(stress[0])


@compiled
def _to_face(trial: FloatArray, law: PointLaw, soft: Softening, stress: FloatArray, g: FloatArray) -> int:
    """Back to the cone and the first plane: bracketed regula falsi (Illinois) with bisection."""
    low, high = 0.0, _largest_root(trial[0], law.lame + 2.0 * law.shear, 1, soft)
    at_low = _on_face(low, trial, law, stress, g) - strength(soft, low)
    at_high = _on_face(high, trial, law, stress, g) - strength(soft, high)
    x, side = high, 0
    for trip in range(200):
        if abs(at_high) <= 1e-15 * soft.strength or high - low <= 1e-16 * high:
            break
        x = 0.5 * (low + high) if trip % 3 == 0 else (low * at_high - high * at_low) / (at_high - at_low)
        value = _on_face(x, trial, law, stress, g) - strength(soft, x)
        if abs(value) <= 1e-15 * soft.strength:
            break
        if value > 0.0:
            low, at_low = x, value
            at_high *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            high, at_high = x, value
            at_low *= 0.5 if side == -1 else 1.0
            side = -1
    stress[0] = strength(soft, x)
    return CONE | 2


@compiled
def _to_edge(trial: FloatArray, law: PointLaw, soft: Softening, stress: FloatArray, g: FloatArray) -> int:
    """Back to the cone and the first two planes, where s1 = s2 = ft: all but ft is linear in x."""
    total = trial[0] + trial[1] + trial[2]
    third = trial[2] - total / 3.0
    # sqrt(J2), the cone's multiplier and the equal stresses as value and slope in x.
    root, root_slope = -0.5 * ROOT3 * third, -law.shear / ROOT3
    stiffness = _cone_stiffness(law)
    cone = (law.alpha * total + root - law.cone) / stiffness
    cone_slope = (root_slope - 3.0 * law.alpha * law.bulk) / stiffness
    pull = 3.0 * law.bulk * law.eta
    equal = total / 3.0 - pull * cone + (root - law.shear * cone) / ROOT3
    equal_slope = -law.bulk - pull * cone_slope + (root_slope - law.shear * cone_slope) / ROOT3
    x = _largest_root(equal, -equal_slope, 1, soft)
    g[0] = cone + cone_slope * x
    apart = (trial[0] - trial[1]) / (4.0 * law.shear)
    g[1], g[2] = 0.5 * x + apart, 0.5 * x - apart
    stress[0] = stress[1] = strength(soft, x)
    left = root + root_slope * x - law.shear * g[0]
    stress[2] = total / 3.0 - law.bulk * x - pull * g[0] - 2.0 * left / ROOT3
    return CONE | 6


@compiled
def _clear(g: FloatArray) -> None:
    # A loop compiles in a tenth of the time that `g[:] = 0.0` takes.
    for i in range(4):
        g[i] = 0.0


@compiled
def principal_return(
    trial: FloatArray, law: PointLaw, soft: Softening, stress: FloatArray, g: FloatArray
) -> int:
    """Principal stress of a trial state.

    Parameters
    ----------
    trial : (3,) float array, Pa
        Elastic stress, descending.
    law : PointLaw
    soft : Softening
    stress : (3,) float array, Pa
        Receives the principal stress.
    g : (4,) float array
        Receives the multipliers of the cone and of the three planes.

    Returns
    -------
    active : int
        Bits of `CONE`, `PLANES` and `APEX`; 0: elastic.
    """
    slack = TINY * soft.strength
    limit = strength(soft, 0.0) + slack
    _clear(g)
    for i in range(3):
        stress[i] = trial[i]
    beyond_cone = _cone_value(trial, law) > slack
    if trial[0] > limit:
        active = _to_planes(trial, law, soft, stress, g)
        if _cone_value(stress, law) <= slack:
            return active
        _clear(g)
    elif not beyond_cone:
        return 0
    if beyond_cone:
        active = _to_cone(trial, law, stress, g)
        if stress[0] <= limit:
            return active
        _clear(g)
    active = _to_face(trial, law, soft, stress, g)
    if stress[1] <= stress[0] + 1e-9 * soft.strength:
        return active
    return _to_edge(trial, law, soft, stress, g)
