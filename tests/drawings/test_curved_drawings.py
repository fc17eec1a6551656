"""Curved edges and storeys: drawn in TOML and DXF, kept by facade.json, with the areas of closed forms."""

import copy
import json

import ezdxf
import numpy as np
import pytest
from ezdxf.math import Vec3
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.drawings import facade_from_dict, facade_to_dict, read_facade
from fd2fem.drawings.facade_toml import facade_from_toml
from fd2fem.errors import InputError
from fd2fem.model import Storey

WALL = "length = 12\nheight = 9\nthickness = 0.4\n"


def area_above_jambs(shape, width, rise):
    """Textbook areas of segments and of sectors less a triangle."""
    half = width / 2.0
    if shape == "elliptical":
        return np.pi / 2.0 * half * rise
    if shape == "gabled":
        return half * rise
    if shape == "arc":
        radius = (half**2 + rise**2) / (2.0 * rise)
        angle = 4.0 * np.arctan(rise / half)
        return radius**2 / 2.0 * (angle - np.sin(angle))
    radius = (half**2 + rise**2) / (2.0 * half)
    return radius**2 * np.arctan2(rise, radius - half) - (radius - half) * rise


RANGES = {"arc": (0.05, 0.5), "elliptical": (0.05, 1.2), "pointed": (0.5, 1.2), "gabled": (0.05, 1.2)}


@st.composite
def headed(draw):
    """An opening with a head, and its area."""
    shape = draw(st.sampled_from(sorted(RANGES)))
    width = draw(st.floats(0.4, 3.0))
    rise = width * draw(st.floats(*RANGES[shape]))
    height = rise + draw(st.just(0.0) | st.floats(0.05, 3.0))
    area = width * (height - rise) + area_above_jambs(shape, width, rise)
    return shape, width, height, rise, area


@settings(max_examples=60, deadline=None)
@given(headed(), st.booleans(), st.sampled_from(["m", "mm"]))
def test_heads_through_toml_and_json(opening, door, units):
    shape, width, height, rise, area = opening
    k = 1000.0 if units == "mm" else 1.0
    text = (
        f"units = '{units}'\nlength = {6 * k}\nheight = {9 * k}\n[[openings]]\nx = {1.3 * k}\n"
        f"z = {0.0 if door else 0.7 * k}\nwidth = {width * k!r}\nheight = {height * k!r}\n"
        f"head = {{shape = '{shape}', rise = {rise * k!r}}}\n"
    )
    facade = facade_from_toml(text, source="a.toml")
    (found,) = facade.openings
    assert found.kind.value == ("door" if door else "window")
    assert found.area == pytest.approx(area, rel=1e-9)
    assert (found.x, found.width, found.height) == pytest.approx((1.3, width, height), rel=1e-9)
    assert len(found.arcs) == (0 if shape == "gabled" else 2)
    again = facade_from_dict(json.loads(json.dumps(facade_to_dict(facade))), source="a.json")
    assert again.openings[0].arcs == found.arcs
    assert np.array_equal(again.openings[0].outline, found.outline)
    assert facade_to_dict(again) == facade_to_dict(facade)


def test_an_arc_without_a_rise_is_a_round_head():
    (arch,) = facade_from_toml(
        WALL + "openings = [{x = 1, z = 0, width = 1.2, height = 2.6, head = {shape = 'arc'}}]", source="a"
    ).openings
    assert arch.area == pytest.approx(1.2 * 2.0 + np.pi * 0.36 / 2, rel=1e-12)
    assert [(arc.x, arc.z, arc.a, arc.b) for arc in arch.arcs] == [pytest.approx((1.6, 2.0, 0.6, 0.6))] * 2


@pytest.mark.parametrize(("width", "height"), [(0.9, 0.9), (1.2, 0.7)])
def test_ellipses(width, height):
    text = WALL + f"openings = [{{shape = 'ellipse', x = 2, z = 5, width = {width}, height = {height}}}]"
    (window,) = facade_from_toml(text, source="a").openings
    assert window.area == pytest.approx(np.pi / 4 * width * height, rel=1e-12)
    assert (window.x, window.z, window.width, window.height) == pytest.approx(
        (2, 5, width, height), rel=1e-12
    )
    assert len(window.arcs) == 4


