"""Facades from STEP files: round trips, other units and orientations, shapes that are no facade."""

import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import Facade, Opening, OpeningKind, rectangle
from fd2fem.solids import cad_solid, facade_from_step, write_step

DOOR, WINDOW = OpeningKind.DOOR, OpeningKind.WINDOW
HOUSE = Facade(
    rectangle(0, 0, 7.3, 6.2),
    0.35,
    (
        Opening(1, DOOR, rectangle(1.1, 0, 1.0, 2.2)),
        Opening(2, WINDOW, rectangle(3.0, 0.9, 1.3, 1.4)),
        Opening(3, DOOR, rectangle(5.0, 0, 1.2, 2.1)),
        Opening(4, WINDOW, rectangle(0.8, 3.5, 1.0, 1.5)),
        Opening(5, WINDOW, rectangle(4.9, 3.6, 1.0, 1.5)),
    ),
)


@pytest.fixture(scope="module")
def house(make_facade_voxels):
    return cad_solid(make_facade_voxels(HOUSE))


def check_house(facade):
    assert facade.outline == pytest.approx(HOUSE.outline, abs=1e-6)
    assert facade.thickness == pytest.approx(HOUSE.thickness, abs=1e-6)
    assert [(o.id, o.kind) for o in facade.openings] == [(o.id, o.kind) for o in HOUSE.openings]
    for have, want in zip(facade.openings, HOUSE.openings, strict=True):
        assert have.outline == pytest.approx(want.outline, abs=1e-6)


def test_round_trip(tmp_path, house):
    write_step(house, tmp_path / "house.step")
    facade = facade_from_step(tmp_path / "house.step")
    check_house(facade)
    assert facade.frame.origin == pytest.approx([0, 0, 0], abs=1e-9)
    assert facade.frame.axes == pytest.approx(np.eye(3), abs=1e-12)
    assert facade.record["source"] == "house.step"
    assert facade.record["volume_over_front_times_thickness"] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(("unit", "metre"), [("MM", 1000.0), ("INCH", 1 / 0.0254)])
def test_other_units_come_out_in_metres(tmp_path, house, unit, metre):
    house.scale(metre).exportStep(str(tmp_path / "house.step"), unit=unit)
    check_house(facade_from_step(tmp_path / "house.step"))


@pytest.mark.parametrize("angle", [-80.0, -30.0, 45.0, 89.0])
def test_walls_at_an_angle_in_plan(tmp_path, house, angle):
    turned = house.rotate((0, 0, 0), (0, 0, 1), angle).translate((10.0, -4.0, 2.5))
    write_step(turned, tmp_path / "house.step")
    facade = facade_from_step(tmp_path / "house.step")
    check_house(facade)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    assert facade.frame.origin == pytest.approx([10.0, -4.0, 2.5], abs=1e-6)
    assert facade.frame.axes == pytest.approx(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), abs=1e-9)


def test_wall_along_y_looks_towards_minus_x(tmp_path, house):
    write_step(house.rotate((0, 0, 0), (0, 0, 1), -90.0), tmp_path / "house.step")
    facade = facade_from_step(tmp_path / "house.step")
    check_house(facade)
    assert facade.frame.axes[1] == pytest.approx([1, 0, 0], abs=1e-9)


def test_thickness_can_be_overruled(tmp_path, house):
    write_step(house, tmp_path / "house.step")
    assert facade_from_step(tmp_path / "house.step", thickness=0.5).thickness == 0.5


def extruded(outer, inner=(), depth=0.3):
    from cadquery import Solid, Vector, Wire

    wires = [Wire.makePolygon([Vector(x, 0, z) for x, z in ring], close=True) for ring in (outer, *inner)]
    return Solid.extrudeLinear(wires[0], wires[1:], Vector(0, depth, 0))


def test_gable_and_step_belong_to_the_outline(tmp_path):
    gable = [(0, 0), (4, 0), (4, 1), (5, 1), (5, 3), (2.5, 5), (0, 3)]
    write_step(extruded(gable), tmp_path / "gable.step")
    facade = facade_from_step(tmp_path / "gable.step")
    assert facade.openings == ()
    assert facade.outline == pytest.approx(np.array(gable), abs=1e-9)


