"""What is wrong with a wall is said in one line, or dealt with as documented, in each format alike."""

import json

import ezdxf
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.drawings import read_facade
from fd2fem.drawings.facade_toml import facade_from_toml
from fd2fem.errors import InputError

WALL = [[0, 0], [5, 0], [5, 4], [0, 4]]


def box(x, z, width=1.0, height=1.0):
    return [[x, z], [x + width, z], [x + width, z + height], [x, z + height]]


def as_json(folder, wall, openings):
    entries = [
        {"kind": "door" if min(z for _, z in ring) <= 0 else "window", "outline": ring} for ring in openings
    ]
    content = {"schema": "fd2fem/facade-1", "units": "m", "outline": wall, "openings": entries}
    (folder / "a.json").write_text(json.dumps(content), encoding="utf-8")
    return folder / "a.json"


def as_toml(folder, wall, openings):
    entries = ", ".join(f"{{outline = {ring}}}" for ring in openings)
    (folder / "a.toml").write_text(f"outline = {wall}\nopenings = [{entries}]", encoding="utf-8")
    return folder / "a.toml"


def as_dxf(folder, wall, openings):
    file = ezdxf.new("R2010")
    file.header["$INSUNITS"] = 6
    for layer, ring in [("WALL", wall), *(("OPENING", ring) for ring in openings)]:
        file.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})
    file.saveas(folder / "a.dxf")
    return folder / "a.dxf"


FORMATS = pytest.mark.parametrize("write", [as_json, as_toml, as_dxf])
CROSSES = "Self-intersection"
NAN, INF = float("nan"), float("inf")


