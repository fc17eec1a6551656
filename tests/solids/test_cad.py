"""STEP solids, held against closed forms and read by gmsh's own OpenCASCADE."""

import re

import gmsh
import pytest

from fd2fem.errors import InputError, NumericsError
from fd2fem.solids import cad_solid, check_step, write_step

WINDOWS = [
    (1.03 + 2.57 * k, 1.11 + 4.01 * r, 2.43 + 2.57 * k, 3.56 + 4.01 * r) for r in range(4) for k in range(7)
]


@pytest.fixture(scope="module")
def gmsh_session():
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


def read_by_gmsh(session, path):
    """Volume, extent and number of faces in metres."""
    session.clear()
    session.option.setString("Geometry.OCCTargetUnit", "M")
    session.option.setNumber("Geometry.OCCBoundsUseStl", 0)
    session.model.occ.importShapes(str(path))
    session.model.occ.synchronize()
    ((_, tag),) = session.model.getEntities(3)
    box = session.model.occ.getBoundingBox(3, tag)
    extent = [high - low for low, high in zip(box[:3], box[3:], strict=True)]
    return session.model.occ.getMass(3, tag), extent, len(session.model.getEntities(2))


def test_wall_with_28_windows(tmp_path, make_wall, gmsh_session):
    """The size of the paper's Building 3."""
    voxels = make_wall(19.36, 17.0, WINDOWS, thickness=0.5)
    volume = 0.5 * (19.36 * 17.0 - 28 * 1.4 * 2.45)
    solid = cad_solid(voxels)
    assert solid.Volume() == pytest.approx(volume, rel=1e-12)
    write_step(solid, tmp_path / "wall.step")
    report = check_step(tmp_path / "wall.step", volume=volume, extent=(19.36, 0.5, 17.0))
    assert report.valid
    assert report.volume == pytest.approx(volume, rel=1e-9)
    assert report.extent == pytest.approx((19.36, 0.5, 17.0), rel=1e-9)
    assert report.faces == 2 + 4 + 4 * 28
    mass, extent, faces = read_by_gmsh(gmsh_session, tmp_path / "wall.step")
    assert mass == pytest.approx(volume, rel=1e-9)
    assert extent == pytest.approx((19.36, 0.5, 17.0), abs=3e-7)  # gmsh widens boxes by its tolerance
    assert faces == 2 + 4 + 4 * 28


def test_wall_stands_in_the_facade_frame(make_voxels):
    box = cad_solid(make_voxels([(0, 0, 2, 3)], 0.5)).BoundingBox()
    assert (box.xmin, box.ymin, box.zmin) == pytest.approx((0, 0, 0), abs=1e-12)
    assert (box.xmax, box.ymax, box.zmax) == pytest.approx((2, 0.5, 3), abs=1e-12)


def test_file_declares_metres_and_its_name(tmp_path, make_voxels):
    write_step(cad_solid(make_voxels([(0, 0, 2, 3)], 0.5)), tmp_path / "a.step", name="north wall")
    text = (tmp_path / "a.step").read_text()
    assert re.findall(r"LENGTH_UNIT\(\) NAMED_UNIT\(\*\) (SI_UNIT\([^)]*\))", text) == ["SI_UNIT($,.METRE.)"]
    assert ".MILLI." not in text
    assert re.findall(r" PRODUCT\('([^']*)','([^']*)'", text) == [("north wall", "north wall")]
    corners = re.findall(r"CARTESIAN_POINT\('',\(([^)]*)\)\)", text)
    assert max(float(v) for corner in corners for v in corner.split(",")) == 3.0


def test_second_file_is_named_like_the_first(tmp_path, make_voxels):
    solid = cad_solid(make_voxels([(0, 0, 2, 3)]))
    for name in ("a", "b"):
        write_step(solid, tmp_path / f"{name}.step")
        assert "PRODUCT('facade','facade'" in (tmp_path / f"{name}.step").read_text()


def test_opencascade_prints_nothing_and_keeps_its_settings(tmp_path, make_voxels, capfd):
    from OCP.Interface import Interface_Static
    from OCP.Message import Message

    solid = cad_solid(make_voxels([(0, 0, 2, 3)]))
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    write_step(solid, tmp_path / "a.step")
    check_step(tmp_path / "a.step", volume=3.0, extent=(2, 0.5, 3))
    (tmp_path / "bad.step").write_text("hello\n")
    with pytest.raises(InputError):
        check_step(tmp_path / "bad.step", volume=3.0, extent=(2, 0.5, 3))
    assert capfd.readouterr().out == ""
    assert Interface_Static.CVal_s("xstep.cascade.unit") == "MM"
    assert len(list(Message.DefaultMessenger_s().Printers())) > 0


@pytest.mark.parametrize(
    ("volume", "extent", "match"),
    [
        (3.00001, (2, 0.5, 3), "a.step: the volume reads back as 3, expected 3.00001"),
        (3.0, (2.00001, 0.5, 3), "the extent in x reads back as 2, expected 2.00001"),
        (3.0, (2, 0.5, 3000), "the extent in z"),
    ],
)
def test_other_sizes_are_noticed(tmp_path, make_voxels, volume, extent, match):
    write_step(cad_solid(make_voxels([(0, 0, 2, 3)])), tmp_path / "a.step")
    with pytest.raises(NumericsError, match=match):
        check_step(tmp_path / "a.step", volume=volume, extent=extent)


def test_millimetre_file_with_metre_numbers_is_noticed(tmp_path, make_voxels):
    """What cadquery writes by default for a model in metres."""
    cad_solid(make_voxels([(0, 0, 2, 3)])).exportStep(str(tmp_path / "mm.step"))
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


@pytest.mark.parametrize(
    ("boxes", "match"),
    [
        ([(0, 0, 1, 1), (3, 0, 4, 2)], r"falls into 2 pieces, the smallest of 1\.0000 m² at x = 0\.000"),
        ([(0, 0, 1, 1), (1, 1, 2, 2)], "falls into 2 pieces"),
        (
            # A ring of voxels around two empty ones that meet in the point (2, 2).
            [(0, 0, 4, 1), (0, 3, 4, 4), (0, 1, 1, 3), (3, 1, 4, 3), (1, 2, 2, 3), (2, 1, 3, 2)],
            r"meet only at their edge at x = 2\.000, z = 2\.000",
        ),
        ([(0, 0, 2, 2), (1, 1, 3, 3)], "overlap"),
    ],
)
def test_walls_that_are_no_solid(boxes, match, make_voxels):
    with pytest.raises(InputError, match=match):
        cad_solid(make_voxels(boxes))


def test_unwritable_path(tmp_path, make_voxels):
    with pytest.raises(NumericsError, match="could not be written"):
        write_step(cad_solid(make_voxels([(0, 0, 2, 3)])), tmp_path / "none" / "a.step")
