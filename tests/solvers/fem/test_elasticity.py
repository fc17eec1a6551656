"""The whole analysis against closed forms, CalculiX and the paper's building."""

import json
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from elastic_states import hold
from exported_meshes import hexahedra20

from fd2fem.errors import ConvergenceError, InputError
from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem import elasticity
from solvers.fem.assembly import body_force
from solvers.fem.elasticity import AnalysisOptions, analyse
from solvers.fem.elements import STIFFNESS_ORDER, ElementType, displacement_space
from solvers.fem.equilibrium import solve
from solvers.fem.linear_solvers import SolverName
from solvers.fem.rules import stiffness_order
from solvers.fem.stress import point_stress
from solvers.ground.settlement import LinearSettlement, PeckTrough, base_displacement
from solvers.materials import Material, elasticity_matrix

ORACLES = Path(__file__).parents[2] / "oracles"
CALCULIX = json.loads((ORACLES / "calculix_wall.json").read_text(encoding="utf-8"))
BUILDING = tomllib.loads((ORACLES / "structural.toml").read_text(encoding="utf-8"))["building_1"]
AT_REST = LinearSettlement(0.0, 0.0, 0.0, 0.0)
ELEMENTS = {"C3D8": ElementType.HEXAHEDRON8, "C3D8I": ElementType.INCOMPATIBLE}
"""CalculiX's names of the elements that are not the default. Its C3D8I is another one than ours, but the same
on parallelepipeds, of which its case consists."""


def _calculix(case):
    """Mesh and options of a recorded run."""
    mesh = VolumeMesh(
        nodes=np.array(case["nodes"]),
        elements=np.array(case["elements"]),
        kind=ElementKind(case["kind"]),
        groups={"base": np.array(case["base"])},
    )
    options = AnalysisOptions(
        material=Material(**CALCULIX["material"]),
        settlement=LinearSettlement(**CALCULIX["settlement"]),
        element=ELEMENTS.get(case["element"], ElementType.HEXAHEDRON20),
    )
    return mesh, options


def test_column_under_its_own_weight(make_mesh):
    # Without lateral strain the column shortens by ρgH²/2E; at height z it carries what is above.
    height, material = 12.0, Material(poisson=0.0)
    mesh = make_mesh([0, 1], [0, 0.4], np.linspace(0, height, 5))
    response = analyse(mesh, options=AnalysisOptions(material=material, settlement=AT_REST))
    gamma = material.density * 9.81
    top = mesh.nodes[:, 2] == height
    assert np.allclose(response.displacement[top, 2], -gamma * height**2 / (2 * material.young), rtol=1e-9)
    assert response.max_displacement == pytest.approx(gamma * height**2 / (2 * material.young))
    assert np.allclose(response.stress[:, 2], -gamma * (height - mesh.nodes[:, 2]), atol=1e-6 * gamma)
    assert np.allclose(response.principal_stress[:, 2], response.stress[:, 2], atol=1e-6 * gamma)
    assert response.weight == pytest.approx(gamma * height * 0.4)
    assert response.reaction == pytest.approx([0.0, 0.0, gamma * height * 0.4], abs=1e-6)
    # U = ∫ σ²/2E dV = A γ² H³ / 6E.
    assert response.strain_energy == pytest.approx(0.4 * gamma**2 * height**3 / (6 * material.young))


def test_rigid_rotation_leaves_no_stress(make_mesh):
    # The base turns as a whole, so the wall follows: u_x = c - θz, u_z = a + θx.
    mesh = make_mesh(np.linspace(0, 2, 3), [0, 0.4], np.linspace(0, 4, 5))
    load = LinearSettlement(
        vertical_left=-0.04, vertical_right=-0.02, horizontal_left=-0.03, horizontal_right=-0.03
    )
    response = analyse(mesh, options=AnalysisOptions(settlement=load, gravity=0.0))
    x, _, z = mesh.nodes.T
    assert np.allclose(response.displacement[:, 0], -0.03 - 0.01 * z, atol=1e-12)
    assert np.allclose(response.displacement[:, 2], -0.04 + 0.01 * x, atol=1e-12)
    assert np.abs(response.stress).max() < 1e-12 * 3.48e9
    assert response.weight == 0.0
    assert np.abs(response.reaction).max() < 1e-3
    assert response.max_displacement == pytest.approx(np.hypot(0.07, 0.04))


