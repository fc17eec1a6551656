"""A candidate (scan-derived) model held against a reference (drawing-derived) one."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Comparison", "QuantityComparison"]


@dataclass(frozen=True)
class QuantityComparison:
    """One quantity in both models.

    `relative_difference` is (candidate - reference) / reference (equation 4 of the paper), `None`
    where the reference is 0; `uncertainty` is the relative numerical uncertainty, `None` where it was
    not estimated; `gated` says whether the quantity decides the verdict.
    """

    quantity: str
    candidate: float
    reference: float
    relative_difference: float | None
    passed: bool
    gated: bool = True
    uncertainty: float | None = None


@dataclass(frozen=True, eq=False)
class Comparison:
    """The verdict, with its figures.

    Attributes
    ----------
    tolerance : float
        Largest relative difference that passes, e.g. 0.05.
    passed : bool
    geometry : mapping
        Errors of length, height and opening area, of each opening, and their statistics; JSON values.
    response : tuple of QuantityComparison
        Empty where only geometry was compared.
    reasons : tuple of str
        One sentence for each thing that falls short.
    notes : tuple of str
        What a reader of the figures must know, whatever the verdict.
    """

    tolerance: float
    passed: bool
    geometry: Mapping[str, Any]
    response: tuple[QuantityComparison, ...] = ()
    reasons: tuple[str, ...] = field(default_factory=tuple)
    notes: tuple[str, ...] = ()
