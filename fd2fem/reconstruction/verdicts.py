"""What a gap is: equation 1, and what its shape, its like and the rays say, joined into one confidence.

Equation 1 (size and height to length ratio) and rectangularity are conditions. What remains is weighed as
log-odds, each piece of evidence adding its share; the weights are judgements, not statistics, chosen so that
no single piece but a shadow, or something seen inside, decides against the others.
"""

from dataclasses import dataclass

import numpy as np

from fd2fem.model import HoleKind
from fd2fem.reconstruction.options import ReconstructionOptions

__all__ = ["Evidence", "equation_1", "weigh"]

PRIOR = 1.0
"""Log-odds of an opening once equation 1 and rectangularity hold."""
SQUARE = 4.0
"""For each unit of rectangularity over the smallest that is allowed."""
ALIKE, MOST_ALIKE = 0.7, 2.0
"""For each gap of the same size in its row or column, and at the most."""
SEEN = 4.0
"""When something was seen inside or behind, in full from `ENOUGH` of the cells on."""
ENOUGH = 0.3
GLASS = 1.5
"""When rays that nothing stopped came back from nowhere, as from glass."""
NOTHING_INSIDE = -3.0
"""When nothing was seen inside, while other gaps of the scan show their insides."""
SHADOW = -8.0
"""When a shadow covers it all."""
FAILED = -3.0
"""When equation 1 or rectangularity do not hold."""


@dataclass(frozen=True)
class Evidence:
    """What speaks of one gap.

    Attributes
    ----------
    length, height : float, m
    rectangularity : float
        Share of its rectangle that it fills.
    in_shadow : float
        Share that is hidden from every station and was not seen through.
    seen_through : float
        Share behind which something was seen.
    missing : float
        Share that rays aimed at without anything to return them; 0 where the stations are not known.
    others_show : bool
        Whether the scan shows what is behind other gaps.
    alike : int
        Gaps of the same size in its row or column.
    stations : int
        Positions of the scanner that are known.
    at_edge : bool
        Whether it reaches an end or the top of the wall.
    """

    length: float
    height: float
    rectangularity: float
    in_shadow: float = 0.0
    seen_through: float = 0.0
    missing: float = 0.0
    others_show: bool = False
    alike: int = 0
    stations: int = 0
    at_edge: bool = False


def equation_1(height: float, length: float, *, options: ReconstructionOptions) -> str:
    """Why a hole of this size is no opening by equation 1 of the paper, or an empty string if it may be one.

    Parameters
    ----------
    height, length : float, m

    Examples
    --------
    >>> equation_1(1.5, 1.0, options=ReconstructionOptions())
    ''
    >>> equation_1(3.0, 0.2, options=ReconstructionOptions())
    'length 0.20 m is under 0.40 m'
    """
    if length < options.min_opening:
        return f"length {length:.2f} m is under {options.min_opening:.2f} m"
    if height < options.min_opening:
        return f"height {height:.2f} m is under {options.min_opening:.2f} m"
    if height / length < options.min_aspect:
        return f"height/length {height / length:.2f} is under {options.min_aspect:.2f}"
    if height / length > options.max_aspect:
        return f"height/length {height / length:.2f} is over {options.max_aspect:.2f}"
    return ""


def weigh(evidence: Evidence, *, options: ReconstructionOptions) -> tuple[HoleKind, str, float]:
    """Verdict, reason and confidence.

    Examples
    --------
    >>> window = Evidence(length=1.0, height=1.5, rectangularity=1.0, seen_through=0.6, stations=1)
    >>> kind, reason, confidence = weigh(window, options=ReconstructionOptions())
    >>> kind.value, reason, round(confidence, 2)
    ('opening', 'size and shape are those of an opening (equation 1); 60 % of it was seen through', 1.0)
    """
    failed = _failed(evidence, options)
    odds = _log_odds(evidence, options) + (FAILED if failed else 0.0)
    hidden = evidence.in_shadow > options.max_shadow and evidence.seen_through < 0.5 * evidence.in_shadow
    if not failed and not hidden and odds > 0.0:
        return HoleKind.OPENING, _for(evidence), _share(odds)
    reason = failed
    if not reason and hidden:
        what = "in the shadow of things before the wall" if evidence.stations else "behind things on the wall"
        reason = f"{100 * evidence.in_shadow:.0f} % of it lies {what}, and nothing was seen through it"
    if not reason:
        reason = "nothing was seen behind it, while other gaps show what is behind them"
    return HoleKind.OCCLUSION, reason, _share(max(-odds, 0.0))


def _failed(evidence: Evidence, options: ReconstructionOptions) -> str:
    """Which condition does not hold, or an empty string."""
    reason = equation_1(evidence.height, evidence.length, options=options)
    if not reason and evidence.rectangularity < options.min_rectangularity:
        reason = (
            f"fills {int(100 * evidence.rectangularity)} % of its rectangle, "
            f"under {100 * options.min_rectangularity:.0f} %"
        )
    if not reason and evidence.at_edge:
        reason = "it reaches the wall's edge, so that no wall shows all around it"
    return reason


def _log_odds(evidence: Evidence, options: ReconstructionOptions) -> float:
    """Log-odds of an opening."""
    odds = PRIOR + SQUARE * (evidence.rectangularity - options.min_rectangularity)
    odds += min(ALIKE * evidence.alike, MOST_ALIKE)
    odds += SEEN * min(evidence.seen_through / ENOUGH, 1.0)
    odds += GLASS * evidence.missing + SHADOW * evidence.in_shadow
    if evidence.others_show and evidence.seen_through == 0.0 and not evidence.stations:
        odds += NOTHING_INSIDE
    return odds


def _for(evidence: Evidence) -> str:
    """Why a gap is an opening."""
    reasons = ["size and shape are those of an opening (equation 1)"]
    if evidence.seen_through > 0.0:
        reasons.append(f"{100 * evidence.seen_through:.0f} % of it was seen through")
    if evidence.alike:
        reasons.append(f"{evidence.alike} like it in its row or column")
    return "; ".join(reasons)


def _share(odds: float) -> float:
    """Probability of log-odds."""
    return float(1.0 / (1.0 + np.exp(-odds)))
