"""The page of verification says what the code finds."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from structural import building, convergence  # noqa: E402
from structural.rows import Row  # noqa: E402


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("verification", DOCS / "verification.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("rows", ["strength_rows", "trough_rows", "damage_rows"])
def test_page_is_up_to_date(script, rows):
    page = script.PAGE.read_text(encoding="utf-8")
    for row in getattr(script, rows)():
        # Case, source, target and our figure; the last digits of the difference are round-off.
        assert str(row).rpartition("|")[0].rpartition("|")[0] in page


def test_recorded_walls_are_on_the_page(script):
    page = script.PAGE.read_text(encoding="utf-8")
    record = script.read_json(script.RECORD)
    assert script.building_table(record) in page
    assert script.mesh_tables(record) in page


def test_building_1_keeps_its_promises(script):
    """Recorded figures against the paper's: 98 to 102 mm, the strength never exceeded, meshes within 2 %."""
    record = script.read_json(script.RECORD)
    for letter in "ab":
        coarse, fine = (record[f"building1 {letter} {size}"] for size in ("0.25", "0.125"))
        for run in (coarse, fine):
            assert 98e-3 < run["displacement"] < 102e-3
            assert 1.0e6 < run["sigma_all"] < 1.1501e6
        assert max(building.difference(coarse, fine, foot) for foot in (0, 1)) < 0.02


def test_orders_of_sequences_known_in_closed_form():
    assert convergence.observed_order([1.0 + 8.0**-k for k in range(4)]) == pytest.approx(3.0)
    assert not np.isfinite(convergence.observed_order([1.0, 2.0, 4.0]))
    assert not np.isfinite(convergence.observed_order([1.0, 2.0, 1.5]))
    assert convergence.grid_convergence_index([5.0, 2.0, 1.25]) == pytest.approx(1.25 * 0.6 / 3.0)


def test_halved_mesh_keeps_the_wall(grid):
    mesh = grid([0, 1, 2.5], [0, 0.4], [0, 1, 2, 3], keep=lambda c: (c[:, 0] > 1) | (c[:, 2] < 1), warp=0.05)
    fine = convergence.halved(mesh)
    assert len(fine.elements) == 8 * len(mesh.elements)
    assert len(fine.groups["base"]) == 4 * len(mesh.groups["base"])
    # Trilinear: every node of the coarse mesh is one of the fine mesh, and the bounds are the same.
    for node in mesh.nodes:
        assert np.linalg.norm(fine.nodes - node, axis=1).min() < 1e-7
    ends = np.ptp(fine.nodes, axis=0), np.ptp(mesh.nodes, axis=0)
    assert ends[0] == pytest.approx(ends[1])


def test_a_row_tells_the_difference():
    assert str(Row("a", "b", 200.0, 201.0)) == "| a | b | 200 | 201 | +0.5 % |"
    assert str(Row("a", "b", -200.0, -200.0)) == "| a | b | -200 | -200 | 0 |"
    assert str(Row("a", "b", 0.0, 3e-9)) == "| a | b | 0 | 3e-09 | 3e-09 |"
