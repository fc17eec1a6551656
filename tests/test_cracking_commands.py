"""``fd2fem analyse`` and ``compare`` of a wall that cracks: what they write, say and take away again."""

import json

import pytest
from exported_meshes import all_kinds

from fd2fem.cli import main
from fd2fem.meshing import write_mesh

CRACKING = """[settlement]
vertical_left = 0.0
vertical_right = -0.003
horizontal_left = 0.0
horizontal_right = 0.001
[masonry]
tensile_strength = 2e5
fracture_energy = 1e3
[stepping]
steps = 4
"""
OF_CRACKS = {"cracks.png", "load_settlement.csv", "response.pvd"}


def call(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """A wall of masonry that cracks, analysed; with its mesh and configuration."""
    folder = tmp_path_factory.mktemp("cracking")
    write_mesh(all_kinds()["hexahedron"], folder / "wall.msh")
    (folder / "cracking.toml").write_text(CRACKING)
    arguments = folder / "wall.msh", "--config", folder / "cracking.toml", "-o", folder / "a"
    assert call("analyse", *arguments) == 0
    return folder


def test_cracks_and_curve_lie_beside_the_response(analysed):
    names = {path.name for path in (analysed / "a").iterdir()}
    assert names == {"response.json", "response.vtu", "steps"} | OF_CRACKS
    figures = json.loads((analysed / "a" / "response.json").read_text())
    assert figures["dissipated_energy_j"] > 0.0
    # Every crack has passed the strength.
    assert figures["max_principal_stress_pa"] == 2e5
    assert 0.0 < figures["final_principal_stress_pa"] <= 2e5
    assert figures["feet"][0]["reaction_n"][2] == pytest.approx(figures["weight_n"], rel=1e-6)
    curve = (analysed / "a" / "load_settlement.csv").read_text().splitlines()
    assert len(curve) == 1 + len(figures["history"])


def test_two_walls_that_crack_are_drawn_side_by_side_and_the_note_is_told(analysed, tmp_path, capsys):
    out = tmp_path / "c"
    assert call("compare", analysed / "a", analysed / "a", "-o", out) == 0
    assert {path.name for path in out.iterdir()} == {"comparison.json", "compared_cracks.png"}
    (note,) = json.loads((out / "comparison.json").read_text())["notes"]
    assert f"fd2fem: note: {note}" in capsys.readouterr().err
    assert "0.2 and 0.2 MPa" in note


def test_nothing_of_cracks_is_left_by_an_elastic_analysis_in_their_place(analysed, tmp_path, capsys):
    (tmp_path / "cracking.toml").write_text(CRACKING)
    (tmp_path / "elastic.toml").write_text(CRACKING.partition("[masonry]")[0])
    out, mesh = tmp_path / "out", analysed / "wall.msh"
    assert call("analyse", mesh, "--config", tmp_path / "cracking.toml", "-o", out) == 0
    said = capsys.readouterr().err.splitlines()
    before = json.loads((out / "response.json").read_text())
    # The last step's message and the summary tell of one crack, the one of the response.
    crack = f"cracks up to {1000 * before['max_crack_opening_m']:.2f} mm"
    assert f"fd2fem: 100.0 % of the settlement, {crack}" in said
    final = f"{before['final_principal_stress_pa'] / 1e6:.3f}"
    assert "largest principal stress 0.200 MPa at the integration points of all steps" in said[-1]
    assert f"({final} in the last one)" in said[-1]
    assert crack in said[-1]
    assert call("analyse", mesh, "--config", tmp_path / "elastic.toml", "-o", out, "--quiet", "--force") == 0
    left = {path.name for path in out.iterdir()}
    assert not left & OF_CRACKS
    figures = json.loads((out / "response.json").read_text())
    assert figures["max_principal_stress_pa"] == figures["final_principal_stress_pa"]
    assert figures["damage"]["strain_label"]
    assert "crack_class" not in figures["damage"]
    assert len(figures["feet"]) == 1


def test_a_warning_of_the_analysis_is_told_even_when_quiet(tmp_path, capsys):
    write_mesh(all_kinds()["hexahedron"], tmp_path / "wall.msh")
    (tmp_path / "brittle.toml").write_text(
        "[masonry]\nfracture_energy = 20\n[settlement]\nvertical_left = 0\n"
        "vertical_right = 0\nhorizontal_left = 0\nhorizontal_right = 0\n"
    )
    arguments = tmp_path / "wall.msh", "--config", tmp_path / "brittle.toml", "-o", tmp_path / "out"
    assert call("analyse", *arguments, "--quiet") == 0
    said = capsys.readouterr().err
    assert said.startswith("fd2fem: warning: ")
    assert "wider than" in said
