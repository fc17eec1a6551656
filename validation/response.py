"""A candidate's response against the reference's.

The verdict rests on the paper's two quantities, the largest displacement and the largest first
principal stress. Both are weak: the one is mostly rigid motion, the other has no limit at an opening's
corner as the mesh is refined, or, in masonry that cracks, is its tensile strength in any wall that cracks at
all. So walls that crack are judged as well by what has been seen to settle with the mesh: strain energy, and
the forces of the ground on each foot of the wall (within 2.4 % between elements of 0.25 and 0.125 m, in
Building 1 under two settlements). The rest is reported beside them. In an elastic wall the percentiles and
the root mean square of the stress settle too, and the displacement field; in one that cracks they, the
dissipated energy and the widest crack depend on which of several cracks opens first (there by 2 to 50 %).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import QuantityComparison, Response
from validation.criterion import ComparisonOptions, relative_error, within_tolerance
from validation.sampling import common_displacements, without_rigid_motion

__all__ = ["FEET", "QUANTITIES", "Gate", "Quantity", "compare_responses", "response_notes"]

FEET = "foot_reactions_n"

RIGID = 1e-9
"""A deformation smaller than this share of the displacement is round-off: the motion is rigid."""


SATURATED = 1e-6
"""A stress this near to the tensile strength, relative to it, is the tensile strength."""


class Gate(Enum):
    """When a quantity decides the verdict: never, always, or where a wall cracks."""

    NEVER = "never"
    ALWAYS = "always"
    CRACKED = "cracked"


@dataclass(frozen=True)
class Quantity:
    """A scalar of a response: its key in response.json, its name in a sentence, and how to get it."""

    key: str
    label: str
    unit: str
    value: Callable[[Response], float]
    gate: Gate = Gate.NEVER


QUANTITIES = (
    Quantity("max_displacement_m", "largest displacement", "m", lambda r: r.max_displacement, Gate.ALWAYS),
    Quantity(
        "max_principal_stress_pa",
        "largest principal stress",
        "Pa",
        lambda r: r.max_principal_stress,
        Gate.ALWAYS,
    ),
    Quantity("p95_principal_stress_pa", "95th percentile of σ1", "Pa", lambda r: r.p95_principal_stress),
    Quantity("p99_principal_stress_pa", "99th percentile of σ1", "Pa", lambda r: r.p99_principal_stress),
    Quantity("rms_stress_pa", "root mean square of σ1", "Pa", lambda r: r.rms_stress),
    Quantity("strain_energy_j", "strain energy", "J", lambda r: r.strain_energy, Gate.CRACKED),
    Quantity("vertical_reaction_n", "vertical reaction", "N", lambda r: float(r.reaction[2])),
    Quantity("dissipated_energy_j", "dissipated energy", "J", lambda r: r.dissipated_energy),
    Quantity("max_crack_opening_m", "largest crack opening", "m", lambda r: r.max_crack_opening),
)
"""What is compared, in the order of the report."""


def compare_responses(
    candidate: Response, reference: Response, *, tolerance: float = 0.05
) -> tuple[QuantityComparison, ...]:
    """Compare two responses to the same load, meshed alike.

    Parameters
    ----------
    candidate, reference : Response
    tolerance : float
        Largest relative difference (equation 4) that passes.

    Returns
    -------
    quantities : tuple of QuantityComparison
        The scalars of `QUANTITIES`; dissipated energy and crack opening only where one of the models
        has any. ``damage_class`` where both have one: it passes if it is the same. Then
        ``foot_reactions_n``, ``displacement_l2`` and ``displacement_l2_without_rigid_motion``: of these
        `candidate` and `reference` are the root of the summed squares of the forces on the feet, N, and the
        root mean square of the displacement over the common wall, m; `relative_difference` is the same of
        the difference of the forces or fields over that of the reference (not the difference of the two
        figures), and for walls on different numbers of feet `None`. Gated are the first two scalars; where
        one of the walls cracks, also `Gate.CRACKED` ones and the forces on the feet.

    Raises
    ------
    InputError
        If a quantity is not finite, the models have no common wall, or `tolerance` does not lie
        between 0 and 1.
    """
    ComparisonOptions(tolerance)
    cracked = candidate.dissipated_energy > 0.0 or reference.dissipated_energy > 0.0
    gates = {Gate.ALWAYS, Gate.CRACKED} if cracked else {Gate.ALWAYS}
    scalars = [
        replace(_compare(quantity, candidate, reference, tolerance), gated=quantity.gate in gates)
        for quantity in QUANTITIES
    ]
    idle = {"dissipated_energy_j", "max_crack_opening_m"}
    kept = [s for s in scalars if s.quantity not in idle or s.candidate or s.reference]
    return (
        *kept,
        *_compare_classes(candidate, reference),
        *_compare_feet(candidate, reference, tolerance, gated=cracked),
        *_compare_fields(candidate, reference, tolerance),
    )


def response_notes(candidate: Response, reference: Response) -> tuple[str, ...]:
    """What must be said of two responses beside their figures."""
    laws = [model.solver.get("law") for model in (candidate, reference)]
    notes = saturation_notes(candidate, reference)
    if None in laws or laws[0] == laws[1]:
        return notes
    different = f"the candidate is {laws[0]}, the reference {laws[1]}: this tells them apart, not their shape"
    return (different, *notes)


def saturation_notes(candidate: Response, reference: Response) -> tuple[str, ...]:
    """What must be said of the largest principal stresses where both are the tensile strength."""
    strengths = [
        (model.solver.get("masonry") or {}).get("tensile_strength") for model in (candidate, reference)
    ]
    stresses = candidate.max_principal_stress, reference.max_principal_stress
    for stress, strength in zip(stresses, strengths, strict=True):
        if strength is None or stress < (1.0 - SATURATED) * strength:
            return ()
    return (
        f"the largest principal stress is the tensile strength in both models ({stresses[0] / 1e6:.4g} and "
        f"{stresses[1] / 1e6:.4g} MPa), as in any wall that cracks: it says little that they agree",
    )


def _compare(
    quantity: Quantity, candidate: Response, reference: Response, tolerance: float
) -> QuantityComparison:
    """Compare one scalar."""
    first, second = float(quantity.value(candidate)), float(quantity.value(reference))
    for model, value in (("candidate", first), ("reference", second)):
        if not math.isfinite(value):
            msg = f"Invalid '{quantity.key}' of the {model}: {value} is not finite; analyse that model again."
            raise InputError(msg)
    passed = within_tolerance(first, second, tolerance=tolerance)
    return QuantityComparison(quantity.key, first, second, relative_error(first, second), passed)


def _compare_classes(candidate: Response, reference: Response) -> tuple[QuantityComparison, ...]:
    """The classes of damage by cracks, where both walls may crack."""
    first, second = candidate.damage_class, reference.damage_class
    if min(first, second) < 0:
        return ()
    return (QuantityComparison("damage_class", first, second, None, first == second, gated=False),)


def _compare_feet(
    candidate: Response, reference: Response, tolerance: float, *, gated: bool
) -> tuple[QuantityComparison, ...]:
    """The forces of the ground on the feet, as one vector; nothing where a response lists none."""
    if not (candidate.feet and reference.feet):
        return ()
    first, second = (
        np.array([foot["reaction_n"] for foot in model.feet], dtype=float) for model in (candidate, reference)
    )
    norms = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    relative = None
    if len(first) == len(second) and norms[1] > 0.0:
        relative = float(np.linalg.norm(first - second)) / norms[1]
    passed = relative <= tolerance if relative is not None else len(first) == len(second) and norms[0] == 0.0
    return (QuantityComparison(FEET, *norms, relative, passed, gated=gated),)


def _compare_fields(
    candidate: Response, reference: Response, tolerance: float
) -> tuple[QuantityComparison, QuantityComparison]:
    """Relative L2 difference of the displacement fields, with and without their rigid motion."""
    common = common_displacements(candidate, reference)
    points, weights = common.points, common.weights
    first, second = (
        without_rigid_motion(points, field, weights=weights) for field in (common.candidate, common.reference)
    )
    floor = RIGID * max(_rms(common.candidate, weights), _rms(common.reference, weights))
    return (
        _compare_field(
            "displacement_l2",
            (common.candidate, common.reference),
            weights=weights,
            tolerance=tolerance,
            floor=0.0,
        ),
        _compare_field(
            "displacement_l2_without_rigid_motion",
            (first, second),
            weights=weights,
            tolerance=tolerance,
            floor=floor,
        ),
    )


def _compare_field(
    name: str,
    fields: tuple[NDArray[np.float64], NDArray[np.float64]],
    *,
    weights: NDArray[np.float64],
    tolerance: float,
    floor: float,
) -> QuantityComparison:
    """Compare two fields (q, 3); what is at most `floor`, m, counts as no field at all."""
    first, second, difference = (_rms(field, weights) for field in (*fields, fields[0] - fields[1]))
    relative = difference / second if second > floor else None
    passed = difference <= floor if relative is None else relative <= tolerance
    return QuantityComparison(name, first, second, relative, passed, gated=False)


def _rms(field: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    """Root mean square by volume of the length of vectors (q, 3)."""
    return float(np.sqrt(np.average(np.sum(field**2, axis=1), weights=weights)))
