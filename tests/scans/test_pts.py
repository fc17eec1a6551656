"""PTS against a file that CloudCompare wrote (see data/README.md)."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.scans.pts import read_pts

DATA = Path(__file__).parent / "data"

# The first lines of the example of https://paulbourke.net/dataformats/pts/.
EXAMPLE = """4
-0.41025 -2.0806 8.00981 55 52 44 65
-0.63016 -1.84527 6.59447 228 228 230 225
-0.4766 -2.14446 7.91288 60 56 54 68
-0.52017 -1.51698 7.91458 60 58 50 71
"""


def pts(path, content):
    path.write_text(content)
    return path


def test_as_cloudcompare_writes_it():
    raw = read_pts(DATA / "cc_wall.pts")
    wall = np.loadtxt(DATA / "wall.txt")
    assert np.abs(raw.points - wall[:, :3]).max() <= 1e-6  # six decimals of float32
    assert np.abs(raw.intensity - wall[:, 3]).max() <= 1e-6


def test_the_published_example(tmp_path):
    raw = read_pts(pts(tmp_path / "a.pts", EXAMPLE))
    assert raw.points[1].tolist() == [-0.63016, -1.84527, 6.59447]
    assert np.array_equal(raw.intensity, np.array([55, 228, 60, 60]) / 255)
    assert np.isnan(raw.scanners).all()


def test_counts_of_leica(tmp_path):
    raw = read_pts(pts(tmp_path / "a.pts", "3\n1 2 3 -2048\n4 5 6 2047\n7 8 9 0\n"))
    assert raw.intensity.tolist() == [0.0, 1.0, 2048 / 4095]


@pytest.mark.parametrize("line", ["1 2 {}", "1 2 {} 200 100 50"])
def test_lines_without_an_intensity(tmp_path, line):
    body = "".join(line.format(z) + "\n" for z in range(5))
    raw = read_pts(pts(tmp_path / "a.pts", "5\n" + body))
    assert raw.points[:, 2].tolist() == [0, 1, 2, 3, 4]
    assert len(raw.intensity) == 0


def test_several_blocks(tmp_path):
    raw = read_pts(pts(tmp_path / "a.pts", EXAMPLE + "2\n1 2 3 10 0 0 0\n4 5 6 20 0 0 0\n\n" + EXAMPLE))
    assert len(raw.points) == 10
    assert raw.station.tolist() == [0, 0, 0, 0, 1, 1, 2, 2, 2, 2]
    assert len(raw.scanners) == 3


def test_as_windows_writes_it(tmp_path):
    (tmp_path / "a.pts").write_bytes(b"\xef\xbb\xbf" + EXAMPLE.replace("\n", "\r\n").encode())
    assert len(read_pts(tmp_path / "a.pts").points) == 4


def test_without_a_count(tmp_path):
    raw = read_pts(pts(tmp_path / "a.pts", EXAMPLE.partition("\n")[2]))
    assert len(raw.points) == 4
    assert raw.station.tolist() == [0, 0, 0, 0]


def test_rays_without_a_return(tmp_path):
    raw = read_pts(pts(tmp_path / "a.pts", "4\n0 0 0 0\n1 2 3 5\n0 0 0 0\n4 5 6 9\n"))
    assert raw.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert raw.no_returns == 2


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.lists(st.tuples(*[st.floats(-1e9, 1e9)] * 3), max_size=6, unique=True), min_size=1, max_size=4
    ).filter(any)
)
def test_blocks_come_back_with_every_digit(tmp_path_factory, blocks):
    content = "".join(
        f"{len(block)}\n" + "".join(f"{x!r} {y!r} {z!r} 7\n" for x, y, z in block) for block in blocks
    )
    raw = read_pts(pts(tmp_path_factory.mktemp("any") / "a.pts", content))
    points = np.concatenate([np.array(block).reshape(-1, 3) for block in blocks])
    back = points.any(axis=1) if np.count_nonzero(~points.any(axis=1)) > 1 else np.full(len(points), True)
    assert np.array_equal(raw.points, points[back])
    assert np.array_equal(raw.station, np.repeat(np.arange(len(blocks)), list(map(len, blocks)))[back])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (EXAMPLE.replace("4\n", "5\n", 1), "line 1, '5', counts the points, but 4 follow"),
        (EXAMPLE.replace("4\n", "3\n", 1), "line 1, '3', counts the points, but 4 follow"),
        (EXAMPLE.rsplit("\n", 2)[0], "counts the points, but 3 follow"),
        (EXAMPLE + "2\n1 2 3 4 5 6 7\n", "line 6, '2', counts the points, but 1 follow"),
        ("1 2 3\n1\n4 5 6\n", "line 2, '1', does not hold three coordinates"),
        ("2\n1 2 3\n4 5\n", "1 lines lack a finite coordinate, the first is line 3, '4 5'"),
        ("2\n1 2 nan\n4 5 6\n", "the first is line 2, '1 2 nan'"),
        ("2\n\n1 2 3\n4 inf 6\n", "the first is line 4, '4 inf 6'"),
        ("2\n1 2 3\n4 five 6\n", "line 3 holds no numbers: '4 five 6'"),
        ("2\n1 2 3 4\n4 5 6 nan\n", "1 of 2 intensities are NaN"),
        ("\n \n", "holds no numbers"),
    ],
)
def test_what_is_refused(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        read_pts(pts(tmp_path / "a.pts", content))
    assert "\n" not in str(caught.value)
