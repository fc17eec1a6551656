"""A candidate's facade against the reference's: overall dimensions, openings one by one, statistics.

The verdict rests on length, height, total opening area, and on every opening being found and none
invented. The size and place of each opening are reported beside it, with the statistics of Appendix B:
a drawing may state an opening without its frame, as the paper's Building 2 does by 0.37 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Comparison, Facade, Opening
from validation.criterion import ComparisonOptions, relative_error, shortfall, within_tolerance
from validation.intervals import standard_deviation, standard_uncertainty, t_interval

__all__ = ["OpeningMatches", "compare_facades", "match_openings"]

DIMENSIONS = ("width", "height")
POSITION = ("x", "z")
STATISTICS = ("mean_m", "std_m", "standard_uncertainty_m", "min_m", "max_m", "lower_m", "upper_m")


@dataclass(frozen=True, eq=False)
class OpeningMatches:
    """Which opening of the candidate is which of the reference.

    Attributes
    ----------
    pairs : tuple of (candidate, reference)
        In the order of the reference's ids.
    missing : tuple of Opening
        Of the reference, without a partner.
    extra : tuple of Opening
        Of the candidate, without a partner.
    """

    pairs: tuple[tuple[Opening, Opening], ...]
    missing: tuple[Opening, ...]
    extra: tuple[Opening, ...]


def match_openings(candidate: Facade, reference: Facade) -> OpeningMatches:
    """Pair the openings of two facades so that their rectangles overlap most in total.

    Each facade is taken in its own frame, with its lower left corner as the origin. Two openings can
    be partners if the centre of one bounding rectangle lies in the other; among those the assignment
    with the largest sum of intersection over union is the one.

    Examples
    --------
    >>> from fd2fem.model import OpeningKind, rectangle
    >>> def facade(*corners):
    ...     openings = [
    ...         Opening(i, OpeningKind.WINDOW, rectangle(x, 1, 1, 1)) for i, x in enumerate(corners, 1)
    ...     ]
    ...     return Facade(rectangle(0, 0, 9, 3), 0.3, tuple(openings))
    >>> matches = match_openings(facade(1.02, 5), facade(1, 3))
    >>> [(c.id, r.id) for c, r in matches.pairs], [o.id for o in matches.missing]
    ([(1, 1)], [2])
    """
    from scipy.optimize import linear_sum_assignment

    overlap = _overlaps(candidate.openings, reference.openings)
    rows, columns = linear_sum_assignment(overlap, maximize=True)
    partner = {int(r): int(c) for c, r in zip(rows, columns, strict=True) if overlap[c, r] > 0.0}
    found = set(partner.values())
    pairs = [(candidate.openings[c], reference.openings[r]) for r, c in partner.items()]
    missing = [opening for r, opening in enumerate(reference.openings) if r not in partner]
    extra = [opening for c, opening in enumerate(candidate.openings) if c not in found]
    return OpeningMatches(
        tuple(sorted(pairs, key=lambda pair: pair[1].id)),
        tuple(sorted(missing, key=lambda opening: opening.id)),
        tuple(sorted(extra, key=lambda opening: opening.id)),
    )


def _overlaps(candidates: Sequence[Opening], references: Sequence[Opening]) -> NDArray[np.float64]:
    """Intersection over union (c, r) of bounding rectangles; 0 where the two can't be partners."""
    first, second = _boxes(candidates)[:, None], _boxes(references)[None]
    sides = np.minimum(first[..., 2:], second[..., 2:]) - np.maximum(first[..., :2], second[..., :2])
    shared = np.prod(np.maximum(sides, 0.0), axis=-1)
    union = np.prod(first[..., 2:] - first[..., :2], axis=-1) + np.prod(
        second[..., 2:] - second[..., :2], axis=-1
    )
    partners = _holds_centre(first, second) | _holds_centre(second, first)
    return np.where(partners, shared / (union - shared), 0.0)