def test_outlines_that_bend():
    # A round gable, half a disc of 2 m radius on a wall of 4 x 3 m; a window that is half an oculus.
    text = (
        "outline = [[10, 5], [14, 5], [14, 8, 1], [10, 8]]\n"
        "openings = [{outline = [[11, 8], [13, 8, 1]]}]\nstoreys = [{z = 7, thickness = 0.2}]"
    )
    facade = facade_from_toml(text, source="a.toml")
    assert (facade.length, facade.height) == pytest.approx((4, 5), rel=1e-12)
    assert facade.wall_area == pytest.approx(12 + np.pi * 2 - np.pi / 2, rel=1e-12)
    assert [(arc.x, arc.z, arc.a) for arc in facade.arcs] == [pytest.approx((2, 3, 2))] * 2
    # Storeys move with the wall: the drawing's ground is at z = 5.
    assert facade.storeys == (Storey(2.0, 0.2),)
    upper = 4 + np.pi * 2 - np.pi / 2
    assert facade.volume == pytest.approx(8 * 0.35 + upper * 0.2, rel=1e-9)


def test_storeys_in_millimetres_and_json():
    text = (
        "units = 'mm'\nlength = 5000\nheight = 9000\nthickness = 480\n"
        "[[storeys]]\nz = 3200\nthickness = 360\n[[storeys]]\nz = 6000\nthickness = 360\n"
        "[[storeys]]\nz = 7000\nthickness = 240"
    )
    facade = facade_from_toml(text, source="a.toml")
    # The second one changes nothing.
    assert facade.storeys == (Storey(3.2, 0.36), Storey(7.0, 0.24))
    assert facade.volume == pytest.approx(5 * (3.2 * 0.48 + 3.8 * 0.36 + 2 * 0.24), rel=1e-12)
    content = facade_to_dict(facade)
    assert content["thickness"] == 0.48
    assert content["storeys"] == [{"z": 3.2, "thickness": 0.36}, {"z": 7.0, "thickness": 0.24}]
    assert facade_from_dict(content, source="a").storeys == facade.storeys
    assert facade_from_toml(text, source="a.toml", thickness=0.6).bands[0].thickness == 0.6


@pytest.mark.parametrize("level", [2.3, 2.0, 2.499999])
def test_an_arch_across_a_storeys_level(level):
    # A round head of 1 m over 2 m: the part of the half disc above the level is a segment.
    text = (
        "length = 5\nheight = 6\nthickness = 0.5\nstoreys = [LEVEL]\n"
        "openings = [{x = 1, z = 0, width = 1, height = 2.5, head = {shape = 'arc'}}]"
    ).replace("LEVEL", f"{{z = {level!r}, thickness = 0.3}}")
    facade = facade_from_toml(text, source="a.toml")
    angle = 2 * np.arccos((level - 2.0) / 0.5)
    above = 0.125 * (angle - np.sin(angle))
    below = 2.0 + np.pi / 8 - above
    exact = 0.5 * (5 * level - below) + 0.3 * (5 * (6 - level) - above)
    assert facade.volume == pytest.approx(exact, rel=1e-8)
    again = facade_from_dict(json.loads(json.dumps(facade_to_dict(facade))), source="a.json")
    assert facade_to_dict(again) == facade_to_dict(facade)


def test_files_without_arcs_and_storeys_still_read():
    content = facade_to_dict(facade_from_toml(WALL, source="a.toml"))
    assert content["arcs"] == content["storeys"] == []
    del content["arcs"], content["storeys"]
    facade = facade_from_dict(content, source="a.json")
    assert facade.arcs == facade.storeys == ()