def test_settlement_and_weight_add_up(punched_wall):
    load = LinearSettlement(-0.01, -0.004, -0.003, 0.002)
    both = analyse(punched_wall, options=AnalysisOptions(settlement=load))
    settled = analyse(punched_wall, options=AnalysisOptions(settlement=load, gravity=0.0))
    weighed = analyse(punched_wall, options=AnalysisOptions(settlement=AT_REST))
    assert np.allclose(both.displacement, settled.displacement + weighed.displacement, atol=1e-14)
    assert np.allclose(both.stress, settled.stress + weighed.stress, atol=1e-3)


def test_clapeyron(punched_wall):
    """The strain energy is half the work of all forces, reactions included, on the displacements."""
    space = displacement_space(punched_wall)
    options = AnalysisOptions(settlement=PeckTrough(0.01, 2.0, 4.0, centre=1.0))
    moved = base_displacement(options.settlement, space.points[space.base, 0], extent=(0.0, 3.0))
    D = elasticity_matrix(options.material)
    force = body_force(space, [0, 0, -options.material.density * 9.81])
    state = hold(space, options.material, force, points=space.base, values=moved)
    work = 0.5 * (force @ state.displacement.ravel() + (state.reaction[space.base] * moved).sum())
    points = point_stress(
        space, options.material, displacement=state.displacement, order=STIFFNESS_ORDER[space.kind]
    )
    strain = points.stress @ np.linalg.inv(D)
    assert analyse(punched_wall, options=options).strain_energy == pytest.approx(work)
    assert 0.5 * ((strain * points.stress).sum(axis=2) * points.volume).sum() == pytest.approx(work)


@pytest.mark.parametrize("case", CALCULIX["cases"], ids=lambda case: case["element"])
def test_calculix(case):
    mesh, options = _calculix(case)
    response = analyse(mesh, options=options)
    theirs = np.array(case["displacement"])
    assert np.abs(response.displacement - theirs).max() < 1e-6 * np.abs(theirs).max()
    assert response.strain_energy == pytest.approx(case["strain_energy"], rel=1e-6)


@pytest.mark.parametrize("case", CALCULIX["cases"], ids=lambda case: case["element"])
def test_calculix_stress_and_internal_force(case):
    mesh, options = _calculix(case)
    material, x = options.material, mesh.nodes[:, 0]
    space = displacement_space(mesh, options.element)
    moved = base_displacement(options.settlement, space.points[space.base, 0], extent=(x.min(), x.max()))
    force = body_force(space, [0, 0, -material.density * 9.81])
    state = hold(space, material, force, points=space.base, values=moved)
    points = point_stress(space, material, displacement=state.displacement, order=stiffness_order(space))
    distance = np.linalg.norm(points.location.reshape(-1, 1, 3) - np.array(case["stress_at"]), axis=2)
    assert distance.min(axis=0).max() < 1e-5
    ours, theirs = points.stress.reshape(-1, 6)[distance.argmin(axis=0)], np.array(case["stress"])
    assert np.abs(ours - theirs).max() < 1e-6 * np.abs(theirs).max()
    # CalculiX sums the internal forces at the base: the reaction with the weight that falls on it.
    internal = state.reaction.sum(axis=0) + force.reshape(-1, 3)[space.base].sum(axis=0)
    assert np.abs(internal - case["internal_force"]).max() < 1e-6 * np.abs(case["internal_force"]).max()


@pytest.mark.parametrize(
    "settlement", [LinearSettlement(-0.012, -0.003, -0.004, 0.002), PeckTrough(0.01, 2, 4)]
)
def test_20_node_elements_answer_as_the_8_node_mesh(grid, settlement):
    mesh = grid([0, 0.7, 1.5, 3], [0, 0.4], [0, 1, 1.7], keep=lambda c: c[:, 2] < 2 - c[:, 0] / 3, warp=0.05)
    options = AnalysisOptions(settlement=settlement)
    eight, twenty = analyse(mesh, options=options), analyse(hexahedra20(mesh), options=options)
    n = len(mesh.nodes)
    scale = np.abs(eight.displacement).max()
    assert np.abs(eight.displacement - twenty.displacement[:n]).max() < 1e-10 * scale
    assert np.abs(eight.stress - twenty.stress[:n]).max() < 1e-9 * np.abs(eight.stress).max()
    # The largest σ1 is at a corner: σ1 is convex and a middle takes the mean of its ends.
    for name in ("max_principal_stress", "p95_principal_stress", "p99_principal_stress", "rms_stress"):
        assert getattr(eight, name) == pytest.approx(getattr(twenty, name), rel=1e-9)
    for name in ("weight", "strain_energy", "dofs"):
        assert getattr(eight, name) == pytest.approx(getattr(twenty, name), rel=1e-10)
    assert eight.solver["element"] == twenty.solver["element"]
    assert twenty.max_displacement == np.linalg.norm(twenty.displacement, axis=1).max()
    assert twenty.max_displacement >= eight.max_displacement * (1 - 1e-10)


