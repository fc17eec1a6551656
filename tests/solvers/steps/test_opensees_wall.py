"""Walls that crack, as a whole, against OpenSees with another law, on the same mesh and in the same element.

OpenSees' law is one of damage; ours is one of plasticity. Two more things set them apart, whatever the steps
and the mesh: OpenSees softens point by point, ours an element at a time; and a wide crack that is pressed
along itself carries that pressure in ours alone. What OpenSees itself finds with cracks that stay open and
with cracks that close again differs by up to 2.6 % in how a wall deforms and 15 % in what its feet push,
which is the measure for the tolerances below.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from solvers import AnalysisOptions, LinearSettlement, MasonryLaw, PeckTrough, SteppingOptions, analyse
from solvers.fem.elements import ElementType

ORACLES = tomllib.loads(
    (Path(__file__).parents[2] / "oracles" / "opensees_wall.toml").read_text(encoding="utf-8")
)
LAW = MasonryLaw(fracture_energy=200.0)
SETTLEMENTS = {
    "hogging_wall": PeckTrough(volume_loss=0.005, diameter=6.0, depth=12.0, centre=-6.0),
    "stretched_portal": LinearSettlement(-0.02, -0.008, -0.012, -0.008),
    "pressed_portal": LinearSettlement(-0.02, -0.008, -0.008, -0.012),
}
UNLOADINGS = ("open", "closed")
PORTALS = ("stretched_portal", "pressed_portal")
CRACKED = ("hogging_wall", "stretched_portal")
"""The legs of the other one have just begun to crack: OpenSees' two answers are not like each other there."""


def _has_two_windows(centre):
    """Of the wall of 6 x 6 m: two windows of 1 x 1.5 m, 2.5 m above the base."""
    x, _, z = centre.T
    return ((np.abs(x - 1.5) < 0.5) | (np.abs(x - 4.5) < 0.5)) & (np.abs(z - 3.25) < 0.75)


def _has_a_door(centre):
    """Of the wall of 3 x 4 m: a door of 2 x 2 m."""
    return (np.abs(centre[:, 0] - 1.5) < 1.0) & (centre[:, 2] < 2.0)


@pytest.fixture(scope="module", params=SETTLEMENTS)
def case(request, grid):
    """What OpenSees found, and our response."""
    name = request.param
    if name == "hogging_wall":
        sides = np.linspace(0, 6, 13), [0.0, 0.3], np.linspace(0, 6, 13)
        mesh = grid(*sides, keep=lambda centre: ~_has_two_windows(centre))
    else:
        sides = np.linspace(0, 3, 13), [0.0, 0.25], np.linspace(0, 4, 17)
        mesh = grid(*sides, keep=lambda centre: ~_has_a_door(centre))
    options = AnalysisOptions(
        masonry=LAW,
        settlement=SETTLEMENTS[name],
        element=ElementType.HEXAHEDRON8,
        stepping=SteppingOptions(steps=25),
    )
    return name, ORACLES[name], analyse(mesh, options=options)


def _nearest(points, places):
    """Index of the point at each place; all of them in the plane of the wall, m."""
    distance = np.linalg.norm(points[:, None] - places[None], axis=2)
    assert distance.min(axis=0).max() < 1e-6
    return distance.argmin(axis=0)


def _deformation(places, moved):
    """What is left of displacements when the wall's motion as a rigid body is taken out."""
    x, z = (places - places.mean(axis=0)).T
    still, one = np.zeros_like(x), np.ones_like(x)
    motions = np.stack([[one, still], [still, one], [z, -x]]).transpose(2, 1, 0).reshape(-1, 3)
    rigid = motions @ np.linalg.lstsq(motions, moved.ravel(), rcond=None)[0]
    return moved - rigid.reshape(-1, 2)


def _difference(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


def _displacements(oracle, response):
    """Places (n, 2), m, then ours and OpenSees' two displacements there, (n, 2), mm."""
    rows = np.array(oracle["displacement"])
    places, mesh = rows[:, :2], response.mesh
    front = np.flatnonzero(mesh.nodes[:, 1] == 0.0)
    moved = 1e3 * response.displacement[front[_nearest(mesh.nodes[front][:, ::2], places)]][:, ::2]
    return places, moved, (rows[:, 2:4], rows[:, 4:6])


def _openings(oracle, response):
    """Cracks of ours and, in columns, of OpenSees in all elements, mm."""
    rows, mesh = np.array(oracle["cracks"]), response.mesh
    theirs = np.zeros((len(mesh.elements), 2))
    middles = mesh.nodes[mesh.elements].mean(axis=1)[:, ::2]
    theirs[_nearest(middles, rows[:, :2])] = rows[:, 2:]
    return 1e3 * response.crack_opening, theirs


def test_walls_move_and_deform_as_in_opensees(case):
    name, oracle, response = case
    places, ours, theirs = _displacements(oracle, response)
    # Found: 0.55, 0.10 and 0.04 % of the motion; 9.5, 1.3 and 0.9 % of the deformation. In the hogging wall,
    # the cracked elements along the base still bear pressure and shear, and hold the wall more tightly.
    whole, shape = {"hogging_wall": (8e-3, 0.12)}.get(name, (2e-3, 0.03))
    assert min(_difference(ours, other) for other in theirs) < whole
    deformed = _deformation(places, ours)
    assert min(_difference(deformed, _deformation(places, other)) for other in theirs) < shape
    largest = [oracle[unloading]["max_displacement"] for unloading in UNLOADINGS]
    assert 1e3 * response.max_displacement == pytest.approx(largest[0], rel=2e-3)


def test_walls_carry_no_more_than_in_opensees(case):
    _, oracle, response = case
    # Lubliner's surface is round: OpenSees goes 0.3 % beyond the strength between two directions.
    assert response.max_principal_stress / 1e6 == pytest.approx(oracle["open"]["stress"][1], rel=5e-3)


@pytest.mark.parametrize("case", PORTALS, indirect=True)
def test_feet_push_as_in_opensees(case):
    _, oracle, response = case
    x, _, z = response.feet[0]["reaction_n"]
    forces = np.array([oracle[unloading]["left_foot"] for unloading in UNLOADINGS])
    # Found: 1.1 and 3.2 % from the nearer one. Half of the weight stands on each foot; OpenSees' stresses are
    # out of balance by its extrapolation.
    assert np.abs(x / forces[:, 0] - 1.0).min() < 0.05
    assert z == pytest.approx(forces[0, 2], rel=2e-3)


@pytest.mark.parametrize("case", CRACKED, indirect=True)
def test_walls_crack_where_they_do_in_opensees(case):
    _, oracle, response = case
    ours, theirs = _openings(oracle, response)
    wide = ours > 0.1
    assert wide.sum() >= 4
    assert (wide == (theirs > 0.1).all(axis=1)).all()
    # Found: 5 % for the widest, 3 to 18 % for all.
    assert ours.max() == pytest.approx(theirs[:, 0].max(), rel=0.08)
    assert ours[wide] == pytest.approx(theirs[wide, 0], rel=0.25)
    # Found: 5.4 and 1.5 % off the energy of OpenSees' cracks, by the area under the softening curve.
    softened = -np.expm1(-1e-3 * theirs[:, 0] * LAW.tensile_strength / LAW.fracture_energy)
    volume = np.prod(np.ptp(response.mesh.nodes[response.mesh.elements[0]], axis=0))
    taken = LAW.fracture_energy * volume ** (2.0 / 3.0) * softened.sum()
    assert response.dissipated_energy == pytest.approx(taken, rel=0.08)
