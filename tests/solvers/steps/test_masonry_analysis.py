"""Walls that crack, or stand on springs, against closed forms, the linear analysis and each other."""

import dataclasses

import numpy as np
import pytest

from fd2fem.errors import ConvergenceError, InputError
from fd2fem.model import VolumeMesh
from solvers import (
    AnalysisOptions,
    BaseKind,
    BaseOptions,
    FunctionSettlement,
    LinearSettlement,
    MasonryLaw,
    Material,
    PeckTrough,
    SettlementTable,
    StepMode,
    SteppingOptions,
    analyse,
    swap_horizontal,
)
from solvers.fem.elements import ElementType
from solvers.fem.stress import principal_stress
from solvers.steps.masonry_analysis import prepare, snapshots

AT_REST = LinearSettlement(0.0, 0.0, 0.0, 0.0)
BENDING = LinearSettlement(-0.01, -0.004, -0.003, 0.002)
STRONG = MasonryLaw(tensile_strength=1e12, cohesion=1e13)
FEW = SteppingOptions(steps=4)


def _quarter_wall(grid):
    """A wall of 2 x 0.4 x 2 m with an opening, elements of 0.25 m: narrower than E Gf / ft²."""

    def keep(centre):
        return (np.abs(centre[:, 0] - 1.0) > 0.25) | (np.abs(centre[:, 2] - 1.0) > 0.25)

    return grid(np.linspace(0, 2, 9), [0.0, 0.2, 0.4], np.linspace(0, 2, 9), keep=keep)


@pytest.fixture(scope="module")
def wall(grid):
    return _quarter_wall(grid)


STRETCH = LinearSettlement(0.0, 0.0, -0.0005, 0.0015)
HOGGING = FunctionSettlement(lambda x: np.column_stack([0 * x, 0 * x, -1e-3 * np.maximum(0.0, x - 0.8)]))
CRACKING = AnalysisOptions(
    masonry=MasonryLaw(), settlement=HOGGING, stepping=SteppingOptions(steps=10, tolerance=1e-6)
)


@pytest.fixture(scope="module")
def cracked(wall):
    return analyse(wall, options=CRACKING)


def test_a_wall_too_strong_to_crack_answers_like_the_linear_analysis(make_mesh):
    mesh = make_mesh(np.linspace(0, 2, 4), [0, 0.4], np.linspace(0, 2, 4), warp=0.03)
    linear = AnalysisOptions(settlement=BENDING, element=ElementType.INCOMPATIBLE)
    expected = analyse(mesh, options=linear)
    ours = analyse(mesh, options=dataclasses.replace(linear, masonry=STRONG, stepping=FEW))
    scale = np.abs(expected.displacement).max()
    assert np.allclose(ours.displacement, expected.displacement, rtol=0, atol=1e-9 * scale)
    assert ours.strain_energy == pytest.approx(expected.strain_energy, rel=1e-9)
    assert np.allclose(ours.reaction, expected.reaction, atol=1e-6 * expected.weight)
    assert ours.weight == pytest.approx(expected.weight, rel=1e-12)
    assert (ours.dissipated_energy, ours.max_crack_opening) == (0.0, 0.0)
    assert [step["iterations"] for step in ours.history] == [1] * 5


@pytest.mark.parametrize("change", ["hexahedron", "tetra10"])
def test_stress_of_an_intact_wall_is_that_of_the_linear_analysis(change, grid, tetrahedra):
    mesh = grid(np.linspace(0, 2, 4), [0, 0.4], np.linspace(0, 2, 4), warp=0.03)
    mesh = tetrahedra(mesh) if change == "tetra10" else mesh
    linear = AnalysisOptions(settlement=BENDING, element=ElementType.INCOMPATIBLE)
    expected = analyse(mesh, options=linear)
    ours = analyse(mesh, options=dataclasses.replace(linear, masonry=STRONG, stepping=FEW))
    scale = np.abs(expected.stress).max()
    if change == "hexahedron":
        assert np.allclose(ours.stress, expected.stress, rtol=0, atol=1e-8 * scale)
    assert ours.rms_stress == pytest.approx(expected.rms_stress, rel=1e-8)
    assert ours.p99_principal_stress == pytest.approx(expected.p99_principal_stress, rel=1e-8)


