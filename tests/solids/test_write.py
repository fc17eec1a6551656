"""All files of a solid together."""

import subprocess
import sys

import numpy as np
import pytest
from anf_rules import check_anf

import fd2fem.solids.write as module
from fd2fem.errors import InputError, NumericsError
from fd2fem.model import Arc, Facade, LoadCase, Opening, OpeningKind, Storey, VoxelModel, WallCells, rectangle
from fd2fem.solids import SolidForm, SolidOptions, Strength, read_anf, write_solid

WALL = rectangle(0, 0, 4, 3)
HOLE = (1.1, 0.9, 2.3, 2.2)
FACADE = Facade(WALL, 0.35, (Opening(1, OpeningKind.WINDOW, rectangle(1.1, 0.9, 1.2, 1.3)),))
VOLUME = 0.35 * (4.0 * 3.0 - 1.2 * 1.3)
CASE = LoadCase(3.48e9, 0.16, 1900.0, 9.81, lambda p: np.outer(p[:, 0], [0.0, 0.0, -0.001]))


@pytest.fixture
def cells(make_wall):
    return make_wall(4.0, 3.0, [HOLE])


@pytest.mark.parametrize("order", [2, 4])
def test_files_agree(tmp_path, cells, order):
    report = write_solid(FACADE, cells, tmp_path, options=SolidOptions(anf_order=order))
    assert sorted(p.name for p in tmp_path.iterdir()) == [report.anf, report.step, report.apdl]
    assert (report.anf, report.step, report.apdl) == ("facade.anf", "facade.step", "facade_apdl.inp")
    assert (report.settlement, report.also) == (None, ())
    for volume in (report.volume, report.cells_volume, report.step_volume, report.anf_volume):
        assert volume == pytest.approx(VOLUME, rel=1e-9)
    assert report.extent == pytest.approx((4.0, 0.35, 3.0), rel=1e-9)
    assert (report.step_solids, report.step_faces) == (1, 2 + 4 + 4)
    solid = read_anf(tmp_path / "facade.anf")
    assert (report.keypoints, report.lines) == (len(solid.keypoints), len(solid.lines))
    assert (report.areas, report.volumes) == (len(solid.areas), len(solid.volumes))
    assert f"\t{order}\t" in (tmp_path / "facade.anf").read_text()


def test_everything_at_once(tmp_path, cells):
    options = SolidOptions(form=SolidForm.VOXELS, also=("brep", "iges"))
    report = write_solid(FACADE, cells, tmp_path, options=options, case=CASE)
    names = {
        "facade.step",
        "facade.anf",
        "facade_apdl.inp",
        "facade_settlement.inp",
        "facade.brep",
        "facade.iges",
    }
    assert {p.name for p in tmp_path.iterdir()} == names
    assert (report.settlement, report.also) == ("facade_settlement.inp", ("facade.brep", "facade.iges"))
    assert report.step_solids == report.volumes
    assert report.step_volume == pytest.approx(VOLUME, rel=1e-9)
    deck = (tmp_path / "facade_settlement.inp").read_text()
    assert "/INPUT,facade,anf" in deck
    assert f"*IF,NVOLGOT,NE,{report.volumes},THEN" in deck


def test_settlement_deck_has_the_strength_of_the_options(tmp_path, cells):
    options = SolidOptions(strength=Strength(cohesion=0.5e6))
    write_solid(FACADE, cells, tmp_path, options=options, case=CASE)
    assert "COHE=500000.0 " in (tmp_path / "facade_settlement.inp").read_text()


def test_storeys(tmp_path):
    facade = Facade(WALL, 0.5, storeys=(Storey(1.0, 0.4), Storey(2.0, 0.25)))
    voxels = VoxelModel([[0, 0], [0, 1], [0, 2]], [[4, 1], [4, 2], [4, 3]], [1, 1, 1], [0.5, 0.4, 0.25])
    report = write_solid(facade, voxels, tmp_path, options=SolidOptions())
    assert report.volumes == 3 + 2 + 1
    for volume in (report.volume, report.cells_volume, report.step_volume, report.anf_volume):
        assert volume == pytest.approx(4 * (0.5 + 0.4 + 0.25), rel=1e-9)
    assert report.extent == pytest.approx((4.0, 0.5, 3.0), rel=1e-9)
    assert report.step_faces == 1 + 3 + 2 + 2 + 2  # front; backs; ledges; ends; ground and top
    assert sum(check_anf((tmp_path / "facade.anf").read_text()).volumes) == pytest.approx(4.6, rel=1e-12)


def test_round_windows_have_one_volume_in_all_files(tmp_path):
    """A square wall around a circle of 16 corners, which lie so far outside that they have its area."""
    angle = np.arange(16) * np.pi / 8
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    ring = 0.8 * np.sqrt(np.pi / (8 * np.sin(np.pi / 8))) * circle + 2.0
    square = 2.0 * circle / np.abs(circle).max(axis=1)[:, None] + 2.0
    window = Opening(1, OpeningKind.WINDOW, ring, arcs=(Arc(0, 0, 2.0, 2.0, 0.8, 0.8),))
    corners = [[i, i + 16, (i + 1) % 16 + 16, (i + 1) % 16] for i in range(16)]
    report = write_solid(
        Facade(rectangle(0, 0, 4, 4), 0.4, (window,)),
        WallCells(np.concatenate([ring, square]), corners, 0.4),
        tmp_path,
        options=SolidOptions(),
    )
    for volume in (report.volume, report.cells_volume, report.step_volume, report.anf_volume):
        assert volume == pytest.approx(0.4 * (16 - np.pi * 0.8**2), rel=1e-9)
    assert report.step_faces == 2 + 4 + 1
    assert report.volumes == 16