@pytest.mark.parametrize("case", [c for c in CALCULIX["cases"] if c["element"] == "C3D20"])
def test_calculix_at_every_node_of_c3d20(case):
    mesh, options = _calculix(case)
    response = analyse(hexahedra20(mesh), options=options)
    theirs = np.array(case["displacement"])
    assert np.abs(response.displacement[: len(theirs)] - theirs).max() < 1e-6 * np.abs(theirs).max()
    assert response.strain_energy == pytest.approx(case["strain_energy"], rel=1e-6)


def _building_1(grid, size):
    """Building 1's outline; its four openings have the published total area, their places are assumed."""
    openings = [(0.425, 0.0, 4.10, 2.956), (0.875, 4.2, 3.20, 2.30), (0.975, 7.3, 3.00, 2.10)]
    openings.append((1.045, 10.0, 2.86, 1.72))

    def planes(end, cuts):
        stops = sorted({0.0, end, *np.round(cuts, 9)})
        pieces = [
            np.linspace(a, b, max(1, round((b - a) / size)), endpoint=False) for a, b in pairwise(stops)
        ]
        return np.append(np.concatenate(pieces), end)

    def keep(centre):
        x, z = centre[:, 0], centre[:, 2]
        inside = [(x > l) & (x < l + w) & (z > b) & (z < b + h) for l, b, w, h in openings]  # noqa: E741
        return ~np.any(inside, axis=0)

    assert sum(w * h for _, _, w, h in openings) == pytest.approx(BUILDING["opening_area"], rel=1e-3)
    xs = planes(BUILDING["length"], [v for l, _, w, _ in openings for v in (l, l + w)])  # noqa: E741
    zs = planes(BUILDING["height"], [v for _, b, _, h in openings for v in (b, b + h)])
    return grid(xs, [0.0, 0.175, 0.35], zs, keep=keep)


def test_building_1_of_the_paper(grid):
    response = analyse(_building_1(grid, 0.25))
    assert 0.098 < response.max_displacement < 0.102
    assert response.max_displacement == pytest.approx(BUILDING["max_displacement"], rel=0.01)
    volume = 0.35 * (BUILDING["length"] * BUILDING["height"] - BUILDING["opening_area"])
    assert response.weight == pytest.approx(1900 * 9.81 * volume, rel=1e-3)
    assert response.reaction == pytest.approx([0, 0, response.weight], abs=1e-8 * response.weight)
    assert 0 < response.p95_principal_stress < response.p99_principal_stress
    assert response.p99_principal_stress < response.max_principal_stress
    assert set(response.timings) == {"assemble", "solve", "stress"}
    assert response.solver["relative_residual"] < 1e-8
    assert response.solver["imbalance"] < 1e-8


def test_settlement_the_other_way_round_turns_the_wall_less(grid):
    load = LinearSettlement(vertical_left=-0.0178, vertical_right=-0.0445)
    response = analyse(_building_1(grid, 0.5), options=AnalysisOptions(settlement=load))
    # 62 mm with the settlement largest at the end the wall moves away from.
    assert response.max_displacement == pytest.approx(0.062, rel=0.02)


def test_a_mesh_that_starts_elsewhere_answers_alike(punched_wall):
    moved = VolumeMesh(
        nodes=punched_wall.nodes + np.array([10.0, 5.0, 2.0]),
        elements=punched_wall.elements,
        kind=punched_wall.kind,
        groups=punched_wall.groups,
    )
    here, there = analyse(punched_wall), analyse(moved)
    assert np.allclose(here.displacement, there.displacement, atol=1e-12)
    assert here.p99_principal_stress == pytest.approx(there.p99_principal_stress)


