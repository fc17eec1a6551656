"""The page of verification says what the code finds."""

import importlib.util
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("verification", DOCS / "verification.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("rows", ["strength_rows", "trough_rows"])
def test_page_is_up_to_date(script, rows):
    page = script.PAGE.read_text(encoding="utf-8")
    for row in getattr(script, rows)():
        # Case, source, target and our figure; the last digits of the difference are round-off.
        assert str(row).rpartition("|")[0].rpartition("|")[0] in page


def test_a_row_tells_the_difference(script):
    assert str(script.Row("a", "b", 200.0, 201.0)) == "| a | b | 200 | 201 | +0.5 % |"
    assert str(script.Row("a", "b", -200.0, -200.0)) == "| a | b | -200 | -200 | 0 |"
    assert str(script.Row("a", "b", 0.0, 3e-9)) == "| a | b | 0 | 3e-09 | 3e-09 |"