ARCHED = (
    "outline = [[0, 0], [6, 0], [6, 4, 1], [0, 4]]\n"
    "openings = [{x = 1, z = 1, width = 1, height = 2, head = {shape = 'arc'}}]"
)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("openings", 0, "arcs", 0, "first"), -1, "opening 1: arc 1: 'first': input should be greater"),
        (
            ("openings", 0, "arcs", 0, "first"),
            1.5,
            "opening 1: arc 1: 'first': input should be a valid integer",
        ),
        (("openings", 0, "arcs", 0, "last"), 99, "Invalid arc 1 of 'outline of opening 1': corners 2 to 99"),
        (
            ("openings", 0, "arcs", 0, "radii"),
            [0.5, 0.0],
            r"opening 1: arc 1: 'radii\[1\]': input should be greater",
        ),
        (("openings", 0, "arcs", 0, "radii"), [0.5, 0.4], "arc 1 of .*its ends do not lie on the curve"),
        (("openings", 0, "arcs", 1, "centre"), [1.5, 2.6], "arc 2 of .*its ends do not lie on the curve"),
        (
            ("openings", 0, "outline", 5),
            [1.9, 2.9],
            "another area than the curve; facet it anew, or leave it out",
        ),
        (("arcs", 0, "centre"), [3.0], "arc 1: 'centre': list should have at least 2 items"),
        (("arcs", 0, "radii"), [3.0, 3.5], "arc 1 of 'outline': its ends do not lie on the curve"),
        (("arcs", 1), {"first": 2, "last": 5, "centre": [3, 4], "radii": [3, 3]}, "arc 2 of 'outline'"),
    ],
)
def test_arcs_that_do_not_fit(path, value, message):
    content = copy.deepcopy(facade_to_dict(facade_from_toml(ARCHED, source="a.toml")))
    place = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    with pytest.raises(InputError, match=message) as caught:
        facade_from_dict(content, source="a.json")
    assert str(caught.value).startswith("a.json: ")
    assert "\n" not in str(caught.value)


def test_arcs_need_an_outline():
    content = facade_to_dict(facade_from_toml(ARCHED, source="a.toml"))
    del content["openings"][0]["outline"]
    with pytest.raises(InputError, match="opening 1: has 'arcs' but no 'outline'"):
        facade_from_dict(content, source="a.json")


def test_corners_in_the_wrong_sense_cannot_have_arcs():
    content = facade_to_dict(facade_from_toml(ARCHED, source="a.toml"))
    content["openings"][0]["outline"].reverse()
    with pytest.raises(InputError, match="with arcs it must run counter-clockwise"):
        facade_from_dict(content, source="a.json")


def drawing(units=6):
    file = ezdxf.new("R2010")
    file.header["$INSUNITS"] = units
    return file, file.modelspace()


def read(tmp_path, file, **options):
    file.saveas(tmp_path / "a.dxf")
    return read_facade(tmp_path / "a.dxf", **options)


BOX = [(0, 0), (12, 0), (12, 9), (0, 9)]


@pytest.mark.parametrize(("units", "k"), [(6, 1.0), (4, 1000.0), (1, 1 / 0.0254)])
def test_circles_and_ellipses_of_a_dxf(tmp_path, units, k):
    file, space = drawing(units)
    space.add_lwpolyline([(x * k + 70, y * k - 3) for x, y in BOX], close=True)
    space.add_circle((2 * k + 70, 3 * k - 3), 0.45 * k)
    space.add_ellipse((5 * k + 70, 3 * k - 3), major_axis=(0.8 * k, 0), ratio=0.5)
    space.add_ellipse((8 * k + 70, 3 * k - 3), major_axis=(0, 0.8 * k), ratio=0.5)
    space.add_ellipse((10 * k + 70, 3 * k - 3), major_axis=(0.4 * k, 0.4 * k), ratio=0.5)
    space.add_ellipse((5 * k + 70, 6 * k - 3), major_axis=(k, 0), ratio=0.5, start_param=0, end_param=3)
    circle, level, upright, leaning = read(tmp_path, file).openings
    assert circle.area == pytest.approx(np.pi * 0.45**2, rel=1e-9)
    assert [arc.a for arc in circle.arcs] == [pytest.approx(0.45)] * 4
    assert (circle.x, circle.width) == pytest.approx((1.55, 0.9), abs=1e-9)
    assert [level.area, upright.area] == pytest.approx([np.pi * 0.8 * 0.4] * 2, rel=1e-9)
    assert {(round(a.a, 9), round(a.b, 9)) for a in (*level.arcs, *upright.arcs)} == {(0.8, 0.4), (0.4, 0.8)}
    # An ellipse that leans has no arcs, but its corners bound its area too.
    assert leaning.arcs == ()
    assert leaning.area == pytest.approx(np.pi * 0.32 * 0.5, rel=1e-9)


