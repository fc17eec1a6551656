"""The density study in docs/: its numbers of the paper, its statistics and the page that it writes."""

import re
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fd2fem.drawings import STAND_INS, stand_in
from fd2fem.model import EdgeSigma, Facade, OpeningKind, rectangle
from fd2fem.pipeline import ORIGINAL_COUNTS, scan_facade
from fd2fem.scans import Density, ScannerOptions, Scene
from validation import compare_facades, standard_uncertainty, t_interval_from_moments

DOCS = Path(__file__).parents[1] / "docs"
ORACLE = Path(__file__).parent / "oracles" / "flying_voxel_tables.toml"


@pytest.fixture(scope="module")
def modules():
    """The two scripts, imported as `python docs/density_study.py` does."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(DOCS)
        import density_study
        import density_study_page
    yield density_study, density_study_page
    for name in ("density_study", "density_study_page"):
        del sys.modules[name]


@pytest.fixture(scope="module")
def study(modules):
    return modules[0]


@pytest.fixture(scope="module")
def page(modules):
    return modules[1]


@pytest.fixture(scope="module")
def outcome(study):
    """Building 2 at S75, the smallest data set of the study."""
    cloud = scan_facade(
        stand_in("building2"),
        scanner=ScannerOptions(seed=0),
        scene=Scene.empty(),
        density=Density.S75,
        original_points=ORIGINAL_COUNTS["building2"],
    )
    return study.measure(cloud, "building2", Density.S75, seed=0)


def _moved(drawing, *, wider=0.0, sigma=0.01):
    """The drawing with each opening's right edge moved, and the same sigma on all edges."""
    openings = tuple(
        replace(
            opening,
            outline=rectangle(opening.x, opening.z, opening.width + wider, opening.height),
            sigma=EdgeSigma(sigma, sigma, sigma, sigma),
        )
        for opening in drawing.openings
    )
    return Facade(drawing.outline, drawing.thickness, openings)


