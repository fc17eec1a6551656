"""Linear elasticity: textbook cases, locking, and CalculiX."""

import json
import shutil
import tempfile
from pathlib import Path

import elastic_benchmarks as benchmarks
import numpy as np
from exported_meshes import hexahedra, hexahedra20, load_case, options_for, tetrahedra

from fd2fem.meshing import write_mesh
from fd2fem.model import ElementKind, VolumeMesh
from solvers import AnalysisOptions, LinearSettlement, Material, analyse
from solvers.calculix.check import compare_with_calculix
from solvers.calculix.files import run_calculix
from solvers.fem.elements import ElementType
from structural.rows import ORACLES, Row, Rows, read_targets

CALCULIX_ELEMENTS = {
    "C3D8": ElementType.HEXAHEDRON8,
    "C3D8I": ElementType.INCOMPATIBLE,
}
"""What is not the default."""
ELEMENTS = (ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE, ElementType.TETRA10)


def textbook_rows() -> Rows:
    """Benchmarks with a printed or analytic target."""
    values, patch = read_targets("benchmarks"), read_targets("structural")["patch_test"]
    expected = [patch["direct_stress"]] * 3 + [patch["shear_stress"]] * 3
    for element in (ElementType.HEXAHEDRON20, ElementType.INCOMPATIBLE):
        stress = benchmarks.patch_test(patch["inner_nodes"], element)
        worst = float(np.abs(stress - expected).max()) / patch["direct_stress"]
        yield Row(f"patch test, {element.value}, largest relative difference", "MacNeal & Harder", 0.0, worst)
    cases = {"le1": benchmarks.nafems_le1, "le10": benchmarks.nafems_le10, "le11": benchmarks.nafems_le11}
    for name, case in cases.items():
        target = values[name]["stress"] / 1e6
        for element in ELEMENTS:
            yield Row(f"{name.upper()}, {element.value}, MPa", "NAFEMS", target, case(element) / 1e6)
    for element in ELEMENTS:
        found = benchmarks.kirsch(element)
        yield Row(
            f"plate with a hole, {element.value}, stress factor", "Kirsch", values["kirsch"]["factor"], found
        )
    growth = benchmarks.corner_growth(16)
    yield Row("re-entrant corner, growth per halving", "Williams", values["corner"]["growth"], growth)


CANTILEVER_TEXT = """\
Tip deflection of a cantilever of ten cubes (20, 40, 80) under a spread load, ν = 0, over Timoshenko's,
with 1, 2, 4 and 8 elements over its depth. Plain 8-node elements lock: one over the depth is 1 + (length
/ depth)² / 2 = 1.5 times too stiff (its own length and depth), which leaves two thirds."""


def cantilever_table() -> str:
    """Tip deflection over the exact one, by element and number of elements over the depth."""
    counts = (1, 2, 4, 8)
    lines = ["| Element | " + " | ".join(map(str, counts)) + " |", "|---|" + "---:|" * len(counts)]
    for element in (ElementType.HEXAHEDRON8, *ELEMENTS):
        found = [benchmarks.cantilever(element, count) for count in counts]
        lines.append(f"| {element.value} | " + " | ".join(f"{value:.3f}" for value in found) + " |")
    return "\n".join(lines)


def calculix_rows() -> Rows:
    """The same mesh and loads in CalculiX; differences relative to the largest value of the quantity."""
    recorded = json.loads((ORACLES / "calculix_wall.json").read_text(encoding="utf-8"))
    material, settlement = Material(**recorded["material"]), LinearSettlement(**recorded["settlement"])
    for case in recorded["cases"]:
        mesh = VolumeMesh(
            np.array(case["nodes"]),
            np.array(case["elements"]),
            ElementKind(case["kind"]),
            {"base": np.array(case["base"])},
        )
        options = AnalysisOptions(
            material=material, settlement=settlement, element=CALCULIX_ELEMENTS.get(case["element"])
        )
        displacement, stress = benchmarks.wall_state(mesh, options, np.array(case["stress_at"]))
        for quantity, ours in (("displacement", displacement), ("stress", stress)):
            theirs = np.array(case[quantity])
            worst = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
            yield Row(f"{case['element']}, {quantity}", "CalculiX 2.20, recorded", 0.0, worst)
    if shutil.which("ccx"):
        yield from _live_rows()


def _live_rows() -> Rows:
    """A wall with a window, run by the CalculiX that is installed."""
    wall = hexahedra(parts=2)
    meshes = {"C3D8": wall, "C3D20": hexahedra20(wall), "C3D10": tetrahedra(wall)}
    for name, mesh in meshes.items():
        options = options_for("trough", element=CALCULIX_ELEMENTS.get(name))
        with tempfile.TemporaryDirectory() as folder:
            deck = Path(folder) / "wall.inp"
            write_mesh(mesh, deck, case=load_case(mesh, options))
            result = run_calculix(deck)
        check = compare_with_calculix(analyse(mesh, options=options), result, options=options)
        for difference in check.differences:
            if difference.quantity in {"displacement", "stress"}:
                case = f"{name}, {difference.quantity}, {len(mesh.elements)} elements"
                yield Row(case, f"CalculiX {result.version}, run", 0.0, difference.relative)
