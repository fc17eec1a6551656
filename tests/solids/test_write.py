"""All files of a solid together."""

import subprocess
import sys

import numpy as np
import pytest

import fd2fem.solids.write as module
from fd2fem.errors import InputError, NumericsError
from fd2fem.solids import SolidOptions, read_anf, write_solid

WINDOWS = [(1.1, 0.9, 2.3, 2.2)]
VOLUME = 0.35 * (4.0 * 3.0 - 1.2 * 1.3)


@pytest.mark.parametrize("order", [2, 4])
def test_files_agree(tmp_path, make_wall, order):
    report = write_solid(make_wall(4.0, 3.0, WINDOWS), tmp_path, options=SolidOptions(anf_order=order))
    assert sorted(p.name for p in tmp_path.iterdir()) == [report.anf, report.step, report.apdl]
    assert (report.anf, report.step, report.apdl) == ("facade.anf", "facade.step", "facade_apdl.inp")
    for volume in (report.volume, report.step_volume, report.anf_volume):
        assert volume == pytest.approx(VOLUME, rel=1e-9)
    assert report.extent == pytest.approx((4.0, 0.35, 3.0), rel=1e-9)
    assert report.step_faces == 2 + 4 + 4
    solid = read_anf(tmp_path / "facade.anf")
    assert (report.keypoints, report.lines) == (len(solid.keypoints), len(solid.lines))
    assert (report.areas, report.volumes) == (len(solid.areas), len(solid.volumes))
    assert f"\t{order}\t" in (tmp_path / "facade.anf").read_text()


def test_product_gets_its_name(tmp_path, make_wall):
    write_solid(make_wall(4.0, 3.0, WINDOWS), tmp_path, options=SolidOptions(step_name="no. 5"))
    assert "PRODUCT('no. 5'" in (tmp_path / "facade.step").read_text()


def test_neutral_file_with_another_volume_is_noticed(tmp_path, make_wall, monkeypatch):
    monkeypatch.setattr(module, "solid_volumes", lambda _: np.array([VOLUME * 1.0001]))
    with pytest.raises(NumericsError, match=r"facade.anf reads back as 3\.65\d* m³ in \d+ volumes, expected"):
        write_solid(make_wall(4.0, 3.0, WINDOWS), tmp_path, options=SolidOptions())


def test_wall_in_pieces_leaves_nothing(tmp_path, make_voxels):
    with pytest.raises(InputError, match="falls into 2 pieces"):
        write_solid(make_voxels([(0, 0, 1, 1), (3, 0, 4, 2)]), tmp_path, options=SolidOptions())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"anf_order": 3}, "Invalid 'anf_order': expected 2 or 4, got 3"),
        ({"step_name": " "}, "Invalid 'step_name': expected a name in printable ASCII"),
        ({"step_name": "façade"}, "Invalid 'step_name'"),
        ({"step_name": "a\nb"}, "Invalid 'step_name'"),
    ],
)
def test_options_are_checked(options, match):
    with pytest.raises(InputError, match=match):
        SolidOptions(**options)


def test_package_is_light_to_import():
    heavy = ("cadquery", "OCP", "gmsh", "scipy", "shapely")
    code = f"import sys, fd2fem.solids; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
