"""Text files of points, in the ways that programs write them."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.scans.text import read_text

POINTS = [[1.5, 2.25, 3.125], [-4.0, 5.0, 6e2], [0.1, 0.2, 0.3], [7.0, 8.0, 9.0]]
PLAIN = "1.5 2.25 3.125\n-4.0 5.0 6e2\n0.1 0.2 0.3\n7 8 9\n"


def text_file(path, content):
    path.write_bytes(content.encode())
    return path


@pytest.mark.parametrize(
    "content",
    [
        PLAIN,
        PLAIN.replace(" ", ","),
        PLAIN.replace(" ", ", "),
        PLAIN.replace(" ", ";"),
        PLAIN.replace(" ", "\t"),
        PLAIN.replace(" ", "   "),
        PLAIN.replace(".", ",").replace(" ", ";"),
        PLAIN.replace(".", ",").replace(" ", "\t"),
        PLAIN.replace(".", ",").replace(" ", "; "),
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace(" ", ",").replace("\n", ",\n"),
        PLAIN.replace("\n", "\n\n"),
        PLAIN.rstrip("\n"),
        "\ufeff" + PLAIN,
        "4\n" + PLAIN,
        "# made by hand\n// twice\n\n" + PLAIN,
        "x y z\n" + PLAIN,
        "X,Y,Z\n" + PLAIN.replace(" ", ","),
        "//X,Y,Z\n" + PLAIN.replace(" ", ","),
        "# x y z of the wall\n" + PLAIN,
        '"X [m]";"Y [m]";"Z [m]"\n' + PLAIN.replace(" ", ";"),
        "easting northing height\n" + PLAIN,
        "  " + PLAIN.replace("\n", "\n  "),
        PLAIN.replace("0.1", "# a comment\n0.1"),
        PLAIN.replace("0.1", "// a comment\n0.1"),
        PLAIN.replace("\n", " 17 200 200 200\n"),
        PLAIN.replace("\n", " brick wall\n"),
        PLAIN.replace("\n", " # a point\n"),
    ],
)
def test_ways_to_write_four_points(tmp_path, content):
    raw = read_text(text_file(tmp_path / "a.txt", content))
    assert raw.points.tolist() == POINTS
    assert len(raw.intensity) == 0


def test_columns_by_name(tmp_path):
    table = pd.DataFrame(POINTS, columns=["Z", "X", "Y"]).assign(Intensity=[0, 51, 255, 102])
    table.insert(0, "point", ["a", "b", "c", "d"])
    table.to_csv(tmp_path / "a.csv", index=False)
    raw = read_text(tmp_path / "a.csv")
    assert raw.points.tolist() == [[y, z, x] for x, y, z in POINTS]
    assert raw.intensity.tolist() == [0.0, 0.2, 1.0, 0.4]


def test_cloudcompare_header_in_a_comment(tmp_path):
    content = "//X Y Z Scalar_Intensity\n4\n" + PLAIN.replace("\n", " 0.5\n", 1).replace(
        "\n", " 1\n"
    ).replace("0.5 1", "0.5")
    raw = read_text(text_file(tmp_path / "a.xyz", content))
    assert raw.points.tolist() == POINTS
    assert raw.intensity.tolist() == [0.5, 1, 1, 1]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=1, max_size=8),
    st.sampled_from([" ", ",", ";", "\t"]),
)
def test_every_digit_is_kept(tmp_path_factory, points, separator):
    path = tmp_path_factory.mktemp("any") / "a.xyz"
    np.savetxt(path, points, fmt="%.17g", delimiter=separator)
    assert np.array_equal(read_text(path).points, np.array(points))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("no point\n", "no columns x, y and z: 'no point'"),
        ("1 2\n3 4\n", "line 1 does not hold three numbers"),
        ("x y z\nx y z\n", "line 2 does not hold three numbers"),
        ("a,b,c,d\n1,2,3,4\n", "no columns x, y and z: 'a,b,c,d'"),
        ("x,y,z\n1,2,3,4\n", "line 2 does not hold three numbers"),
        ("Point Name X Y Z R\nP1 1 2 3 9\n", "line 2 does not hold three numbers"),
        ("# nothing\n", "none of its first lines holds three numbers"),
        ("4\n4\n1 2 3\n", "line 2 does not hold three numbers"),
        ("4\n", "none of its first lines holds three numbers"),
        ("1 2 3\n4 5 6\n7 eight 9\n", "line 3 does not hold three numbers.*: '7 eight 9'"),
        ("# c\n\n1,2,3\n4,5,6\n7,8\n", "line 5 does not hold three numbers"),
        ("1,2,3\n4,,6\n", "line 2 does not hold three numbers"),
        ("1;2;3\n4;5;NA\n", "line 2 does not hold three numbers"),
        ("1 2 3\n4 5 nan\n7 8 9\ninf 1 2\n", "2 points with .* NaN or infinite, the first on line 2"),
        ("nan 2 3\n4 5 6\n7 8 9\n", "1 point with .* the first on line 1"),
        ("1 2 3\n// c\n4 5 6\n7 x 9\n", "line 4 does not hold"),
        ("1 2 3\n4 5 1_0\n", "cannot be read as columns of numbers"),
        ("x,y,z,intensity\n1,2,3,4\n5,6,7,nan\n", "1 of 2 intensities are NaN"),
    ],
)
def test_what_is_refused(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        read_text(text_file(tmp_path / "a.csv", content))
    assert "\n" not in str(caught.value)
