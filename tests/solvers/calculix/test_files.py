"""The check against CalculiX: what it reads and finds, and what it says when CalculiX is missing or fails.

``oracles/calculix_*.dat`` were printed by CalculiX 2.20 (Debian package calculix-ccx) for the decks of
`_block`, the stress request of `run_calculix` included.
"""

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from exported_meshes import all_kinds, hexahedra20, load_case, options_for
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fd2fem.errors import InputError, NumericsError
from fd2fem.meshing import quadratic_mesh, write_mesh
from solvers import AnalysisOptions, LinearSettlement, analyse
from solvers.calculix.check import check_to_dict, compare_with_calculix, write_check
from solvers.calculix.files import find_calculix, read_results, run_calculix
from solvers.calculix.tables import last_table
from solvers.fem.elements import ElementType
from solvers.masonry import MasonryLaw
from solvers.steps.supports import BaseKind, BaseOptions

ORACLES = Path(__file__).parents[2] / "oracles"
KINDS = ["hexahedron8", "hexahedron20", "tetra10"]
QUANTITIES = ["displacement", "stress", "reaction", "total reaction"]

needs_ccx = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="needs CalculiX (Debian and Ubuntu: calculix-ccx)"
)
needs_shell = pytest.mark.skipif(os.name != "posix", reason="the stand-in for CalculiX is a shell script")


def _block(grid, tetrahedra, kind):
    """A crooked block of one hexahedron, or six tetrahedra, whose stresses vary in every direction."""
    mesh = grid([0, 1], [0, 0.6], [0, 1.3], warp=0.05)
    options = options_for("linear", element=ElementType(kind if kind == "hexahedron8" else "hexahedron20"))
    return {"hexahedron8": mesh, "hexahedron20": hexahedra20(mesh), "tetra10": tetrahedra(mesh)}[
        kind
    ], options


@pytest.fixture(params=KINDS)
def block(request, grid, tetrahedra):
    """Response to what CalculiX was asked, and its recorded answer."""
    mesh, options = _block(grid, tetrahedra, request.param)
    printed = (ORACLES / f"calculix_{request.param}.dat").read_text(encoding="ascii")
    return analyse(mesh, options=options), read_results(printed, version="2.20", seconds=1.0), options


@pytest.fixture
def hexahedron(grid, tetrahedra):
    """The same of the 20-node hexahedron."""
    mesh, options = _block(grid, tetrahedra, "hexahedron20")
    printed = (ORACLES / "calculix_hexahedron20.dat").read_text(encoding="ascii")
    return analyse(mesh, options=options), read_results(printed, version="2.20", seconds=1.0), options


def test_recorded_answers(block):
    response, result, options = block
    check = compare_with_calculix(response, result, options=options)
    assert check.passed
    assert [difference.quantity for difference in check.differences] == QUANTITIES
    for difference in check.differences:
        # Nothing differs but the digits that were not printed.
        assert difference.relative < 1.1 * difference.resolution
        assert difference.resolution <= 5e-7
    assert (check.nodes, check.elements) == (len(response.mesh.nodes), len(response.mesh.elements))
    assert check.points == check.elements * {8: 8, 20: 27, 10: 4}[response.mesh.kind.nodes]


def test_what_is_read(hexahedron):
    """Some values by eye, of the last step's tables."""
    _, result, _ = hexahedron
    printed = (ORACLES / "calculix_hexahedron20.dat").read_text(encoding="ascii")
    assert result.displacement.shape == (20, 3)
    assert result.stress.shape == (1, 27, 6)
    row = printed[printed.index(" stresses (") :].splitlines()[3].split()
    assert row[:2] == ["1", "2"]
    # sxx, syy, szz, sxy, sxz, syz become xx, yy, zz, xy, yz, xz.
    assert result.stress[0, 1].tolist() == [float(row[k]) for k in (2, 3, 4, 5, 7, 6)]
    assert len(result.base) == 8
    assert result.force.sum(axis=0) == pytest.approx(result.total_force, abs=1.0)


