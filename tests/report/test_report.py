"""A small real run and what the report makes of it."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image
from synthetic import cleaned_cloud, facade_of

from fd2fem.config import PipelineOptions
from fd2fem.meshing import MeshOptions
from fd2fem.pipeline import run
from fd2fem.report import facade_summary, write_report
from solvers import AnalysisOptions, LinearSettlement, MasonryLaw, SteppingOptions, analyse

DRAWING = facade_of(4.0, 3.0, [(0.6, 0.0, 0.9, 2.0), (2.2, 1.0, 1.2, 1.3)])
PICTURES = [
    "01_scan",
    "02_boundary",
    "03_openings",
    "03_rays",
    "04_lines",
    "05_voxels",
    "06_mesh",
    "07_response",
]
WITH_REFERENCE = ["08_reference", "09_comparison"]
BAD = "<script>alert('x')</script> & <b>bold</b>"
VOID = {"meta", "img", "br", "hr", "link", "input"}


class _Page(HTMLParser):
    """What a page holds; complains about tags that are not closed in turn."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.images, self.text, self.cells = [], [], [], []
        self._open = []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
        if self._open and self._open[-1] == "td":
            self.cells.append(data)


def _page(folder):
    return _Page((folder / "report.html").read_text(encoding="utf-8"))


def _run(folder, reference):
    options = PipelineOptions(mesh=MeshOptions(size=0.5))
    cloud = cleaned_cloud(DRAWING, 0.03, seed=2)
    return run(cloud, folder, reference=reference, options=options, progress=lambda _: None)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alone")
    return _run(folder, None), folder


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    return _run(folder, DRAWING), folder


@pytest.mark.parametrize("name", PICTURES + WITH_REFERENCE)
def test_every_picture_shows_something(compared, name):
    with Image.open(compared[1] / f"{name}.png") as picture:
        picture.verify()
    with Image.open(compared[1] / f"{name}.png") as picture:
        assert picture.format == "PNG"
        assert 600 < picture.width < 2500
        assert 300 < picture.height < 2500
        pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
    # Axes, ticks and text are grey: a picture that shows no data has no colour in it.
    coloured = pixels[np.ptp(pixels, axis=1) > 25]
    assert len(coloured) > 0.004 * len(pixels)
    assert len(np.unique(pixels, axis=0)) > 20
    assert (pixels == 255).all(axis=1).mean() > 0.1


def test_without_a_reference_there_is_nothing_of_one(alone):
    _, folder = alone
    assert sorted(path.stem for path in folder.glob("*.png")) == PICTURES
    page = _page(folder)
    assert [image["src"] for image in page.images] == [f"{name}.png" for name in PICTURES]
    assert "No reference was given" in " ".join(page.text)


def test_page_shows_every_picture_with_a_caption(compared):
    _, folder = compared
    page = _page(folder)
    assert [image["src"] for image in page.images] == [f"{name}.png" for name in PICTURES + WITH_REFERENCE]
    for image in page.images:
        assert (folder / image["src"]).is_file()
        assert image["alt"]
    assert page.tags.count("figcaption") == len(page.images)


def test_page_gives_verdict_and_figures(compared):
    result, folder = compared
    page = _page(folder)
    assert result.comparison.passed
    assert "The scan- and drawing-derived models agree within 5 %." in " ".join(page.text)
    cells = page.cells
    # The drawing's figures by hand: 0.9 x 2.0 + 1.2 x 1.3 m² of openings.
    for name, reference in (("length", "4.000"), ("height", "3.000"), ("opening_area", "3.360")):
        assert cells[cells.index(name) + 2] == reference
    assert [cell for cell in cells if re.match(r"\d (door|window)$", cell)] == ["1 door", "2 window"]
    widths = [float(cells[cells.index(name) + 3]) for name in ("1 door", "2 window")]
    assert widths == pytest.approx([0.9, 1.2], abs=0.03)


def test_page_without_a_reference_gives_the_response(alone):
    result, folder = alone
    cells = _page(folder).cells
    shown = float(cells[cells.index("largest displacement, mm") + 1])
    assert shown == pytest.approx(1000 * result.response.max_displacement, abs=0.05)


def _changed(result, *, warnings, **comparison):
    """The same run with other warnings and another verdict."""
    rebuilt = result.reconstruction
    record = dict(rebuilt.facade.record) | {"warnings": list(warnings)}
    rebuilt = replace(rebuilt, facade=replace(rebuilt.facade, record=record))
    return replace(result, reconstruction=rebuilt, comparison=replace(result.comparison, **comparison))


