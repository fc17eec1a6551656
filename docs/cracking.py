"""Run walls that crack, draw them, and write `cracking.md` with its pictures: `python docs/cracking.py`.

Some fifteen minutes on two cores. `--states FOLDER` keeps what is drawn, and does not run a wall again that
is there. `--finest` runs the walls of 1/12 m as well, which takes as long again. The figures go to
`structural/walls.json`.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

# The folder beside this file had to be put on the path first: hence E402.
from structural.building import building_summary, energy_table  # noqa: E402
from structural.joints import base_table  # noqa: E402
from structural.pictures import foot_figure, overlap  # noqa: E402
from structural.rows import read_json  # noqa: E402
from structural.walls import (  # noqa: E402
    RECORD,
    Case,
    Run,
    building_cases,
    read_run,
    run_case,
    trough_cases,
    write_run,
)

PAGE = HERE / "cracking.md"
TEMPLATE = HERE / "structural" / "cracking_template.md"
FINEST = 1 / 12


def run_cases(cases: Mapping[str, Case], folder: Path) -> dict[str, Any]:
    """Figures of all cases; runs those that have left nothing in the folder."""
    record: dict[str, Any] = read_json(RECORD) if RECORD.exists() else {}
    for name, case in cases.items():
        state = state_file(folder, name)
        failed = state.with_suffix(".failed")
        if name in record and (state.exists() or failed.exists()):
            continue
        record[name], run = run_case(case)
        if run is None:
            failed.touch()
        else:
            write_run(run, state)
        RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return record


def state_file(folder: Path, name: str) -> Path:
    """Where the state of a case is kept."""
    return folder / f"{name.replace(' ', '_')}.npz"


def draw(folder: Path) -> dict[str, float]:
    """Draw all pictures; how well the cracks of two meshes overlap, by reading."""
    states: dict[str, Run] = {}
    for letter in "ab":
        for size in ("0.25", "0.125"):
            states[f"{letter}, {size} m"] = read_run(state_file(folder, f"building1 {letter} {size}"))
    foot_figure(states, HERE / "cracking_building1.png", width=0.425, height=1.0)
    return {letter: overlap(states[f"{letter}, 0.25 m"], states[f"{letter}, 0.125 m"]) for letter in "ab"}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what is missing, draw, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=Path, help="folder that keeps the states")
    parser.add_argument("--finest", action="store_true", help="run the walls of 1/12 m as well")
    options = parser.parse_args(arguments)
    cases = building_cases() | trough_cases()
    if not options.finest:
        cases = {name: case for name, case in cases.items() if case.size > FINEST}
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.states or Path(temporary)
        record = run_cases(cases, folder)
        overlaps = draw(folder)
    page = TEMPLATE.read_text(encoding="utf-8").format(
        overlap_a=100 * overlaps["a"],
        overlap_b=100 * overlaps["b"],
        summary=building_summary(record),
        energies=energy_table(record),
        bases=base_table(record),
    )
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