@pytest.mark.parametrize(
    ("name", "place"),
    [("displacement", (7, 1)), ("stress", (0, 13, 4)), ("force", (3, 0)), ("total_force", 2)],
)
@pytest.mark.parametrize(("size", "passes"), [(0.3e-6, True), (2e-6, False)])
def test_a_difference_is_found(hexahedron, name, place, size, passes):
    response, result, options = hexahedron
    values = getattr(result, name).copy()
    values[place] += size * np.abs(values).max()
    check = compare_with_calculix(response, replace(result, **{name: values}), options=options)
    assert check.passed == passes
    if not passes:
        quantity = {"force": "reaction", "total_force": "total reaction"}.get(name, name)
        assert check.worst.quantity == quantity
        assert check.worst.relative == pytest.approx(2e-6, rel=0.2)
        node = f"node {response.mesh.group_nodes('base')[3] + 1}"
        places = {"displacement": "node 8", "stress": "element 1, integration point 14", "reaction": node}
        assert check.worst.place == places.get(quantity, "sum over the base")


def test_a_response_of_the_corners_is_compared_too(hexahedron, grid):
    """An 8-node mesh is analysed with 20-node elements: its own displacements count as well."""
    full, result, options = hexahedron
    response = analyse(grid([0, 1], [0, 0.6], [0, 1.3], warp=0.05), options=options)
    assert compare_with_calculix(response, result, options=options, full=full).passed
    moved = response.displacement.copy()
    moved[5, 2] += 2e-6 * np.abs(result.displacement).max()
    check = compare_with_calculix(replace(response, displacement=moved), result, options=options, full=full)
    assert not check.passed
    assert check.worst.place == "node 6"
    reaction = response.reaction * (1 + 2e-6)
    check = compare_with_calculix(replace(response, reaction=reaction), result, options=options, full=full)
    assert not check.passed
    assert check.worst.quantity == "total reaction"
    elsewhere = replace(response, mesh=grid([0, 2], [0, 1], [0, 1]))
    with pytest.raises(InputError, match="of 20 nodes and 1 elements of 27 points"):
        compare_with_calculix(elsewhere, result, options=options, full=full)


def test_json(hexahedron, tmp_path):
    response, result, options = hexahedron
    check = compare_with_calculix(response, result, options=options)
    write_check(check, tmp_path / "calculix.json")
    read = json.loads((tmp_path / "calculix.json").read_text(encoding="utf-8"))
    assert read == check_to_dict(check)
    assert read["schema"] == "fd2fem/calculix-1"
    assert read["passed"] is True
    assert (read["limit"], read["printed_digits"], read["version"]) == (1e-6, 7, "2.20")
    assert [row["quantity"] for row in read["differences"]] == QUANTITIES
    assert all(row["relative"] <= row["resolution"] * 1.1 for row in read["differences"])
    assert read["timings_s"]["calculix"] == 1.0
    assert read["timings_s"]["fd2fem"] > 0.0


def test_comparisons_refused(hexahedron, grid, tetrahedra):
    response, result, options = hexahedron
    for other in (AnalysisOptions(masonry=MasonryLaw()), AnalysisOptions(base=BaseOptions(BaseKind.ELASTIC))):
        with pytest.raises(InputError, match="checks only elastic walls that are tied to the ground"):
            compare_with_calculix(response, result, options=other)
    modes = replace(options, element=ElementType.INCOMPATIBLE)
    eight = analyse(grid([0, 1], [0, 0.6], [0, 1.3]), options=modes)
    with pytest.raises(InputError, match="CalculiX has no hexahedra with our incompatible modes: take 20"):
        compare_with_calculix(eight, result, options=modes)
    tetra = analyse(_block(grid, tetrahedra, "tetra10")[0], options=options)
    with pytest.raises(InputError, match=r"1 elements of 27 points, ours of 27, 6 and 4: they must be"):
        compare_with_calculix(tetra, result, options=options)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("stresses", "strains"), "printed no stresses: the deck must ask"),
        (lambda text: text.replace(" displacements (", " velocities ("), "printed no displacements"),
        (lambda text: text[: text.index(" stresses") + 200], "printed no stresses|printed stresses that are"),
        (
            lambda text: text.replace("-1.146196E-02", "          NaN"),
            "displacements that are damaged or not",
        ),
        (lambda text: text.replace("-1.146196E-02", "*************"), "displacements that are no numbers"),
        (lambda text: text.replace("\n         1   2 ", "\n         1   3 "), "in the order of the deck"),
        (lambda text: text.replace("\n         4 ", "\n        44 "), "in the order of the deck"),
    ],
)
def test_damaged_output(change, message):
    printed = (ORACLES / "calculix_hexahedron20.dat").read_text(encoding="ascii")
    changed = change(printed)
    assert changed != printed
    with pytest.raises(NumericsError, match=message) as caught:
        read_results(changed, version="2.20", seconds=1.0)
    assert "\n" not in str(caught.value)


