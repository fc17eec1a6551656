"""DXF drawings, made with ezdxf as a draughtsman would."""

import ezdxf
import numpy as np
import pytest

from fd2fem.drawings import read_facade
from fd2fem.errors import InputError


def box(x, y, width, height):
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def drawing(units=6):
    file = ezdxf.new("R2010")
    file.header["$INSUNITS"] = units
    return file, file.modelspace()


def read(tmp_path, file, **options):
    file.saveas(tmp_path / "a.dxf")
    return read_facade(tmp_path / "a.dxf", **options)


def sizes(facade):
    return [(o.kind.value, *(round(v, 6) for v in (o.x, o.z, o.width, o.height))) for o in facade.openings]


EXPECTED = [
    ("door", 0.5, 0.0, 1.0, 2.1),
    ("window", 2.5, 0.9, 1.5, 1.2),
    ("window", 0.5, 3.0, 1.2, 1.4),
    ("window", 2.75, 3.1, 1.2, 1.4),
]


@pytest.mark.parametrize(
    ("units", "per_metre"), [(6, 1), (5, 100), (4, 1000), (0, 1), (0, 1000), (1, 1 / 0.0254)]
)
def test_units(tmp_path, units, per_metre):
    file, space = drawing(units)
    for kind, *shape in [EXPECTED[3], EXPECTED[1], ("wall", 0, 0, 5, 6), EXPECTED[0], EXPECTED[2]]:
        points = [(x * per_metre, y * per_metre) for x, y in box(shape[0] + 7, shape[1] - 3, *shape[2:])]
        space.add_lwpolyline(points, close=True, dxfattribs={"layer": kind.upper()})
    facade = read(tmp_path, file)
    assert (facade.length, facade.height) == pytest.approx((5, 6), abs=1e-9)
    assert sizes(facade) == EXPECTED
    assert [o.id for o in facade.openings] == [1, 2, 3, 4]  # by rows, left to right
    assert facade.thickness == 0.35
    assert facade.record["source"] == "a.dxf"
    assert read(tmp_path, file, thickness=0.5).thickness == 0.5


def test_polylines_of_all_kinds(tmp_path):
    file, space = drawing()
    corners = box(0, 0, 5, 6)
    space.add_polyline2d([*corners, corners[0]])  # ends where it begins, without the closed flag
    space.add_polyline3d([(x, y, 0) for x, y in box(1, 1, 1, 1)], close=True)
    space.add_polyline2d(box(3, 1, 1, 1), close=True)
    space.add_lwpolyline([*box(1, 3, 1, 1), (1, 3)])
    space.add_lwpolyline(box(3, 3, 1, 1))  # open: does not count
    space.add_line((0, 0), (5, 6))
    space.add_text("elevation")
    assert sizes(read(tmp_path, file)) == [("window", x, z, 1, 1) for x, z in ((1, 1), (3, 1), (1, 3))]