def test_a_wall_with_a_round_gable_and_a_pointed_window(tmp_path):
    file, space = drawing()
    space.add_lwpolyline([(0, 0, 0), (6, 0, 0), (6, 4, 1), (0, 4, 0)], format="xyb", close=True)
    # Two arcs of 60 degrees about the other springing: an equilateral pointed arch of 1.2 m.
    bulge = np.tan(np.radians(60) / 4)
    apex = 2 + 1.2 * np.sqrt(0.75)
    points = [(1, 0, 0), (2.2, 0, 0), (2.2, 2, bulge), (1.6, apex, bulge), (1, 2, 0)]
    space.add_lwpolyline(points, format="xyb", close=True)
    facade = read(tmp_path, file)
    assert facade.height == pytest.approx(7.0, abs=1e-9)
    assert len(facade.arcs) == 2
    (door,) = facade.openings
    exact = 2.4 + 2 * (1.44 * np.pi / 6) - 1.44 * np.sqrt(3) / 4
    assert door.area == pytest.approx(exact, rel=1e-9)
    assert facade.wall_area == pytest.approx(24 + np.pi * 4.5 - exact, rel=1e-9)
    assert sorted(round(arc.x, 9) for arc in door.arcs) == [1.0, 2.2]


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-0.4, 1.0), min_size=4, max_size=4), st.booleans(), st.booleans())
def test_bulges_have_the_area_of_segments(tmp_path_factory, bulges, clockwise, heavy):
    # A bulge b over a chord c: a segment of the angle 4 atan b; to the left of a counter-clockwise square
    # edge lies the square, so that a positive bulge adds it. Less than -0.41 and two of them would cross.
    corners = [(4.0, 3.0), (7.0, 3.0), (7.0, 6.0), (4.0, 6.0)]
    area = 9.0
    for bulge in bulges:
        if abs(bulge) > 1e-4:
            angle = 4 * np.arctan(abs(bulge))
            radius = 3.0 * (1 + bulge**2) / (4 * abs(bulge))
            area += np.sign(bulge) * radius**2 / 2 * (angle - np.sin(angle))
        else:  # a parabola
            area += 2 / 3 * 3.0 * 3.0 * bulge / 2
    points = [(*corner, bulge) for corner, bulge in zip(corners, bulges, strict=True)]
    if clockwise:
        points = [(*corners[-k], -bulges[-k - 1]) for k in range(4)]
    file, space = drawing()
    space.add_lwpolyline(BOX, close=True)
    if heavy:
        space.add_polyline2d(points, format="xyb", close=True)
    else:
        space.add_lwpolyline(points, format="xyb", close=True)
    facade = read(tmp_path_factory.mktemp("bulges"), file)
    (opening,) = facade.openings
    # What bulges by less than 1e-6 m is straight.
    assert opening.area == pytest.approx(area, abs=1e-5)
    if all(abs(bulge) > 1e-3 for bulge in bulges):
        assert opening.area == pytest.approx(area, rel=1e-9)
    assert len(opening.arcs) >= sum(3.0 * abs(bulge) / 2 > 2e-6 for bulge in bulges)