def test_an_unbalanced_solution_is_refused(punched_wall, monkeypatch):
    def tampered(*args, **options):
        state = solve(*args, **options)
        state.reaction[0, 0] += 1.0
        return state

    monkeypatch.setattr(elasticity, "solve", tampered)
    with pytest.raises(ConvergenceError, match="reaction at the base differs from the weight"):
        analyse(punched_wall)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gravity": -9.81}, "Invalid 'gravity': expected 0 or a positive number, got -9.81"),
        ({"gravity": float("nan")}, "Invalid 'gravity'"),
        ({"gravity": float("inf")}, "Invalid 'gravity'"),
        ({"element": ElementType.TETRA10}, "Invalid 'element': hexahedra cannot be analysed as tetrahedra"),
    ],
)
def test_options_refuse(options, message):
    with pytest.raises(InputError, match=message):
        AnalysisOptions(**options)


@pytest.mark.parametrize("solver", [SolverName.PARDISO, SolverName.SUPERLU, SolverName.AMG])
def test_solvers_answer_alike_and_are_named(grid, solver):
    pytest.importorskip({"pardiso": "pypardiso", "amg": "pyamg"}.get(solver, "scipy"))
    mesh = _building_1(grid, 0.5)
    options = AnalysisOptions(solver=solver)
    found, reference = analyse(mesh, options=options), analyse(mesh)
    scale = reference.max_displacement
    assert np.abs(found.displacement - reference.displacement).max() < 1e-8 * scale
    assert found.p99_principal_stress == pytest.approx(reference.p99_principal_stress, rel=1e-7)
    names = {"pardiso": "MKL PARDISO", "superlu": "scipy SuperLU", "amg": "pyamg smoothed aggregation + CG"}
    assert found.solver["name"] == names[solver]
    assert found.solver["relative_residual"] < 1e-8
    assert found.solver["unknowns"] == found.dofs - 3 * len(displacement_space(mesh).base)


def test_elements_are_chosen_and_named(grid):
    mesh = _building_1(grid, 0.5)
    twenty = analyse(mesh)
    found = analyse(mesh, options=AnalysisOptions(element=ElementType.INCOMPATIBLE))
    assert found.solver["element"] == "8-node hexahedron with incompatible modes"
    assert found.dofs == 3 * len(mesh.nodes)
    # Both converge to the same wall.
    assert found.max_displacement == pytest.approx(twenty.max_displacement, rel=1e-3)
    # Whatever is asked for, quadratic meshes are analysed as they are.
    quadratic = analyse(hexahedra20(mesh), options=AnalysisOptions(element=ElementType.INCOMPATIBLE))
    assert quadratic.solver["element"] == twenty.solver["element"] == "20-node serendipity hexahedron"


@pytest.mark.parametrize("poisson", [0.49, 0.4999])
def test_nearly_incompressible_is_still_solved(grid, poisson):
    # A column that may bulge shortens by ρgH²/2E whatever ν is; its base, held, is stiffer.
    height = 12.0
    material = Material(young=3.48e9, poisson=poisson)
    mesh = grid(np.linspace(0, 0.5, 3), [0, 0.25, 0.5], np.linspace(0, height, 13))
    response = analyse(mesh, options=AnalysisOptions(material=material, settlement=AT_REST))
    top = response.displacement[mesh.nodes[:, 2] == height, 2].mean()
    assert top == pytest.approx(-1900 * 9.81 * height**2 / (2 * 3.48e9), rel=0.06)


@pytest.mark.parametrize("solver", [SolverName.PARDISO, SolverName.SUPERLU, SolverName.AMG])
def test_flat_elements_give_an_answer_that_balances_or_none(grid, solver):
    """A layer of a millionth of the wall's thickness: what comes out has passed all checks."""
    pytest.importorskip({"pardiso": "pypardiso", "amg": "pyamg"}.get(solver, "scipy"))
    mesh = grid([0, 1, 2, 3], [0, 4e-7, 0.4], [0, 1, 2, 3])
    try:
        response = analyse(mesh, options=AnalysisOptions(solver=solver))
    except ConvergenceError as error:
        message = str(error)
        assert "residual" in message or "singular" in message or "reaction" in message
        return
    reference = analyse(grid([0, 1, 2, 3], [0, 0.4], [0, 1, 2, 3]))
    assert response.max_displacement == pytest.approx(reference.max_displacement, rel=1e-2)


def test_a_settlement_in_the_wrong_unit_is_refused(grid):
    short = grid([0, 0.2], [0, 0.1], [0, 0.3])
    with pytest.raises(InputError, match=r"wall of 0\.2 m would move 0.0445 m"):
        analyse(short)
