"""PCD against files that the Point Cloud Library wrote (see data/README.md)."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.scans.pcd import read_pcd

DATA = Path(__file__).parent / "data"
WALL = np.loadtxt(DATA / "wall.txt")
SURVEY = np.array([674321.0, 5403210.0, 512.0])
KINDS = ["ascii", "binary", "compressed"]


def pcd(path, body, **changed):
    """A text file of PCD by hand; `changed` replaces lines of the header, None leaves one out."""
    lines = {
        "VERSION": "0.7",
        "FIELDS": "x y z",
        "SIZE": "8 8 8",
        "TYPE": "F F F",
        "COUNT": "1 1 1",
        "WIDTH": str(len(body.splitlines())),
        "HEIGHT": "1",
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": str(len(body.splitlines())),
        "DATA": "ascii",
    } | changed
    head = "".join(f"{name} {text}\n" for name, text in lines.items() if text is not None)
    path.write_text("# .PCD v0.7\n" + head + body)
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_single_precision_by_pcl(kind):
    raw = read_pcd(DATA / f"pcl_float_{kind}.pcd")
    # A float32 between 8 and 16 has steps of 2**-20 m.
    assert np.abs(raw.points - WALL[:, :3]).max() <= 2.0**-21
    assert np.abs(raw.intensity - WALL[:, 3]).max() <= 2.0**-25
    assert np.allclose(raw.scanners, [[2.5, -9.0, 1.6]], rtol=0, atol=1e-12)
    assert raw.step <= 2.0**-20


@pytest.mark.parametrize("kind", KINDS)
def test_double_precision_by_pcl(kind):
    raw = read_pcd(DATA / f"pcl_double_{kind}.pcd")
    # 12 digits in the text; PCL read the numbers as doubles.
    tolerance = 1e-5 if kind == "ascii" else 1e-9
    assert np.abs(raw.points - (WALL[:, :3] + SURVEY)).max() <= tolerance
    assert np.isnan(raw.scanners).all()
    assert raw.step == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_rays_without_a_return_by_pcl(kind):
    raw = read_pcd(DATA / f"pcl_nan_{kind}.pcd")
    back = np.arange(80) % 10 != 3
    assert raw.no_returns == 8
    assert np.abs(raw.points - WALL[back, :3]).max() <= 2.0**-21
    assert np.abs(raw.intensity - WALL[back, 3]).max() <= 2.0**-25


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.95])
def test_cut_short(tmp_path, kind, share):
    content = (DATA / f"pcl_float_{kind}.pcd").read_bytes()
    path = tmp_path / "a.pcd"
    path.write_bytes(content[: int(share * len(content.rstrip(b"\0")))])
    with pytest.raises(InputError, match=r"a\.pcd.*(cut short|not a PCD|line \d+ does not hold)") as caught:
        read_pcd(path)
    assert "\n" not in str(caught.value)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(KINDS), st.integers(0, 2**30), st.integers(0, 255))
def test_a_damaged_byte_is_refused_or_does_no_harm(tmp_path_factory, kind, place, value):
    content = bytearray((DATA / f"pcl_float_{kind}.pcd").read_bytes())
    content[place % len(content)] = value
    path = tmp_path_factory.mktemp("any") / "a.pcd"
    path.write_bytes(content)
    try:
        raw = read_pcd(path)
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert len(raw.points) + raw.no_returns <= 80


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-1e9, 1e9)] * 3), min_size=1, max_size=9, unique=True))
def test_every_digit_is_kept(tmp_path_factory, points):
    body = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
    raw = read_pcd(pcd(tmp_path_factory.mktemp("any") / "a.pcd", body))
    assert np.array_equal(raw.points, np.array(points))


def test_fields_of_all_kinds_are_skipped(tmp_path):
    # PCL pads records with fields named _, and stores features with many numbers in one field.
    record = np.dtype(
        [("rgb", "<u4"), ("_", "u1", (4,)), ("x", "<f4"), ("fpfh", "<f4", (33,)), ("y", "<f4"), ("z", "<f4")]
    )
    data = np.zeros(80, dtype=record)
    for name, column in zip("xyz", WALL.T, strict=False):
        data[name] = column
    head = pcd(
        tmp_path / "head.pcd",
        "",
        FIELDS="rgb _ x fpfh y z",
        SIZE="4 1 4 4 4 4",
        TYPE="U U F F F F",
        COUNT="1 4 1 33 1 1",
        WIDTH="80",
        POINTS="80",
        DATA="binary",
    )
    path = tmp_path / "a.pcd"
    path.write_bytes(head.read_bytes() + data.tobytes())
    assert np.array_equal(read_pcd(path).points, WALL[:, :3].astype(np.float32))


@pytest.mark.parametrize("view", ["0 0 0 0.7 0 0 0.7", "1.5 -8 1.6 1 0 0 0"])
def test_a_viewpoint_does_not_move_the_points(tmp_path, view):
    raw = read_pcd(pcd(tmp_path / "a.pcd", "1 2 3\n4 5 6\n7 8 9\n", VIEWPOINT=view))
    assert raw.points.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert raw.scanners.tolist() == [[float(word) for word in view.split()[:3]]]


def test_older_files_have_no_viewpoint_and_may_lack_a_count(tmp_path):
    raw = read_pcd(pcd(tmp_path / "a.pcd", "1 2 3\n4 5 6\n", VERSION=".6", VIEWPOINT=None, COUNT=None))
    assert len(raw.points) == 2
    assert np.isnan(raw.scanners).all()


@pytest.mark.parametrize(
    ("body", "changed", "message"),
    [
        ("1 2 3\n", {"VERSION": "2.0"}, r"PCD file of version '2\.0', not 0\.7"),
        ("1 2 3\n", {"VERSION": None}, "PCD file of version 'unknown'"),
        ("1 2 3\n", {"FIELDS": "x y q"}, "lines of its header do not fit"),
        ("1 2 3\n", {"FIELDS": "x y z x"}, "lines of its header do not fit"),
        ("1 2 3\n", {"SIZE": "8 8"}, "lines of its header do not fit"),
        ("1 2 3\n", {"SIZE": "8 8 3"}, "lines of its header do not fit"),
        ("1 2 3\n", {"TYPE": "F F D"}, "lines of its header do not fit"),
        ("1 2 3\n", {"WIDTH": "7"}, "lines of its header do not fit"),
        ("1 2 3\n", {"DATA": "zip"}, "lines of its header do not fit"),
        ("1 2 3\n", {"VIEWPOINT": "0 0 0"}, "lines of its header do not fit"),
        ("1 2 3\n", {"POINTS": "-1"}, "lines of its header do not fit"),
        ("1 2 3\n", {"POINTS": "many"}, "is missing or no number"),
        ("1 2 3\n", {"TYPE": None}, "'TYPE' in its header is missing"),
        ("1 2 3\n", {"DATA": None}, "header does not end with a line"),
        ("1 2 3\n", {"WIDTH": "2", "POINTS": "2"}, "its header says 2 points, the file holds 1"),
        ("1 2 3\n4 5\n", {}, "line 13 does not hold 3 numbers: '4 5'"),
        ("1 2 3\n4 five 6\n", {}, "line 13 does not hold 3 numbers: '4 five 6'"),
        ("", {"WIDTH": str(10**15), "POINTS": str(10**15)}, "is cut short"),
    ],
)
def test_what_is_refused(tmp_path, body, changed, message):
    path = pcd(tmp_path / "a.pcd", body, **changed)
    with pytest.raises(InputError, match=message) as caught:
        read_pcd(path)
    assert "\n" not in str(caught.value)
