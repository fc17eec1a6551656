"""The joint between ground and wall: what it does to a wall over a trough."""

from collections.abc import Mapping
from typing import Any

from solvers import BaseKind, equivalent_beam_check
from structural.walls import FAILED, GENTLE

HEADS = (
    "base",
    "largest σ1, MPa",
    "bay strain, ‰",
    "class by strain",
    "largest crack, mm",
    "class by cracks",
    "lifted by, mm",
)


def base_table(record: Mapping[str, Mapping[str, Any]]) -> str:
    """The wall over a trough by its joint with the ground, and the hand check."""
    lines = [f"| {' | '.join(HEADS)} |", "|---|" + "---:|" * (len(HEADS) - 1)]
    for kind in BaseKind:
        run = record[f"trough {kind.value} 0.25"]
        if FAILED in run:
            lines.append(f"| {kind.value} | {run[FAILED].partition(':')[0]} | | | | | |")
            continue
        cells = [
            f"{run['sigma_all'] / 1e6:.2f}",
            f"{1e3 * run['strain']:.3f}",
            f"{run['strain_class']}",
            f"{1e3 * run['opening']:.2f}",
            f"{run['crack_class']}",
            f"{1e3 * run['gap']:.2f}",
        ]
        lines.append(f"| {kind.value} | {' | '.join(cells)} |")
    check = equivalent_beam_check(GENTLE, extent=(0.0, 9.0), height=6.0)
    beam = f"{1e3 * check.tensile_strain:.3f} | {int(check.damage_class)}"
    lines.append(f"| equivalent beam, by hand | | {beam} | | | |")
    return "\n".join(lines)
