"""The verdict on geometry and response together, and the file that keeps it."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fd2fem.errors import InputError
from fd2fem.model import Comparison, QuantityComparison
from validation.criterion import ComparisonOptions, shortfall, within_tolerance
from validation.response import FEET, QUANTITIES

__all__ = ["SCHEMA", "comparison_to_dict", "judge", "write_comparison"]

SCHEMA = "fd2fem/comparison-1"


def judge(
    geometry: Comparison | None,
    response: Sequence[QuantityComparison],
    *,
    tolerance: float = 0.05,
    notes: Sequence[str] = (),
) -> Comparison:
    """Join what the facades and what the responses show into one verdict.

    Parameters
    ----------
    geometry : Comparison or None
        Of the facades; `None` where only responses were compared.
    response : sequence of QuantityComparison
        Empty where only geometry was compared.
    tolerance : float
        The one that both were compared with.
    notes : sequence of str
        What a reader of the figures must know.

    Returns
    -------
    comparison : Comparison
        Passes if the geometry passes and every gated quantity does; `reasons` says what does not.

    Raises
    ------
    InputError
        If there is nothing to judge by, `tolerance` does not lie between 0 and 1, or something was
        compared with another one.

    Examples
    --------
    The paper's Building 1: the displacement is within 5 %, the principal stress is not.

    >>> quantities = [
    ...     QuantityComparison("max_displacement_m", 0.1021, 0.0996, 0.0251, passed=True),
    ...     QuantityComparison("max_principal_stress_pa", 1.14e6, 1.05e6, 0.0857, passed=False),
    ... ]
    >>> judge(None, quantities).reasons[0].split(":")[0]
    'largest principal stress is 8.57 % larger than the reference (tolerance 5 %)'
    """
    ComparisonOptions(tolerance)
    gated = [quantity for quantity in response if quantity.gated]
    if geometry is None and not gated:
        msg = "Nothing to judge by: give the comparison of the facades, or of the responses, or both."
        raise InputError(msg)
    if geometry is not None and geometry.tolerance != tolerance:
        msg = (
            f"Invalid 'tolerance': {tolerance}, but the facades were compared with {geometry.tolerance}; "
            "use one for both."
        )
        raise InputError(msg)
    reasons = list(geometry.reasons) if geometry is not None else []
    reasons += [_reason(quantity, tolerance) for quantity in gated if not _passes(quantity, tolerance)]
    passed = not reasons and (geometry is None or geometry.passed)
    details = geometry.geometry if geometry is not None else {}
    return Comparison(tolerance, passed, details, tuple(response), tuple(reasons), tuple(notes))


def _passes(quantity: QuantityComparison, tolerance: float) -> bool:
    """Whether a quantity passes; its figures and its own word must say the same."""
    passes = within_tolerance(quantity.candidate, quantity.reference, tolerance=tolerance)
    if quantity.quantity == FEET:  # a vector: its figures are lengths, which agree where directions differ
        relative = quantity.relative_difference
        passes = quantity.passed if relative is None else relative <= tolerance
    if passes != quantity.passed:
        msg = (
            f"'{quantity.quantity}' says passed = {quantity.passed}, but {quantity.candidate} against "
            f"{quantity.reference} says otherwise at a tolerance of {tolerance}; use one for both."
        )
        raise InputError(msg)
    return passes


def _reason(quantity: QuantityComparison, tolerance: float) -> str:
    """Sentence for a quantity that falls short."""
    if quantity.quantity == FEET:
        return _feet_reason(quantity.relative_difference, tolerance)
    known = {q.key: (q.label, q.unit) for q in QUANTITIES}
    label, unit = known.get(quantity.quantity, (quantity.quantity, ""))
    candidate, reference = quantity.candidate, quantity.reference
    if not (math.isfinite(candidate) and math.isfinite(reference)):
        return f"{label} is not a finite number: {candidate} against {reference}"
    return shortfall(label, candidate, reference, tolerance=tolerance, unit=unit).rstrip()


def _feet_reason(relative: float | None, tolerance: float) -> str:
    if relative is None:
        return "the walls do not stand on the same number of feet"
    return (
        f"forces of the ground on the feet differ by {100.0 * relative:.3g} % of the reference's "
        f"(tolerance {100.0 * tolerance:.3g} %)"
    )


def comparison_to_dict(comparison: Comparison) -> dict[str, Any]:
    """Content of comparison.json, as JSON values."""
    return {
        "schema": SCHEMA,
        "tolerance": comparison.tolerance,
        "passed": comparison.passed,
        "reasons": list(comparison.reasons),
        "notes": list(comparison.notes),
        "geometry": dict(comparison.geometry),
        "response": [
            {
                "quantity": q.quantity,
                "candidate": q.candidate,
                "reference": q.reference,
                "relative_difference": q.relative_difference,
                "uncertainty": q.uncertainty,
                "passed": q.passed,
                "gated": q.gated,
            }
            for q in comparison.response
        ],
    }


def write_comparison(comparison: Comparison, path: str | Path) -> None:
    """Write comparison.json; it appears whole or not at all.

    Raises
    ------
    InputError
        If a figure is not finite.
    """
    target = Path(path)
    try:
        text = json.dumps(comparison_to_dict(comparison), indent=2, ensure_ascii=False, allow_nan=False)
    except ValueError as error:
        msg = f"Cannot write {target}: a figure of the comparison is not finite; compare the models again."
        raise InputError(msg) from error
    partial = target.with_name(f".{target.name}.part")
    try:
        partial.write_text(text + "\n", encoding="utf-8")
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
