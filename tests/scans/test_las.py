"""LAS and LAZ against files that laspy itself writes."""

import struct

import laspy
import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import PointCloud
from fd2fem.scans.las import read_las, write_las
from fd2fem.scans.readers import Units, read_scan

SURVEY = np.array([1674321.0, 5403210.0, 512.0])


def wall(n=500):
    return np.random.default_rng(3).uniform([0, -0.01, 0], [5, 0.01, 12], (n, 3)) + SURVEY


def laspy_file(path, *, point_format, version):
    """A file by laspy: coordinates on a grid of 1/1024 m, which a LAS scale can hold exactly."""
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.scales, header.offsets = np.full(3, 1 / 1024), SURVEY
    las = laspy.LasData(header)
    counts = np.random.default_rng(4).integers(0, 10000, (300, 3))
    las.X, las.Y, las.Z = counts.T
    las.intensity = np.linspace(0, 65535, 300).astype(np.uint16)
    las.write(path)
    return counts / 1024 + SURVEY, np.linspace(0, 65535, 300).astype(np.uint16) / 65535


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize(
    ("point_format", "version"), [(0, "1.2"), (3, "1.2"), (1, "1.3"), (6, "1.4"), (7, "1.4")]
)
def test_files_written_by_laspy(tmp_path, suffix, point_format, version):
    path = tmp_path / f"a.{suffix}"
    points, intensity = laspy_file(path, point_format=point_format, version=version)
    raw = read_las(path)
    assert np.array_equal(raw.points, points)
    assert np.array_equal(raw.intensity, intensity)
    assert raw.scanners.shape == (0, 3)


@pytest.mark.parametrize(("suffix", "compressed"), [("las", False), ("LAZ", True)])
def test_written_file_read_by_laspy(tmp_path, suffix, compressed):
    points, intensity = wall(), np.linspace(0, 1, 500)
    write_las(PointCloud(points, "", intensity), tmp_path / f"a.{suffix}")
    with laspy.open(tmp_path / f"a.{suffix}") as file:
        assert file.header.are_points_compressed is compressed
        las = file.read()
    assert np.abs(las.xyz - points).max() <= 0.5001e-4  # half a step
    assert np.abs(las.intensity / 65535 - intensity).max() <= 0.5001 / 65535
    assert (las.header.scales == 1e-4).all()


def test_round_trip_with_scanners(tmp_path):
    scanners = SURVEY + np.array([[2.123456789, -8.0, 1.6], [9.0, -12.5, 1.1]])
    write_las(PointCloud(wall(), "", scanners=scanners), tmp_path / "a.laz")
    raw = read_las(tmp_path / "a.laz")
    assert np.array_equal(raw.scanners, scanners)
    assert len(raw.intensity) == 0


def test_scanners_survive_another_program(tmp_path):
    write_las(PointCloud(wall(), "", scanners=SURVEY[np.newaxis]), tmp_path / "a.laz")
    laspy.read(tmp_path / "a.laz").write(tmp_path / "b.las")
    assert np.array_equal(read_las(tmp_path / "b.las").scanners, SURVEY[np.newaxis])


def test_round_trip_with_stations(tmp_path):
    scanners = SURVEY + np.array([[2.125, -8.0, 1.6], [9.0, -12.5, 1.1]])
    station = np.random.default_rng(5).integers(-1, 2, 500)
    write_las(PointCloud(wall(), "", scanners=scanners, station=station), tmp_path / "a.laz")
    assert np.array_equal(read_las(tmp_path / "a.laz").station, station)
    # What other programs see: the ASPRS field, 0 for points whose source is not known.
    assert np.array_equal(laspy.read(tmp_path / "a.laz").point_source_id, station + 1)


def test_point_sources_of_other_programs_are_no_stations(tmp_path):
    path = tmp_path / "a.las"
    laspy_file(path, point_format=6, version="1.4")
    las = laspy.read(path)
    las.point_source_id[:] = 1
    las.write(path)
    assert len(read_las(path).station) == 0
    write_las(PointCloud(wall(), "", scanners=SURVEY[np.newaxis], station=np.zeros(500, dtype=int)), path)
    las = laspy.read(path)
    las.point_source_id[:9] = 77  # flight lines, say
    las.write(path)
    assert len(read_las(path).station) == 0


UTM = (
    'PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.25]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["metre",1]]'
)
TEXAS = (  # EPSG 2277 in the form that GDAL writes
    'PROJCS["NAD83 / Texas Central (ftUS)",GEOGCS["NAD83",DATUM["North_American_Datum_1983",'
    'SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],'
    'PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["false_easting",2296583.333],'
    'UNIT["US survey foot",0.304800609601219]]'
)
TEXAS_2 = (  # the same in WKT 2, shortened; the ellipsoid is in metres
    'PROJCRS["NAD83 / Texas Central (ftUS)",BASEGEOGCRS["NAD83",DATUM["North American Datum 1983",'
    'ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,'
    'ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["a",METHOD["b"],PARAMETER["Easting at false origin",'
    '2296583.333,LENGTHUNIT["US survey foot",0.304800609601219]]],CS[Cartesian,2],AXIS["easting (X)",east],'
    'LENGTHUNIT["US survey foot",0.304800609601219]]'
)
HEIGHTS = 'VERT_CS["NAVD88 height",VERT_DATUM["North American Vertical Datum 1988",2005],UNIT["metre",1]]'
DEGREES = (
    'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.25]],UNIT["degree",0.017453292519943]]'
)


