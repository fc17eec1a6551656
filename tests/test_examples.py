"""The examples run, and each gives the number that is known from elsewhere."""

import runpy
from functools import cache
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"

# Name of a variable, its value, how near it must be (relative), and where the value comes from.
EXPECTED = {
    # Paper, table 2: 30.699 m² of openings in the drawing of Building 1; 1 % at 20 mm between points.
    "ex01_scan_to_facade": ("opening_area", 30.699, 0.01),
    # By hand: -ρ g H² / (2E) = -1900 x 9.81 x 6² / (2 x 3.48e9).
    "ex02_gravity_wall": ("u_top", -9.6408621e-5, 1e-6),
    # By hand: the panel of 1.0 x 1.4 m at 9 m from the scanner, thrown to 10 m: 1.4 x (10/9)².
    "ex03_occlusion_or_opening": ("shadow_area", 1.7284, 0.03),
    # By hand: (4 x 3 - 1.0 x 1.2) x 0.35; 0.5 % for points about 20 mm apart.
    "ex04_intermediate_records": ("volume", 3.78, 0.005),
    # By hand: the same wall, drawn.
    "ex05_solid_and_neutral_file": ("anf_volume", 3.78, 1e-9),
    # Paper, section 4: 99.6 mm; by hand, as a rigid body, 99.1 mm.
    "ex06_settlement": ("max_displacement", 0.0996, 0.01),
    # No error at all would be 0; the criterion of the paper is 5 %, its own worst at S75 is 1.1 %.
    "ex07_density_study": ("worst", 0.0, 0.02),
    # Paper, section 4: 99.6 mm for the wall that cracks.
    "ex08_cracking_wall": ("max_displacement", 0.0996, 0.01),
}


@cache
def _run(name):
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("ex*.py")))
def test_example_gives_its_known_number(name):
    variable, value, tolerance = EXPECTED[name]  # KeyError: an example without a number
    assert _run(name)[variable] == pytest.approx(value, rel=tolerance, abs=tolerance if value == 0 else 0)


def test_expected_numbers_all_have_an_example():
    assert {path.stem for path in EXAMPLES.glob("ex*.py")} == EXPECTED.keys()


def test_the_panel_passes_for_a_window_only_while_the_scanner_is_unknown():
    result = _run("ex03_occlusion_or_opening")
    assert (result["openings_known"], result["openings_unknown"]) == (1, 2)
    assert [round(opening.x, 1) for opening in result["known"].openings] == [1.0]


def test_settlement_the_other_way_round_moves_the_top_less():
    # By hand, as a rigid body: sqrt((65.6 - 23.0)² + 44.5²) = 61.6 mm; another program gave 62 mm.
    assert _run("ex06_settlement")["max_displacement_other"] == pytest.approx(0.0620, rel=0.01)


def test_leaves_and_voxels_cover_the_wall_once():
    result = _run("ex04_intermediate_records")
    assert result["covered"] == pytest.approx(result["facade_area"], rel=1e-12)
    assert result["leaf_area"] == pytest.approx(result["box_area"], rel=1e-12)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_examples_are_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 70
