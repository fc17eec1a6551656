"""The neutral file: its text by a separate parser and SciPy's B-splines, a file by another writer, errors."""

import re
from pathlib import Path

import numpy as np
import pytest
from anf_rules import check_anf, records
from scipy.interpolate import BSpline

from fd2fem.errors import InputError
from fd2fem.model import WallCells
from fd2fem.solids import (
    anf_source,
    read_anf,
    solid_from_cells,
    solid_from_voxels,
    solid_volumes,
    write_anf,
)

HERE = Path(__file__).parent
TEE = [(0, 0, 2, 2), (2, 0, 3, 1), (2, 1, 3, 2)]


def parse(text):
    """Keypoints, curves, surfaces and volumes of a text by id."""
    tables = {"kpt": {}, "lcurv": {}, "asurf": {}, "vbody": {}}
    for command, fields, data in records(text):
        number = int(fields[0])
        if command == "kpt":
            assert data == []
            tables["kpt"][number] = tuple(fields[1:])
        elif command == "lcurv":
            _, order, rational, knots, points = map(int, data[:5])
            assert rational == 0
            assert len(data) == 5 + knots + 3 * points
            control = np.reshape(data[5 + knots :], (points, 3))
            curve = BSpline(np.array(data[5 : 5 + knots]), control, order - 1)
            tables["lcurv"][number] = (int(fields[2]), int(fields[3]), curve(fields[4:]), curve, order)
        elif command == "asurf":
            tables["asurf"][number] = surface(fields, data)
        else:
            assert len(data) == 2 + data[1] == 2 + fields[2]
            tables["vbody"][number] = [int(i) for i in data[2:]]
    return tables


def surface(fields, data):
    """Loop, and S and dS/du x dS/dv as functions."""
    assert fields[1:3] == [1, 1]
    kind, size = map(int, data[:2])
    assert kind == 0
    assert size == fields[3]
    loop = [int(i) for i in data[2 : 2 + size]]
    form, order, order_v, rational, knots_u, knots_v, n, m = map(int, data[2 + size : 10 + size])
    assert (form, order) == (0, order_v)
    rest = data[10 + size :]
    u, v = np.array(rest[:knots_u]), np.array(rest[knots_u : knots_u + knots_v])
    rest = rest[knots_u + knots_v :]
    assert rest[3 * n * m :] == ([1.0] * (n * m) if rational else [])
    control = np.reshape(rest[: 3 * n * m], (m, n, 3))  # u fastest

    def at(s, t, du=0, dv=0):
        along = BSpline(u, control.swapaxes(0, 1), order - 1)
        along = along.derivative(du) if du else along
        across = BSpline(v, along(s), order - 1)
        return (across.derivative(dv) if dv else across)(t)

    return loop, at, (order, rational), (fields[4:], [u[0], u[-1], v[0], v[-1]])


@pytest.fixture(params=[2, 4])
def order(request):
    return request.param


@pytest.fixture
def written(tmp_path, make_wall, order):
    """A wall with T-junctions, its record and the text."""
    solid = solid_from_voxels(make_wall(4.0, 3.0, [(1.1, 0.9, 2.3, 2.2)]))
    write_anf(solid, tmp_path / "wall.anf", order=order)
    return solid, (tmp_path / "wall.anf").read_text()


def test_lines_are_straight_from_keypoint_to_keypoint(written, order):
    tables = parse(written[1])
    assert len(tables["lcurv"]) == len(written[0].lines)
    for start, end, ends, curve, curve_order in tables["lcurv"].values():
        a, b = np.array(tables["kpt"][start]), np.array(tables["kpt"][end])
        assert curve_order == order
        assert ends == pytest.approx(np.array([a, b]), abs=1e-12)
        assert curve(0.3) == pytest.approx(0.7 * a + 0.3 * b, abs=1e-12)
        assert curve.t.tolist() == [0.0] * order + [1.0] * order