def test_the_reaction_carries_the_weight_after_every_step(cracked):
    reactions = np.array([step["reaction"] for step in cracked.history])
    assert len(reactions) >= 11
    assert np.allclose(reactions, [0.0, 0.0, cracked.weight], rtol=0, atol=1e-5 * cracked.weight)
    assert cracked.history[-1]["share"] == pytest.approx(1.0, abs=1e-12)
    assert np.allclose(cracked.reaction, reactions[-1])


def test_what_the_loads_do_is_stored_or_taken_by_cracks(cracked):
    # By the first law: no more than the loads' work, less what cracks that run at once set free. On the way
    # the extrapolated strengths may store some per cent too much.
    assert cracked.dissipated_energy > 5.0
    for step in cracked.history:
        inside = step["strain_energy"] + step["dissipated_energy"]
        assert inside <= 1.05 * step["external_work"]
        if step["dissipated_energy"] == 0.0:
            assert inside == pytest.approx(step["external_work"], rel=1e-9)
    assert inside < step["external_work"]
    assert cracked.dissipation.sum() == pytest.approx(cracked.dissipated_energy, rel=1e-9)
    assert step["plastic_energy"] == 0.0


def test_cracks_take_at_most_the_fracture_energy_of_their_area(cracked):
    # An element of 0.25 x 0.2 x 0.25 m has V / h of it, with h = V^(1/3); the floor takes a little more.
    area = 0.0125 ** (2 / 3) * np.count_nonzero(cracked.crack_opening)
    assert 0.0 < cracked.dissipated_energy < 1.05 * 100.0 * area


def test_no_stress_is_beyond_the_strength(cracked):
    strength = MasonryLaw().tensile_strength
    assert 0.3 * strength < cracked.max_principal_stress <= strength * (1 + 1e-9)
    assert principal_stress(cracked.stress)[:, 0].max() <= cracked.max_principal_stress * (1 + 1e-9)
    assert max(step["max_principal_stress"] for step in cracked.history) <= strength * (1 + 1e-9)


def test_the_wall_is_torn_off_the_ground_at_the_end_that_stays(cracked, wall):
    """The stiff wall follows the end that sinks; at the other it turns away from the ground."""
    centres = wall.nodes[wall.elements].mean(axis=1)
    widest = int(cracked.crack_opening.argmax())
    assert centres[widest, [0, 2]].tolist() == [0.125, 0.125]
    assert cracked.crack_normal[widest, 2] > 0.99
    assert cracked.max_crack_opening == cracked.crack_opening.max()
    # The ground sinks by 1.2 mm at the other end: no crack is wider.
    assert 0.5e-3 < cracked.max_crack_opening < 1.2e-3
    assert not cracked.crack_normal[cracked.crack_opening == 0.0].any()


def test_damage_is_classed_by_cracks_and_by_strain_beside_the_beam(cracked):
    damage = cracked.damage
    assert cracked.damage_class == damage["crack_class"]
    assert damage["crack_width"] == pytest.approx(cracked.max_crack_opening)
    # By hand: the ground bends once, from level to 1 in 1000.
    assert damage["equivalent_beam"]["max_slope"] == pytest.approx(1e-3, rel=1e-6)
    assert damage["equivalent_beam"]["max_settlement"] == pytest.approx(1.2e-3, rel=1e-6)
    assert 0.0 < damage["tensile_strain"] < 1e-3


@pytest.mark.slow
def test_more_steps_give_the_same_wall(cracked, wall):
    coarse, fine = (
        analyse(wall, options=dataclasses.replace(CRACKING, stepping=SteppingOptions(steps=steps)))
        for steps in (20, 40)
    )
    assert coarse.max_displacement == pytest.approx(fine.max_displacement, rel=0.01)
    assert coarse.max_crack_opening == pytest.approx(fine.max_crack_opening, rel=0.03)
    assert coarse.dissipated_energy == pytest.approx(fine.dissipated_energy, rel=0.03)
    # Ten steps extrapolate too coarsely, and say so.
    assert "set free as motion" in cracked.solver["warnings"][-1]
    assert fine.solver["warnings"] == []


@pytest.mark.slow
def test_past_a_snap_back_the_implicit_mode_gives_up_in_one_line(wall):
    stepping = SteppingOptions(steps=10, mode=StepMode.IMPLICIT, smallest=0.1)
    with pytest.raises(ConvergenceError, match=r"past \d+\.\d\d % of the settlement"):
        analyse(wall, options=dataclasses.replace(CRACKING, stepping=stepping))


