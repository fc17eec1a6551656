"""What the user is told: progress and warnings on stderr, the summary of a run, how a comparison ended."""

import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fd2fem.model import Comparison, Facade, Response, RunResult

if TYPE_CHECKING:
    from solvers.calculix.check import CalculixCheck

__all__ = [
    "DONE",
    "SHORT",
    "Say",
    "Summary",
    "progress",
    "response_words",
    "run_summary",
    "tell_check",
    "tell_verdict",
    "warn",
]

DONE, SHORT = 0, 1
"""Exit codes: done; a comparison falls short."""

Summary = dict[str, Any]
Say = Callable[[str], None]


def progress(*, quiet: bool) -> Say:
    """A function that tells the user what is going on, unless that is not wanted."""

    def say(text: str) -> None:
        if not quiet:
            sys.stderr.write(f"fd2fem: {text}\n")
            sys.stderr.flush()

    return say


def warn(*results: Facade | Response) -> None:
    """What the user must know even when progress is not wanted."""
    for result in results:
        record = result.record if isinstance(result, Facade) else result.solver
        for warning in record.get("warnings", ()):
            sys.stderr.write(f"fd2fem: warning: {warning}\n")


def run_summary(result: RunResult, folder: Path) -> Summary:
    """What a run tells on stdout."""
    from fd2fem.report import facade_summary
    from solvers import response_to_dict
    from validation import comparison_to_dict

    summary: Summary = {
        "output": str(folder),
        "facade": facade_summary(result.reconstruction.facade),
        "solid": dict(result.solid),
        "mesh": asdict(result.quality),
        "response": response_to_dict(result.response),
        "timings_s": dict(result.timings),
    }
    if result.comparison is not None:
        summary["comparison"] = comparison_to_dict(result.comparison)
    return summary


def response_words(response: Response) -> str:
    """The figures of a response that a user looks at first."""
    words = (
        f"largest displacement {1000 * response.max_displacement:.1f} mm, largest principal stress "
        f"{response.max_principal_stress / 1e6:.3f} MPa"
    )
    if response.history:
        final = response.final_principal_stress / 1e6
        words += f" at the integration points of all steps ({final:.3f} in the last one)"
    if response.knows_cracks:
        words += f", cracks up to {1000 * response.max_crack_opening:.2f} mm: damage class "
        words += f"{response.damage_class}, {response.damage['crack_label']}"
    return words


def tell_verdict(say: Say, comparison: Comparison) -> int:
    """Say how a comparison ended, and give its exit code."""
    for note in comparison.notes:
        say(f"note: {note}")
    if comparison.passed:
        say(f"within {100 * comparison.tolerance:g} % of the reference")
        return DONE
    for reason in comparison.reasons:
        sys.stderr.write(f"fd2fem: falls short: {reason}\n")
    return SHORT


def tell_check(say: Say, check: "CalculixCheck") -> int:
    """Say how a check by CalculiX ended, and give its exit code."""
    for difference in check.differences:
        says = (
            f"{difference.quantity} differs from CalculiX's by at most {difference.relative:.1e} of its "
            f"largest, {difference.scale:.4g} {difference.unit} ({difference.place})"
        )
        if difference.relative > check.limit:
            sys.stderr.write(f"fd2fem: falls short: {says}, more than {check.limit:g}\n")
        else:
            say(says)
    say(f"CalculiX {check.version} took {check.seconds:.2f} s, our own analysis {check.own_seconds:.2f} s")
    return DONE if check.passed else SHORT
