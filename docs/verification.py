"""Run the benchmarks of the structural half and write `verification.md`: `python docs/verification.py`.

Targets and their sources are in `tests/oracles/`; what is computed is what the tests compute. The walls that
crack take half an hour: their figures are those of `structural/walls.json`, which `docs/cracking.py` writes.
"""

import sys
from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]

# The cases are those of the tests, whose folder had to be put on the path first: hence E402.
from structural.at_point import program_rows, strength_rows  # noqa: E402
from structural.building import BUILDING_TEXT, building_table, mesh_tables  # noqa: E402
from structural.convergence import STUDIES, STUDY_TEXT, run_study, study_table  # noqa: E402
from structural.elastic import CANTILEVER_TEXT, calculix_rows, cantilever_table, textbook_rows  # noqa: E402
from structural.ground import damage_rows, trough_rows  # noqa: E402
from structural.rows import Rows, read_json, table  # noqa: E402
from structural.structures import structure_rows  # noqa: E402
from structural.walls import RECORD  # noqa: E402

PAGE = HERE / "verification.md"

INTRODUCTION = """\
# Verification of the structural half

Written by `python docs/verification.py`, which runs every case but the walls that crack; their figures are
recorded by `python docs/cracking.py`. The targets come from outside this code: closed forms, published
benchmarks, other programs. They and their sources in full are in `tests/oracles/`; the same cases, with their
tolerances, are tests in `tests/solvers/`.

The difference is relative to the target, or absolute where that is 0. A crack that is "implicit" softens
within a step; with "implex", the strength is foretold from the step before, as in the analysis of a wall.
Elements are 20-node hexahedra in the sphere, 8-node ones with incompatible modes in bar and beam. A case that
finds no equilibrium is "nan".
"""

TABLES: dict[str, Callable[[], Rows]] = {
    "Masonry at a point: closed forms": strength_rows,
    "Masonry at a point: other programs": program_rows,
    "Linear elasticity: textbooks": textbook_rows,
    "Linear elasticity: CalculiX, same mesh and loads, largest relative difference": calculix_rows,
    "Structures that crack or yield": structure_rows,
    "Ground": trough_rows,
    "Damage": damage_rows,
}


def convergence_section() -> str:
    """The mesh convergence studies."""
    parts = [STUDY_TEXT]
    for study in STUDIES:
        parts.append(f"{study.title}:\n\n{study_table(run_study(study))}\n")
    return "\n".join(parts)


def main() -> None:
    """Run all cases and write the page."""
    parts = [INTRODUCTION]
    for title, rows in TABLES.items():
        parts.append(f"## {title}\n\n{table(rows())}\n")
    parts.append(f"## Locking\n\n{CANTILEVER_TEXT}\n\n{cantilever_table()}\n")
    parts.append(f"## Mesh convergence: elastic walls\n\n{convergence_section()}")
    record = read_json(RECORD)
    parts.append(f"## Mesh convergence: walls that crack\n\n{mesh_tables(record)}\n")
    parts.append(f"## The paper's Building 1\n\n{BUILDING_TEXT}\n\n{building_table(record)}\n")
    PAGE.write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
