"""What a step of the settlement found, in numbers."""

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.cracking import Motion, PointFields, Strengths
from solvers.damage.cracks import element_cracks
from solvers.fem.stress import principal_stress
from solvers.steps.stepping import LoadStep, Snapshot
from solvers.steps.wall_model import Balance, WallModel

__all__ = ["crack_energy", "largest_stress", "raised_stress", "step_record"]

FloatArray = NDArray[np.float64]


def step_record(
    model: WallModel,
    before: Snapshot,
    fields: PointFields,
    motion: Motion,
    balance: Balance,
    softening: Strengths,
) -> tuple[LoadStep, FloatArray, FloatArray]:
    """Record of a step, the energy (e,), J, that elements have dissipated by now, and the forces (3m,), N.

    Cracks take the area under the softening curve; the cone's work and that of the forces are summed up by
    the trapezoidal rule. No stress is beyond the tensile strength but by rounding, which is cut off. Share,
    iterations and error are left at 0.
    """
    in_cracks = crack_energy(fields.kappa, softening) - crack_energy(before.fields.kappa, softening)
    in_cone = _cone_energy(before.fields, fields)
    dissipated = before.dissipated + ((in_cracks + in_cone) * model.volumes).sum(axis=1)
    force = model.weight + balance.held
    moved = (motion.displacement - before.motion.displacement).ravel()
    work = 0.5 * float((before.force + force) @ moved)
    last = before.history[-1] if before.history else None
    x, y, z = balance.held.reshape(-1, 3).sum(axis=0).tolist()
    record = LoadStep(
        share=0.0,
        iterations=0,
        residual=balance.residual / max(balance.scale, np.finfo(float).tiny),
        reaction=(x, y, z),
        max_displacement=float(np.linalg.norm(motion.displacement, axis=1).max()),
        max_principal_stress=min(largest_stress(fields.stress), float(softening.tensile.max())),
        max_crack_opening=float(element_cracks(fields.crack, model.volumes, model.band).opening.max()),
        strain_energy=_strain_energy(model, fields.stress),
        dissipated_energy=float(dissipated.sum()),
        plastic_energy=(last.plastic_energy if last else 0.0) + float((in_cone * model.volumes).sum()),
        external_work=(last.external_work if last else 0.0) + work,
        strength_error=0.0,
    )
    return record, dissipated, force


def crack_energy(kappa: FloatArray, softening: Strengths) -> FloatArray:
    """Energy per volume (e, q), J/m³, that cracks have taken: the area under ft(kappa).

    Examples
    --------
    A wide crack in a band of 0.1 m has taken a fracture energy of 100 N/m, and a little by the floor.

    >>> band, wide = Strengths(np.array([[1e6]]), np.array([1e-3]), 1e-3), np.array([[0.02]])
    >>> float(crack_energy(wide, band)[0, 0].round(1))
    1012.1
    """
    strength, ductility = softening.tensile, softening.ductility[:, None]
    to_floor = -np.log(softening.floor) * ductility
    spent = strength * ductility * -np.expm1(-np.minimum(kappa, to_floor) / ductility)
    energy: FloatArray = spent + softening.floor * strength * np.maximum(kappa - to_floor, 0.0)
    return energy


def largest_stress(stress: FloatArray) -> float:
    """Largest σ1, Pa, of stresses (..., 6): the axes are sought only where it can be.

    Examples
    --------
    >>> largest_stress(np.array([[2.0, 0, 0, 0, 0, 0], [0, 0, 0, 3.0, 0, 0]]))
    3.0
    """
    low, high = _bounds(stress)
    return float(principal_stress(stress[high >= low.max()])[..., 0].max())


def raised_stress(largest: FloatArray, stress: FloatArray) -> FloatArray:
    """Largest σ1 (e,), Pa, in each element so far, when stresses (e, q, 6) join those before."""
    _, high = _bounds(stress)
    may = np.flatnonzero(high.max(axis=1) > largest)
    raised = largest.copy()
    raised[may] = np.maximum(largest[may], principal_stress(stress[may])[..., 0].max(axis=1))
    return raised


def _bounds(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Between which σ1 lies: the mean plus √(J2/3) and plus twice that, by the angle of Lode."""
    mean = stress[..., :3].mean(axis=-1)
    deviator = stress[..., :3] - mean[..., None]
    part = np.sqrt(((0.5 * deviator**2).sum(axis=-1) + (stress[..., 3:] ** 2).sum(axis=-1)) / 3.0)
    return mean + part, mean + 2.0 * part


def _cone_energy(before: PointFields, fields: PointFields) -> FloatArray:
    """Energy per volume (e, q), J/m³, that the cone took in a step."""
    flowed = (fields.inelastic - before.inelastic) - (fields.crack - before.crack)
    taken: FloatArray = np.einsum("eqi,eqi->eq", 0.5 * (before.stress + fields.stress), flowed)
    return np.where(fields.cone > before.cone, taken, 0.0)


def _strain_energy(model: WallModel, stress: FloatArray) -> float:
    """Elastic energy, J, of stresses (e, q, 6), Pa."""
    law = model.body.law
    mean = stress[..., :3].mean(axis=2)
    deviator, shear = stress[..., :3] - mean[..., None], stress[..., 3:]
    squares = (deviator**2).sum(axis=2) + 2.0 * (shear**2).sum(axis=2)
    density = mean**2 / (2.0 * law.bulk) + squares / (4.0 * law.shear)
    return float((density * model.volumes).sum())
