"""facade.json: the contract's keys, exact round trips, and what is refused."""

import copy
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.drawings import facade_from_dict, facade_to_dict, read_facade, write_facade
from fd2fem.errors import InputError
from fd2fem.model import (
    EdgeSigma,
    Facade,
    FacadeFrame,
    FilledHole,
    Opening,
    OpeningKind,
    rectangle,
)


def example():
    turn = np.radians(30.0)
    axes = [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    arch = [[2.0, 1.0], [3.0, 1.0], [3.0, 2.0], [2.5, 2.4], [2.0, 2.0]]
    return Facade(
        outline=np.array([[0, 0], [6.1, 0], [6.1, 3], [3, 4.2], [0, 3]]),
        thickness=0.1 + 0.2,
        openings=(
            Opening(1, OpeningKind.DOOR, rectangle(0.7, 0, 0.9, 2.1), 0.8, {"rays": 12, "share": 1 / 3}),
            Opening(2, OpeningKind.WINDOW, np.array(arch), sigma=EdgeSigma(0.001, 0.002, 0.003, 0.004)),
        ),
        filled_holes=(FilledHole(rectangle(4, 0.5, 1, 1), "shadow of a post", {"seen": False}),),
        frame=FacadeFrame(np.array([674321.123456789, 5403210.1, 512.7]), np.array(axes)),
        record={
            "points": {"read": 190865, "on_facade": 150000},
            "options": {"spacing": None, "seed": 7},
            "timings_s": {"plane": 0.25},
            "version": "0.1.0",
            "warnings": ["one", "two"],
        },
    )


def test_keys_of_the_contract():
    content = facade_to_dict(example())
    assert set(content) >= {
        *("schema", "units", "frame", "length", "height", "thickness", "opening_area", "outline", "openings"),
        *("filled_holes", "points", "options", "timings_s", "version"),
    }
    assert content["schema"] == "fd2fem/facade-1"
    assert content["units"] == "m"
    assert set(content["frame"]) == {"origin", "x", "y", "z"}
    # By hand: 0.9 * 2.1 and the unit square with a gable of 0.4.
    assert content["length"] == 6.1
    assert content["height"] == 4.2
    assert content["opening_area"] == pytest.approx(1.89 + 1.2, abs=1e-12)
    door, window = content["openings"]
    assert set(door) == {
        *("id", "kind", "x", "z", "width", "height", "area", "outline", "arcs"),
        *("confidence", "evidence", "sigma"),
    }
    assert (door["id"], door["kind"], door["x"], door["z"]) == (1, "door", 0.7, 0.0)
    assert window["area"] == pytest.approx(1.2, abs=1e-12)
    assert window["height"] == pytest.approx(1.4, abs=1e-12)
    assert window["sigma"] == {"left": 0.001, "right": 0.002, "bottom": 0.003, "top": 0.004}
    assert content["filled_holes"] == [
        {
            "outline": [[4, 0.5], [5, 0.5], [5, 1.5], [4, 1.5]],
            "area": 1.0,
            "reason": "shadow of a post",
            "evidence": {"seen": False},
        }
    ]


def assert_same(a, b):
    assert np.array_equal(a.outline, b.outline)
    assert a.thickness == b.thickness
    assert np.array_equal(a.frame.origin, b.frame.origin)
    assert np.array_equal(a.frame.axes, b.frame.axes)
    assert dict(a.record) == dict(b.record)
    for p, q in zip(a.openings, b.openings, strict=True):
        assert (p.id, p.kind, p.confidence, p.sigma) == (q.id, q.kind, q.confidence, q.sigma)
        assert np.array_equal(p.outline, q.outline)
        assert dict(p.evidence) == dict(q.evidence)
    for p, q in zip(a.filled_holes, b.filled_holes, strict=True):
        assert np.array_equal(p.outline, q.outline)
        assert (p.reason, dict(p.evidence)) == (q.reason, dict(q.evidence))


def test_round_trip_is_exact(tmp_path):
    write_facade(example(), tmp_path / "facade.json")
    assert_same(read_facade(tmp_path / "facade.json"), example())
    content = json.loads((tmp_path / "facade.json").read_text(encoding="utf-8"))
    assert facade_to_dict(facade_from_dict(content, source="x")) == content


LENGTHS = st.floats(0.2, 30.0)
FREE = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(LENGTHS, LENGTHS), max_size=5),
    st.floats(0.05, 2.0),
    st.tuples(*[st.floats(-1e7, 1e7)] * 3),
    st.dictionaries(
        st.text().filter(lambda key: key not in {"schema", "units", "frame", "length", "height"}),
        FREE,
        max_size=4,
    ),
)
def test_round_trip_of_any_facade(tmp_path_factory, sizes, thickness, origin, extra):
    x, openings = 0.3, []
    for number, (width, height) in enumerate(sizes, start=1):
        openings.append(Opening(number, OpeningKind.WINDOW, rectangle(x, 0.3, width, height), 1 / number))
        x += width + 0.3
    top = max((height for _, height in sizes), default=3.0) + 0.9
    own = {"points": {"read": 1}, "options": {}, "timings_s": {}, "version": "x"}
    keys = facade_to_dict(Facade(rectangle(0, 0, 1, 1), 1)).keys()
    record = {**{key: value for key, value in extra.items() if key not in keys}, **own}
    facade = Facade(
        rectangle(0, 0, x + 0.3, top),
        thickness,
        tuple(openings),
        frame=FacadeFrame(np.array(origin), np.eye(3)),
        record=record,
    )
    path = tmp_path_factory.mktemp("any") / "facade.json"
    write_facade(facade, path)
    assert_same(read_facade(path), facade)


