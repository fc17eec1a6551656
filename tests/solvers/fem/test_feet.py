"""What the ground does to each foot of a wall: equilibrium, symmetry by hand, and CalculiX."""

import csv
import dataclasses
import shutil

import numpy as np
import pytest
from exported_meshes import HEX_FACETS, groups_of, load_case

from fd2fem.meshing import write_mesh
from fd2fem.model import VolumeMesh
from solvers import (
    AnalysisOptions,
    BaseKind,
    BaseOptions,
    FunctionSettlement,
    LinearSettlement,
    MasonryLaw,
    Material,
    SteppingOptions,
    analyse,
    write_response,
)
from solvers.calculix.files import run_calculix
from solvers.fem.elements import ElementType, displacement_space
from solvers.fem.feet import foot_forces, foot_records, wall_feet
from solvers.steps.masonry_analysis import analyse_steps

AT_REST = LinearSettlement(0.0, 0.0, 0.0, 0.0)
MOVED = LinearSettlement(-0.006, -0.002, -0.001, 0.002)
EXACT = SteppingOptions(steps=2, tolerance=1e-8)
WEIGHT = Material().density * 9.81
"""N/m³"""


def _portal(mesh_of, low=1.0, high=3.5):
    """A wall of 5 x 0.4 x 3 m over a door from `low` to `high`, 2 m high."""

    def keep(centre):
        return (centre[:, 0] < low) | (centre[:, 0] > high) | (centre[:, 2] > 2.0)

    return mesh_of(np.linspace(0, 5, 11), [0, 0.4], np.linspace(0, 3, 7), keep=keep)


def _corner(grid):
    """An upright 1 m wide, and a beam above it that reaches 1 m further to the right."""
    return grid([0, 0.5, 1, 1.5, 2], [0, 0.4], [0, 0.5, 1], keep=lambda c: (c[:, 0] < 1) | (c[:, 2] > 0.5))


@pytest.mark.parametrize("element", [ElementType.HEXAHEDRON20, ElementType.HEXAHEDRON8])
def test_piers_beside_a_door_are_feet_of_their_own(make_mesh, element):
    mesh = _portal(make_mesh)
    feet = wall_feet(mesh, displacement_space(mesh, element))
    assert feet.low.tolist() == [[0, 0, 0], [3.5, 0, 0]]
    assert feet.high.tolist() == [[1, 0.4, 0], [5, 0.4, 0]]
    x = feet.points[:, 0]
    assert np.array_equal(feet.number, (x > 2.0).astype(int))


def test_feet_that_touch_in_a_line_are_two_and_come_from_left_to_right(grid):
    mesh = grid([0, 1, 2], [0, 1, 2], [0, 1], keep=lambda c: (c[:, 0] > 1) != (c[:, 1] > 1))
    mesh = dataclasses.replace(mesh, groups={"base": mesh.groups["base"][::-1]})
    feet = wall_feet(mesh, displacement_space(mesh))
    assert feet.middle.tolist() == [[0.5, 1.5, 0], [1.5, 0.5, 0]]


@pytest.mark.parametrize("settlement", [AT_REST, MOVED])
def test_forces_and_moments_of_the_feet_balance_the_weight(make_mesh, settlement):
    mesh = _portal(make_mesh)
    response = analyse(mesh, options=AnalysisOptions(settlement=settlement))
    assert len(response.feet) == 2
    forces = np.array([foot["reaction_n"] for foot in response.feet])
    moments = np.array([foot["moment_nm"] for foot in response.feet])
    middles = np.array([foot["middle_m"] for foot in response.feet])
    assert np.allclose(forces.sum(axis=0), response.reaction, atol=1e-9 * response.weight)
    # By hand: the wall's centre of gravity; about the origin nothing turns.
    area, arm = 5 * 3 - 2.5 * 2, 5 * 3 * 2.5 - 2.5 * 2 * 2.25
    turn = (moments + np.cross(middles, forces)).sum(axis=0)
    turn += np.cross([arm / area, 0.2, 1.0], [0.0, 0.0, -area * 0.4 * WEIGHT])
    assert np.abs(turn).max() < 1e-6 * response.weight
    assert sum(foot["share_of_weight"] for foot in response.feet) == pytest.approx(1.0, abs=1e-8)
    assert [foot["x_m"] for foot in response.feet] == [[0.0, 1.0], [3.5, 5.0]]


def test_an_overhang_presses_on_the_right_of_its_foot(make_mesh):
    # By hand: 0.4 m² x γ of beam, whose middle is 1 m right of the foot's.
    mesh = make_mesh(
        [0, 0.5, 1, 1.5, 2], [0, 0.4], [0, 0.5, 1], keep=lambda c: (c[:, 0] < 1) | (c[:, 2] > 0.5)
    )
    (foot,) = analyse(mesh, options=AnalysisOptions(settlement=MOVED)).feet
    assert foot["moment_nm"] == pytest.approx([0.0, -0.5 * 0.4 * WEIGHT, 0.0], abs=1e-6 * WEIGHT)
    assert foot["reaction_n"] == pytest.approx([0.0, 0.0, 1.5 * 0.4 * WEIGHT], abs=1e-6 * WEIGHT)
    assert foot["share_of_weight"] == pytest.approx(1.0)


