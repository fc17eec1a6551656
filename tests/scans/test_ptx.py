"""PTX against CloudCompare's reading and a published example (see data/README.md)."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fd2fem.errors import InputError
from fd2fem.scans.ptx import read_ptx
from fd2fem.scans.units import Units

DATA = Path(__file__).parent / "data"

# The example of https://rapidlasso.de/matrix-transformation-in-lastools/, and what LAStools made of it.
EXAMPLE = """3
3
0.000000 0.000000 0.000000
1.000000 0.000000 0.000000
0.000000 1.000000 0.000000
0.000000 0.000000 1.000000
-0.955179 0.296021 -0.002106 0.000000
-0.296023 -0.955180 0.001152 0.000000
-0.001670 0.001724 0.999997 0.000000
3.847211 12.235314 -0.425777 1.000000
1.111111 2.111111 3.111 0.111
1.222222 2.222222 3.222 0.212
0 0 0 0
0 0 0 0
1.333333 2.333333 3.333 0.312
1.444444 2.444444 3.444 0.423
0 0 0 0
1.555555 2.555555 3.555 0.534
1.666666 2.666666 3.666 0.678
"""
PUBLISHED = [
    [2.156, 10.553, 2.685],
    [2.017, 10.480, 2.796],
    [1.877, 10.407, 2.907],
    [1.738, 10.334, 3.018],
    [1.599, 10.261, 3.129],
    [1.460, 10.188, 3.240],
]
STATION = np.array([674_321.25, 5_403_210.5, 513.6])
IDENTITY = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
AXES = "1 0 0\n0 1 0\n0 0 1\n"


def grid(columns=12, rows=9):
    """Directions of a scanner's rays, column by column, and their distances to a wall 8 m away."""
    azimuth, elevation = np.meshgrid(
        np.radians(np.linspace(40, 140, columns)), np.radians(np.linspace(-8, 50, rows)), indexing="ij"
    )
    level = np.cos(elevation)
    rays = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)
    return (rays * (8.0 / rays[..., 1:2])).reshape(-1, 3)


def ptx(path, points, *, columns, position, matrix=IDENTITY, axes=AXES, append=False):
    """A scan as text, every digit of its points kept."""
    head = f"{columns}\n{len(points) // columns}\n" + " ".join(map(repr, map(float, position))) + "\n"
    body = "".join(f"{x!r} {y!r} {z!r} 0.5\n" for x, y, z in np.asarray(points).tolist())
    with path.open("a" if append else "w") as file:
        file.write(head + axes + matrix + body)
    return path


def matrix_text(rotation, translation):
    """4 x 4 for row vectors."""
    rows = [*rotation.T, translation]
    return "".join(
        " ".join(map(repr, map(float, row))) + f" {int(last)}\n"
        for row, last in zip(rows, (0, 0, 0, 1), strict=True)
    )


def test_the_published_example(tmp_path):
    (tmp_path / "a.ptx").write_text(EXAMPLE)
    raw = read_ptx(tmp_path / "a.ptx")
    assert np.abs(raw.points - PUBLISHED).max() <= 0.00051  # three decimals were published
    assert raw.scanners.tolist() == [[3.847211, 12.235314, -0.425777]]
    assert raw.intensity.tolist() == [0.111, 0.212, 0.312, 0.423, 0.534, 0.678]
    assert raw.no_returns == 3
    assert raw.units is Units.M


def test_as_cloudcompare_reads_it():
    raw = read_ptx(DATA / "two_scans.ptx")
    other = np.loadtxt(DATA / "cc_two_scans.asc")
    assert np.abs(raw.points - other[:, :3]).max() <= 2e-5  # CloudCompare has 24 bits for ranges of 20 m
    assert np.abs(raw.intensity - other[:, 3]).max() <= 1e-6
    assert np.bincount(raw.station).tolist() == [61, 48]  # its messages: "Found one cloud with 61 points"
    assert raw.no_returns == 9 * 8 + 8 * 7 - 61 - 48
    assert np.abs(raw.points[:, 1]).max() < 1e-5  # the wall is y = 0; six decimals
    assert raw.scanners.tolist() == [[2.1, -9.25, 1.62], [7.4, -11.5, 1.71]]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 5), st.integers(1, 7))
def test_any_pose_comes_back(tmp_path_factory, seed, columns, rows):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=rng).as_matrix()
    world = STATION + rng.normal(scale=10.0, size=(columns * rows, 3))
    path = ptx(
        tmp_path_factory.mktemp("any") / "a.ptx",
        (world - STATION) @ rotation,
        columns=columns,
        position=STATION,
        matrix=matrix_text(rotation, STATION),
    )
    raw = read_ptx(path)
    assert np.allclose(raw.points, world, rtol=0, atol=1e-8)  # doubles near 5e6 have steps of 1e-9
    assert np.array_equal(raw.scanners, [STATION])


