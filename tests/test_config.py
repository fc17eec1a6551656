import pytest

from fd2fem.config import options_from_dict, read_options
from fd2fem.errors import InputError
from fd2fem.meshing import ElementShape
from fd2fem.solids import SolidForm
from solvers import LinearSettlement, PeckTrough, SettlementTable

WHOLE = """
[reconstruction]
min_opening = 0.5
thickness = 0.4

[solid]
anf_order = 4

[mesh]
size = 0.2

[material]
young = 2.0e9
poisson = 0.2

[settlement]
kind = "peck"
volume_loss = 0.01
diameter = 6.0
depth = 15.0

[analysis]
gravity = 9.8

[comparison]
tolerance = 0.1
"""


def test_every_section_arrives(tmp_path):
    path = tmp_path / "c.toml"
    path.write_text(WHOLE)
    options = read_options(path)
    assert options.reconstruction.min_opening == 0.5
    assert options.reconstruction.thickness == 0.4
    assert options.solid.anf_order == 4
    assert options.mesh.size == 0.2
    assert (options.analysis.material.young, options.analysis.material.density) == (2.0e9, 1900.0)
    assert isinstance(options.analysis.settlement, PeckTrough)
    assert options.analysis.gravity == 9.8
    assert options.comparison.tolerance == 0.1


def test_empty_configuration_is_the_default():
    options = options_from_dict({}, source="empty")
    assert options.analysis.settlement == LinearSettlement()
    assert options.mesh.size is None


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"mehs": {}}, r"c: unknown section \[mehs\]; did you mean 'mesh'"),
        ({"mesh": 3}, r"c: 'mesh' must be a section"),
        ({"mesh": {"sise": 0.2}}, r"c: \[mesh\]: unknown key 'sise'; did you mean 'size'"),
        ({"solid": {"strength": {"friktion": 30.0}}}, r"c: \[solid\]: strength: .*did you mean 'friction'"),
        ({"mesh": {"size": "coarse"}}, r"c: \[mesh\]: size: .*number"),
        ({"mesh": {"size": -1.0}}, r"c: \[mesh\]: .*size"),
        ({"mesh": {"size": True}}, r"c: \[mesh\]: size: .*number"),
        ({"reconstruction": {"seed": -1}}, r"c: \[reconstruction\]: .*seed"),
        ({"analysis": {"gravity": "high"}}, r"c: \[analysis\]: gravity: .*number"),
        ({"analysis": {"material": {}}}, r"c: \[analysis\]: unknown key 'material'"),
        ({"settlement": {"kind": [1]}}, r"c: \[settlement\]: kind is \[1\]"),
        ({"reconstruction": {"threshold": 0.3}}, r"more than half of the smallest opening"),
        ({"material": {"poisson": 0.5}}, r"c: \[material\]: .*poisson"),
        (
            {"settlement": {"kind": "sinkhole"}},
            r"c: \[settlement\]: kind is 'sinkhole', expected 'linear', 'table', 'peck' or 'trough'",
        ),
        ({"settlement": {"kind": "peck", "depth": 15.0}}, r"c: \[settlement\]: volume_loss: .*required"),
        ({"reconstruction": {"min_opening": 0}}, r"c: \[reconstruction\]: .*min_opening"),
    ],
)
def test_mistakes_are_named_in_one_line(data, message):
    with pytest.raises(InputError, match=message) as caught:
        options_from_dict(data, source="c")
    assert "\n" not in str(caught.value)


def test_file_that_is_not_toml(tmp_path):
    path = tmp_path / "c.toml"
    path.write_text("size 3")
    with pytest.raises(InputError, match=r"c\.toml is not TOML"):
        read_options(path)
    with pytest.raises(InputError, match="Cannot read the configuration"):
        read_options(tmp_path / "missing.toml")


def test_overrides_of_verdicts():
    table = {"x": 1.0, "z": 2, "verdict": "opening"}
    found = options_from_dict({"reconstruction": {"overrides": [table]}}, source="a.toml").reconstruction
    assert [(one.x, one.z, one.verdict.value) for one in found.overrides] == [(1.0, 2.0, "opening")]


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ({"x": 1.0, "z": 2.0, "verdict": "window"}, "verdict"),
        ({"x": 1.0, "verdict": "opening"}, "z"),
        ({"x": 1.0, "z": 2.0, "verdict": "opening", "why": "x"}, "overrides 1: unknown key 'why'"),
        ({"x": "left", "z": 2.0, "verdict": "opening"}, "x"),
    ],
)
def test_bad_override_is_one_line(table, text):
    with pytest.raises(InputError, match=text) as caught:
        options_from_dict({"reconstruction": {"overrides": [table]}}, source="a.toml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [("wall", 0), ("wall_band", 3.0), ("voxel_tolerance", 0.0)])
def test_settings_out_of_range_are_refused(name, value):
    with pytest.raises(InputError, match=name):
        options_from_dict({"reconstruction": {name: value}}, source="a.toml")


def test_a_settlement_table_in_a_file_beside_the_configuration(tmp_path):
    (tmp_path / "moves.csv").write_text("x,ux,uz\n0,-2,-12\n5,-1,-3\n")
    path = tmp_path / "c.toml"
    path.write_text('[settlement]\nkind = "table"\nfile = "moves.csv"\nunit = "mm"\n')
    settlement = read_options(path).analysis.settlement
    assert settlement == SettlementTable(x=(0, 5), ux=(-0.002, -0.001), uz=(-0.012, -0.003))


def test_a_settlement_table_in_the_configuration():
    table = {"kind": "table", "x": [0, 5], "uz": [-0.02, -0.01]}
    settlement = options_from_dict({"settlement": table}, source="c").analysis.settlement
    assert settlement == SettlementTable(x=(0, 5), uz=(-0.02, -0.01))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"file": "moves.csv", "unit": "inch"}, r"c: \[settlement\]: expected file = .* 'm' or 'mm'"),
        ({"file": 3}, r"c: \[settlement\]: expected file = "),
        ({"file": "moves.csv", "x": [0, 1]}, r"c: \[settlement\]: unknown key 'x'"),
        ({"file": "no-such.csv"}, r"no-such\.csv"),
    ],
)
def test_a_settlement_table_that_cannot_be_read(table, message):
    with pytest.raises(InputError, match=message):
        options_from_dict({"settlement": {"kind": "table", **table}}, source="c")


def test_how_solid_and_mesh_are_made():
    data = {
        "solid": {"form": "voxels", "also": ["iges"], "anf_order": 4},
        "mesh": {"size": 0.2, "order": 2, "elements": "tetrahedra", "corner_size": 0.05},
    }
    options = options_from_dict(data, source="c")
    assert (options.solid.form, options.solid.also) == (SolidForm.VOXELS, ("iges",))
    assert (options.mesh.order, options.mesh.elements) == (2, ElementShape.TETRAHEDRA)