def file_with_crs(path, record_id, payload):
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = np.full(3, 1e-3), np.zeros(3)
    header.vlrs.append(laspy.VLR("LASF_Projection", record_id, "", payload))
    las = laspy.LasData(header)
    las.xyz = np.random.default_rng(3).uniform([0, -0.01, 0], [15, 0.01, 40], (500, 3))
    las.write(path)
    return path


def keys(entries):
    """A directory of GeoTIFF keys: version 1.1.0, then key, 0, 1, value each."""
    rows = [(1, 1, 0, len(entries)), *((key, 0, 1, value) for key, value in sorted(entries.items()))]
    return np.array(rows, dtype="<u2").tobytes()


@pytest.mark.parametrize(
    ("record_id", "payload", "metres"),
    [
        (2112, UTM.encode() + b"\0", 1.0),
        (2112, TEXAS.encode(), 1200 / 3937),
        (2112, TEXAS_2.encode(), 1200 / 3937),
        (2112, b'COMPD_CS["a",' + UTM.encode() + b"," + HEIGHTS.encode() + b"]", 1.0),
        (2112, b"\xff\xfe nothing", 1.0),
        (34735, keys({1024: 1, 3076: 9001}), 1.0),
        (34735, keys({1024: 1, 3076: 9002}), 0.3048),
        (34735, keys({1024: 1, 3076: 9003, 4099: 9003}), 1200 / 3937),
        (34735, keys({1024: 1, 3072: 32632}), 1.0),
        (34735, keys({}), 1.0),
    ],
)
def test_units_of_the_coordinate_system(tmp_path, record_id, payload, metres):
    path = file_with_crs(tmp_path / "a.las", record_id, payload)
    height = np.ptp(laspy.read(path).z)
    assert np.ptp(read_scan(path).points[:, 2]) == pytest.approx(height * metres, rel=1e-12)
    assert np.ptp(read_scan(path, units=Units.M).points[:, 2]) == pytest.approx(height, rel=1e-12)


@pytest.mark.parametrize(
    ("record_id", "payload", "message"),
    [
        (2112, DEGREES.encode(), "is in degrees of longitude and latitude: project it"),
        (34735, keys({1024: 2}), "is in degrees of longitude and latitude: project it"),
        (
            34735,
            keys({3076: 9003, 4099: 9001}),
            "has x and y in another unit than z, m and us-ft: convert it",
        ),
        (
            2112,
            f'COMPD_CS["a",{TEXAS},{HEIGHTS}]'.encode(),
            "has x and y in another unit than z, m and us-ft",
        ),
    ],
)
def test_coordinate_systems_that_are_no_metres(tmp_path, record_id, payload, message):
    path = file_with_crs(tmp_path / "a.las", record_id, payload)
    with pytest.raises(InputError, match=message):
        read_scan(path)
    assert len(read_scan(path, units=Units.M)) == 500


@pytest.mark.parametrize(
    "payload",
    [b"{", b'{"scanners": 3, "x": "y"', b"[]", b'{"scanners": [["a", 1, 2]]}', b'{"scanners": [[1, 2]]}'],
)
def test_damaged_scanner_record(tmp_path, payload):
    las = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    las.xyz = np.eye(3)
    las.header.vlrs.append(laspy.VLR("fd2fem", 1, "", payload))
    las.write(tmp_path / "a.las")
    with pytest.raises(InputError, match="record of scanner positions is damaged"):
        read_las(tmp_path / "a.las")


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("kept", [3, 100, 300, 0.5, 0.99])
def test_cut_short(tmp_path, suffix, kept):
    path = tmp_path / f"a.{suffix}"
    write_las(PointCloud(wall(), ""), path)
    data = path.read_bytes()
    path.write_bytes(data[: kept if kept > 1 else int(kept * len(data))])
    with pytest.raises(InputError, match=r"cut short|damaged|does not begin with LASF") as caught:
        read_las(path)
    assert "\n" not in str(caught.value)


def test_counts_of_points_in_the_message(tmp_path):
    path = tmp_path / "a.las"
    write_las(PointCloud(wall(), ""), path)
    path.write_bytes(path.read_bytes()[: 375 + 30 * 123 + 7])  # header 1.4, point format 6: 30 bytes each
    with pytest.raises(InputError, match="its header says 500 points, the file holds 123"):
        read_las(path)


@pytest.mark.parametrize(
    ("offset", "layout", "value"),
    [(94, "<H", 65535), (96, "<I", 2**31), (100, "<I", 2**32 - 1), (105, "<H", 0), (247, "<Q", 2**60)],
)
def test_damaged_header_takes_no_memory(tmp_path, offset, layout, value):
    path = tmp_path / "a.las"
    write_las(PointCloud(wall(), ""), path)
    data = bytearray(path.read_bytes())
    struct.pack_into(layout, data, offset, value)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"damaged|cut short"):
        read_las(path)


@pytest.mark.parametrize(
    ("points", "name", "message"),
    [
        (wall(), "a.ply", r"must end in \.las or \.laz"),
        (np.empty((0, 3)), "a.las", "the cloud has no points"),
        (np.array([[0, 0, 0], [3e5, 0, 0]]), "a.las", r"points are 300000 m apart"),
        (wall(), "missing/a.las", "cannot be written: No such file"),
    ],
)
def test_what_is_not_written(tmp_path, points, name, message):
    with pytest.raises(InputError, match=message):
        write_las(PointCloud(points, ""), tmp_path / name)
    assert not (tmp_path / name).exists()