def test_a_matrix_for_column_vectors(tmp_path):
    rotation = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    rows = np.vstack([np.column_stack([rotation, STATION]), [0, 0, 0, 1]])
    text = "".join(" ".join(map(repr, row)) + "\n" for row in rows.tolist())
    raw = read_ptx(ptx(tmp_path / "a.ptx", grid(), columns=12, position=STATION, matrix=text))
    assert np.allclose(raw.points, grid() @ rotation.T + STATION, rtol=0, atol=1e-8)
    assert np.array_equal(raw.scanners, [STATION])


def test_points_in_the_world_already(tmp_path):
    # Transformation none, position given: the columns are vertical planes through that position.
    position = [3.0, -8.0, 1.6]
    raw = read_ptx(ptx(tmp_path / "a.ptx", grid() + position, columns=12, position=position))
    assert raw.scanners.tolist() == [position]
    assert np.array_equal(raw.points, grid() + position)


def test_a_user_frame_at_the_scanner(tmp_path):
    # Transformation none, since the user chose the scanner's frame; the header keeps the registered position.
    raw = read_ptx(ptx(tmp_path / "a.ptx", grid(), columns=12, position=STATION))
    assert raw.scanners.tolist() == [[0.0, 0.0, 0.0]]


def test_world_coordinates_with_an_empty_header_have_no_scanner(tmp_path):
    raw = read_ptx(ptx(tmp_path / "a.ptx", grid() + STATION, columns=12, position=[0, 0, 0]))
    assert np.isnan(raw.scanners).all()
    assert len(raw.points) == 108


def test_several_scans(tmp_path):
    path = tmp_path / "a.ptx"
    for number in range(3):
        position = STATION + np.array([2.0 * number, 0.25, 0.1])
        matrix = matrix_text(np.eye(3), position)
        ptx(path, grid(12, 3 + number), columns=12, position=position, matrix=matrix, append=number > 0)
    raw = read_ptx(path)
    assert np.bincount(raw.station).tolist() == [36, 48, 60]
    assert np.allclose(raw.scanners[2] - raw.scanners[0], [4.0, 0.0, 0.0], atol=1e-9)


def test_large_files_are_read_in_pieces(monkeypatch):
    monkeypatch.setattr("fd2fem.scans.rows.CHUNK", 7)
    whole = DATA / "two_scans.ptx"
    raw = read_ptx(whole)
    monkeypatch.undo()
    assert np.array_equal(raw.points, read_ptx(whole).points)


LINES = EXAMPLE.splitlines()


def changed(number, text):
    """The example with another line `number` (from 1); None leaves it out."""
    lines = LINES.copy()
    lines[number - 1 : number] = [] if text is None else [text]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("\n".join(LINES[:6]), "the end of the file should hold 4 numbers, line 7 of the header"),
        ("\n".join(LINES[:-2]), "is cut short: a header says 9 points, the file holds 7"),
        (EXAMPLE + "1 2 3 0.5\n", "line 20, '1 2 3 0.5', should hold 1 number, line 1 of the header"),
        (changed(3, "0 0"), "line 3, '0 0', should hold 3 numbers"),
        (changed(7, None), "does not rotate and move it only"),
        (changed(1, "2.5"), "a scan has 2.5 columns and 3 rows"),
        (changed(1, "-3"), "a scan has -3 columns"),
        (changed(7, "2 0 0 0"), "does not rotate and move it only"),
        (changed(7, "0.955179 -0.296021 0.002106 0"), "does not rotate and move it only"),
        (changed(12, "1 2"), "line 12, '1 2', does not hold three finite coordinates"),
        (changed(12, "1 2 nan 0.5"), "line 12, '1 2 nan 0.5', does not hold three"),
        (changed(12, "1 inf 3 0.5"), "line 12, '1 inf 3 0.5', does not hold three"),
        (changed(12, "1 two 3 0.5"), "line 12 holds no numbers: '1 two 3 0.5'"),
        (changed(12, "1.0 2.0 3.0 nan"), "1 of 6 intensities are NaN"),
        ("\n\n", "holds no numbers"),
    ],
)
def test_what_is_refused(tmp_path, content, message):
    (tmp_path / "a.ptx").write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        read_ptx(tmp_path / "a.ptx")
    assert "\n" not in str(caught.value)