def _holds_centre(outer: NDArray[np.float64], inner: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether rectangles (..., 4) of `outer` hold the centres of those of `inner`."""
    centre = 0.5 * (inner[..., :2] + inner[..., 2:])
    inside = (outer[..., :2] <= centre) & (centre <= outer[..., 2:])
    return inside[..., 0] & inside[..., 1]


def _boxes(openings: Sequence[Opening]) -> NDArray[np.float64]:
    """Bounding rectangles (n, 4): left, bottom, right, top, m."""
    corners = [[o.x, o.z, o.x + o.width, o.z + o.height] for o in openings]
    return np.array(corners, dtype=np.float64).reshape(-1, 4)


def compare_facades(
    candidate: Facade, reference: Facade, *, tolerance: float = 0.05, level: float = 0.90
) -> Comparison:
    """Hold the geometry of a scan-derived facade against the drawing-derived one.

    Parameters
    ----------
    candidate, reference : Facade
    tolerance : float
        Largest relative error (equation 4) of length, height and opening area that passes.
    level : float
        Confidence level of the intervals.

    Returns
    -------
    comparison : Comparison
        `geometry` holds, as JSON values: ``length``, ``height``, ``opening_area`` (candidate,
        reference, signed error, relative error, passed); ``openings`` (matched pairs with their
        errors in m; ids of the missing and the extra ones; passed); ``opening_dimensions`` and
        ``opening_positions``, each the statistics of two errors per matched opening (width and
        height, x and z), `None` where no opening matches. The t interval takes these errors as
        independent, as the paper does.

    Raises
    ------
    InputError
        If `tolerance` or `level` does not lie between 0 and 1.
    """
    options = ComparisonOptions(tolerance, level)
    matches = match_openings(candidate, reference)
    geometry: dict[str, Any] = {}
    reasons: list[str] = []
    for name, unit, suffix in (("length", "m", "m"), ("height", "m", "m"), ("opening_area", "m²", "m2")):
        values = (getattr(candidate, name), getattr(reference, name))
        geometry[name] = _overall(*values, suffix=suffix, tolerance=options.tolerance)
        if not geometry[name]["passed"]:
            what = name.replace("_", " ")
            reasons.append(shortfall(what, *values, tolerance=options.tolerance, unit=unit))
    reasons += [f"{_name(opening)} of the reference is missing" for opening in matches.missing]
    reasons += [f"{_name(opening)} of the candidate is not in the reference" for opening in matches.extra]
    geometry["openings"] = {
        "matched": [_opening_errors(*pair) for pair in matches.pairs],
        "missing": [opening.id for opening in matches.missing],
        "extra": [opening.id for opening in matches.extra],
        "passed": not (matches.missing or matches.extra),
    }
    geometry["opening_dimensions"] = _statistics(matches, DIMENSIONS, level=options.level)
    geometry["opening_positions"] = _statistics(matches, POSITION, level=options.level)
    return Comparison(options.tolerance, not reasons, geometry, reasons=tuple(reasons))


def _overall(candidate: float, reference: float, *, suffix: str, tolerance: float) -> dict[str, Any]:
    """One overall dimension in both facades; `suffix` names the unit of the error."""
    return {
        "candidate": candidate,
        "reference": reference,
        f"error_{suffix}": candidate - reference,
        "relative_error": relative_error(candidate, reference),
        "passed": within_tolerance(candidate, reference, tolerance=tolerance),
    }


def _opening_errors(candidate: Opening, reference: Opening) -> dict[str, Any]:
    """Errors of one opening's size and lower left corner, m: equation 10."""
    errors = {
        f"{name}_error_m": getattr(candidate, name) - getattr(reference, name)
        for name in DIMENSIONS + POSITION
    }
    return {"candidate_id": candidate.id, "reference_id": reference.id, **errors}


def _statistics(matches: OpeningMatches, names: Sequence[str], *, level: float) -> dict[str, Any]:
    """Rows of the paper's tables 3 and 4, m; `None` where no opening matches."""
    errors = [getattr(c, name) - getattr(r, name) for c, r in matches.pairs for name in names]
    if not errors:
        return {"n": 0, **dict.fromkeys(STATISTICS), "level": level, "method": "t"}
    std = standard_deviation(errors)
    interval = t_interval(errors, level=level)
    uncertainty = standard_uncertainty(std, n=len(errors))
    row = (interval.estimate, std, uncertainty, min(errors), max(errors), interval.lower, interval.upper)
    return {"n": len(errors), **dict(zip(STATISTICS, row, strict=True)), "level": level, "method": "t"}


def _name(opening: Opening) -> str:
    """An opening as a reason names it."""
    return (
        f"opening {opening.id} ({opening.kind}, {opening.width:.3f} x {opening.height:.3f} m "
        f"at x = {opening.x:.3f}, z = {opening.z:.3f})"
    )