@pytest.mark.parametrize("kind", [BaseKind.ELASTIC, BaseKind.NO_TENSION])
def test_a_column_sinks_into_its_springs(make_mesh, kind):
    # By hand: the base sinks by γH/k; above it the column shortens by γ(H z - z²/2)/E.
    height, material = 3.0, Material(poisson=0.0)
    mesh = make_mesh([0, 1], [0, 0.4], np.linspace(0, height, 4))
    base = BaseOptions(kind, normal_stiffness=1e8, shear_stiffness=1e8)
    options = AnalysisOptions(material=material, settlement=AT_REST, base=base, stepping=FEW)
    response = analyse(mesh, options=options)
    gamma, z = material.density * 9.81, mesh.nodes[:, 2]
    expected = -gamma * height / 1e8 - gamma * (height * z - z**2 / 2) / material.young
    # Springs at the nodes are not quite the pressure that would leave the base of quadratic elements plane.
    tolerance = 1e-9 if mesh.kind.nodes == 8 else 0.03
    assert np.allclose(response.displacement[:, 2], expected, rtol=tolerance)
    assert response.reaction[2] == pytest.approx(gamma * height * 0.4, rel=1e-6)


def test_a_wall_bridges_a_trough_that_it_is_not_glued_to(grid):
    """The ground sinks under the middle; the wall is stiff, and lifts off there."""
    mesh = grid(np.linspace(0, 4, 9), [0, 0.4], np.linspace(0, 2, 5))

    def sinks(x):
        return np.column_stack([0 * x, 0 * x, np.where(np.abs(x - 2.0) < 0.9, -0.01, 0.0)])

    base = BaseOptions(BaseKind.NO_TENSION, normal_stiffness=1e9, shear_stiffness=1e8)
    options = AnalysisOptions(settlement=FunctionSettlement(sinks), base=base, stepping=FEW)
    free = analyse(mesh, options=options)
    tied = analyse(mesh, options=dataclasses.replace(options, base=BaseOptions()))
    middle = (mesh.nodes[:, 2] == 0.0) & (np.abs(mesh.nodes[:, 0] - 2.0) < 0.1)
    assert np.allclose(tied.displacement[middle, 2], -0.01)
    assert (free.displacement[middle, 2] > -0.002).all()
    assert free.reaction == pytest.approx([0.0, 0.0, free.weight], abs=1e-4 * free.weight)
    # What is glued to the ground is torn: its stresses are far larger.
    assert free.p99_principal_stress < 0.1 * tied.p99_principal_stress


def test_on_springs_that_pull_the_wall_is_drawn_into_the_trough(grid):
    mesh = grid(np.linspace(0, 4, 9), [0, 0.4], np.linspace(0, 2, 5))
    options = AnalysisOptions(settlement=PeckTrough(0.02, 2.0, 3.0, centre=2.0), stepping=FEW)
    kinds = BaseKind.TIED, BaseKind.ELASTIC, BaseKind.NO_TENSION
    sag = []
    for kind in kinds:
        base = BaseOptions(kind, normal_stiffness=1e8, shear_stiffness=1e7)
        uz = analyse(mesh, options=dataclasses.replace(options, base=base)).displacement[:, 2]
        x, _, z = mesh.nodes.T
        ends = (z == 0.0) & ((x == 0.0) | (x == 4.0))
        sag.append(uz[ends].mean() - uz[(z == 0.0) & (x == 2.0)].mean())
    assert sag[0] > sag[1] > sag[2] > -1e-5


def test_a_base_held_upwards_only_slides(grid):
    # Only the middle follows the ground along the wall: a base that is stretched leaves no stress.
    mesh = grid(np.linspace(0, 2, 5), [0, 0.4], np.linspace(0, 2, 5))
    options = AnalysisOptions(
        settlement=STRETCH, gravity=0.0, base=BaseOptions(BaseKind.VERTICAL), stepping=FEW
    )
    response = analyse(mesh, options=options)
    assert np.abs(response.stress).max() < 1.0
    assert np.allclose(response.displacement, [0.0005, 0.0, 0.0], atol=1e-9)


