"""Running CalculiX on a deck, and reading what it answers."""

import os
import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError, NumericsError
from fd2fem.model.checks import as_array
from solvers.calculix.tables import last_table

__all__ = ["CalculixResult", "find_calculix", "run_calculix"]

FloatArray = NDArray[np.float64]

MISSING = "CalculiX is not installed: apt-get install calculix-ccx, or leave out --check."
NAME = re.compile(r"ccx_(\d+)\.(\d+)(_\w+)?(\.exe)?", re.IGNORECASE)
"""Programs built from the source are called ccx_2.20, ccx_2.22_MT, …"""

FINISHED = "Job finished"
END = "*END STEP"
STRESS_REQUEST = "*EL PRINT, ELSET=WALL\nS\n"
LONGEST_RUN = 24 * 3600.0


@dataclass(frozen=True, eq=False)
class CalculixResult:
    """What CalculiX printed at the end of the last step, to seven digits.

    Attributes
    ----------
    displacement : (n, 3) float array, m
    stress : (e, q, 6) float array, Pa
        xx, yy, zz, xy, yz, xz at the q integration points of each element, in CalculiX's order.
    base : (k,) int array
        Nodes of the set BASE, from 0.
    force : (k, 3) float array, N
        Of the stresses on these nodes: their reactions, less the weight that falls on them.
    total_force : (3,) float array, N
    version : str
    seconds : float
        Wall time of the whole run.
    """

    displacement: FloatArray
    stress: FloatArray
    base: NDArray[np.intp]
    force: FloatArray
    total_force: FloatArray
    version: str
    seconds: float

    def __post_init__(self) -> None:
        k = len(self.base)
        shapes = {"displacement": (None, 3), "stress": (None, None, 6), "force": (k, 3), "total_force": (3,)}
        for name, shape in shapes.items():
            object.__setattr__(self, name, as_array(name, getattr(self, name), shape))
        object.__setattr__(self, "base", as_array("base", self.base, (k,), dtype=np.intp))


def find_calculix() -> Path:
    """The program: what the environment variable CCX names, else ``ccx`` or the newest ``ccx_2.…`` on PATH.

    Raises
    ------
    InputError
        If there is none.
    """
    named = os.environ.get("CCX")
    if named:
        program = shutil.which(named)
        if program is None:
            msg = f"The environment variable CCX names {named}, which is no program: correct or unset it."
            raise InputError(msg)
        return Path(program).absolute()
    program = shutil.which("ccx") or shutil.which(_newest_name())
    if program is None:
        raise InputError(MISSING)
    return Path(program).absolute()


def run_calculix(deck: Path, *, timeout: float = LONGEST_RUN) -> CalculixResult:
    """Run CalculiX on a deck, in a folder of its own that is removed afterwards.

    Parameters
    ----------
    deck : Path
        Whole analysis as ``write_mesh`` of fd2fem.meshing writes it with a load case. A request for the
        stresses at the integration points is added to the copy that is run: other uses need it not.
    timeout : float, s

    Raises
    ------
    InputError
        If CalculiX is not installed, or the deck is not there or no whole analysis.
    NumericsError
        If CalculiX stops with an error, takes too long or does not print the results.
    """
    program = find_calculix()
    text = _with_stresses(deck)
    with tempfile.TemporaryDirectory(prefix="fd2fem-calculix-") as name:
        folder = Path(name)
        (folder / "wall.inp").write_text(text, encoding="ascii", newline="\n")
        start = time.perf_counter()
        log = _run(program, folder, timeout)
        seconds = time.perf_counter() - start
        try:
            printed = (folder / "wall.dat").read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError) as error:
            msg = f"CalculiX ({program}) printed no results that can be read ({error})."
            raise NumericsError(msg) from error
    found = re.search(r"CalculiX Version (\S+?),", log)
    return read_results(printed, version=found[1] if found else "unknown", seconds=seconds)


def read_results(printed: str, *, version: str, seconds: float) -> CalculixResult:
    """The last step's results in the text of a ``.dat`` file.

    Raises
    ------
    NumericsError
        If a table is missing, damaged or holds a value that is not finite.
    """
    displacement = last_table(printed, "displacements", columns=4)
    forces = last_table(printed, "forces", columns=4)
    stresses = last_table(printed, "stresses", columns=8)
    elements = int(np.count_nonzero(stresses[:, 1] == 1.0))
    points = len(stresses) // max(elements, 1)
    place = np.column_stack([np.repeat(np.arange(elements), points), np.tile(np.arange(points), elements)])
    in_order = len(place) == len(stresses) and np.array_equal(stresses[:, :2], place + 1)
    if not in_order or not np.array_equal(displacement[:, 0], np.arange(1, len(displacement) + 1)):
        msg = "CalculiX did not print all nodes and elements in the order of the deck: nothing to compare."
        raise NumericsError(msg)
    return CalculixResult(
        displacement=displacement[:, 1:],
        # CalculiX prints xx, yy, zz, xy, xz, yz.
        stress=stresses[:, [2, 3, 4, 5, 7, 6]].reshape(elements, points, 6),
        base=forces[:, 0].astype(np.intp) - 1,
        force=forces[:, 1:],
        total_force=last_table(printed, "total force", columns=3)[0],
        version=version,
        seconds=seconds,
    )


def _newest_name() -> str:
    """The ``ccx_2.…`` of the highest version in the folders of PATH; "ccx" if there is none."""
    newest, name = (0, 0), "ccx"
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        for path in Path(folder).glob("ccx_*") if folder else ():
            match = NAME.fullmatch(path.name)
            if match and (int(match[1]), int(match[2])) > newest:
                newest, name = (int(match[1]), int(match[2])), path.name
    return name


def _with_stresses(deck: Path) -> str:
    """Text of a deck whose last step also asks for the stresses at the integration points."""
    try:
        text = Path(deck).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as error:
        msg = f"{deck} cannot be read ({error})."
        raise InputError(msg) from error
    before, end, after = text.rpartition(END)
    if not end:
        msg = f"{deck} holds no step of an analysis: write it with a load case."
        raise InputError(msg)
    return before + STRESS_REQUEST + end + after


def _run(program: Path, folder: Path, timeout: float) -> str:
    """Run the program on ``wall.inp``; what it says."""
    # CalculiX reads a name without a suffix, and writes beside it.
    command = [str(program), "-i", "wall"]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=timeout,
            check=False,
            text=True,
            errors="replace",
        )
    except subprocess.TimeoutExpired as error:
        msg = f"CalculiX ({program}) did not finish within {timeout:g} s: take larger elements."
        raise NumericsError(msg) from error
    except OSError as error:
        msg = f"{program} cannot be run ({error.strerror or error}): install calculix-ccx, or correct CCX."
        raise InputError(msg) from error
    # It may end with 0 after an error.
    if done.returncode != 0 or FINISHED not in done.stdout or "*ERROR" in done.stdout:
        msg = f"CalculiX ({program}) failed with exit code {done.returncode}: {_complaint(done.stdout)}"
        raise NumericsError(msg)
    return done.stdout


def _complaint(log: str) -> str:
    """What a log says went wrong, in one line: its first error with the lines that belong to it."""
    lines = [line.strip() for line in log.splitlines()]
    start = next((k for k, line in enumerate(lines) if line.startswith("*ERROR")), None)
    if start is None:
        last = [line for line in lines if line][-1:]
        return f"its last line is {last[0]!r}." if last else "it said nothing."
    end = next((k for k in range(start, len(lines)) if not lines[k]), len(lines))
    return " ".join(lines[start:end])[:300].rstrip(".") + "."