def test_surfaces_span_their_loops_and_look_the_same_way(written, order):
    tables = parse(written[1])
    for loop, at, kind, (announced, knots) in tables["asurf"].values():
        assert kind == (order, 1 if order == 4 else 0)
        assert announced == knots == [0, 1, 0, 1]
        starts = [tables["lcurv"][abs(i)][0 if i > 0 else 1] for i in loop]
        ends = [tables["lcurv"][abs(i)][1 if i > 0 else 0] for i in loop]
        assert ends == starts[1:] + starts[:1]
        ring = np.array([tables["kpt"][k] for k in starts])
        corners = np.array([at(0, 0), at(1, 0), at(1, 1), at(0, 1)])
        assert all(np.abs(ring - corner).max(axis=1).min() < 1e-12 for corner in corners)
        vector = 0.5 * np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
        for s, t in ((0.2, 0.7), (0.5, 0.5)):
            normal = np.cross(at(s, t, du=1), at(s, t, dv=1))
            assert normal == pytest.approx(vector, abs=1e-9)


def test_signed_surfaces_enclose_the_volumes(written):
    tables = parse(written[1])
    total = 0.0
    for areas in tables["vbody"].values():
        for i in areas:
            at = tables["asurf"][abs(i)][1]
            flux = np.dot(at(0.5, 0.5), np.cross(at(0.5, 0.5, du=1), at(0.5, 0.5, dv=1))) / 3
            total += flux if i > 0 else -flux
    assert total == pytest.approx(0.35 * (12 - 1.2 * 1.3), rel=1e-12)


def test_text_is_laid_out_as_ansys_lays_it_out(written):
    solid, text = written
    assert text.startswith("/com,\n")
    assert "/com,    Units:       Meters\n" in text
    counts = (len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes))
    assert "/com,    keypoints {}  lines {}  areas {}  volumes {}\n".format(*counts) in text
    assert text.endswith("finish\n/gopr\n")
    commands = [command for command, *_ in records(text)]
    assert commands == [
        name
        for name, count in zip(("kpt", "lcurv", "asurf", "vbody"), counts, strict=True)
        for _ in range(count)
    ]
    reals = re.findall(r"\S*\.\S*", text.split("/aux15\n")[1])
    assert all(
        re.fullmatch(r"-?\d\.\d{15}e[+-]\d\d", real)
        for real in set(",".join(reals).split(","))
        if "." in real
    )


def test_long_loops_and_shells_have_ten_ids_a_line(tmp_path, make_voxels):
    boxes = [(0, 0, 2, 8), *((2, i, 3, i + 1) for i in range(8))]
    solid = solid_from_voxels(make_voxels(boxes))
    write_anf(solid, tmp_path / "comb.anf")
    text = (tmp_path / "comb.anf").read_text()
    front = re.search(r"^asurf,1,1,1,11,.*\nA1\n\t0\t11\n(.*)\n(.*)\n\t0\t2", text, re.MULTILINE)
    assert [len(line.split()) for line in front.groups()] == [10, 1]
    shell = re.search(r"^vbody,1,1,13\nNULL_ID\n\t0\t13\n(.*)\n(.*)\n", text, re.MULTILINE)
    assert [len(line.split()) for line in shell.groups()] == [10, 3]


def test_one_box_says_the_same_as_a_file_by_another_writer(tmp_path, make_voxels):
    write_anf(solid_from_voxels(make_voxels([(0, 0, 2, 0.5)], 3.0)), tmp_path / "box.anf")
    ours, theirs = (parse(path.read_text()) for path in (tmp_path / "box.anf", HERE / "one_box.anf"))
    assert sorted(ours["kpt"].values()) == sorted(theirs["kpt"].values())

    def lines(tables):
        return sorted(
            sorted((tables["kpt"][start], tables["kpt"][end])) for start, end, *_ in tables["lcurv"].values()
        )

    def areas(tables):
        """Centre and outward vector of each face of the volume."""
        found = []
        for i in tables["vbody"][1]:
            at = tables["asurf"][abs(i)][1]
            vector = np.sign(i) * np.cross(at(0.5, 0.5, du=1), at(0.5, 0.5, dv=1))
            found.append([*at(0.5, 0.5).round(9).tolist(), *(vector.round(9) + 0.0).tolist()])
        return sorted(found)

    assert lines(ours) == lines(theirs)
    assert areas(ours) == areas(theirs)


def test_reads_a_file_by_another_writer(measured):
    solid = read_anf(HERE / "one_box.anf")
    found = measured(solid)
    assert found.volumes == pytest.approx([3.0])
    assert found.euler == [2]
    assert found.extent == [2, 3, 0.5]