@FORMATS
@pytest.mark.parametrize(
    ("wall", "openings", "message"),
    [
        pytest.param([[0, 0], [5, 4], [5, 0], [0, 4]], [], CROSSES, id="wall crosses itself"),
        pytest.param(
            [[0, 0], [5, 0], [5, 4], [2, 4], [2, 6], [2, 4], [0, 4]], [], CROSSES, id="wall with a spike"
        ),
        pytest.param([[0, 0], [5, 0], [5, 4], [2.5, 0], [0, 4]], [], CROSSES, id="wall touches itself"),
        pytest.param([[0, 0], [5, 0], [2, 0]], [], f"{CROSSES}|no closed polyline", id="wall without area"),
        pytest.param([[0, 0], [5, 0]], [], "at least 3|no closed polyline", id="wall of two corners"),
        pytest.param([[0, 0], [5, 0], [5, NAN], [0, 4]], [], "NaN|finite", id="corner that is not a number"),
        pytest.param(WALL, [box(1, 1, INF)], "Infinity|finite", id="corner at infinity"),
        pytest.param(WALL, [[[1, 1], [2, 2], [2, 1], [1, 2]]], CROSSES, id="opening crosses itself"),
        pytest.param(
            WALL, [[[1, 1], [2, 1], [2, 2], [1.5, 1], [1, 2]]], CROSSES, id="opening touches itself"
        ),
        pytest.param(
            WALL, [[*box(1, 1)[:3], [1.5, 2], [1.5, 3], [1.5, 2], [1, 2]]], CROSSES, id="opening with a spike"
        ),
        pytest.param(WALL, [box(4.5, 1)], "opening 1 .*does not lie inside the wall", id="across the end"),
        pytest.param(WALL, [box(1, -0.5)], "opening 1 .*does not lie inside the wall", id="below the ground"),
        pytest.param(WALL, [box(4, 1)], "opening 1 .*touches the edge of the wall", id="at the end"),
        pytest.param(WALL, [box(1, 3)], "opening 1 .*touches the edge of the wall", id="at the top"),
        pytest.param(
            WALL, [box(1, 0, 1, 4)], "opening 1 .*touches the edge of the wall", id="from ground to top"
        ),
        pytest.param(WALL, [box(0, 0)], "opening 1 .*touches the edge of the wall", id="door at the end"),
        pytest.param(WALL, [box(1, 1), box(2, 1)], "openings 1 and 2 touch or overlap", id="sides touch"),
        pytest.param(WALL, [box(1, 1), box(2, 2)], "openings 1 and 2 touch or overlap", id="corners touch"),
        pytest.param(WALL, [box(1, 1), box(1.5, 1.5)], "openings 1 and 2 touch or overlap", id="overlap"),
        pytest.param(WALL, [box(1, 0), box(2, 0)], "openings 1 and 2 touch or overlap", id="doors touch"),
    ],
)
def test_refused_in_one_line(tmp_path, write, wall, openings, message):
    path = write(tmp_path, wall, openings)
    with pytest.raises(InputError, match=message) as caught:
        read_facade(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@FORMATS
@pytest.mark.parametrize(
    ("wall", "opening"),
    [
        pytest.param(WALL[::-1], box(1, 1)[::-1], id="clockwise"),
        pytest.param([*WALL, WALL[0]], [*box(1, 1), [1, 1]], id="closed"),
        pytest.param([WALL[0], *WALL, WALL[3]], [*box(1, 1)[:2], *box(1, 1)[1:]], id="corners twice"),
        pytest.param([WALL[0], [0, 1e-8], *WALL[1:]], box(1, 1), id="corners a hair apart"),
    ],
)
def test_dealt_with(tmp_path, write, wall, opening):
    facade = read_facade(write(tmp_path, wall, [opening]))
    assert len(facade.outline) == 4
    assert (facade.length, facade.height) == pytest.approx((5, 4), abs=1e-7)
    assert len(facade.openings[0].outline) == 4
    assert facade.wall_area == pytest.approx(19.0, abs=1e-6)


@pytest.mark.parametrize("write", [as_json, as_toml])
@pytest.mark.parametrize(
    ("openings", "message"),
    [
        pytest.param([box(6, 1)], "opening 1 .*does not lie inside the wall", id="beside the wall"),
        pytest.param([box(1, 1), box(1, 1)], "openings 1 and 2 touch or overlap", id="twice"),
        pytest.param([box(1, 1, 2, 2), box(1.5, 1.5)], "openings 1 and 2 touch or overlap", id="nested"),
        pytest.param([box(1, 1, 1e-4)], "opening 1 .*narrower than a millimetre", id="narrow"),
        pytest.param([box(0, 0, 5, 4)], "touches the edge of the wall", id="the whole wall"),
    ],
)
def test_what_a_drawing_of_lines_may_hold_and_a_list_may_not(tmp_path, write, openings, message):
    # Of a DXF drawing, panes, what is drawn twice, strokes and what lies beside the wall are left out.
    with pytest.raises(InputError, match=message):
        read_facade(write(tmp_path, WALL, openings))
    counts = [len(read_facade(as_dxf(tmp_path, WALL, openings)).openings)]
    assert counts in ([0], [1])


STOREYS = [
    ([{"z": 2.0, "thickness": 0.0}], "storey 1: 'thickness': input should be greater than 0, got 0.0"),
    ([{"z": 2.0, "thickness": -0.2}], "storey 1: 'thickness': input should be greater than 0"),
    ([{"z": 2.0}], "storey 1: 'thickness' is missing"),
    ([{"z": "top", "thickness": 0.2}], "storey 1: 'z': input should be a valid number, got 'top'"),
    ([{"z": 0.0, "thickness": 0.2}], "Invalid 'z of a storey': expected a positive number, got 0"),
    ([{"z": 4.0, "thickness": 0.2}], "storey from z = 4 m must begin .* below the wall's top at 4 m"),
    (
        [{"z": 2.0, "thickness": 0.3}, {"z": 1.0, "thickness": 0.2}],
        "storey from z = 1 m must begin above z = 2",
    ),
    (
        [{"z": 2.0, "thickness": 0.3}, {"z": 2.0, "thickness": 0.2}],
        "storey from z = 2 m must begin above z = 2",
    ),
]


@pytest.mark.parametrize(("storeys", "message"), STOREYS)
def test_storeys_that_are_refused(tmp_path, storeys, message):
    content = {"schema": "fd2fem/facade-1", "units": "m", "outline": WALL, "storeys": storeys, "openings": []}
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    tables = "".join("[[storeys]]\n" + "".join(f"{k} = {v!r}\n" for k, v in s.items()) for s in storeys)
    (tmp_path / "a.toml").write_text(f"outline = {WALL}\n{tables}", encoding="utf-8")
    for name in ("a.json", "a.toml"):
        with pytest.raises(InputError, match=message) as caught:
            read_facade(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path / name))
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("opening", "message"),
    [
        (
            "head = {shape = 'arc', rise = 0.8}",
            "'head.rise' is 0.8, but an arc rises by at most half the width, 0.5",
        ),
        (
            "head = {shape = 'pointed', rise = 0.4}",
            "'head.rise' is 0.4, but a pointed head rises by at least half",
        ),
        (
            "head = {shape = 'elliptical', rise = 2.5}",
            "'head.rise' is 2.5, more than the opening's 'height' of 2",
        ),
        ("head = {shape = 'elliptical'}", "'head.rise' is missing: only a head of shape 'arc'"),
        (
            "head = {shape = 'round'}",
            "'head.shape': input should be 'arc', 'elliptical', 'pointed' or 'gabled'",
        ),
        ("head = {shape = 'arc', rise = 0}", "'head.rise': input should be greater than 0"),
        ("head = {shape = 'arc', rise = nan}", "'head.rise': input should be a finite number"),
        ("head = {shape = 'arc', hight = 1}", "unknown key 'head.hight'"),
        ("head = 'arc'", "'head': input should be a valid dictionary"),
        ("shape = 'circle'", "'shape': input should be 'rectangle' or 'ellipse', got 'circle'"),
        ("shape = 'ellipse', head = {shape = 'arc'}", "has both 'head' and 'shape': leave one out"),
    ],
)
def test_heads_that_are_refused(tmp_path, opening, message):
    text = f"outline = {WALL}\nopenings = [{{x = 1, z = 1, width = 1, height = 2, {opening}}}]"
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=f"opening 1: {message}") as caught:
        read_facade(tmp_path / "a.toml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("head = {shape = 'arc'}", "has both 'head' and 'outline': leave one out"),
        ("shape = 'ellipse'", "has both 'shape' and 'outline': leave one out"),
    ],
)
def test_outlines_with_another_shape_are_refused(tmp_path, key, message):
    text = f"outline = {WALL}\nopenings = [{{outline = {box(1, 1)}, {key}}}]"
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_facade(tmp_path / "a.toml")