def test_a_circle_of_two_bulges_is_one_curve(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(BOX, close=True)
    tilt = Vec3(0.6, 0.8)  # corners away from the extremes
    first, second = Vec3(5, 5) + tilt, Vec3(5, 5) - tilt
    space.add_lwpolyline([(first.x, first.y, 1), (second.x, second.y, 1)], format="xyb", close=True)
    (window,) = read(tmp_path, file).openings
    assert len(window.arcs) == 4
    assert window.area == pytest.approx(np.pi, rel=1e-9)
    assert (window.width, window.height) == pytest.approx((2, 2), abs=1e-9)


def test_blocks_that_are_turned_mirrored_and_stretched(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(BOX, close=True)
    block = file.blocks.new("ARCH", base_point=(1, 1))
    block.add_lwpolyline([(1, 1, 0), (2, 1, 0), (2, 2, 1), (1, 2, 0)], format="xyb", close=True)
    outer = file.blocks.new("PAIR")
    outer.add_blockref("ARCH", (0, 0))
    outer.add_blockref("ARCH", (3, 0), dxfattribs={"xscale": -1})
    area = 1 + np.pi / 8
    space.add_blockref("PAIR", (1, 1))
    space.add_blockref("ARCH", (6, 1), dxfattribs={"yscale": 2})  # the arc becomes half an ellipse
    space.add_blockref("ARCH", (10, 1), dxfattribs={"rotation": 90})
    space.add_blockref("ARCH", (2, 5), dxfattribs={"column_count": 3, "column_spacing": 2, "layer": "DOORS"})
    # What a block has on layer 0 is on the layer of its insert.
    with pytest.raises(InputError, match=r"door.*does not reach the ground"):
        read(tmp_path, file)
    space[-1].dxf.layer = "WINDOWS"
    openings = read(tmp_path, file).openings
    assert [o.area for o in openings] == pytest.approx(
        [area, area, 2 * area, area, area, area, area], rel=1e-9
    )
    assert [(o.x, o.z) for o in openings[:3]] == [
        pytest.approx(at, abs=1e-9) for at in ((1, 1), (3, 1), (6, 1))
    ]
    assert {(round(arc.a, 9), round(arc.b, 9)) for arc in openings[2].arcs} == {(0.5, 1.0)}
    assert all(len(opening.arcs) == 2 for opening in openings)


def test_a_drawing_seen_from_behind_or_upright_in_space(tmp_path):
    # Extrusion (0, 0, -1) mirrors the polyline's own x axis; (0, -1, 0) makes its plane the elevation's.
    mirrored, space = drawing()
    space.add_lwpolyline(BOX, close=True)
    arch = [(-2, 1, 0), (-1, 1, 0), (-1, 2, 1), (-2, 2, 0)]
    space.add_lwpolyline(arch, format="xyb", close=True, dxfattribs={"extrusion": (0, 0, -1)})
    space.add_circle((-4, 2), 0.5, dxfattribs={"extrusion": (0, 0, -1)})
    upright, space = drawing()
    for points in (BOX, [(1, 1, 0), (2, 1, 0), (2, 2, 1), (1, 2, 0)]):
        format_ = "xyb" if len(points[0]) == 3 else "xy"
        space.add_lwpolyline(points, format=format_, close=True, dxfattribs={"extrusion": (0, -1, 0)})
    space.add_circle((4, 2, 0), 0.5, dxfattribs={"extrusion": (0, -1, 0)})
    for file in (mirrored, upright):
        arch, circle = read(tmp_path, file).openings
        assert (arch.x, arch.z, arch.area) == pytest.approx((1, 1, 1 + np.pi / 8), rel=1e-9)
        assert (circle.x, circle.z, circle.area) == pytest.approx((3.5, 1.5, np.pi / 4), rel=1e-9)
        assert len(arch.arcs) == 2


@pytest.mark.parametrize("lift", [0.0004, -0.0004])
def test_feet_that_are_set_down_keep_the_arcs(tmp_path, lift):
    file, space = drawing()
    space.add_lwpolyline(BOX, close=True)
    points = [(1, lift, 0), (2, lift, 0), (2, 2, 1), (1, 2, 0)]
    space.add_lwpolyline(points, format="xyb", close=True)
    space.add_lwpolyline([(4, lift, 0), (6, lift, 1)], format="xyb", close=True)  # its feet end its arc
    door, lunette = read(tmp_path, file).openings
    assert {door.kind.value, lunette.kind.value} == {"door"}
    assert (door.z, lunette.z) == pytest.approx((0, 0), abs=1e-12)
    assert door.area == pytest.approx(2 + np.pi / 8, rel=1e-9)
    assert lunette.area == pytest.approx(np.pi / 2, rel=1e-9)
    assert len(door.arcs) == len(lunette.arcs) == 2


def test_arcs_far_from_the_origin(tmp_path):
    file, space = drawing(4)
    shift = np.array([674321e3, 5403210e3])
    space.add_lwpolyline(np.array(BOX) * 1000 + shift, close=True)
    space.add_circle(np.array([2000, 3000]) + shift, 450)
    (window,) = read(tmp_path, file).openings
    arc = window.arcs[0]
    assert (arc.x, arc.z, arc.a, arc.b) == pytest.approx((2, 3, 0.45, 0.45), abs=1e-8)
    assert window.area == pytest.approx(np.pi * 0.45**2, rel=1e-7)
