"""State of a point in space, compiled by numba.

Strain, stress and tangent are ordered xx, yy, zz, xy, yz, xz, with engineering shear strains. The return map
works in the principal axes of the trial strain, which are those of the stress as well.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.point_tangent import elastic_tangent, point_tangent
from solvers.compiled.principal_axes import principal_axes
from solvers.compiled.return_map import ROOT3, PointLaw, Softening, principal_return, strength
from solvers.compiled.workspace import COLUMN, ROW, Workspace

__all__ = ["PointState", "elastic_stress", "return_point", "stays_elastic", "update_point"]

FloatArray = NDArray[np.float64]


class PointState(NamedTuple):
    """What a point remembers: inelastic strain (6,), sums of the planes' and of the cone's multipliers."""

    inelastic: FloatArray
    kappa: float
    cone: float


@compiled
def update_point(
    strain: FloatArray, state: PointState, law: PointLaw, soft: Softening, work: Workspace
) -> int:
    """Stress, tangent, inelastic strain and multipliers at a strain (6,); returns the active set."""
    stress = elastic_stress(
        law,
        strain[0] - state.inelastic[0],
        strain[1] - state.inelastic[1],
        strain[2] - state.inelastic[2],
        strain[3] - state.inelastic[3],
        strain[4] - state.inelastic[4],
        strain[5] - state.inelastic[5],
    )
    if stays_elastic(stress, law, soft, state.cone):
        for i in range(4):
            work.g[i] = 0.0
        for r in range(6):
            work.stress[r], work.inelastic[r] = stress[r], state.inelastic[r]
        elastic_tangent(law, work.tangent)
        return 0
    active, now = return_point(strain, state, law, soft, work)
    point_tangent(active, now, soft, work)
    return active


@compiled
def elastic_stress(
    law: PointLaw, xx: float, yy: float, zz: float, xy: float, yz: float, xz: float
) -> tuple[float, float, float, float, float, float]:
    """Stress of an elastic strain. Numbers, not arrays: most points of a wall need no more than this."""
    pressure, twice = law.lame * (xx + yy + zz), 2.0 * law.shear
    return (
        pressure + twice * xx,
        pressure + twice * yy,
        pressure + twice * zz,
        law.shear * xy,
        law.shear * yz,
        law.shear * xz,
    )


@compiled
def stays_elastic(
    stress: tuple[float, float, float, float, float, float], law: PointLaw, soft: Softening, cone: float
) -> bool:
    """Whether a bound on the first principal stress, without its axes, shows that nothing yields.

    `cone` is the sum of the cone's multipliers so far.
    """
    xx, yy, zz, xy, yz, xz = stress
    mean = (xx + yy + zz) / 3.0
    j2 = 0.5 * ((xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2) + xy**2 + yz**2 + xz**2
    root_j2 = np.sqrt(j2)
    k = max(law.cone + law.hardening * cone, law.least_cone)
    return bool(3.0 * law.alpha * mean + root_j2 <= k and mean + 2.0 / ROOT3 * root_j2 <= strength(soft, 0.0))


@compiled
def return_point(
    strain: FloatArray, state: PointState, law: PointLaw, soft: Softening, work: Workspace
) -> tuple[int, PointLaw]:
    """Stress, inelastic strain and multipliers of a point that may yield.

    Returns the active set and the law with the cone as strong as it was taken, both for `point_tangent`.
    """
    tensor, values, inelastic = work.tensor, work.values, work.inelastic
    for r in range(6):
        i, j = ROW[r], COLUMN[r]
        inelastic[r] = state.inelastic[r]
        tensor[i, j] = tensor[j, i] = (strain[r] - inelastic[r]) * (1.0 if r < 3 else 0.5)
    trace = tensor[0, 0] + tensor[1, 1] + tensor[2, 2]
    principal_axes(tensor, values, work.axes)
    for i in range(3):
        work.trial[i] = law.lame * trace + 2.0 * law.shear * values[i]
    active, now = _return(state.cone, law, soft, work)
    _spread(law, work)
    return active, now


@compiled
def _spread(law: PointLaw, work: Workspace) -> None:
    """Stress and inelastic strain in space: what of the strain is not elastic is inelastic."""
    young = 9.0 * law.bulk * law.shear / (3.0 * law.bulk + law.shear)
    poisson = 0.5 * law.lame / (law.lame + law.shear)
    stress, inelastic, axes, modes = work.stress, work.inelastic, work.axes, work.modes
    principal, values = work.principal, work.values
    total = principal[0] + principal[1] + principal[2]
    for r in range(6):
        stress[r] = 0.0
    for a in range(3):
        elastic = ((1.0 + poisson) * principal[a] - poisson * total) / young
        for r in range(6):
            modes[a, r] = axes[ROW[r], a] * axes[COLUMN[r], a]
            stress[r] += principal[a] * modes[a, r]
            inelastic[r] += (1.0 if r < 3 else 2.0) * (values[a] - elastic) * modes[a, r]


@compiled
def _return(cone: float, law: PointLaw, soft: Softening, work: Workspace) -> tuple[int, PointLaw]:
    """Return map with the cone as strong as it is now; where it softens past its least, at the least."""
    if law.hardening == 0.0:
        return principal_return(work.trial, law, soft, work.principal, work.g), law
    now = _with_cone(law, max(law.cone + law.hardening * cone, law.least_cone), law.hardening)
    active = principal_return(work.trial, now, soft, work.principal, work.g)
    if now.cone + law.hardening * work.g[0] < law.least_cone:
        now = _with_cone(law, law.least_cone, 0.0)
        active = principal_return(work.trial, now, soft, work.principal, work.g)
    return active, now


@compiled
def _with_cone(law: PointLaw, cone: float, hardening: float) -> PointLaw:
    return PointLaw(law.alpha, cone, law.eta, hardening, law.least_cone, law.shear, law.bulk, law.lame)