def _fortran(value):
    """A number by the format 1p,e13.6."""
    text = f"{value:.6E}"
    mantissa, exponent = text.split("E")
    tail = f"E{exponent[0]}{int(exponent[1:]):02d}" if abs(int(exponent)) < 100 else f"{int(exponent):+d}"
    return f"{mantissa}{tail}".rjust(13)


@settings(deadline=None)
@given(arrays(float, st.tuples(st.integers(1, 5), st.just(3)), elements=st.floats(-1e300, 1e300)))
def test_every_number_that_fortran_prints(values):
    rows = "".join(f"{k:10d} " + " ".join(map(_fortran, row)) + "\n" for k, row in enumerate(values, 1))
    head = "\n displacements (vx,vy,vz) for set ALL and time  0.1000000E+01\n\n"
    old = head + "         1  9.000000E+00  9.000000E+00  9.000000E+00\n"
    table = last_table(old + head + rows, "displacements", columns=4)
    assert table[:, 0].tolist() == list(range(1, len(values) + 1))
    np.testing.assert_allclose(table[:, 1:], values, rtol=6e-7, atol=1e-307)


def _install(folder, script, name="ccx"):
    """A program of that name."""
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def deck(tmp_path, grid, tetrahedra, monkeypatch):
    mesh, options = _block(grid, tetrahedra, "hexahedron20")
    write_mesh(mesh, tmp_path / "deck.inp", case=load_case(mesh, options))
    monkeypatch.delenv("CCX", raising=False)
    return tmp_path / "deck.inp"


@needs_shell
@pytest.mark.parametrize(
    ("script", "message"),
    [
        (
            "echo ' *ERROR reading *BOUNDARY:'; echo '  node set NO'; echo; echo 'not this'",
            r"failed with exit code 0: \*ERROR reading \*BOUNDARY: node set NO\.",
        ),
        ("echo ' Job finished'; echo ' *ERROR in spooles: singular matrix'", r"\*ERROR in spooles: singular"),
        ("echo ' Job finished'; exit 201", r"failed with exit code 201: its last line is 'Job finished'\."),
        ("kill -9 $$", r"failed with exit code -9: it said nothing\."),
        ("echo ' STEP 1'", r"failed with exit code 0: its last line is 'STEP 1'\."),
        ("echo ' Job finished'", r"printed no results that can be read"),
        ("echo ' Job finished'; echo nothing > wall.dat", "printed no displacements: the deck must ask"),
        ("exec sleep 60", r"did not finish within 1 s: take larger elements\."),
    ],
)
def test_failures(deck, tmp_path, monkeypatch, script, message):
    monkeypatch.setenv("CCX", str(_install(tmp_path / "bin", script)))
    with pytest.raises(NumericsError, match=message) as caught:
        run_calculix(deck, timeout=1.0 if "sleep" in script else 60.0)
    assert "\n" not in str(caught.value)