def _cells(text):
    """Rows of the Markdown tables in a text."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_paper_numbers_are_those_of_the_oracle(page):
    oracle = tomllib.loads(ORACLE.read_text(encoding="utf-8"))
    assert page.PAPER["datasets"] == oracle["datasets"] == list(Density)
    for building in STAND_INS:
        for name in ("table3", "table4"):
            ours, theirs = page.PAPER[name][building], oracle[name][building]
            assert ours == {key: theirs[key] for key in ours}
        ours, theirs = page.PAPER["table2"][building], oracle["table2"][building]
        for key in theirs.keys() & {"length", "height", "opening_area"}:
            assert ours[key] == theirs[key]
        assert theirs["cad"].items() <= ours["drawing"].items()
        assert page.PAPER["table1"][building][0] == ORIGINAL_COUNTS[building]


@pytest.mark.parametrize("table", ["table3", "table4"])
@pytest.mark.parametrize("building", STAND_INS)
def test_paper_bounds_follow_from_its_average_and_std(page, table, building):
    # Rounded to 0.1 mm: see tests/validation/test_intervals.py for the slack.
    rows = page.PAPER[table][building]
    for k in range(len(Density)):
        interval = t_interval_from_moments(rows["average"][k], rows["std"][k], n=rows["n"])
        assert (interval.lower, interval.upper) == pytest.approx(
            (rows["lower"][k], rows["upper"][k]), abs=0.15
        )
        uncertainty = standard_uncertainty(rows["std"][k], n=rows["n"])
        assert uncertainty == pytest.approx(rows["standard_uncertainty"][k], abs=0.07)


def test_openings_of_building2_at_s75(outcome):
    # The drawing is the truth. The paper's own errors are 7.7 ± 137.1 mm, its opening area is off by 2.7 %.
    dimensions = outcome.geometry["opening_dimensions"]
    assert dimensions["n"] == 16
    assert abs(dimensions["mean_m"]) < 0.008
    assert dimensions["std_m"] < 0.015
    assert abs(outcome.error("opening_area")) < 1.5
    assert abs(outcome.error("height")) < 0.5
    assert len(outcome.scores) == 4 * 8 - 1  # the door's foot is no edge
    # Normal errors with an honest sigma: 31 scores have an rms of 1, and one in 1.6 million lies beyond 5.
    assert 0.3 < np.sqrt(np.mean(np.square(outcome.scores))) < 1.7
    assert np.abs(outcome.scores).max() < 5.0


def test_scores_count_the_edges_that_are_off(study):
    drawing = stand_in("building1")
    # Right edges off by 30 mm at a sigma of 10 mm: a score of 3 each; all others 0.
    scores = study.edge_scores(_moved(drawing, wider=0.03), drawing)
    doors = sum(opening.kind is OpeningKind.DOOR for opening in drawing.openings)
    assert len(scores) == 4 * 4 - doors
    assert sorted(scores)[-4:] == pytest.approx([3.0] * 4)
    assert sorted(scores)[:-4] == pytest.approx([0.0] * (len(scores) - 4), abs=1e-9)


def test_scores_do_not_count_from_the_corner_found(study):
    # The wall found is 20 mm short on the left: its openings move in its frame, not in the scan's.
    drawing = stand_in("building1")
    shifted = [
        replace(o, outline=o.outline - [0.02, 0.0], sigma=EdgeSigma(0.01, 0.01, 0.01, 0.01))
        for o in drawing.openings
    ]
    wall = rectangle(0.0, 0.0, drawing.length - 0.02, drawing.height)
    found = Facade(wall, 0.35, tuple(shifted), frame=drawing.frame.moved(0.02, 0.0))
    assert study.edge_scores(found, drawing) == pytest.approx([0.0] * 15, abs=1e-9)


def test_table_shows_known_errors(page, outcome):
    # Widths + 20 mm, heights right: 8 values with a mean of 10 mm and a std of 10 √(8/7) = 10.69 mm;
    # bounds 10 ± t(0.95, 7) · 10.69 / √8 = 10 ± 1.8946 · 3.780 mm.
    drawing = stand_in("building1")
    geometry = dict(compare_facades(_moved(drawing, wider=0.02), drawing).geometry)
    outcomes = [
        replace(outcome, building=b, density=d, geometry=geometry) for b in STAND_INS for d in Density
    ]
    rows = _cells(page.statistics_table(outcomes, page.DIMENSIONS))
    shown = {row[0]: row[2] for row in rows[2:9]}
    assert shown == {
        "Average": "10.0",
        "Min": "0.0",
        "Max": "20.0",
        "Std.": "10.7",
        "Std. uncert.": "3.8",
        "Lower est.": "2.8",
        "Upper est.": "17.2",
    }
    paper = {row[0]: row[1] for row in rows[2:9]}
    assert (paper["Average"], paper["Lower est."], paper["Upper est."]) == ("-19.7", "-88.6", "49.1")
    corrected = rows[-2:]  # lower and upper bounds of Building 3, which the paper misprints
    assert [row[1] for row in corrected] == ["-9.6ᵇ", "11.0ᵇ"]


def test_page_is_whole(page, outcome, tmp_path):
    outcomes = [
        replace(outcome, building=b, density=d, seed=seed)
        for b in STAND_INS
        for d in Density
        for seed in (0, 1)
    ]
    page.write_study(outcomes, tmp_path)
    text = (tmp_path / "density_study.md").read_text(encoding="utf-8")
    assert not re.search(r"[{}]|nan", text)
    for name in re.findall(r"\]\((.*?\.png)\)", text):
        picture = (tmp_path / name).read_bytes()
        assert picture.startswith(b"\x89PNG")
        assert len(picture) < 120_000
    rows = _cells(page.overall_table(outcomes))
    assert {len(row) for row in rows} == {7}
    assert len(rows) == 2 + 3 * 5
    building2 = next(k for k, row in enumerate(rows) if row[0] == "**Building 2**, drawing")
    assert rows[building2] == [rows[building2][0], "4.900", "4.900", "13.280", "13.280", "34.230ᵃ", "34.230"]
    assert f"{outcome.geometry['length']['candidate']:.3f}" == rows[building2 + 4][2]
    assert len(_cells(page.seeds_table(outcomes))) == 2 + 12


def test_published_page_has_its_pictures():
    text = (DOCS / "density_study.md").read_text(encoding="utf-8")
    names = re.findall(r"\]\((.*?\.png)\)", text)
    assert len(names) == 3
    assert all((DOCS / name).is_file() for name in names)