def test_numpy_values_and_numbers_that_json_has_not():
    record = {
        "a": np.float64(0.1),
        "b": np.arange(3),
        "c": (np.int64(2), np.bool_(1)),
        "d": float("nan"),
        "e": OpeningKind.DOOR,
    }
    content = facade_to_dict(Facade(rectangle(0, 0, 2, 2), 0.3, record=record))
    assert json.loads(json.dumps({key: content[key] for key in record}, allow_nan=False)) == {
        "a": 0.1,
        "b": [0, 1, 2],
        "c": [2, True],
        "d": None,
        "e": "door",
    }


def test_least_that_a_file_must_hold():
    facade = facade_from_dict(
        {
            "schema": "fd2fem/facade-1",
            "units": "m",
            "length": 5,
            "height": 4,
            "openings": [{"kind": "window", "x": 1, "z": 1, "width": 2, "height": 1, "colour": "red"}],
            "surveyor": "J. Doe",
        },
        source="a.json",
    )
    assert facade.outline.tolist() == [[0, 0], [5, 0], [5, 4], [0, 4]]
    assert facade.openings[0].outline.tolist() == [[1, 1], [3, 1], [3, 2], [1, 2]]
    assert (facade.openings[0].id, facade.openings[0].confidence) == (1, 1.0)
    assert facade.thickness == 0.35
    assert facade.frame.axes.tolist() == np.eye(3).tolist()
    assert dict(facade.record) == {"surveyor": "J. Doe"}


def test_thickness_in_place_of_the_files(tmp_path):
    write_facade(example(), tmp_path / "facade.json")
    assert read_facade(tmp_path / "facade.json", thickness=0.5).thickness == 0.5
    with pytest.raises(InputError, match="Invalid 'thickness'"):
        read_facade(tmp_path / "facade.json", thickness=-1.0)


