import pytest

from fd2fem.config import options_from_dict, read_options
from fd2fem.errors import InputError
from solvers import LinearSettlement, PeckTrough

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
    assert options.mesh.size == 0.25


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"mehs": {}}, r"c: unknown section \[mehs\]; did you mean 'mesh'"),
        ({"mesh": 3}, r"c: 'mesh' must be a section"),
        ({"mesh": {"sise": 0.2}}, r"c: \[mesh\]: unknown key 'sise'; did you mean 'size'"),
        ({"mesh": {"size": "coarse"}}, r"c: \[mesh\]: size: .*number"),
        ({"mesh": {"size": -1.0}}, r"c: \[mesh\]: .*size"),
        ({"mesh": {"size": True}}, r"c: \[mesh\]: size: .*number"),
        ({"reconstruction": {"seed": -1}}, r"c: \[reconstruction\]: .*seed"),
        ({"analysis": {"gravity": "high"}}, r"c: \[analysis\]: gravity: expected a number"),
        ({"analysis": {"material": {}}}, r"c: \[analysis\]: unknown key 'material'"),
        ({"settlement": {"kind": [1]}}, r"c: \[settlement\]: kind is \[1\]"),
        ({"reconstruction": {"threshold": 0.3}}, r"more than half of the smallest opening"),
        ({"material": {"poisson": 0.5}}, r"c: \[material\]: .*poisson"),
        (
            {"settlement": {"kind": "sinkhole"}},
            r"c: \[settlement\]: kind is 'sinkhole', expected 'linear' or 'peck'",
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
