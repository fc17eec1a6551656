"""Solids and meshes of an arched wall that gets thinner, through the command line."""

import json
import shutil
import subprocess

import meshio
import numpy as np
import pytest

from fd2fem.cli import main

# 6 x 5 m, 0.5 m thick up to 3 m and 0.36 m above, a round-headed door and a window with a segmental head.
DRAWING = """
length = 6.0
height = 5.0
thickness = 0.5
[[storeys]]
z = 3.0
thickness = 0.36
[[openings]]
kind = "door"
x = 0.8
z = 0.0
width = 1.2
height = 2.4
head = {shape = "arc"}
[[openings]]
x = 3.4
z = 1.0
width = 1.5
height = 1.6
head = {shape = "arc", rise = 0.25}
"""


def segment(width, rise):
    """Area of a circle's segment, m²."""
    radius = (width**2 / 4.0 + rise**2) / (2.0 * rise)
    half = np.arcsin(width / (2.0 * radius))
    return radius**2 * (half - np.sin(half) * np.cos(half))


DOOR = 1.2 * 1.8 + np.pi * 0.6**2 / 2.0
WINDOW = 1.5 * (1.6 - 0.25) + segment(1.5, 0.25)
VOLUME = (6.0 * 3.0 - DOOR - WINDOW) * 0.5 + 6.0 * 2.0 * 0.36


@pytest.fixture
def drawing(tmp_path):
    path = tmp_path / "arched.toml"
    path.write_text(DRAWING)
    return path


def call(*arguments):
    return main([str(argument) for argument in arguments])


def test_every_file_of_the_solid_has_the_volume_of_the_drawing(drawing, tmp_path, capsys):
    assert call("solid", drawing, "-o", tmp_path / "s", "--also", "iges", "--also", "brep", "--json") == 0
    solid = json.loads(capsys.readouterr().out)["solid"]
    assert solid["volume"] == pytest.approx(VOLUME, rel=1e-9)
    assert solid["step_volume"] == pytest.approx(VOLUME, rel=1e-9)
    assert solid["anf_volume"] == pytest.approx(VOLUME, rel=1e-9)
    names = {path.name for path in (tmp_path / "s").iterdir()}
    assert names == {
        "facade.step", "facade.iges", "facade.brep", "facade.anf", "facade_apdl.inp", "facade_settlement.inp",
    }  # fmt: skip
    # Two arcs through the wall, cut nowhere else.
    assert (tmp_path / "s" / "facade.step").read_text().count("CYLINDRICAL_SURFACE") == 2


def test_step_read_back_is_the_drawing(drawing, tmp_path):
    assert call("solid", drawing, "-o", tmp_path / "s") == 0
    assert call("compare", tmp_path / "s" / "facade.step", drawing, "--tolerance", 1e-6) == 0


@pytest.mark.parametrize("elements", ["hexahedra", "tetrahedra"])
def test_mesh_options_on_the_command_line(drawing, tmp_path, capsys, elements):
    path = tmp_path / "wall.msh"
    assert (
        call("mesh", drawing, "-o", path, "--size", 0.4, "--order", 2, "--elements", elements, "--json") == 0
    )
    mesh = json.loads(capsys.readouterr().out)["mesh"]
    kind = {"hexahedra": "hexahedron20", "tetrahedra": "tetra10"}[elements]
    assert kind in meshio.read(path).cells_dict
    tolerance = {"hexahedra": 1e-9, "tetrahedra": 1e-2}[elements]
    assert mesh["volume"] == pytest.approx(VOLUME, rel=tolerance)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--size", "0"], "size"),
        (["--size", "nan"], "size"),
        (["--corner-size", "-1"], "corner_size"),
    ],
)
def test_bad_mesh_options_are_one_line(drawing, tmp_path, capsys, arguments, message):
    assert call("mesh", drawing, "-o", tmp_path / "wall.msh", *arguments, "--quiet") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert message in error


def last_table(path, heading):
    """Rows of the last table of CalculiX's printed results whose heading begins so."""
    rows, inside = [], False
    for line in path.read_text().splitlines():
        fields = line.split()
        if fields and not fields[0].isdigit():
            inside = fields[0] == heading
            rows = [] if inside else rows
        elif fields and inside:
            rows.append(fields)
    return rows


@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX (Debian: calculix-ccx)")
def test_calculix_runs_the_deck_and_moves_as_the_analysis_says(drawing, tmp_path, capsys):
    assert call("mesh", drawing, "-o", tmp_path / "wall.inp", "--size", 0.5) == 0
    config = tmp_path / "c.toml"
    config.write_text("[mesh]\nsize = 0.5\norder = 2\n")
    assert call("analyse", drawing, "--config", config, "-o", tmp_path / "a", "--json") == 0
    response = json.loads(capsys.readouterr().out)["response"]
    subprocess.run(["ccx", "wall"], cwd=tmp_path, check=True, capture_output=True)
    moved = [
        np.linalg.norm([float(value) for value in fields[1:]])
        for fields in last_table(tmp_path / "wall.dat", "displacements")
    ]
    assert max(moved) == pytest.approx(response["max_displacement_m"], rel=1e-6)