def changed(*path, value):
    content = copy.deepcopy(facade_to_dict(example()))
    place = content
    for key in path[:-1]:
        place = place[key]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return content


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([1, 2], "a.json is not a facade: it has no key 'schema'"),
        ({}, "is not a facade: it has no key 'schema'"),
        (
            changed("schema", value="fd2fem/response-1"),
            "its schema is 'fd2fem/response-1', expected 'fd2fem/facade-1'",
        ),
        (changed("schema", value=["\n"]), "is not a facade: its schema"),
        (changed("units", value="mm"), "a.json: 'units': input should be 'm', got 'mm'"),
        (changed("units", value=...), "'units' is missing"),
        (changed("openings", value=...), "'openings' is missing"),
        (
            changed("openings", 1, "kind", value="hatch"),
            "opening 2: 'kind': input should be 'window' or 'door', got 'hatch'",
        ),
        (changed("openings", 1, "kind", value=...), "opening 2: 'kind' is missing"),
        (
            changed("openings", 0, "outline", 2, 1, value="high"),
            r"opening 1: 'outline\[2\]\[1\]': input should be a valid number",
        ),
        (changed("openings", 0, "width", value=1.9), "opening 1: 'width' is 1.9, but the outlines say 0.9"),
        (changed("openings", 0, "area", value=3.9), "opening 1: 'area' is 3.9, but the outlines say 1.89"),
        (changed("openings", 0, "id", value=2), r"have the same 'id': \[2, 2\]"),
        (
            changed("openings", 0, "confidence", value=1.1),
            "opening 1: 'confidence': input should be less than or equal to 1",
        ),
        (changed("length", value=7.0), "'length' is 7, but the outlines say 6.1"),
        (changed("opening_area", value=7.0), "'opening_area' is 7, but the outlines say 3.09"),
        (changed("thickness", value=0.0), "'thickness': input should be greater than 0, got 0.0"),
        (changed("outline", value=[[0, 0], [1, 1]]), "'outline': list should have at least 3 items"),
        (
            changed("outline", value=[[0, 0], [1, 1], [1, 0], [0, 1]]),
            "a.json: Invalid 'outline': Self-intersection",
        ),
        (changed("frame", "x", value=[1, 1, 0]), "a.json: Invalid 'axes': expected three orthonormal rows"),
        (changed("frame", "y", value=...), "'frame.y' is missing"),
        (
            changed("filled_holes", 0, "outline", value=3),
            "filled hole 1: 'outline': input should be a valid list",
        ),
        (changed("openings", 0, "outline", value=[[7, 1], [8, 1], [8, 2]]), "does not lie inside the wall"),
        ({**changed("outline", value=...), "height": None}, "'height' is missing"),
    ],
)
def test_what_is_refused(content, message):
    with pytest.raises(InputError, match=message) as caught:
        facade_from_dict(content, source="a.json")
    assert str(caught.value).startswith("a.json")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is not JSON"),
        ("{", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ('{"schema": NaN}', "is not JSON: it holds NaN"),
        ("\udcff", "is not text: byte 1"),
    ],
)
def test_files_that_are_not_json(tmp_path, text, message):
    (tmp_path / "a.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=message) as caught:
        read_facade(tmp_path / "a.json")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("record", "message"),
    [({"length": 3}, "'length' is a key of the facade itself"), ({"a": [{1}]}, "JSON cannot hold a set")],
)
def test_records_that_are_not_written(record, message):
    with pytest.raises(InputError, match=message):
        facade_to_dict(Facade(rectangle(0, 0, 2, 2), 0.3, record=record))


def test_files_that_cannot_be(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.json: no such file"):
        read_facade(tmp_path / "nowhere.json")
    with pytest.raises(InputError, match="is a folder"):
        read_facade(tmp_path)
    (tmp_path / "a.step").write_text("ISO-10303-21;")
    with pytest.raises(InputError, match=r"a\.step is not read as a facade; convert to"):
        read_facade(tmp_path / "a.step")
    with pytest.raises(InputError, match="cannot be written: No such file"):
        write_facade(example(), tmp_path / "nowhere" / "a.json")
