"""The paper's Building 1 and the walls that crack, from recorded figures."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from structural.rows import read_targets

Record = Mapping[str, Mapping[str, Any]]

BUILDING_TEXT = """\
The stand-in of Building 1, whose dimensions and openings' number and area are the paper's, under the
paper's settlement in 50 steps. The paper does not say which end moves more to the side: reading a has the
horizontal movement largest where the settlement is (28.3 mm at x = 0), reading b at the other end.
Stresses are those at integration points; "left" and "right" are the forces of the ground under the two
piers beside the door. The figures are recorded in `structural/walls.json`; `python docs/cracking.py` runs
the walls anew. What they mean is said in [`cracking.md`](cracking.md)."""


def difference(first: Mapping[str, Any], second: Mapping[str, Any], foot: int) -> float:
    """Of the force under a foot, relative to its magnitude in the second."""
    ours, theirs = np.array(first["feet"][foot]), np.array(second["feet"][foot])
    return float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs))


def building_table(record: Record) -> str:
    """Building 1 at two sizes and under both readings, beside the paper's figures."""
    target = read_targets("benchmarks")["building_1"]
    paper = {
        "displacement": [1e3 * value for value in target["displacement"]],
        "sigma_last": [value / 1e6 for value in target["principal_stress"]],
    }
    runs = [record[f"building1 {letter} {size}"] for letter in "ab" for size in ("0.25", "0.125")]
    lines = [
        "| | paper, CAD | paper, scan | a, 0.25 m | a, 0.125 m | b, 0.25 m | b, 0.125 m |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, key, scale, digits in LINES:
        printed = [f"{value:g}" for value in paper.get(key, ())] or ["", ""]
        found = [f"{scale * run[key]:.{digits}f}" for run in runs]
        lines.append(f"| {name} | {' | '.join(printed + found)} |")
    for foot, name in enumerate(("left", "right")):
        found = [_force(run["feet"][foot]) for run in runs]
        lines.append(f"| {name}: along the wall, upwards, kN | | | {' | '.join(found)} |")
        pairs = [f" | {100 * difference(runs[i], runs[i + 1], foot):.2f} %" for i in (0, 2)]
        lines.append(f"| {name}: difference of the two meshes | | | {' | '.join(pairs)} |")
    return "\n".join(lines)


LINES = (
    ("elements", "elements", 1, 0),
    ("largest displacement, mm", "displacement", 1e3, 2),
    ("largest σ1 in the last step, MPa", "sigma_last", 1e-6, 3),
    ("largest σ1 of all steps, MPa", "sigma_all", 1e-6, 3),
    ("σ1, 99 % by volume, MPa", "sigma_p99", 1e-6, 3),
    ("dissipated energy, J", "dissipated", 1, 1),
    ("largest crack, mm", "opening", 1e3, 2),
)


def _force(force: list[float]) -> str:
    return f"{force[0] / 1e3:.2f}, {force[2] / 1e3:.2f}"


MESH_LINES = (
    ("elements", "elements", 1.0),
    ("largest displacement, mm", "displacement", 1e3),
    ("σ1, root mean square, MPa", "sigma_rms", 1e-6),
    ("σ1, 99 % by volume, MPa", "sigma_p99", 1e-6),
    ("largest σ1, MPa", "sigma_last", 1e-6),
    ("strain energy, J", "strain_energy", 1.0),
    ("dissipated energy, J", "dissipated", 1.0),
    ("largest crack, mm", "opening", 1e3),
)


def mesh_table(record: Record, wall: str) -> str:
    """Figures of a wall on the meshes that it was run on."""
    runs = {size: record[f"{wall} {size}"] for size in SIZES if f"{wall} {size}" in record}
    lines = [f"| | {' | '.join(f'{size} m' for size in runs)} |", "|---|" + "---:|" * len(runs)]
    for name, key, scale in MESH_LINES:
        found = " | ".join(f"{scale * run[key]:.5g}" for run in runs.values())
        lines.append(f"| {name} | {found} |")
    for foot, name in enumerate(("left", "right")):
        forces = " | ".join(_force(run["feet"][foot]) for run in runs.values())
        lines.append(f"| force under the {name} half: along, up, kN | {forces} |")
    return "\n".join(lines)


SIZES = ("0.25", "0.175", "0.125", "0.08333")


def building_summary(record: Record) -> str:
    """What counts of both readings, on both meshes, in a short table."""
    lines = ["| | a, 0.25 m | a, 0.125 m | b, 0.25 m | b, 0.125 m |", "|---|---:|---:|---:|---:|"]
    runs = [record[f"building1 {letter} {size}"] for letter in "ab" for size in ("0.25", "0.125")]
    for name, key, scale, digits in LINES[1:]:
        lines.append(f"| {name} | " + " | ".join(f"{scale * run[key]:.{digits}f}" for run in runs) + " |")
    return "\n".join(lines)


ENERGIES = (1, 50, 100, 200)
"""Fracture energies that Building 1 was run with at 0.25 m, N/m."""


def energy_table(record: Record) -> str:
    """Building 1 at 0.25 m, reading a, with several fracture energies."""
    heads = " | ".join(f"{energy / 1e3:g} N/mm" for energy in ENERGIES)
    lines = [f"| | {heads} |", "|---|" + "---:|" * len(ENERGIES)]
    # 100 N/m is the default.
    names = ["building1 a 0.25" + ("" if energy == 100 else f" Gf {energy}") for energy in ENERGIES]
    for name, key, scale, digits in LINES[1:]:
        lines.append(f"| {name} | {' | '.join(f'{scale * record[n][key]:.{digits}f}' for n in names)} |")
    forces = " | ".join(_force(record[name]["feet"][0]) for name in names)
    lines.append(f"| force under the left pier: along the wall, upwards, kN | {forces} |")
    return "\n".join(lines)


MESH_TEXT = """\
Building 1 on meshes of their own: the mesher divides piers and wall anew, so that no order can be drawn
from them. The largest displacement changes by 0.02 %, strain energy by 2 to 4 %. The upward forces follow
from equilibrium; the force along the wall approaches a value from one side, the more slowly in reading b,
where it has changed by 4 % from 0.175 to 0.125 m. Dissipated energy has fallen by 5 % (a) and 3 % (b)
there. Percentile and root mean square of σ1 have not settled: what is stressed in the last step is what
lies near the cracks. The largest σ1 is bounded by the strength and has no limit of its own, nor has the
largest crack in reading b, which runs through two rows of elements, however high."""


def mesh_tables(record: Record) -> str:
    """The walls that were run on several meshes."""
    parts = [MESH_TEXT]
    for letter in "ab":
        parts.append(f"Building 1, reading {letter}:\n\n{mesh_table(record, f'building1 {letter}')}")
    return "\n\n".join(parts)