def test_largest_polyline_is_the_wall_and_what_stands_on_it_a_door(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(box(1, 0.0004, 1, 2), close=True)  # drawn 0.4 mm too high
    space.add_lwpolyline(box(0, 0, 5, 6), close=True)
    facade = read(tmp_path, file)
    assert (facade.openings[0].kind, facade.openings[0].z) == ("door", 0.0)


def test_frame_of_the_sheet_and_panes_are_left_out(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(box(-10, -10, 40, 30), close=True, dxfattribs={"layer": "SHEET"})
    space.add_lwpolyline(box(0, 0, 5, 6), close=True, dxfattribs={"layer": "A-WALL-OUTLINE"})
    space.add_lwpolyline(box(1, 1, 1, 2), close=True, dxfattribs={"layer": "GLAZ"})
    for _ in range(2):
        space.add_lwpolyline(box(1.1, 1.1, 0.8, 0.8), close=True, dxfattribs={"layer": "GLAZ"})
        space.add_lwpolyline(box(3, 1, 1, 2), close=True, dxfattribs={"layer": "GLAZ"})  # twice in one place
    space.add_lwpolyline(box(20, 1, 1, 2), close=True, dxfattribs={"layer": "DETAIL"})
    assert sizes(read(tmp_path, file)) == [("window", 1, 1, 1, 2), ("window", 3, 1, 1, 2)]


@pytest.mark.parametrize(("units", "per_metre"), [(6, 1), (4, 1000)])
def test_arch(tmp_path, units, per_metre):
    # Semicircle of radius 0.6 m over a rectangle of 1.2 x 1 m: a bulge of 1 is half a turn.
    file, space = drawing(units)
    space.add_lwpolyline([(x * per_metre, y * per_metre) for x, y in box(0, 0, 5, 6)], close=True)
    points = [(1, 1, 0), (2.2, 1, 0), (2.2, 2, 1), (1, 2, 0)]
    space.add_lwpolyline([(x * per_metre, y * per_metre, b) for x, y, b in points], format="xyb", close=True)
    (arch,) = read(tmp_path, file).openings
    assert (arch.width, arch.height) == pytest.approx((1.2, 1.6), abs=1e-9)
    assert arch.area == pytest.approx(1.2 + np.pi * 0.6**2 / 2, rel=1e-12)
    assert [(a.x, a.z, a.a, a.b) for a in arch.arcs] == [pytest.approx((1.6, 2.0, 0.6, 0.6))] * 2
    radii = np.hypot(*(arch.outline[arch.outline[:, 1] > 2.0001] - [1.6, 2.0]).T)
    assert radii.min() > 0.6 - 1e-9
    assert radii.max() < 0.601
    assert 8 <= len(arch.outline) <= 70


def test_windows_as_blocks(tmp_path):
    file, space = drawing()
    block = file.blocks.new("WINDOW")
    block.add_lwpolyline(box(0, 0, 1, 1), close=True)
    space.add_lwpolyline(box(0, 0, 5, 6), close=True)
    space.add_blockref("WINDOW", (1, 1))
    space.add_blockref("WINDOW", (3, 1), dxfattribs={"yscale": 2})
    assert sizes(read(tmp_path, file)) == [("window", 1, 1, 1, 1), ("window", 3, 1, 1, 2)]


def test_elevation_drawn_upright_in_space(tmp_path):
    file, space = drawing()
    for shape in (box(0, 0, 5, 6), box(1, 1, 1, 2)):
        space.add_polyline3d([(x, 0, z) for x, z in shape], close=True)
    assert sizes(read(tmp_path, file)) == [("window", 1, 1, 1, 2)]


def test_door_layer_that_does_not_reach_the_ground(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(box(0, 0, 5, 6), close=True)
    space.add_lwpolyline(box(1, 0.2, 1, 2), close=True, dxfattribs={"layer": "Doors"})
    with pytest.raises(InputError, match=r"a\.dxf: opening 1 \(door.*does not reach the ground"):
        read(tmp_path, file)


def test_opening_across_the_edge(tmp_path):
    file, space = drawing()
    space.add_lwpolyline(box(0, 0, 5, 6), close=True)
    space.add_lwpolyline(box(4.5, 1, 1, 2), close=True)
    with pytest.raises(InputError, match=r"opening 1 .* does not lie inside the wall"):
        read(tmp_path, file)


def test_no_closed_polyline(tmp_path):
    file, space = drawing()
    space.add_line((0, 0), (5, 0))
    space.add_lwpolyline([(0, 0), (5, 0)], close=True)
    with pytest.raises(InputError, match="is not a facade: it has no closed polyline"):
        read(tmp_path, file)


def test_polyline_that_crosses_itself(tmp_path):
    file, space = drawing()
    space.add_lwpolyline([(0, 0), (5, 6), (5, 0), (0, 6)], close=True, dxfattribs={"layer": "Wall"})
    with pytest.raises(InputError, match="on layer 'wall' is wrong: Self-intersection"):
        read(tmp_path, file)


def test_unknown_units(tmp_path):
    file, space = drawing(units=13)
    space.add_lwpolyline(box(0, 0, 5, 6), close=True)
    with pytest.raises(InputError, match=r"\$INSUNITS is 13, which is not read"):
        read(tmp_path, file)


@pytest.mark.parametrize(
    "content",
    [b"", b"a drawing", bytes(range(256)) * 4, b"0\nSECTION\n2\nENTITIES\n0\nEOF\n", b"0\nSECTION\n2\n"],
)
def test_files_that_are_not_dxf(tmp_path, content):
    (tmp_path / "a.dxf").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.dxf is not a DXF drawing that can be read") as caught:
        read_facade(tmp_path / "a.dxf")
    assert "\n" not in str(caught.value)