def test_both_readings_of_the_horizontal_movement_run(wall):
    load = LinearSettlement(-0.004, -0.002, -0.002, -0.001)
    one, other = (
        analyse(wall, options=dataclasses.replace(CRACKING, settlement=each))
        for each in (load, swap_horizontal(load))
    )
    # By hand, as a rigid body that turns by 1e-3: the wall's middle moves by the mean of the base's ends.
    for response in (one, other):
        assert response.displacement[:, 0].mean() == pytest.approx(-0.0015 - 1e-3 * 1.0, rel=0.1)
    assert abs(one.dissipated_energy - other.dissipated_energy) > 0.01 * one.dissipated_energy


@pytest.mark.parametrize(
    ("settlement", "match"),
    [
        (FunctionSettlement(lambda x: np.full((len(x), 3), -10.0)), "would move 10 m"),
        (SettlementTable(x=(0.0, 1.0), uz=(0.0, -0.001)), "1"),
    ],
    ids=["10 m", "table too short"],
)
def test_what_is_no_settlement_of_this_wall_is_refused(wall, settlement, match):
    with pytest.raises(InputError, match=match):
        analyse(wall, options=dataclasses.replace(CRACKING, settlement=settlement))


def test_a_loose_part_and_a_base_on_a_line_are_refused(grid):
    mesh = grid([0, 1, 2, 3], [0, 0.4], [0, 1, 2], keep=lambda c: ~((c[:, 0] > 1) & (c[:, 0] < 2)))
    half = VolumeMesh(mesh.nodes, mesh.elements, mesh.kind, {"base": mesh.groups["base"][:1]})
    with pytest.raises(InputError, match="loose part"):
        analyse(half, options=CRACKING)


def test_a_wall_that_does_not_stand_is_no_answer(grid):
    # Its own weight presses by 57 kPa; 2 c cos φ / (1 - sin φ) = 4 kPa is what it takes.
    weak = MasonryLaw(tensile_strength=100.0, cohesion=1e3)
    mesh = grid([0, 1], [0, 0.4], np.linspace(0, 3, 4))
    with pytest.raises(ConvergenceError, match="under its own weight"):
        analyse(mesh, options=dataclasses.replace(CRACKING, masonry=weak))


def test_a_step_without_equilibrium_says_how_far_it_came(wall):
    # No step can do it in two iterations, nor be cut.
    stepping = SteppingOptions(steps=2, max_iterations=2, smallest=0.9, tolerance=1e-13)
    with pytest.raises(ConvergenceError, match=r"past \d+\.\d\d % of the settlement"):
        analyse(wall, options=dataclasses.replace(CRACKING, stepping=stepping))


def test_wide_elements_are_warned_about(grid):
    wide = analyse(grid([0, 1], [0, 1], [0, 1]), options=dataclasses.replace(CRACKING, settlement=AT_REST))
    assert "wider than" in wide.solver["warnings"][0]


def test_narrow_elements_are_not(cracked):
    assert not [warning for warning in cracked.solver["warnings"] if "wider" in warning]


def test_weak_masonry_follows_sagging_ground(grid):
    # 0.1 MPa is what mortar joints bear. The ends of the ground stay, the middle sinks by 6 mm.
    mesh = grid(np.linspace(0, 6, 11), [0.0, 0.4], np.linspace(0, 3, 6))
    weak = MasonryLaw(tensile_strength=1e5, fracture_energy=50.0)
    sagging = SettlementTable(x=(0.0, 2.5, 3.5, 6.0), uz=(0.0, -0.006, -0.006, 0.0))
    stepping = SteppingOptions(steps=10, tolerance=1e-4)
    options = AnalysisOptions(masonry=weak, settlement=sagging, stepping=stepping)
    response = analyse(mesh, options=options)
    # Ten steps, and a few that were cut because a crack ran.
    assert len(response.history) <= 16
    assert response.history[-1]["share"] == pytest.approx(1.0, abs=1e-12)
    assert response.reaction == pytest.approx([0.0, 0.0, response.weight], abs=1e-3 * response.weight)
    assert response.max_crack_opening > 0.5e-3
    last = response.history[-1]
    assert last["strain_energy"] + last["dissipated_energy"] <= 1.05 * last["external_work"]


def test_steps_come_one_by_one(wall):
    steps = snapshots(prepare(wall, options=CRACKING))
    first, second = next(steps), next(steps)
    assert (first.share, second.share) == (0.0, pytest.approx(0.1))