def test_round_trip(written, tmp_path):
    solid, _ = written
    back = read_anf(tmp_path / "wall.anf")
    assert back.keypoints == pytest.approx(solid.keypoints, abs=1e-14)
    assert back.lines.tolist() == solid.lines.tolist()
    assert back.patches.tolist() == solid.patches.tolist()
    assert back.areas == solid.areas
    assert back.volumes == solid.volumes


def test_orders_other_than_2_and_4_are_refused(tmp_path, make_voxels):
    with pytest.raises(InputError, match="Invalid 'order': expected 2 or 4, got 3"):
        write_anf(solid_from_voxels(make_voxels(TEE)), tmp_path / "x.anf", order=3)
    assert not (tmp_path / "x.anf").exists()


BOX_TEXT = (HERE / "one_box.anf").read_text()


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("vbody,1,1,6", "/com", "no VBODY record"),
        ("  1 2 3 4 5 6\n", "  1 2 3 4 5\n", "volume 1 has fewer numbers than it announces"),
        ("  1 2 3 4 5 6\n", "  1 2 3 4 5 7\n", "volume refers to area 7, which the file does not define"),
        ("kpt,8,0.", "kpt,9,0.", "line refers to keypoint 8"),
        ("kpt,8,0.", "kpt,7,0.", "line 23: number 7 is defined twice"),
        ("kpt,8,0.,", "kpt,8,", "line 23: kpt has 3 fields, expected 4"),
        ("kpt,8,0.", "kpt,8,zero", "keypoint 8 needs numbers here"),
        ("kpt,8,0.", "kpt,8,nan", "keypoints"),
        ("kpt,8,0.", "kpt,8,1.", "line at place 2 is bent or misses its keypoints by 1 m"),
        ("lcurv,2,1,", "lcurv,2,2,", "line 2 is not a straight line of one span"),
        ("L2\n  1 2 0 4 2\n  0. 0. 1. 1.", "L2\n  1 2 0 4 2\n  0. 0. .5 1.", "line 2 is not a straight line"),
        ("asurf,3,1,1,4", "asurf,3,1,2,4", "area 3 has 2 loops"),
        (
            "A3\n  0 4\n  9 8 -10 -1",
            "A3\n  0 4\n  9 8 10 -1",
            "area at place 3 has a loop that is not closed",
        ),
        (
            "A3\n  0 4\n  9 8 -10 -1",
            "A3\n  0 4\n  1 10 -8 -9",
            "area at place 3 has a loop that does not run",
        ),
        ("A3\n  0 4\n  9 8 -10 -1", "A3\n  0 4\n  4 12 -5 -9", "area at place 3 has a surface corner"),
        ("A3\n  0 4\n", "A3\n  0 5\n", "area 3 needs integers here"),
        ("finish\n/gopr\n", "7\nfinish\n/gopr\n", "volume 1 has more numbers than it announces"),
        ("  0 6\n  1 2 3 4 5 6\n", "  0 6.0\n  1 2 3 4 5 6\n", "volume 1 needs integers here"),
        ("  0 6\n  1 2 3 4 5 6\n", "  0 -6\n  1 2 3 4 5 6\n", "volume 1 has a negative count"),
        ("vbody,1,1,6", "vbody,1,2,6", "volume 1 has 2 shells"),
        ("  0 6\n  1 2 3 4 5 6\nfinish\n/gopr\n", "  0 6\n", "volume 1 has fewer numbers than it announces"),
        ("vbody,1,1,6\nNULL_ID\n  0 6\n  1 2 3 4 5 6\nfinish\n/gopr\n", "vbody,1,1,6", "ends inside vbody"),
    ],
)
def test_broken_files_are_refused(tmp_path, old, new, match):
    assert old in BOX_TEXT
    path = tmp_path / "broken.anf"
    path.write_text(BOX_TEXT.replace(old, new))
    with pytest.raises(InputError, match=match) as caught:
        read_anf(path)
    assert "broken.anf" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bent_areas_and_uneven_weights_are_refused(tmp_path, make_voxels):
    path = tmp_path / "box.anf"
    write_anf(solid_from_voxels(make_voxels([(0, 0, 1, 1)])), path, order=4)
    text = path.read_text()
    first, second = text.index("asurf,1,"), text.index("asurf,2,")
    one = "\t1.000000000000000e+00\n"
    weight = text.rindex(one, first, second)
    path.write_text(text[:weight] + "\t2.0\n" + text[weight + len(one) :])
    with pytest.raises(InputError, match="area 1 has weights that differ"):
        read_anf(path)
    third = "3.333333333333333e-01\t"
    inside = text.index(third, first)
    path.write_text(text[:inside] + "3.5e-01\t" + text[inside + len(third) :])
    with pytest.raises(InputError, match=r"area at place 1 is bent or misses its keypoints by 0.0167 m"):
        read_anf(path)


