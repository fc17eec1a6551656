"""A candidate's response against the reference's.

The verdict rests on the paper's two quantities, the largest displacement and the largest first
principal stress. Both are weak: the one is mostly rigid motion, the other has no limit at an opening's
corner as the mesh is refined. What does converge is reported beside them: percentiles and root mean
square of the stress, energies, the reaction, and the displacement field itself.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import QuantityComparison, Response
from validation.criterion import ComparisonOptions, relative_error, within_tolerance
from validation.sampling import common_displacements, without_rigid_motion

__all__ = ["QUANTITIES", "Quantity", "compare_responses"]

RIGID = 1e-9
"""A deformation smaller than this share of the displacement is round-off: the motion is rigid."""


@dataclass(frozen=True)
class Quantity:
    """A scalar of a response: its key in response.json, its name in a sentence, and how to get it."""

    key: str
    label: str
    unit: str
    value: Callable[[Response], float]
    gated: bool = False


QUANTITIES = (
    Quantity("max_displacement_m", "largest displacement", "m", lambda r: r.max_displacement, gated=True),
    Quantity(
        "max_principal_stress_pa",
        "largest principal stress",
        "Pa",
        lambda r: r.max_principal_stress,
        gated=True,
    ),
    Quantity("p95_principal_stress_pa", "95th percentile of σ1", "Pa", lambda r: r.p95_principal_stress),
    Quantity("p99_principal_stress_pa", "99th percentile of σ1", "Pa", lambda r: r.p99_principal_stress),
    Quantity("rms_stress_pa", "root mean square of σ1", "Pa", lambda r: r.rms_stress),
    Quantity("strain_energy_j", "strain energy", "J", lambda r: r.strain_energy),
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
        has any. Then ``displacement_l2`` and ``displacement_l2_without_rigid_motion``: for these two
        `candidate` and `reference` are the root mean square of the displacement over the common
        wall, m, and `relative_difference` is that of the difference of the fields over that of the
        reference (not the difference of the two figures). Only the first two scalars are gated.

    Raises
    ------
    InputError
        If a quantity is not finite, the models have no common wall, or `tolerance` does not lie
        between 0 and 1.
    """
    ComparisonOptions(tolerance)
    scalars = [_compare(quantity, candidate, reference, tolerance) for quantity in QUANTITIES]
    idle = {"dissipated_energy_j", "max_crack_opening_m"}
    kept = [s for s in scalars if s.quantity not in idle or s.candidate or s.reference]
    return (*kept, *_compare_fields(candidate, reference, tolerance))


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
    return QuantityComparison(
        quantity.key, first, second, relative_error(first, second), passed, gated=quantity.gated
    )


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