@needs_shell
def test_what_is_run(deck, tmp_path, monkeypatch):
    """The deck with a request for stresses in its last step, in a folder that is removed."""
    kept = tmp_path / "kept"
    script = (
        f"cp wall.inp {kept}; pwd >> {kept}; cp {ORACLES}/calculix_hexahedron20.dat wall.dat\n"
        "echo 'CalculiX Version 2.99, Copyright'; echo ' Job finished'"
    )
    monkeypatch.setenv("CCX", str(_install(tmp_path / "bin", script)))
    before = deck.read_text()
    result = run_calculix(deck)
    assert result.version == "2.99"
    assert result.seconds > 0.0
    text, _, folder = kept.read_text().rstrip("\n").rpartition("\n")
    assert text.endswith("*EL PRINT, ELSET=WALL\nS\n*END STEP")
    assert text.replace("*EL PRINT, ELSET=WALL\nS\n", "") + "\n" == before == deck.read_text()
    assert not Path(folder).exists()


@needs_shell
def test_which_program(tmp_path, monkeypatch):
    monkeypatch.delenv("CCX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    with pytest.raises(
        InputError, match=r"^CalculiX is not installed: apt-get install calculix-ccx, or leave"
    ):
        find_calculix()
    for name in ("ccx_2.9", "ccx_2.20", "ccx_2.20.1.txt", "ccx_notes"):
        _install(tmp_path / "bin", "", name)
    assert find_calculix().name == "ccx_2.20"
    _install(tmp_path / "bin", "", "ccx_2.22_MT")
    assert find_calculix().name == "ccx_2.22_MT"
    assert find_calculix().is_absolute()
    _install(tmp_path / "bin", "", "ccx")
    assert find_calculix().name == "ccx"
    monkeypatch.setenv("CCX", str(tmp_path / "bin" / "ccx_2.9"))
    assert find_calculix().name == "ccx_2.9"
    monkeypatch.setenv("CCX", "no-such-program")
    with pytest.raises(InputError, match="CCX names no-such-program, which is no program"):
        find_calculix()


@needs_shell
def test_programs_and_decks_refused(deck, tmp_path, monkeypatch):
    broken = tmp_path / "broken"
    broken.write_text("#!/no/such/shell\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CCX", str(broken))
    with pytest.raises(InputError, match=r"broken cannot be run \(No such file"):
        run_calculix(deck)
    with pytest.raises(InputError, match=r"nowhere\.inp cannot be read"):
        run_calculix(tmp_path / "nowhere.inp")
    (tmp_path / "mesh.inp").write_text("*NODE\n1, 0, 0, 0\n")
    with pytest.raises(InputError, match="holds no step of an analysis: write it with a load case"):
        run_calculix(tmp_path / "mesh.inp")


@needs_ccx
@pytest.mark.parametrize("settlement", ["linear", "trough"])
@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10"])
def test_calculix_itself(tmp_path, kind, settlement):
    mesh, options = all_kinds()[kind], options_for(settlement)
    whole = quadratic_mesh(mesh)
    write_mesh(whole, tmp_path / "wall.inp", case=load_case(mesh, options))
    response, full = analyse(mesh, options=options), analyse(whole, options=options)
    result = run_calculix(tmp_path / "wall.inp")
    check = compare_with_calculix(response, result, options=options, full=full)
    assert check.passed
    assert max(difference.relative - difference.resolution for difference in check.differences) < 1e-8
    # The answer to other loads does not pass.
    options = replace(options, gravity=9.8101)
    other = analyse(whole, options=options)
    assert not compare_with_calculix(other, result, options=options).passed


@needs_ccx
def test_a_wall_that_turns_as_a_rigid_body(tmp_path):
    """Nothing but rounding is left of its stresses and forces: it is not held against itself."""
    mesh = all_kinds()["hexahedron20"]
    turn = LinearSettlement(-0.04, -0.02, -0.03, -0.03)
    options = AnalysisOptions(settlement=turn, gravity=0.0)
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options))
    result = run_calculix(tmp_path / "wall.inp")
    check = compare_with_calculix(analyse(mesh, options=options), result, options=options)
    assert check.passed
    stress = check.differences[1]
    assert stress.largest < 1e-3
    assert stress.scale > 1.0