def test_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_anf(tmp_path / "missing.anf")
    (tmp_path / "x.anf").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not plain text"):
        read_anf(tmp_path / "x.anf")


def test_file_is_sound(written):
    solid, text = written
    sound = check_anf(text)
    assert (sound.keypoints, sound.lines, sound.areas) == (
        len(solid.keypoints),
        len(solid.lines),
        len(solid.areas),
    )
    assert sum(sound.volumes) == pytest.approx(0.35 * (12 - 1.2 * 1.3), rel=1e-12)
    rim = 0.35 * (14 + 2 * (1.2 + 1.3))
    assert sound.outer_surface == pytest.approx(2 * (12 - 1.2 * 1.3) + rim, rel=1e-12)


@pytest.mark.parametrize(
    ("pattern", "replacement", "match"),
    [
        (r"^(vbody,2,.*\n.*\n.*\n\t)1?", r"\g<1>-", "walked twice|open"),
        (r"^(asurf,1,.*\n.*\n\t0\t\d\n\t)(\S+)\t(\S+)", r"\1\3\t\2", "a loop is open"),
        (r"^(kpt,3,)(\S+?),", r"\g<1>9.0,", "a curve leaves"),
        (r"^kpt,2,(.*)$", "kpt,2,0.0,0.0,0.0", "a curve leaves"),
    ],
)
def test_rules_notice_what_is_wrong(written, pattern, replacement, match):
    broken = re.sub(pattern, replacement, written[1], count=1, flags=re.MULTILINE)
    assert broken != written[1]
    with pytest.raises(AssertionError, match=match):
        check_anf(broken)


@pytest.mark.parametrize("block", [1, 7, 64, 1000])
def test_blocks_may_end_anywhere(written, tmp_path, monkeypatch, block):
    solid, _ = written
    monkeypatch.setattr(anf_source, "BLOCK", block)
    text = (tmp_path / "wall.anf").read_text()
    assert read_anf(tmp_path / "wall.anf").areas == solid.areas
    (tmp_path / "wall.anf").write_text(text.replace("vbody,3,1,", "vbody,2,1,"))
    number = text[: text.index("vbody,3,1,")].count("\n") + 1
    with pytest.raises(InputError, match=rf"wall.anf, line {number}: number 2 is defined twice"):
        read_anf(tmp_path / "wall.anf")


def test_other_commands_and_capitals_are_passed_over(tmp_path):
    text = BOX_TEXT.replace(
        "asurf,1,", "*if,_z1,gt,0,then\n  *msg,error\n 12 files are open\n*endif\n ASURF ,1,"
    )
    (tmp_path / "box.anf").write_text("kpt\n" + text.replace("lcurv", "LCURV"))
    plain, other = read_anf(HERE / "one_box.anf"), read_anf(tmp_path / "box.anf")
    assert other.areas == plain.areas
    assert other.keypoints.tolist() == plain.keypoints.tolist()


def test_plane_quadrilaterals_of_any_shape_are_read(tmp_path):
    cells = WallCells([[0, 0], [4, 0], [3, 2], [1, 2]], [[0, 1, 2, 3]], 0.5)
    solid = solid_from_cells(cells)
    for order in (2, 4):
        write_anf(solid, tmp_path / "trapezoid.anf", order=order)
        back = read_anf(tmp_path / "trapezoid.anf")
        assert back.patches.tolist() == solid.patches.tolist()
        assert solid_volumes(back).sum() == pytest.approx(cells.volume, rel=1e-14)


@pytest.mark.parametrize("moved", ["2. 0. .1", ".5 2. 0."])
def test_twisted_and_dented_areas_are_refused(tmp_path, moved):
    """A corner off the plane of the other three, and one inside their triangle."""
    text = BOX_TEXT.replace("kpt,2,2.,0.,0.", "kpt,2," + ",".join(moved.split()))
    (tmp_path / "box.anf").write_text(text.replace("  2. 0. 0.\n", f"  {moved}\n"))
    with pytest.raises(InputError, match="not a plane and convex quadrilateral"):
        read_anf(tmp_path / "box.anf")
