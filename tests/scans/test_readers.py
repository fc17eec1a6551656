"""Reading of scans: dispatch, units, joining, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.las import write_las
from fd2fem.scans.readers import Units, guess_units, read_scan, read_scans

DATA = Path(__file__).parent / "data"
SURVEY = np.array([674321.125, 5403210.25, 512.5])


def wall(n=200, seed=0):
    """Points on a wall of 5 x 12 m."""
    return np.random.default_rng(seed).uniform([0, -0.01, 0], [5, 0.01, 12], (n, 3))


def write_xyz(path, points):
    np.savetxt(path, points, fmt="%.17g")
    return path


def test_survey_offsets_are_exact(tmp_path):
    points = wall() + SURVEY
    cloud = read_scan(write_xyz(tmp_path / "a.xyz", points))
    assert cloud.source == "a.xyz"
    assert np.array_equal(cloud.points, points)  # written by numpy with every digit


@pytest.mark.parametrize("suffix", ["XYZ", "Txt", "CSV"])
def test_suffix_in_any_case(tmp_path, suffix):
    assert len(read_scan(write_xyz(tmp_path / f"a.{suffix}", wall()))) == 200


def test_millimetres_are_found_and_stay_exact(tmp_path):
    millimetres = np.rint((wall() + SURVEY) * 1000)
    path = write_xyz(tmp_path / "a.xyz", millimetres)
    for units in (Units.AUTO, Units.MM):
        assert np.array_equal(read_scan(path, units=units).points, millimetres / 1000)
    with pytest.raises(InputError, match="damaged or in another unit"):
        read_scan(path, units=Units.M)


def test_given_units_are_not_questioned(tmp_path):
    path = write_xyz(tmp_path / "a.xyz", wall() * 1000)
    assert np.array_equal(read_scan(path, units=Units.M).points, wall() * 1000)


@pytest.mark.parametrize(
    ("height", "expected"),
    [
        (0.0, Units.M),
        (60.0, Units.M),
        (199.0, Units.M),
        (5001.0, Units.MM),
        (12160.0, Units.MM),
        (1.9e5, Units.MM),
    ],
)
def test_guess_units(height, expected):
    assert guess_units(np.linspace(500.0, 500.0 + height * 1.0021, 5001)) is expected


def test_stray_returns_do_not_decide_the_units():
    z = np.append(np.linspace(0, 12, 5000), [4000.0, -900.0])
    assert guess_units(z) is Units.M


# A wall of 12 m in centimetres is as high as one of 1.2 m in millimetres; 300 m as 3 m in centimetres.
@pytest.mark.parametrize("height", [210.0, 600.0, 1216.0, 4500.0, 2.5e5])
def test_units_that_cannot_be_told(tmp_path, height):
    path = write_xyz(tmp_path / "a.xyz", wall() * (height / 12 * 1.01))
    with pytest.raises(
        InputError, match=r"a\.xyz is .* high, .* m if in m, .* m if in cm, .*: say --units m, cm"
    ):
        read_scan(path)
    assert len(read_scan(path, units=Units.M)) == 200


def test_what_each_unit_would_mean():
    with pytest.raises(
        InputError, match=r"12\.2 m if in cm, 1\.22 m if in mm, 371 m if in ft, 30\.9 m if in in"
    ):
        guess_units(np.linspace(0.0, 1216.0 / 0.998, 5001))


# The international foot is 0.3048 m, the foot of the US survey 1200/3937 m (NIST SP 811, appendix B.6).
@pytest.mark.parametrize(
    ("units", "metres"),
    [
        (Units.M, 1.0),
        (Units.CM, 0.01),
        (Units.MM, 0.001),
        (Units.FT, 0.3048),
        (Units.US_FT, 0.30480060960121924),
        (Units.IN, 0.0254),
    ],
)
def test_every_unit(tmp_path, units, metres):
    scanner = [[2.0, -8.0, 1.5]]
    cloud = read_scan(write_xyz(tmp_path / "a.xyz", wall()), units=units, scanners=scanner)
    assert np.allclose(cloud.points, wall() * metres, rtol=1e-15, atol=0)
    assert cloud.scanners.tolist() == scanner  # --scanner is in metres, whatever the file is in


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(*[st.floats(-1e7, 1e7, allow_subnormal=False)] * 3), min_size=4, max_size=20, unique=True
    )
)
def test_any_coordinates_come_back_or_are_refused(tmp_path_factory, points):
    path = write_xyz(tmp_path_factory.mktemp("any") / "a.xyz", np.array(points))
    refusal = ""
    cloud = None
    try:
        cloud = read_scan(path, units=Units.M)
    except InputError as error:
        refusal = str(error)
    if cloud is None:
        assert "on one line" in refusal or "in one place" in refusal
    else:
        assert np.array_equal(cloud.points, np.array(points))


def test_scans_are_joined(tmp_path):
    first = PointCloud(wall(50, 1), "", np.full(50, 0.25), np.array([[2.0, -8.0, 1.5]]))
    second = PointCloud(wall(60, 2), "", np.full(60, 0.5), np.array([[4.0, -9.0, 1.5]]))
    paths = [tmp_path / "a.las", tmp_path / "b.laz"]
    write_las(first, paths[0])
    write_las(second, paths[1])
    cloud = read_scans(paths)
    assert cloud.source == "a.las, b.laz"
    assert np.allclose(cloud.points, np.vstack([first.points, second.points]), rtol=0, atol=5.1e-5)
    assert cloud.scanners.tolist() == [[2.0, -8.0, 1.5], [4.0, -9.0, 1.5]]
    assert np.allclose(cloud.intensity, np.repeat([0.25, 0.5], [50, 60]), rtol=0, atol=1e-5)
    third = write_xyz(tmp_path / "c.xyz", wall())
    assert len(read_scans([*paths, third]).intensity) == 0  # not all of them have it
    assert read_scans([third]).source == "c.xyz"


def test_scanners_are_converted_too(tmp_path):
    write_las(
        PointCloud(wall() * 1000, "", scanners=np.array([[2000.0, -8000.0, 1500.0]])), tmp_path / "a.las"
    )
    assert read_scan(tmp_path / "a.las").scanners.tolist() == [[2.0, -8.0, 1.5]]


def test_scans_in_different_units_are_refused(tmp_path):
    paths = [write_xyz(tmp_path / "a.xyz", wall()), write_xyz(tmp_path / "b.xyz", wall() * 1000)]
    with pytest.raises(InputError, match=r"a\.xyz seems to be in m and .*b\.xyz in mm: convert one"):
        read_scans(paths)


def test_no_scan():
    with pytest.raises(InputError, match="no scan is given"):
        read_scans([])


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.las: no such file"):
        read_scan(tmp_path / "nowhere.las")
    (tmp_path / "folder.las").mkdir()
    with pytest.raises(InputError, match=r"folder\.las is a folder"):
        read_scan(tmp_path / "folder.las")


@pytest.mark.parametrize("suffix", ["las", "laz", "e57", "ply", "pcd", "pts", "ptx", "xyz", "csv", "txt"])
def test_empty_and_garbage(tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    path.write_bytes(b"")
    with pytest.raises(InputError, match=rf"a\.{suffix} is empty"):
        read_scan(path)
    for garbage in (
        b"this is not\na point cloud\n",
        bytes(range(256)) * 8,
        b"\x89PNG\r\n\x1a\n" + b"\0" * 500,
    ):
        path.write_bytes(garbage)
        with pytest.raises(InputError, match=rf"a\.{suffix}.* not an? .*point cloud") as caught:
            read_scan(path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["a.e5", "a.rcp", "a.docx"])
def test_formats_that_are_not_read(tmp_path, name):
    (tmp_path / name).write_bytes(b"something")
    with pytest.raises(InputError, match="files are not read; convert to LAS, LAZ, E57, PLY, PCD, PTS, PTX,"):
        read_scan(tmp_path / name)


WRITTEN = {
    "las": b"",
    "laz": b"",
    "ply": b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    b"end_header\n0 0 0\n1 0 2\n3 0 5\n2 1 7\n",
    "pcd": (DATA / "pcl_nan_compressed.pcd").read_bytes(),
    "pts": (DATA / "cc_wall.pts").read_bytes(),
    "ptx": (DATA / "two_scans.ptx").read_bytes(),
    "xyz": (DATA / "wall.txt").read_bytes(),
    "csv": b"x,y,z\n0,0,0\n1,0,2\n3,0,5\n2,1,7\n",
}


@settings(max_examples=150, deadline=None)
@given(
    suffix=st.sampled_from(sorted(WRITTEN)),
    place=st.integers(0, 2**20),
    other=st.one_of(
        st.binary(max_size=40), st.text("0123456789 .-+enaif\n\t,;", max_size=40).map(str.encode)
    ),
)
def test_damage_never_shows_a_traceback(tmp_path_factory, suffix, place, other):
    content = WRITTEN[suffix]
    place %= len(content) + 1
    path = tmp_path_factory.mktemp("any") / f"a.{suffix}"
    path.write_bytes(content[:place] + other + content[place + len(other) :])
    try:
        read_scan(path, units=Units.M)
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
        assert f"a.{suffix}" in str(error)  # noqa: PT017


def test_file_without_suffix(tmp_path):
    (tmp_path / "scan").write_bytes(b"something")
    with pytest.raises(InputError, match="without a suffix is not read;"):
        read_scan(tmp_path / "scan")


@pytest.mark.parametrize("count", [1, 2, 3])
def test_too_few_points(tmp_path, count):
    path = write_xyz(tmp_path / "a.xyz", wall()[:count])
    with pytest.raises(InputError, match=rf"has {count} points?: a facade needs at least 4"):
        read_scan(path)


@pytest.mark.parametrize("offset", [0.0, SURVEY])
@pytest.mark.parametrize("digits", [3, 12])
def test_points_on_one_line(tmp_path, offset, digits):
    line = np.linspace(0, 1, 50)[:, np.newaxis] * [3.0, 0.7, 11.0] + offset
    path = write_xyz(tmp_path / "a.xyz", np.round(line, digits))
    with pytest.raises(InputError, match="all 50 points lie on one line"):
        read_scan(path)


def test_points_in_one_place(tmp_path):
    path = write_xyz(tmp_path / "a.xyz", np.repeat([SURVEY], 9, axis=0))
    with pytest.raises(InputError, match="all 9 points are in one place"):
        read_scan(path)


def test_a_return_at_the_origin_does_not_make_a_line(tmp_path):
    points = np.vstack([wall() + SURVEY, np.zeros(3)])
    assert len(read_scan(write_xyz(tmp_path / "a.xyz", points), units=Units.M)) == 201


def test_coordinates_off_the_earth(tmp_path):
    points = wall()
    points[6, 0] = 3e9
    with pytest.raises(
        InputError, match=r"1 of 200 points have a coordinate beyond 1e\+08 m, the first is point 7"
    ):
        read_scan(write_xyz(tmp_path / "a.xyz", points))


def write_ptx(path, positions, *, count=40):
    """Scans with the identity as rotation, as published: header of ten lines, points, one column."""
    with path.open("w") as file:
        for x, y, z in positions:
            file.write(
                f"1\n{count}\n{x} {y} {z}\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n{x} {y} {z} 1\n"
            )
            np.savetxt(file, wall(count) - [x, y, z], fmt="%.6f")
    return path


PLACES = [(2.25, -9.0, 1.6), (4.5, -8.0, 1.7)]


def test_stations_of_several_files(tmp_path):
    two = write_ptx(tmp_path / "a.ptx", PLACES)
    none = write_xyz(tmp_path / "b.xyz", wall(30))
    one = tmp_path / "c.las"
    write_las(PointCloud(wall(20), "", scanners=[[1.0, -7.0, 1.5]]), one)
    cloud = read_scans([two, none, one])
    assert cloud.scanners.tolist() == [[2.25, -9.0, 1.6], [4.5, -8.0, 1.7], [1.0, -7.0, 1.5]]
    assert cloud.station.tolist() == [0] * 40 + [1] * 40 + [-1] * 30 + [2] * 20
    assert len(read_scan(none).station) == 0
    assert read_scan(one).station.tolist() == [0] * 20


@pytest.mark.parametrize(
    ("count", "station"),
    [
        (1, [0] * 110),  # one position: everything was measured from there
        (2, [0] * 80 + [1] * 30),  # one of each file
        (3, [0] * 40 + [1] * 40 + [2] * 30),  # one of each scan
        (4, []),  # nobody can know
    ],
)
def test_positions_that_the_user_gives(tmp_path, count, station):
    paths = [write_ptx(tmp_path / "a.ptx", PLACES), write_xyz(tmp_path / "b.xyz", wall(30))]
    scanners = [(float(k), -5.0, 1.5) for k in range(count)]
    cloud = read_scans(paths, scanners=scanners)
    assert cloud.scanners.tolist() == [list(place) for place in scanners]
    assert cloud.station.tolist() == station


def test_scans_in_metres_by_definition_join_with_others(tmp_path):
    ptx = write_ptx(tmp_path / "a.ptx", PLACES)
    assert len(read_scans([ptx, write_xyz(tmp_path / "b.xyz", wall())])) == 280
    with pytest.raises(InputError, match=r"a\.ptx seems to be in m and .*c\.xyz in mm"):
        read_scans([ptx, write_xyz(tmp_path / "c.xyz", wall() * 1000)])


def test_rays_without_a_return_are_counted(tmp_path):
    path = write_ptx(tmp_path / "a.ptx", PLACES[:1])
    lines = path.read_text().splitlines()
    lines[12:15] = ["0 0 0 0"] * 3
    path.write_text("\n".join(lines))
    cloud = read_scans([path, write_ptx(tmp_path / "b.ptx", PLACES)])
    assert (len(cloud), cloud.no_returns) == (117, 3)


@pytest.mark.parametrize("digits", [8, 9, 12])
def test_float32_survey_coordinates_show_in_text_too(tmp_path, digits):
    points = (wall() + SURVEY).astype(np.float32)
    for name in ("a.xyz", "a.pts"):
        np.savetxt(tmp_path / name, points, fmt=f"%.{digits}g")
        with pytest.raises(InputError, match=r"has lost precision: float32 coordinates .* 500 mm apart"):
            read_scan(tmp_path / name)


@pytest.mark.parametrize("decimals", [2, 3, 4])
def test_rounded_survey_coordinates_are_not_taken_for_float32(tmp_path, decimals):
    points = (wall() + SURVEY).round(decimals)
    assert np.array_equal(read_scan(write_xyz(tmp_path / "a.xyz", points)).points, points)


def test_one_copy_of_the_points(tmp_path):
    # The reader's array is the cloud's: a scan of 50 M points takes 1.2 GB once, not three times.
    assert not read_scan(write_xyz(tmp_path / "a.xyz", wall())).points.flags.writeable
    points = wall()
    points.setflags(write=False)
    assert PointCloud(points, "").points is points
