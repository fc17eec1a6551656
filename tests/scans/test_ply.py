"""PLY against files that meshio and struct write."""

import struct

import meshio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.scans.ply import read_ply
from fd2fem.scans.readers import read_scan

# Type names of the format and the codes of Python's struct module for them.
CODES = {
    "char": "b",
    "uchar": "B",
    "short": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "float": "f",
    "double": "d",
    "int8": "b",
    "uint16": "H",
    "float32": "f",
    "float64": "d",
}

SURVEY = np.array([674321.0, 5403210.0, 512.0])


def wall(n=100):
    return np.random.default_rng(5).uniform([0, -0.01, 0], [5, 0.01, 12], (n, 3))


def ply(path, form, elements):
    """Write with struct: `elements` are (name, [(type, property)], rows)."""
    lines = ["ply", f"format {form} 1.0", "comment by hand", "obj_info none"]
    body = b""
    order = ">" if form == "binary_big_endian" else "<"
    for name, properties, rows in elements:
        lines += [f"element {name} {len(rows)}", *(f"property {kind} {key}" for kind, key in properties)]
        for row in rows:
            if form == "ascii":
                body += (" ".join(map(repr, row)) + "\n").encode()
            else:
                body += struct.pack(order + "".join(CODES[kind] for kind, _ in properties), *row)
    path.write_bytes(("\n".join([*lines, "end_header"]) + "\n").encode() + body)
    return path


FORMS = ("ascii", "binary_little_endian", "binary_big_endian")


@pytest.mark.parametrize("binary", [True, False])
def test_files_written_by_meshio(tmp_path, binary):
    points = wall() + SURVEY
    cells = [("triangle", np.array([[0, 1, 2], [3, 4, 5]]))]
    meshio.write(tmp_path / "a.ply", meshio.Mesh(points, cells), binary=binary)
    raw = read_ply(tmp_path / "a.ply")
    assert np.array_equal(raw.points, points)
    assert raw.step == 0.0


@pytest.mark.parametrize("form", FORMS)
def test_other_properties_and_elements_around(tmp_path, form):
    points = wall().tolist()
    before = ("camera", [("double", "view"), ("uchar", "view")], [(1.5, 7), (2.5, 8)])
    properties = [
        ("uchar", "red"),
        ("double", "z"),
        ("short", "n"),
        ("double", "x"),
        ("ushort", "intensity"),
        ("double", "y"),
    ]
    rows = [(i % 256, z, -i, x, 655 * i, y) for i, (x, y, z) in enumerate(points)]
    after = ("edge", [("int", "a")], [(1,), (2,)])
    raw = read_ply(ply(tmp_path / "a.ply", form, [before, ("vertex", properties, rows), after]))
    assert np.array_equal(raw.points, points)
    assert np.allclose(raw.intensity, 655 * np.arange(100) / 65535, rtol=0, atol=1e-15)


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from(FORMS),
    st.lists(st.sampled_from(sorted(CODES)), min_size=3, max_size=7),
    st.randoms(use_true_random=False),
    st.integers(1, 6),
)
def test_any_types_in_any_order(tmp_path_factory, form, kinds, random, count):
    keys = ["x", "y", "z", *(f"p{i}" for i in range(len(kinds) - 3))]
    random.shuffle(keys)
    # Whole numbers from 0 to 127 fit every type exactly.
    rows = [
        [float(v) if CODES[k] in "fd" else v for k in kinds for v in [random.randint(0, 127)]]
        for _ in range(count)
    ]
    path = tmp_path_factory.mktemp("any") / "a.ply"
    raw = read_ply(ply(path, form, [("vertex", list(zip(kinds, keys, strict=True)), rows)]))
    expected = [[row[keys.index(key)] for key in "xyz"] for row in rows]
    assert np.array_equal(raw.points, np.array(expected, dtype=float))


def test_windows_line_ends(tmp_path):
    path = ply(tmp_path / "a.ply", "ascii", [("vertex", [("double", c) for c in "xyz"], wall().tolist())])
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert np.array_equal(read_ply(path).points, wall())


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0.0, 0.25, 1.0, 0.5], [0.0, 0.25, 1.0, 0.5]),
        ([0.0, 51.0, 255.0, 102.0], [0.0, 0.2, 1.0, 0.4]),
        ([-2048.0, 0.0, 2048.0, 1024.0], [0.0, 0.5, 1.0, 0.75]),  # Leica
        ([7.0, 7.0, 7.0, 7.0], []),
    ],
)
def test_intensity_is_brought_between_0_and_1(tmp_path, values, expected):
    rows = [(*p, v) for p, v in zip(wall(4).tolist(), values, strict=True)]
    properties = [("double", "x"), ("double", "y"), ("double", "z"), ("float", "scalar_Intensity")]
    raw = read_ply(ply(tmp_path / "a.ply", "binary_little_endian", [("vertex", properties, rows)]))
    assert np.allclose(raw.intensity, expected, rtol=0, atol=1e-15)
    assert raw.intensity.shape == (len(expected),)