def test_walls_wider_above_their_base_keep_their_extent(tmp_path):
    """The gable's top is not as wide as its foot, nor does the extent come from the first keypoint."""
    gable = np.array([[0, 0], [4, 0], [4, 2], [2, 3.5], [0, 2]], dtype=float)
    cells = WallCells([*gable, [2, 0]], [[0, 5, 3, 4], [5, 1, 2, 3]], 0.3)
    report = write_solid(Facade(gable, 0.3), cells, tmp_path, options=SolidOptions())
    assert report.extent == pytest.approx((4.0, 0.3, 3.5), rel=1e-9)
    assert report.anf_volume == pytest.approx(0.3 * (8 + 3), rel=1e-12)


def test_product_gets_its_name(tmp_path, cells):
    write_solid(FACADE, cells, tmp_path, options=SolidOptions(step_name="no. 5"))
    assert "PRODUCT('no. 5'" in (tmp_path / "facade.step").read_text()


@pytest.mark.parametrize("grown", [1.0001, 0.9999])
def test_cells_of_another_volume_are_noticed(tmp_path, grown):
    voxels = VoxelModel([[0, 0]], [[4 * grown, 3]], [1], 0.35)
    with pytest.raises(
        NumericsError, match=r"cells of the neutral file have 4\.\d+ m³, the facade has 4\.2 m³"
    ) as caught:
        write_solid(Facade(WALL, 0.35), voxels, tmp_path, options=SolidOptions())
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_edges_that_a_division_moved_by_less_than_a_micrometre_are_allowed(tmp_path):
    """A window's edge at 2.0000004 m, beside a line of the division at 2 m."""
    facade = Facade(WALL, 0.35, (Opening(1, OpeningKind.WINDOW, rectangle(1.0, 1.0, 1.0 + 4e-7, 1.0)),))
    boxes = [(0, 0, 4, 1), (0, 1, 1, 2), (2, 1, 4, 2), (0, 2, 4, 3)]
    voxels = VoxelModel([b[:2] for b in boxes], [b[2:] for b in boxes], np.ones(4), 0.35)
    report = write_solid(facade, voxels, tmp_path, options=SolidOptions())
    assert report.cells_volume - report.volume == pytest.approx(4e-7 * 0.35, rel=1e-3)
    apart = Facade(WALL, 0.35, (Opening(1, OpeningKind.WINDOW, rectangle(1.0, 1.0, 1.0 + 4e-6, 1.0)),))
    with pytest.raises(NumericsError, match="the facade has"):
        write_solid(apart, voxels, tmp_path, options=SolidOptions())


def test_neutral_file_with_another_volume_is_noticed(tmp_path, cells, monkeypatch):
    write = module.write_anf

    def write_less(solid, path, *, order):
        write(solid, path, order=order)
        path.write_text(path.read_text().replace("3.500000000000000e-01", "3.400000000000000e-01"))

    monkeypatch.setattr(module, "write_anf", write_less)
    with pytest.raises(
        NumericsError, match=r"facade.anf reads back as 3\.\d+ m³ in \d+ volumes, expected 3\.654"
    ):
        write_solid(FACADE, cells, tmp_path, options=SolidOptions())


@pytest.mark.parametrize(
    ("boxes", "match"),
    [
        ([(0, 0, 1, 1), (3, 0, 4, 2)], "falls into 2 pieces"),
        ([], "None of the 0 voxels is full"),
        ([(0, 0, 2, 2), (1, 1, 3, 3)], "overlap"),
    ],
)
def test_cells_that_make_no_solid_leave_nothing(tmp_path, make_voxels, boxes, match):
    with pytest.raises(InputError, match=match):
        write_solid(FACADE, make_voxels(boxes), tmp_path, options=SolidOptions())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"anf_order": 3}, "Invalid 'anf_order': expected 2 or 4, got 3"),
        ({"step_name": " "}, "Invalid 'step_name': expected a name in printable ASCII"),
        ({"step_name": "façade"}, "Invalid 'step_name'"),
        ({"step_name": "a\nb"}, "Invalid 'step_name'"),
        ({"form": "solid"}, "Invalid 'form': expected merged or voxels, got 'solid'"),
        ({"also": ("stl",)}, "Invalid 'also': expected each of iges, brep at most once"),
        ({"also": ("iges", "iges")}, "Invalid 'also'"),
    ],
)
def test_options_are_checked(options, match):
    with pytest.raises(InputError, match=match):
        SolidOptions(**options)


def test_options_may_come_from_text():
    assert SolidOptions(form="voxels", also=["iges"]) == SolidOptions(form=SolidForm.VOXELS, also=("iges",))


def test_package_is_light_to_import():
    heavy = ("cadquery", "OCP", "gmsh", "scipy", "shapely")
    code = f"import sys, fd2fem.solids; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