@pytest.fixture(scope="module")
def short(compared, tmp_path_factory):
    """The page of a run that falls short, with warnings and a reason that a browser could trip over."""
    folder = tmp_path_factory.mktemp("short")
    result = _changed(
        compared[0],
        warnings=[BAD, "costs $title and ${tables}"],
        passed=False,
        reasons=("height is 7 % short", BAD),
    )
    write_report(result, folder)
    return folder


def test_nothing_in_a_warning_or_reason_is_markup(short):
    text = (short / "report.html").read_text(encoding="utf-8")
    assert "<script" not in text
    assert "<b>" not in text
    assert " ".join(_Page(text).text).count(BAD) == 2  # as text, once as a warning and once as a reason


def test_a_dollar_in_a_warning_is_a_dollar(short):
    assert "costs $title and ${tables}" in " ".join(_page(short).text)


def test_failing_comparison_says_why(short):
    text = " ".join(_page(short).text)
    assert "do not agree within 5 %: height is 7 % short" in text
    assert "models agree within" not in text


def test_summary_of_a_reconstructed_facade(alone):
    result, _ = alone
    facade = result.reconstruction.facade
    summary = facade_summary(facade)
    assert summary["length"] == pytest.approx(4.0, abs=0.03)
    assert summary["opening_area"] == facade.opening_area
    assert [(entry["id"], entry["kind"]) for entry in summary["openings"]] == [(1, "door"), (2, "window")]
    assert summary["points"]["read"] == len(result.cloud)
    assert summary["warnings"] == list(facade.record["warnings"])


TOUGH = AnalysisOptions(
    masonry=MasonryLaw(tensile_strength=2e5, fracture_energy=1e3),
    settlement=LinearSettlement(0.0, -0.003, 0.0, 0.001),
    stepping=SteppingOptions(steps=4),
)


@pytest.fixture(scope="module")
def cracked(compared, tmp_path_factory):
    """The run of `compared`, its walls of masonry that cracks."""
    folder = tmp_path_factory.mktemp("cracked")
    result = compared[0]
    response = analyse(result.mesh, options=TOUGH)
    response = replace(response, solver=dict(response.solver) | {"warnings": ["elements are wide"]})
    reference = replace(result.reference, response=response)
    comparison = replace(result.comparison, notes=("both at the strength",))
    result = replace(result, response=response, reference=reference, comparison=comparison)
    write_report(result, folder)
    return result, folder


def test_page_of_a_wall_that_cracks_shows_cracks_and_curve(cracked):
    result, folder = cracked
    assert result.response.dissipated_energy > 0.0
    page = _page(folder)
    sources = [image["src"] for image in page.images]
    for name in ("07_cracks", "07_load_settlement", "09_cracks"):
        assert f"{name}.png" in sources
        with Image.open(folder / f"{name}.png") as picture:
            pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
        coloured = pixels[np.ptp(pixels, axis=1) > 25]
        assert len(coloured) > 0.004 * len(pixels)
    text = " ".join(page.text)
    assert "Note: both at the strength." in text
    assert "Warning: elements are wide" in text


def test_page_of_a_wall_that_cracks_gives_damage_feet_and_energies(cracked):
    result, folder = cracked
    response, cells = result.response, _page(folder).cells
    assert f"{response.damage['crack_class']}, {response.damage['crack_label']}" in cells
    assert cells[cells.index("iterations") + 1] == str(sum(step["iterations"] for step in response.history))
    # By hand: a door in the base from 0.6 to 1.5 m leaves two feet, which carry the wall.
    feet = [cell for cell in cells if re.match(r"\d: ", cell)]
    assert [cell.split(": ")[1][:4] for cell in feet] == ["0.00", "1.50"]
    upwards = [float(cells[cells.index(foot) + 2]) for foot in feet]
    assert sum(upwards) == pytest.approx(response.weight / 1000, abs=0.02)
    start = cells.index("work of weight and ground, J")
    work, stored, taken, left = (cells[start + 2 * row + 1] for row in range(4))
    cracks, crushing = map(float, taken.split("; "))
    assert float(work) == pytest.approx(float(stored) + cracks + crushing + float(left), abs=0.03)
