"""Reading CAD files back: other units, loose surfaces, wrong sizes, and files that are none."""

import pytest

from fd2fem.errors import InputError, NumericsError
from fd2fem.model import Facade, rectangle
from fd2fem.solids import cad_wall, check_step, write_brep, write_iges, write_step
from fd2fem.solids.occ import read_shape

WRITERS = {"step": write_step, "iges": write_iges, "brep": write_brep}


@pytest.fixture(scope="module")
def plain():
    """2 x 0.5 x 3 m."""
    return cad_wall(Facade(rectangle(0, 0, 2, 3), 0.5))


@pytest.mark.parametrize(
    ("volume", "extent", "match"),
    [
        (3.00001, (2, 0.5, 3), "a.step: the volume reads back as 3, expected 3.00001"),
        (3.0, (2.00001, 0.5, 3), "the extent in x reads back as 2, expected 2.00001"),
        (3.0, (2, 0.5, 3000), "the extent in z"),
    ],
)
def test_other_sizes_are_noticed(tmp_path, plain, volume, extent, match):
    write_step(plain, tmp_path / "a.step")
    with pytest.raises(NumericsError, match=match):
        check_step(tmp_path / "a.step", volume=volume, extent=extent)


def test_millimetre_file_with_metre_numbers_is_noticed(tmp_path, plain):
    """What cadquery writes by default for a model in metres."""
    plain.exportStep(str(tmp_path / "mm.step"))
    with pytest.raises(NumericsError, match="volume reads back as 3e-09"):
        check_step(tmp_path / "mm.step", volume=3.0, extent=(2, 0.5, 3))


def test_unsound_shape_is_noticed(tmp_path):
    from cadquery import Solid, Vector, Wire

    # Two windows that meet in a point: the wall hangs together by an edge there.
    rings = [
        [(0, 0), (4, 0), (4, 4), (0, 4)],
        [(1, 1), (2, 1), (2, 2), (1, 2)],
        [(2, 2), (3, 2), (3, 3), (2, 3)],
    ]
    outer, *inner = (Wire.makePolygon([Vector(x, 0, z) for x, z in ring], close=True) for ring in rings)
    write_step(Solid.extrudeLinear(outer, inner, Vector(0, 1, 0)), tmp_path / "bad.step")
    with pytest.raises(NumericsError, match="not sound"):
        check_step(tmp_path / "bad.step", volume=14.0, extent=(4, 1, 4))


def test_iges_in_millimetres_and_in_loose_surfaces(tmp_path, plain):
    """What many programs write: no solid, but the surfaces around it."""
    from OCP.IGESControl import IGESControl_Writer

    for name, mode in (("solid", 1), ("surfaces", 0)):
        writer = IGESControl_Writer("MM", mode)
        writer.AddShape(plain.scale(1000.0).wrapped)
        writer.ComputeModel()
        writer.Write(str(tmp_path / f"{name}.igs"))
        report = check_step(tmp_path / f"{name}.igs", volume=3.0, extent=(2, 0.5, 3))
        assert (report.solids, report.faces) == (1, 6)


def test_surfaces_that_do_not_close_are_no_solid(tmp_path, plain):
    from cadquery import Compound

    write_brep(Compound.makeCompound(plain.Faces()[:5]), tmp_path / "open.brep")
    assert read_shape(tmp_path / "open.brep").Solids() == []
    with pytest.raises(NumericsError, match="reads back with 0 solids in it"):
        check_step(tmp_path / "open.brep", volume=3.0, extent=(2, 0.5, 3))


@pytest.mark.parametrize("suffix", ["step", "iges", "brep"])
@pytest.mark.parametrize("part", [0.05, 0.3, 0.6, 0.9, 0.995])
def test_files_that_are_cut_off(tmp_path, plain, suffix, part, capfd):
    """Some make OpenCASCADE talk, some make it die."""
    path = tmp_path / f"a.{suffix}"
    WRITERS[suffix](plain, path)
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(InputError, match=rf"a\.{suffix} is not a whole "):
        read_shape(path)
    assert capfd.readouterr() == ("", "")


def test_files_of_other_kinds(tmp_path):
    (tmp_path / "a.dwg").write_text("x")
    with pytest.raises(InputError, match=r"a\.dwg: '\.dwg' is not a CAD format .* use \.step, \.stp, \.iges"):
        read_shape(tmp_path / "a.dwg")