def test_round_windows_and_arched_doors_are_flattened(tmp_path):
    from cadquery import Solid

    wall = extruded([(0, 0), (6, 0), (6, 5), (0, 5)])
    eye = Solid.makeCylinder(0.5, 1.0, pnt=(4.5, -0.5, 3.0), dir=(0, 1, 0))
    door = Solid.makeBox(1.2, 1.0, 2.0, pnt=(1.0, -0.5, 0.0))
    arch = Solid.makeCylinder(0.6, 1.0, pnt=(1.6, -0.5, 2.0), dir=(0, 1, 0))
    write_step(wall.cut(eye, door.fuse(arch)).Solids()[0], tmp_path / "wall.step")
    facade = facade_from_step(tmp_path / "wall.step")
    assert [o.kind for o in facade.openings] == [DOOR, WINDOW]
    first, second = facade.openings
    # A chord leaves its arc by 1 mm at the most, so the area lacks less than 2/3 mm times the arc's length.
    assert 0 < 1.2 * 2.0 + np.pi * 0.6**2 / 2 - first.area < 1e-3 * np.pi * 0.6
    assert 0 < np.pi * 0.5**2 - second.area < 1e-3 * np.pi
    assert np.hypot(*(second.outline - [4.5, 3.0]).T) == pytest.approx(
        np.full(len(second.outline), 0.5), abs=2e-9
    )
    assert facade.outline == pytest.approx(rectangle(0, 0, 6, 5), abs=1e-9)


def test_faces_in_pieces_are_joined(tmp_path):
    """As a program leaves them that fuses boxes without cleaning up."""
    from cadquery import Solid

    left, right = (Solid.makeBox(2.0, 0.3, 3.0, pnt=(x, 0, 0)) for x in (0.0, 2.0))
    fused = left.fuse(right).Solids()[0]
    assert len(fused.Faces()) == 10
    write_step(fused, tmp_path / "wall.step")
    assert facade_from_step(tmp_path / "wall.step").outline == pytest.approx(rectangle(0, 0, 4, 3), abs=1e-9)


def shapes():
    from cadquery import Compound, Face, Solid, Vector

    box = Solid.makeBox(4.0, 0.3, 3.0)
    elbow = extruded([(0, 0), (4, 0), (4, 4), (3.7, 4), (3.7, 0.3), (0, 0.3)], depth=5.0)
    wedge = extruded([(0, 0), (4, 0), (2, 3)], depth=5.0)
    return {
        "sphere": (Solid.makeSphere(1.0, pnt=Vector(0, 0, 0)), "no vertical plane face"),
        "slab": (Solid.makeBox(4.0, 3.0, 0.3), r"it is 3\.000 m thick and 0\.300 m high"),
        "pair": (Compound.makeCompound([box, box.translate((9, 0, 0))]), "it holds 2 solids"),
        "face": (Face.makePlane(4.0, 3.0), "it holds 0 solids"),
        "wedge": (wedge.rotate((0, 0, 0), (1, 0, 0), 90), "no plane face lies opposite"),
        "elbow": (elbow.rotate((0, 0, 0), (1, 0, 0), 90), r"its volume is 2\.081 times"),
    }


@pytest.mark.parametrize("name", ["sphere", "slab", "pair", "face", "wedge", "elbow"])
def test_shapes_that_are_no_facade(tmp_path, name):
    shape, match = shapes()[name]
    write_step(shape, tmp_path / "shape.step")
    with pytest.raises(InputError, match=rf"shape.step is not a facade: .*({match})"):
        facade_from_step(tmp_path / "shape.step")


def test_files_that_are_no_step(tmp_path, house):
    with pytest.raises(InputError, match="no such file"):
        facade_from_step(tmp_path / "missing.step")
    write_step(house, tmp_path / "whole.step")
    whole = (tmp_path / "whole.step").read_text()
    for text in ("", "hello\nworld\n", whole[: len(whole) // 2]):
        (tmp_path / "bad.step").write_text(text)
        with pytest.raises(InputError, match=r"bad\.step is not a whole STEP file"):
            facade_from_step(tmp_path / "bad.step")
    data = whole.index("DATA;") + len("DATA;\n")
    (tmp_path / "empty.step").write_text(whole[:data] + whole[whole.rindex("ENDSEC;") :])
    with pytest.raises(InputError, match=r"empty\.step holds no geometry|not a whole STEP file"):
        facade_from_step(tmp_path / "empty.step")