NUMBERS = st.floats(0.5, 2.0) | st.floats() | st.integers(-(10**12), 10**12)


@settings(max_examples=150, deadline=None)
@given(
    st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS),
    NUMBERS,
    st.sampled_from(["", "head = {shape = '%s', rise = %r}", "shape = 'ellipse'"]),
    st.sampled_from(["arc", "elliptical", "pointed", "gabled"]),
)
def test_numbers_of_any_size_end_in_a_facade_or_in_one_line(sizes, number, shape, head):
    keys = ", ".join(
        f"{key} = {size!r}" for key, size in zip(("x", "z", "width", "height"), sizes, strict=True)
    )
    more = shape % (head, number) if "%" in shape else shape
    bent = f"{{outline = [[3, 1], [4, 1], [4, 2, {number!r}], [3, 2]]}}"
    text = f"outline = {WALL}\nopenings = [{{{keys}{', ' * bool(more)}{more}}}, {bent}]"
    try:
        facade = facade_from_toml(text, source="a.toml")
    except InputError as error:
        one_line = str(error)
    else:
        one_line = f"a.toml: {len(facade.openings)} openings"
    assert one_line.startswith("a.toml: ")
    assert "\n" not in one_line


def test_what_no_dxf_can_mean(tmp_path):
    # Enormous, flat and mirrored blocks, circles and bulges of no size, blocks inside themselves.
    for k, value in enumerate([0.0, -1.0, 1e-12, 1e9, 1e20, 1e300, NAN]):
        file = ezdxf.new("R2010")
        file.header["$INSUNITS"] = 6
        space, block = file.modelspace(), file.blocks.new("B")
        space.add_lwpolyline(WALL, close=True, dxfattribs={"layer": "WALL"})
        block.add_circle((1, 1), 0.2 if k % 2 else value)
        block.add_blockref("B", (0, 0))
        space.add_blockref("B", (1, 1), dxfattribs={"xscale": value, "yscale": value})
        space.add_lwpolyline([(3, 1, value), (4, 1, value)], format="xyb", close=True)
        file.saveas(tmp_path / "a.dxf")
        try:
            found = f"{tmp_path / 'a.dxf'}: {len(read_facade(tmp_path / 'a.dxf').openings)}"
        except InputError as error:
            found = str(error)
        assert found.startswith(str(tmp_path / "a.dxf"))
        assert "\n" not in found


@pytest.mark.parametrize(
    ("kind", "z", "message"),
    [
        ("window", 0.0, "opening 1 .*touches the edge of the wall at the ground: call it a door or raise it"),
        ("door", 0.2, "opening 1 .*does not reach the ground at z = 0: call it a window or lower it"),
    ],
)
def test_kinds_that_do_not_fit_the_place(tmp_path, kind, z, message):
    ring = box(1, z)
    content = {
        "schema": "fd2fem/facade-1",
        "units": "m",
        "outline": WALL,
        "openings": [{"kind": kind, "outline": ring}],
    }
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    (tmp_path / "a.toml").write_text(
        f"outline = {WALL}\nopenings = [{{kind = '{kind}', outline = {ring}}}]", encoding="utf-8"
    )
    for name in ("a.json", "a.toml"):
        with pytest.raises(InputError, match=message) as caught:
            read_facade(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path / name))
