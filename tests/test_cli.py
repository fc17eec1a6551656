import json
import signal
import subprocess
import sys
from pathlib import Path

import laspy
import meshio
import numpy as np
import pytest
from synthetic import cleaned_cloud, facade_of

from fd2fem.cli import main
from fd2fem.drawings import write_facade
from fd2fem.scans import write_las

DRAWING = """
length = 5.0
height = 6.0
thickness = 0.4

[[openings]]
x = 1.0
z = 1.0
width = 1.2
height = 1.6

[[openings]]
kind = "door"
x = 3.0
z = 0.0
width = 1.1
height = 2.2
"""
HOUSE = facade_of(5.0, 6.0, [(1.0, 1.0, 1.2, 1.6), (3.0, 0.0, 1.1, 2.2)], thickness=0.4)


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A cleaned scan of the house; kept for the whole module."""
    path = tmp_path_factory.mktemp("scan") / "house.laz"
    write_las(cleaned_cloud(HOUSE, 0.03), path)
    return path


@pytest.fixture
def drawing(tmp_path):
    path = tmp_path / "house.toml"
    path.write_text(DRAWING)
    return path


def call(*arguments):
    return main([str(argument) for argument in arguments])


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_run_ends_with_a_verdict_and_every_result(scan, drawing, tmp_path, capsys):
    out = tmp_path / "out"
    assert call("run", scan, "--reference", drawing, "-o", out, "--json", "--quiet") == 0
    printed = capsys.readouterr()
    summary = json.loads(printed.out)
    assert printed.err == ""
    assert summary["comparison"]["passed"] is True
    assert summary["facade"]["length"] == pytest.approx(5.0, abs=0.02)
    names = everything(out)
    for name in ("facade.json", "facade.step", "facade.anf", "facade_apdl.inp", "mesh.msh", "response.json"):
        assert name in names
    assert {"response.vtu", "comparison.json", "report.html", "reference/response.json"} <= set(names)
    assert sum(name.endswith(".png") for name in names) == 10
    # The wall's thickness is that of the drawing: a scan of the outside does not show it.
    assert json.loads((out / "facade.json").read_text())["thickness"] == 0.4
    assert meshio.read(out / "response.vtu").point_data["displacement"].shape[1] == 3


def test_step_by_step_gives_the_same_verdict(scan, drawing, tmp_path, capsys):
    assert call("reconstruct", scan, "-o", tmp_path / "a") == 0
    facade = tmp_path / "a" / "facade.json"
    assert call("solid", facade, "-o", tmp_path / "a") == 0
    for suffix in (".msh", ".vtu", ".inp", ".cdb", ".med"):
        assert call("mesh", facade, "-o", tmp_path / f"wall{suffix}") == 0
    assert call("analyse", facade, "-o", tmp_path / "a") == 0
    assert call("analyse", drawing, "-o", tmp_path / "b") == 0
    assert call("compare", tmp_path / "a", tmp_path / "b", "-o", tmp_path / "c") == 0
    comparison = json.loads((tmp_path / "c" / "comparison.json").read_text())
    assert comparison["schema"] == "fd2fem/comparison-1"
    assert {row["quantity"] for row in comparison["response"]} >= {
        "max_displacement_m",
        "max_principal_stress_pa",
    }
    assert call("analyse", tmp_path / "wall.msh", "-o", tmp_path / "d") == 0
    first, second = (json.loads((tmp_path / name / "response.json").read_text()) for name in "ad")
    assert second["max_displacement_m"] == pytest.approx(first["max_displacement_m"], rel=1e-9)
    assert capsys.readouterr().out == ""


def test_comparison_that_falls_short_is_code_1(drawing, tmp_path, capsys):
    other = tmp_path / "other.toml"
    other.write_text(DRAWING.replace("length = 5.0", "length = 5.5"))
    assert call("compare", other, drawing) == 1
    assert "length is 10 % larger" in capsys.readouterr().err
    assert call("compare", other, drawing, "--tolerance", 0.2) == 0


def test_virtual_scan_is_a_laz_file_with_its_stations(drawing, tmp_path):
    path = tmp_path / "scan.laz"
    assert call("scan", drawing, "-o", path, "--density", "S50", "--clean", "--seed", 3) == 0
    with laspy.open(path) as reader:
        assert reader.header.point_count > 5000
        assert reader.read().intensity.max() > 0
    assert call("reconstruct", path, "-o", tmp_path / "out") == 0
    facade = json.loads((tmp_path / "out" / "facade.json").read_text())
    assert [opening["kind"] for opening in facade["openings"]] == ["window", "door"]


@pytest.mark.slow
def test_demo(tmp_path, capsys):
    assert call("demo", "-o", tmp_path / "demo", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    # The paper's settlement on its building 1: 99.6 mm from the drawing, 102.1 mm from the scan.
    assert 0.098 <= summary["response"]["max_displacement_m"] <= 0.102
    row = next(r for r in summary["comparison"]["response"] if r["quantity"] == "max_displacement_m")
    assert abs(row["relative_difference"]) < 0.025
    assert len(summary["facade"]["openings"]) == 4
    for name in ("length", "height", "opening_area"):
        assert abs(summary["comparison"]["geometry"][name]["relative_error"]) < 0.012


def test_facade_without_an_opening_is_valid(tmp_path):
    path = tmp_path / "blank.laz"
    write_las(cleaned_cloud(facade_of(4.0, 3.0, []), 0.03), path)
    assert call("reconstruct", path, "-o", tmp_path / "out") == 0
    assert json.loads((tmp_path / "out" / "facade.json").read_text())["openings"] == []


def points_file(path, points):
    np.savetxt(path, points, fmt="%.6f")
    return path


def bad_scans(folder):
    rng = np.random.default_rng(0)
    wall = cleaned_cloud(HOUSE, 0.1).points
    with_nan = wall.copy()
    with_nan[7, 1] = np.nan
    (folder / "empty.xyz").write_text("")
    (folder / "letter.laz").write_text("Dear Sir")
    (folder / "words.xyz").write_text("not a point cloud\nat all\n")
    line = np.outer(np.linspace(0, 5, 500), [1.0, 1.0, 1.0])
    ground = np.column_stack([rng.uniform(0, 20, (3000, 2)), rng.normal(0, 0.004, 3000)])
    return {
        "missing": folder / "missing.laz",
        "folder": folder,
        "empty": folder / "empty.xyz",
        "no cloud": folder / "letter.laz",
        "words": folder / "words.xyz",
        "nan": points_file(folder / "nan.xyz", with_nan),
        "three": points_file(folder / "three.xyz", wall[:3]),
        "line": points_file(folder / "line.xyz", line),
        "no wall": points_file(folder / "ground.xyz", ground),
        "sparse": points_file(folder / "sparse.xyz", cleaned_cloud(HOUSE, 0.25).points),
    }


@pytest.mark.parametrize(
    ("case", "text"),
    [
        ("missing", "missing.laz"),
        ("folder", "folder"),
        ("empty", "empty"),
        ("no cloud", "letter.laz"),
        ("words", "words.xyz"),
        ("nan", "not finite|NaN|nan"),
        ("three", "3 points"),
        ("line", "line"),
        ("no wall", "No wall found"),
        ("sparse", "too far to show openings"),
    ],
)
@pytest.mark.parametrize("verb", ["reconstruct", "run"])
def test_bad_scan_is_one_line_and_leaves_nothing(case, text, verb, tmp_path, capsys):
    (tmp_path / "in").mkdir()
    scan = bad_scans(tmp_path / "in")[case]
    before = everything(tmp_path)
    assert call(verb, scan, "-o", tmp_path / "out", "--quiet", "--json") == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert printed.err.startswith("fd2fem: ")
    assert any(part in printed.err for part in text.split("|"))
    assert everything(tmp_path) == before


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("list.json", "[1, 2]"),
        ("other.json", '{"schema": "something/else"}'),
        ("recipe.toml", 'title = "Pancakes"'),
        ("broken.toml", "length = "),
        ("solid.step", "not a step file"),
        ("drawing.dxf", "not a drawing"),
        ("facade.doc", "a letter"),
    ],
)
def test_bad_reference_is_one_line_and_leaves_nothing(name, content, scan, tmp_path, capsys):
    (tmp_path / name).write_text(content)
    assert call("run", scan, "--reference", tmp_path / name, "-o", tmp_path / "out", "--quiet") == 2
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1
    assert name in printed.err
    assert everything(tmp_path) == [name]


def test_existing_result_is_kept_unless_forced(drawing, tmp_path, capsys):
    out = tmp_path / "out"
    assert call("analyse", drawing, "-o", out) == 0
    written = (out / "response.json").read_bytes()
    assert call("analyse", drawing, "-o", out, "--quiet") == 2
    assert "--force" in capsys.readouterr().err.splitlines()[-1]
    assert (out / "response.json").read_bytes() == written
    assert call("analyse", drawing, "-o", out, "--force") == 0


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("levitate",),
        ("reconstruct", "scan.laz"),
        ("reconstruct", "scan.laz", "-o", "out", "--scanner", "1,2"),
        ("scan", "building1", "-o", "x.laz", "--density", "S33"),
        ("compare", "building1", "building1", "--tolerance", "much"),
    ],
)
def test_wrong_words_are_code_2_in_one_line(arguments, capsys):
    with pytest.raises(SystemExit) as left:
        call(*arguments)
    assert left.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("tolerance", ["0", "-1", "nan", "2"])
def test_tolerance_out_of_range(tolerance, capsys):
    assert call("compare", "building1", "building1", f"--tolerance={tolerance}") == 2
    assert "tolerance" in capsys.readouterr().err


def test_analysis_options_come_from_the_configuration(drawing, tmp_path, capsys):
    config = tmp_path / "c.toml"
    config.write_text(
        "[settlement]\nkind = 'linear'\nvertical_left = 0.0\nvertical_right = 0.0\n"
        "horizontal_left = 0.0\nhorizontal_right = 0.0\n[mesh]\nsize = 0.5\n"
    )
    assert call("analyse", drawing, "--config", config, "-o", tmp_path / "out", "--json", "--quiet") == 0
    response = json.loads(capsys.readouterr().out)["response"]
    # Self-weight alone: density x gravity x volume, and a shortening of well under a millimetre.
    assert response["reaction_n"][2] == pytest.approx(1900 * 9.81 * HOUSE.wall_area * 0.4, rel=1e-6)
    assert response["max_displacement_m"] < 5e-4


def test_mesh_that_cannot_be_made_is_code_3(tmp_path, capsys):
    path = tmp_path / "thin.toml"
    # A tenth of a millimetre of masonry between two windows.
    path.write_text(
        "length = 5.0\nheight = 6.0\n"
        + "".join(f"[[openings]]\nx = {x}\nz = 1.0\nwidth = 1.0\nheight = 1.0\n" for x in (1.0, 2.0001))
    )
    assert call("mesh", path, "-o", tmp_path / "wall.msh", "--quiet") == 3
    assert capsys.readouterr().err.count("\n") == 1
    assert everything(tmp_path) == ["thin.toml"]


def test_traceback_only_with_debug(tmp_path, capsys):
    assert call("reconstruct", tmp_path / "no.laz", "-o", tmp_path / "out", "--debug") == 2
    assert "Traceback" in capsys.readouterr().err


def test_installed_command_answers():
    answer = subprocess.run(
        [sys.executable, "-m", "fd2fem", "--version"], capture_output=True, text=True, check=True
    )
    assert answer.stdout.startswith("fd2fem 0.")


def test_facade_round_trip_through_step(drawing, tmp_path):
    assert call("solid", drawing, "-o", tmp_path / "s") == 0
    assert call("compare", tmp_path / "s" / "facade.step", drawing, "--tolerance", 1e-6) == 0
    assert call("mesh", tmp_path / "s" / "facade.step", "-o", tmp_path / "tets.msh") == 0


def test_several_scans_are_joined(tmp_path):
    cloud = cleaned_cloud(HOUSE, 0.03)
    low = cloud.points[:, 2] < 3.0
    paths = []
    for name, part in (("low", low), ("high", ~low)):
        paths.append(points_file(tmp_path / f"{name}.xyz", cloud.points[part]))
    assert call("reconstruct", *paths, "--scanner", "2.5,-10,1.6", "-o", tmp_path / "out") == 0
    facade = json.loads((tmp_path / "out" / "facade.json").read_text())
    assert facade["height"] == pytest.approx(6.0, abs=0.02)
    assert facade["outside_by"] == "the scanner's position"


def test_facade_file_of_a_record_round_trips(tmp_path):
    write_facade(HOUSE, tmp_path / "facade.json")
    assert call("compare", tmp_path, tmp_path / "facade.json", "--tolerance", 1e-9) == 0


def test_reference_of_another_building_is_a_verdict_not_a_mistake(scan, tmp_path, capsys):
    other = tmp_path / "other.toml"
    other.write_text(DRAWING.replace("length = 5.0", "length = 14.0").replace("height = 6.0", "height = 9.0"))
    assert call("run", scan, "--reference", other, "-o", tmp_path / "out", "--quiet") == 1
    assert "length is" in capsys.readouterr().err
    comparison = json.loads((tmp_path / "out" / "comparison.json").read_text())
    assert comparison["passed"] is False
    assert any("of the reference's volume" in reason for reason in comparison["reasons"])


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows ends processes without a signal")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_stopped_run_leaves_nothing(number, scan, tmp_path):
    command = [sys.executable, "-m", "fd2fem", "run", str(scan), "-o", str(tmp_path / "out")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if "reconstructing" in line:
                process.send_signal(number)
                break
        rest = process.stderr.read()
    assert process.returncode == 128 + number
    assert rest.endswith("fd2fem: stopped\n")
    assert everything(tmp_path) == []


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a device that is always full")
def test_full_stdout_is_an_error_in_one_line(drawing):
    command = [sys.executable, "-m", "fd2fem", "compare", str(drawing), str(drawing), "--json", "--quiet"]
    with Path("/dev/full").open("w") as sink:
        answer = subprocess.run(command, stdout=sink, stderr=subprocess.PIPE, text=True, check=False)
    assert answer.returncode == 2
    assert answer.stderr.startswith("fd2fem: ")


def test_empty_reference_is_not_ignored(scan, tmp_path, capsys):
    assert call("run", scan, "--reference", "", "-o", tmp_path / "out", "--quiet") == 2
    assert "empty" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["not a solid", "ISO-10303-21;\nHEADER;\ncut off"])
def test_stdout_stays_clean_of_other_programs(text, tmp_path, capfd):
    (tmp_path / "text.step").write_text(text)
    assert call("mesh", tmp_path / "text.step", "-o", tmp_path / "m.msh", "--quiet") == 2
    assert capfd.readouterr().out == ""
