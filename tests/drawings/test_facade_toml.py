"""TOML drawings: what they say, and how their mistakes are named."""

import numpy as np
import pytest

from fd2fem.drawings import read_facade
from fd2fem.errors import InputError
from fd2fem.model import OpeningKind

DRAWING = """
name = "Gable end"
source = "survey of 2019, sheet 4"
length = 4.95
height = 12
[[openings]]
x = 0.4
z = 0
width = 1.25
height = 2.5
[[openings]]
outline = [[2, 1], [3, 1], [3, 2], [2.5, 2.5], [2, 2]]
"""


def read(tmp_path, text, **options):
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    return read_facade(tmp_path / "a.toml", **options)


def test_a_drawing(tmp_path):
    facade = read(tmp_path, DRAWING)
    assert facade.outline.tolist() == [[0, 0], [4.95, 0], [4.95, 12], [0, 12]]
    assert facade.thickness == 0.35
    assert [(o.id, o.kind) for o in facade.openings] == [(1, OpeningKind.DOOR), (2, OpeningKind.WINDOW)]
    assert facade.opening_area == pytest.approx(1.25 * 2.5 + 1.25, abs=1e-12)  # by hand
    assert dict(facade.record) == {"name": "Gable end", "source": "survey of 2019, sheet 4"}
    assert np.array_equal(facade.frame.axes, np.eye(3))
    assert read(tmp_path, DRAWING, thickness=0.5).thickness == 0.5
    assert read(tmp_path, "length = 3\nheight = 2\nthickness = 0.4").thickness == 0.4
    assert read(tmp_path, "length = 3\nheight = 2\nthickness = 0.4", thickness=0.5).thickness == 0.5


def test_a_wall_without_openings_is_a_facade(tmp_path):
    assert read(tmp_path, "length = 3\nheight = 2").openings == ()


def test_millimetres(tmp_path):
    facade = read(
        tmp_path,
        "units = 'mm'\nlength = 4950\nheight = 12160\nthickness = 215\nframe.origin = [1000, 2000, 3000]\n"
        "openings = [{x = 425, z = 0, width = 4100, height = 2956}]",
    )
    assert (facade.length, facade.height, facade.thickness) == (4.95, 12.16, 0.215)
    assert facade.frame.origin.tolist() == [1, 2, 3]
    assert facade.openings[0].outline.tolist() == [[0.425, 0], [4.525, 0], [4.525, 2.956], [0.425, 2.956]]


def test_outline_that_does_not_begin_at_the_origin(tmp_path):
    facade = read(
        tmp_path,
        "outline = [[10, 5], [14, 5], [14, 8], [12, 9], [10, 8]]\n"
        "frame = {origin = [100, 200, 300], heading = 90}\n"
        "openings = [{x = 11, z = 5, width = 1, height = 2}, {x = 12.5, z = 6, width = 1, height = 1}]",
    )
    assert facade.outline.tolist() == [[0, 0], [4, 0], [4, 3], [2, 4], [0, 3]]
    assert [(o.x, o.z, o.kind.value) for o in facade.openings] == [(1, 0, "door"), (2.5, 1, "window")]
    # Facing east-west by hand: x points north, y (into the wall) west; the corner is 10 m along, 5 m up.
    assert np.allclose(facade.frame.axes, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], rtol=0, atol=1e-15)
    assert np.allclose(facade.frame.origin, [100, 210, 305], rtol=0, atol=1e-12)
    assert np.allclose(facade.frame.to_world([[1, 0, 0]]), [[100, 211, 305]], rtol=0, atol=1e-12)


def test_heading_turns_anticlockwise_from_east(tmp_path):
    facade = read(tmp_path, "length = 3\nheight = 2\n[frame]\nheading = 30")
    assert np.allclose(facade.frame.axes[0], [np.sqrt(3) / 2, 0.5, 0], rtol=0, atol=1e-15)
    assert np.linalg.det(facade.frame.axes) == pytest.approx(1.0, abs=1e-15)


WALL = "length = 5\nheight = 4\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.toml is not a facade: it has neither 'length' and 'height' nor 'outline'"),
        ("[material]\nyoung = 1e9", "a.toml is not a facade"),
        ("length = = 5", r"a\.toml is not TOML: .*line 1"),
        ("length = 5", "a.toml: 'height' is missing"),
        ("length = 5\nheigth = 4", "unknown key 'heigth'"),
        ("length = -5\nheight = 4", "'length': input should be greater than 0, got -5"),
        ("length = '5'\nheight = 4", "'length': input should be a valid number, got '5'"),
        ("length = nan\nheight = 4", "'length': input should be a finite number, got nan"),
        ("length = true\nheight = 4", "'length': input should be a valid number, got True"),
        (WALL + "outline = [[0, 0], [1, 0], [1, 1]]", "has both 'outline' and 'length', 'height'"),
        (WALL + "units = 'ft'", "'units': input should be 'm' or 'mm', got 'ft'"),
        (WALL + "thickness = 0", "'thickness': input should be greater than 0"),
        (WALL + "frame.origin = [1, 2]", "'frame.origin': list should have at least 3 items"),
        (WALL + "frame.heading = 'north'", "'frame.heading': input should be a valid number, got 'north'"),
        (WALL + "openings = 3", "'openings': input should be a valid list, got 3"),
        (WALL + "[[openings]]\nx = 1", "opening 1: 'z', 'width', 'height' are missing"),
        (
            WALL + "[[openings]]\nkind = 'door'",
            "opening 1: needs 'x', 'z', 'width' and 'height', or 'outline'",
        ),
        (
            WALL + "openings = [{x=1,z=1,width=1,height=1}, {x=3,z=1,width=-1,height=1}]",
            "opening 2: 'width': .*greater than 0, got -1",
        ),
        (WALL + "openings = [{x=1,z=1,widht=1,height=1}]", "opening 1: unknown key 'widht'"),
        (WALL + "openings = [{x='a',z='b',width=1,height=1}]", r"opening 1: 'x': .*got 'a' \(and 1 more\)"),
        (WALL + "openings = [{kind='gate',x=1,z=1,width=1,height=1}]", "opening 1: 'kind': .*got 'gate'"),
        (
            WALL + "openings = [{x=1,outline=[[1,1],[2,1],[2,2]]}]",
            "opening 1: has both 'outline' and 'x': leave one out",
        ),
        (
            WALL + "openings = [{outline=[[1,1],[2,2],[2,1],[1,2]]}]",
            "outline of opening 1': Self-intersection",
        ),
        (
            WALL + "openings = [{x=1,z=1,width=5,height=1}]",
            "a.toml: opening 1 .*does not lie inside the wall",
        ),
        (WALL + "openings = [{x=1,z=-1,width=1,height=1}]", "opening 1 .*does not lie inside the wall"),
        (
            WALL + "openings = [{kind='door',x=1,z=1,width=1,height=1}]",
            "opening 1 .*does not reach the ground",
        ),
        (
            WALL + "openings = [{x=1,z=1,width=1,height=1},{x=1.5,z=1,width=1,height=1}]",
            "openings 1 and 2 touch or overlap",
        ),
        (WALL + "openings = [{x=0,z=1,width=1,height=1}]", "opening 1 .*touches the edge of the wall"),
    ],
)
def test_what_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)