@pytest.mark.parametrize("kind", list(BaseKind))
def test_in_steps_the_feet_are_those_of_the_whole_base(grid, kind):
    mesh = _corner(grid)
    options = AnalysisOptions(settlement=MOVED, base=BaseOptions(kind), stepping=EXACT)
    response = analyse_steps(mesh, options=options)
    (foot,) = response.feet
    assert foot["reaction_n"] == pytest.approx(response.reaction.tolist(), abs=1e-9 * response.weight)
    # By hand, as above; what the tolerance of the steps leaves.
    assert foot["moment_nm"] == pytest.approx([0.0, -0.5 * 0.4 * WEIGHT, 0.0], abs=1e-5 * response.weight)
    for step in response.history:
        assert step["feet"] == [pytest.approx(step["reaction"], abs=1e-9 * response.weight)]


def test_under_its_own_weight_a_portal_stands_on_both_feet_alike_and_thrusts_outwards(grid):
    mesh = _portal(grid, 1.0, 4.0)
    response = analyse(
        mesh, options=AnalysisOptions(settlement=AT_REST, masonry=MasonryLaw(), stepping=EXACT)
    )
    left, right = response.feet
    half = (5 * 3 - 3 * 2) * 0.4 * WEIGHT / 2
    assert left["reaction_n"][2] == pytest.approx(half, rel=1e-6)
    assert right["reaction_n"][2] == pytest.approx(half, rel=1e-6)
    assert left["reaction_n"][0] > 0.01 * half
    assert right["reaction_n"][0] == pytest.approx(-left["reaction_n"][0], rel=1e-5)
    assert right["moment_nm"][1] == pytest.approx(-left["moment_nm"][1], rel=1e-5)
    assert [foot["share_of_weight"] for foot in response.feet] == pytest.approx([0.5, 0.5], rel=1e-6)


def test_every_step_of_a_cracking_wall_is_in_the_history(grid, tmp_path):
    mesh = _portal(grid)
    sinks = FunctionSettlement(lambda x: np.column_stack([0 * x, 0 * x, -0.001 * np.clip(x - 1.0, 0.0, 1.0)]))
    tough = MasonryLaw(tensile_strength=1e5, fracture_energy=1e3)
    options = AnalysisOptions(settlement=sinks, masonry=tough, stepping=SteppingOptions(steps=3))
    response = analyse(mesh, options=options)
    assert response.dissipated_energy > 0.0
    forces = np.array([step["feet"] for step in response.history])
    assert forces.shape == (len(response.history), 2, 3)
    total = np.array([step["reaction"] for step in response.history])
    assert np.allclose(forces.sum(axis=1), total, atol=1e-9 * response.weight)
    # The foot that sinks is relieved; what it no longer carries the other one does.
    assert (np.diff(forces[:2, 1, 2]) < 0.0).all()
    assert np.allclose(forces[-1], [foot["reaction_n"] for foot in response.feet])
    write_response(response, tmp_path)
    *_, row = csv.DictReader((tmp_path / "load_settlement.csv").read_text().splitlines())
    for name, force in (("foot1", forces[-1, 0]), ("foot2", forces[-1, 1]), ("reaction", total[-1])):
        assert [float(row[f"{name}_{axis}_n"]) for axis in "xyz"] == force.tolist()
    assert [step["settlement"] for step in response.history] == pytest.approx(
        [0.001 * step["share"] for step in response.history]
    )


def test_a_wall_without_weight_has_no_shares_of_it(grid):
    mesh = _portal(grid)
    response = analyse(mesh, options=AnalysisOptions(settlement=MOVED, gravity=0.0))
    left, right = response.feet
    assert (left["share_of_weight"], right["share_of_weight"]) == (None, None)
    assert left["reaction_n"] == pytest.approx((-np.array(right["reaction_n"])).tolist(), rel=1e-6, abs=1e-3)


def test_forces_are_summed_by_foot(grid):
    mesh = _portal(grid)
    feet = wall_feet(mesh, displacement_space(mesh, ElementType.HEXAHEDRON8))
    forces = np.where(feet.points[:, :1] < 2.0, 1.0, 10.0) * [1.0, 2.0, 3.0]
    # 3 x 2 nodes on the left, 4 x 2 on the right.
    assert foot_forces(feet, forces).tolist() == [[6.0, 12.0, 18.0], [80.0, 160.0, 240.0]]
    assert foot_records(feet, forces, weight=100.0)[0]["share_of_weight"] == pytest.approx(0.18)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX (Debian and Ubuntu: calculix-ccx)")
def test_calculix_puts_the_same_forces_on_the_feet(grid, tmp_path):
    # Without weight CalculiX's forces on the nodes are their whole reactions; seven digits.
    mesh = _portal(grid)
    groups = groups_of(mesh.nodes, mesh.elements, HEX_FACETS)
    mesh = VolumeMesh(mesh.nodes, mesh.elements, mesh.kind, groups)
    options = AnalysisOptions(settlement=MOVED, gravity=0.0, element=ElementType.HEXAHEDRON8)
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options))
    theirs = run_calculix(tmp_path / "wall.inp")
    response = analyse(mesh, options=options)
    x = mesh.nodes[theirs.base, 0]
    for foot, inside in zip(response.feet, (x < 2.0, x > 2.0), strict=True):
        arm = mesh.nodes[theirs.base][inside] - foot["middle_m"]
        force, turn = theirs.force[inside], np.cross(arm, theirs.force[inside])
        scale = np.abs(force).sum()
        assert foot["reaction_n"] == pytest.approx(force.sum(axis=0).tolist(), abs=1e-6 * scale)
        assert foot["moment_nm"] == pytest.approx(turn.sum(axis=0).tolist(), abs=1e-6 * scale)
