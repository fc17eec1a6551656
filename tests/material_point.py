"""A material point that is driven by strains or by stresses, for tests and the page of verification."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solvers.compiled.point_update import PointState, update_point
from solvers.compiled.return_map import PointLaw, Softening
from solvers.compiled.workspace import new_workspace
from solvers.masonry import FLOOR, MasonryLaw, point_law
from solvers.materials import Material

FloatArray = NDArray[np.float64]

MATERIAL, MASONRY = Material(), MasonryLaw()
LAW = point_law(MATERIAL, MASONRY)
DUCTILITY = 1e-3
"""Strain by which the strength falls to 1/e in tests where no crack band is meant."""
NEVER = 1e15
"""Tensile strength, Pa, of a point that does not crack."""

VOIGT = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Component of each entry of the tensor, row by row."""


@dataclass(frozen=True, eq=False)
class Update:
    """What a point answers to a strain: copies of the workspace of `update_point`."""

    active: int
    stress: FloatArray
    tangent: FloatArray
    inelastic: FloatArray
    multipliers: FloatArray


def update(strain: ArrayLike, law: PointLaw, soft: Softening, state: PointState | None = None) -> Update:
    """Answer of a point; by default of one without a past but for the softening's kappa."""
    work = new_workspace()
    state = state or PointState(np.zeros(6), soft.kappa, 0.0)
    active = update_point(np.asarray(strain, dtype=np.float64), state, law, soft, work)
    return Update(active, work.stress, work.tangent, work.inelastic, work.g)


class MaterialPoint:
    """A point that remembers its past."""

    def __init__(
        self, law: PointLaw = LAW, *, strength: float = MASONRY.tensile_strength, ductility: float = DUCTILITY
    ) -> None:
        self.law, self.strength, self.ductility = law, strength, ductility
        self.strain, self.stress = np.zeros(6), np.zeros(6)
        self.state = PointState(np.zeros(6), 0.0, 0.0)

    def trial(self, strain: ArrayLike) -> Update:
        """Answer to a strain that is not accepted."""
        soft = Softening(self.strength, self.ductility, FLOOR, self.state.kappa)
        return update(strain, self.law, soft, self.state)

    def move(self, strain: ArrayLike) -> Update:
        """Go to a strain and stay there."""
        result = self.trial(strain)
        self.strain, self.stress = np.array(strain, dtype=np.float64), result.stress
        planes = float(result.multipliers[1:].sum())
        self.state = PointState(
            result.inelastic, self.state.kappa + planes, self.state.cone + float(result.multipliers[0])
        )
        return result

    def drive(self, imposed: Mapping[int, float], held: Mapping[int, float] | None = None) -> Update:
        """Go where some components of the strain are imposed; the stresses of the others are `held`, or 0.

        Newton's method with the consistent tangent, so that a wrong tangent fails to arrive.
        """
        free = [i for i in range(6) if i not in imposed]
        target = np.array([(held or {}).get(i, 0.0) for i in free])
        strain = self.strain.copy()
        strain[list(imposed)] = list(imposed.values())
        for _ in range(30):
            result = self.trial(strain)
            residual = result.stress[free] - target
            if np.abs(residual).max() < 1e-12 * self.law.bulk:
                return self.move(strain)
            strain[free] -= np.linalg.solve(result.tangent[np.ix_(free, free)], residual)
        message = f"the point found no equilibrium: {residual}"
        raise AssertionError(message)


def principal(stress: FloatArray) -> FloatArray:
    """Principal values of a stress, descending, by LAPACK."""
    values: FloatArray = np.linalg.eigvalsh(stress[VOIGT].reshape(3, 3))[::-1]
    return values


def cone_value(stress: FloatArray, law: PointLaw = LAW) -> float:
    """alpha I1 + sqrt(J2) - k of principal stresses, Pa."""
    mean = stress.mean()
    return float(3 * law.alpha * mean + np.sqrt(0.5 * ((stress - mean) ** 2).sum()) - law.cone)


def confined(point: MaterialPoint, pressure: float) -> None:
    """Press a fresh point from all sides, Pa."""
    point.move(np.array([1.0, 1, 1, 0, 0, 0]) * -pressure / (3 * point.law.bulk))


def triaxial_test(pressure: float, axial_strain: float) -> MaterialPoint:
    """The paper's material, pressed from all sides and then along z: total axial strain."""
    point = MaterialPoint()
    confined(point, pressure)
    point.drive({2: axial_strain}, {0: -pressure, 1: -pressure})
    return point


def aster_test(values: Mapping[str, float], shares: list[float]) -> list[tuple[float, float]]:
    """Axial stress, MPa, and equivalent plastic strain p of SSNV168a at shares of the axial strain.

    Its sigma_eq + A I1 = R(p) is ours times sqrt(3): alpha = eta = A / sqrt(3), k = R / sqrt(3). The same
    flow has p = g / sqrt(3) with our multiplier g, so that dk/dg = (dR/dp) / 3.
    """
    E, nu, root3 = values["young"] * 1e6, values["poisson"], np.sqrt(3.0)
    law = PointLaw(
        alpha=values["alpha"] / root3,
        cone=values["yield_stress"] * 1e6 / root3,
        eta=values["alpha"] / root3,
        hardening=values["slope"] * 1e6 / 3.0,
        least_cone=(values["yield_stress"] + values["slope"] * values["ultimate"]) * 1e6 / root3,
        shear=E / (2 * (1 + nu)),
        bulk=E / (3 * (1 - 2 * nu)),
        lame=E * nu / ((1 + nu) * (1 - 2 * nu)),
    )
    point, pressure = MaterialPoint(law, strength=NEVER), values["confinement"] * 1e6
    confined(point, pressure)
    start, found = point.strain[2], []
    for share in shares:
        point.drive({2: start + share * values["axial_strain"]}, {0: -pressure, 1: -pressure})
        found.append((point.stress[2] / 1e6, point.state.cone / root3))
    return found


def dissipated_energy(band: float, *, steps: int = 400) -> float:
    """Energy per crack area, N/m, that a point of a crack band (m) takes until its strength is gone.

    Pulled along x; the work of the stress on the inelastic strain, by the trapezoidal rule.
    """
    ductility = MASONRY.fracture_energy / (band * MASONRY.tensile_strength)
    point, energy = MaterialPoint(ductility=ductility), 0.0
    onset = MASONRY.tensile_strength / MATERIAL.young
    for strain in np.linspace(onset, onset + 7 * ductility, steps + 1):
        before, inelastic = point.stress, point.state.inelastic
        point.drive({0: strain})
        energy += 0.5 * float((before + point.stress) @ (point.state.inelastic - inelastic))
    return energy * band