@pytest.mark.parametrize("form", FORMS)
def test_float32_survey_coordinates_are_refused(tmp_path, form):
    # At 5.4e6 a float32 has steps of 0.5 m, IEEE 754: 2**(22 - 23).
    points = (wall() + SURVEY).astype(np.float32).astype(float)
    path = ply(tmp_path / "a.ply", form, [("vertex", [("float", c) for c in "xyz"], points.tolist())])
    assert read_ply(path).step == 0.5
    with pytest.raises(InputError, match=r"a\.ply has lost precision: float32 coordinates .* 500 mm apart"):
        read_scan(path)


@pytest.mark.parametrize(("largest", "accepted"), [(32_000, True), (33_000, False)])
def test_float32_is_accepted_up_to_2_mm(tmp_path, largest, accepted):
    # From 2**14 to 2**15 = 32 768 m a float32 has steps of 2**-9 m = 1.95 mm, beyond of 3.9 mm.
    points = (wall() + np.array([largest, 0, 0])).astype(np.float32).astype(float)
    path = ply(
        tmp_path / "a.ply", "binary_big_endian", [("vertex", [("float", c) for c in "xyz"], points.tolist())]
    )
    if accepted:
        assert np.array_equal(read_scan(path).points, points)
    else:
        with pytest.raises(InputError, match=r"3\.91 mm apart"):
            read_scan(path)


def test_float32_in_millimetres(tmp_path):
    # 5 403 210 mm has steps of 0.5 mm.
    points = (wall() * 1000 + [5403210.0, 0, 0]).astype(np.float32).astype(float)
    path = ply(tmp_path / "a.ply", "ascii", [("vertex", [("float", c) for c in "xyz"], points.tolist())])
    assert np.array_equal(read_scan(path).points, points / 1000)


def test_text_that_says_float_but_spells_every_digit(tmp_path):
    points = wall() + SURVEY
    path = ply(tmp_path / "a.ply", "ascii", [("vertex", [("float", c) for c in "xyz"], points.tolist())])
    assert np.array_equal(read_scan(path).points, points)


def with_header(*lines, body=b""):
    return ("\n".join(lines) + "\n").encode() + body


XYZ = ("property double x", "property double y", "property double z", "end_header")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (with_header("ply", "format ascii 2", "element"), "line 3 of its header is 'element'"),
        (with_header("ply", "format binary_middle_endian 1.0"), "line 2 of its header"),
        (
            with_header("ply", "format ascii 1.0", "element vertex 3"),
            "line 4 of its header is .*the end of the file",
        ),
        (with_header("ply", "element vertex 3", *XYZ), "line 6 of its header is 'end_header'"),
        (with_header("ply", "format ascii 1.0", "element face 1", *XYZ), "no element 'vertex', only face"),
        (with_header("ply", "format ascii 1.0", "end_header"), "no element 'vertex'"),
        (with_header("ply", "format ascii 1.0", "element vertex 3", *XYZ[1:]), "need one each of x, y, z"),
        (
            with_header("ply", "format ascii 1.0", "element vertex 3", XYZ[0], *XYZ),
            "need one each of x, y, z",
        ),
        (
            with_header("ply", "format ascii 1.0", "element vertex 3", "property quad x"),
            "line 4 of its header",
        ),
        (
            with_header(
                "ply",
                "format ascii 1.0",
                "element face 1",
                "property list uchar int i",
                "element vertex 3",
                *XYZ,
            ),
            "element 'face', before or among the vertices, holds lists",
        ),
        (
            with_header("ply", "format ascii 1.0", "element vertex 3", *XYZ, body=b"1 2 3\n1 2 3\n"),
            "says 3 points, the file holds 2",
        ),
        (with_header("ply", "format ascii 1.0", "element vertex 3", *XYZ), "says 3 points, the file holds 0"),
        (
            with_header("ply", "format ascii 1.0", "element vertex 2", *XYZ, body=b"1 2 3\n1 2\n"),
            "line 9 is no vertex: '1 2'",
        ),
        (
            with_header("ply", "format ascii 1.0", "element vertex 2", *XYZ, body=b"1 2 3\n1 2 z\n"),
            "line 9 is no vertex",
        ),
        (
            with_header("ply", "format ascii 1.0", "element vertex 2", *XYZ, body=b"1 nan 3\n1 2 3\n"),
            "1 of 2 points .* the first is point 1",
        ),
        (
            with_header("ply", "format binary_little_endian 1.0", "element vertex 3", *XYZ, body=b"\0" * 71),
            "says 3 points, the file holds 2",
        ),
        (
            with_header(
                "ply",
                "format binary_little_endian 1.0",
                "element vertex 2",
                *XYZ,
                body=struct.pack("<6d", 1, 2, 3, 4, np.inf, 6),
            ),
            "1 of 2 points have a coordinate that is NaN or infinite, the first is point 2",
        ),
        (
            with_header("ply", "format binary_little_endian 1.0", "element vertex 99999999999999", *XYZ),
            "cut short",
        ),
    ],
)
def test_what_is_refused(tmp_path, content, message):
    (tmp_path / "a.ply").write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_ply(tmp_path / "a.ply")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("form", FORMS)
def test_no_points(tmp_path, form):
    path = ply(tmp_path / "a.ply", form, [("vertex", [("double", c) for c in "xyz"], [])])
    with pytest.raises(InputError, match="has 0 points"):
        read_scan(path)
