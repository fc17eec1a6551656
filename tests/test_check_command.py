"""``fd2fem analyse --check calculix``: what it writes and how it ends."""

import json
import os
import shutil

import pytest
from exported_meshes import all_kinds

from fd2fem.cli import main
from fd2fem.meshing import write_mesh

SETTLEMENT = """[settlement]
vertical_left = -0.01
vertical_right = -0.004
horizontal_left = -0.001
horizontal_right = 0.002
"""
needs_ccx = pytest.mark.skipif(
    shutil.which("ccx") is None or os.name != "posix",
    reason="needs CalculiX (Debian and Ubuntu: calculix-ccx) and a shell",
)


@pytest.fixture(params=["hexahedron", "hexahedron20", "tetra10"])
def arguments(request, tmp_path, monkeypatch):
    monkeypatch.delenv("CCX", raising=False)
    write_mesh(all_kinds()[request.param], tmp_path / "wall.msh")
    (tmp_path / "load.toml").write_text(SETTLEMENT)
    paths = [str(tmp_path / name) for name in ("wall.msh", "load.toml", "out")]
    return ["analyse", paths[0], "--config", paths[1], "-o", paths[2], "--check", "calculix"]


@needs_ccx
def test_a_check_that_passes(arguments, tmp_path, capsys):
    assert main([*arguments, "--json"]) == 0
    said = capsys.readouterr()
    written = json.loads((tmp_path / "out" / "calculix.json").read_text())
    assert written["passed"]
    assert json.loads(said.out)["check"] == written
    deck = (tmp_path / "out" / "calculix.inp").read_text()
    nodes = deck.partition("*NODE, NSET=ALL\n")[2].partition("*")[0]
    assert written["nodes"] == len(nodes.splitlines())
    assert "falls short" not in said.err
    # Without the check nothing of it is left.
    assert main([*arguments[:-2], "--force", "--quiet"]) == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["response.json", "response.vtu"]


@needs_ccx
def test_a_check_that_falls_short(arguments, tmp_path, monkeypatch, capsys):
    """A CalculiX that takes the masonry to be softer, and so answers something else."""
    script = tmp_path / "ccx"
    real = shutil.which("ccx")
    script.write_text(f"#!/bin/sh\nsed -i 's/^3480000000, /3479000000, /' wall.inp\nexec {real} \"$@\"\n")
    script.chmod(0o755)
    monkeypatch.setenv("CCX", str(script))
    assert main([*arguments, "--quiet"]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines
    assert all(line.startswith("fd2fem: falls short: ") for line in lines)
    assert any("stress differs from CalculiX's by at most" in line for line in lines)
    assert json.loads((tmp_path / "out" / "calculix.json").read_text())["passed"] is False


def test_calculix_missing(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said == "fd2fem: CalculiX is not installed: apt-get install calculix-ccx, or leave out --check.\n"
    assert not (tmp_path / "out").exists()
