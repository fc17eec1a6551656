"""The masonry law at a point in space, against closed forms and other programs."""

import tomllib
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from material_point import (
    DUCTILITY,
    LAW,
    MASONRY,
    MATERIAL,
    NEVER,
    MaterialPoint,
    aster_test,
    dissipated_energy,
    principal,
    triaxial_test,
    update,
)

from solvers.compiled.point_update import principal_axes
from solvers.compiled.return_map import APEX, CONE, Softening
from solvers.masonry import FLOOR
from solvers.materials import elasticity_matrix

ORACLES = tomllib.loads((Path(__file__).parents[2] / "oracles" / "masonry.toml").read_text(encoding="utf-8"))
FT, E = MASONRY.tensile_strength, MATERIAL.young
CONE_ONLY = Softening(9.7e6, np.inf, 0.0, 0.0)
"""A tensile strength just under the cone's apex."""

strains = st.tuples(*[st.floats(min_value=-1.0, max_value=1.0)] * 6).map(np.array)
sizes = st.floats(min_value=-5.0, max_value=-1.5).map(lambda exponent: 10.0**exponent)
kappas = st.floats(min_value=0.0, max_value=3 * DUCTILITY)


def _softening(kappa):
    return Softening(FT, DUCTILITY, FLOOR, kappa)


def _tensor(strain):
    return np.array(strain)[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3) / (2.0 - np.eye(3))


def _components(tensor):
    return np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[1, 2], tensor[0, 2]])


def test_uniaxial_compression():
    point = triaxial_test(0.0, -0.02)
    assert point.stress[2] / 1e6 == pytest.approx(-ORACLES["uniaxial_compression"]["strength"], abs=5e-5)
    # Lateral over axial flow, by hand: the deviator is (1, 1, -2), so (eta + 1/sqrt(12)) / (eta - 1/sqrt(3)).
    flow = (LAW.eta + 1 / np.sqrt(12)) / (LAW.eta - 1 / np.sqrt(3))
    inelastic = point.state.inelastic
    assert inelastic[:2] / inelastic[2] == pytest.approx([flow, flow], rel=1e-10)


@pytest.mark.parametrize("case", range(3))
def test_triaxial_compression(case):
    values = ORACLES["triaxial"]
    point = triaxial_test(values["confinement"][case] * 1e6, -0.03)
    assert point.stress[2] / 1e6 == pytest.approx(values["axial_stress"][case], abs=5e-5)


def test_pure_shear_cracks_at_the_tensile_strength():
    point = MaterialPoint()
    before = point.move([0, 0, 0, 0.9999 * FT / LAW.shear, 0, 0])
    assert before.active == 0
    assert before.stress[3] == pytest.approx(0.9999 * FT)
    assert point.move([0, 0, 0, 1.0001 * FT / LAW.shear, 0, 0]).active == 2


def test_pure_shear_of_what_does_not_crack_yields_at_k():
    point = MaterialPoint(LAW._replace(eta=0.0), strength=NEVER)
    result = point.move([0, 0, 0, 0.02, 0, 0])
    assert result.active == CONE
    expected = [0, 0, 0, ORACLES["pure_shear"]["strength"], 0, 0]
    assert result.stress / 1e6 == pytest.approx(expected, abs=5e-7)


@pytest.mark.parametrize("steps", [1, 7])
def test_uniaxial_tension_follows_the_softening(steps):
    point = MaterialPoint()
    for strain in np.linspace(0.0, 2e-3, steps + 1)[1:]:
        point.drive({0: strain})
    # By hand: strain = stress / E + kappa and stress = ft exp(-kappa / ku).
    kappa = point.state.kappa
    assert kappa > 1e-3
    assert point.stress[0] == pytest.approx(FT * np.exp(-kappa / DUCTILITY), rel=1e-12)
    assert point.strain[0] == pytest.approx(point.stress[0] / E + kappa, rel=1e-12)
    assert point.strain[1] == pytest.approx(-MATERIAL.poisson * point.stress[0] / E, rel=1e-9)
    assert point.state.inelastic == pytest.approx([kappa, 0, 0, 0, 0, 0], abs=1e-14)


@pytest.mark.parametrize("band", [0.05, 0.1, 0.2])
def test_crack_takes_the_fracture_energy_whatever_the_band(band):
    # Cut off at exp(-7) of the strength, where 0.1 % of the energy is left.
    assert dissipated_energy(band) == pytest.approx(MASONRY.fracture_energy, rel=2e-3)


def test_code_aster_softening_cone():
    values = ORACLES["code_aster"]
    found = np.array(aster_test(values, values["share"]))
    assert found[:, 0] == pytest.approx(values["axial_stress"], rel=1e-8)
    assert found[:, 1] == pytest.approx(values["p"], rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("case", range(4))
def test_opensees_triaxial_compression(case):
    values = ORACLES["opensees"]["triaxial"]
    point = triaxial_test(values["confinement"][case] * 1e6, values["axial_strain"])
    assert point.strain[0] == pytest.approx(values["lateral_strain"][case], rel=1e-10)
    assert point.stress[2] / 1e6 == pytest.approx(values["axial_stress"][case], rel=1e-10)


@pytest.mark.parametrize("case", range(3))
def test_opensees_strain_paths(case):
    values = ORACLES["opensees"]["paths"][case]
    point = MaterialPoint(strength=CONE_ONLY.strength, ductility=np.inf)
    for share in (0.25, 0.5, 0.75, 1.0):
        result = point.move(share * np.array(values["strain"]))
    assert result.active == CONE
    # OpenSees imposed the strains by penalty, to some 1e-11.
    assert result.stress / 1e6 == pytest.approx(values["stress"], abs=1e-8)


def test_opensees_damage_law_softens_alike():
    values = ORACLES["asd_concrete"]
    point = MaterialPoint(ductility=MASONRY.fracture_energy / (0.1 * FT))
    found = [point.drive({0: strain}).stress[0] / 1e6 for strain in values["strain"]]
    assert found == pytest.approx(values["stress"], abs=values["tolerance"])


@pytest.mark.skipif(find_spec("openseespy") is None, reason="OpenSeesPy is not installed")
def test_opensees_now():
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    for number, corner in enumerate(corners, start=1):
        ops.node(number, *map(float, corner))
        ops.fix(number, *[int(value == 0) for value in corner])
    cone = [np.sqrt(3) * LAW.cone / 1e6, np.sqrt(2) * LAW.alpha, np.sqrt(2) * LAW.eta]
    ops.nDMaterial("DruckerPrager", 1, LAW.bulk / 1e6, LAW.shear / 1e6, *cone, *[0.0] * 5, 1.0, 0.0, 101.0)
    ops.element("stdBrick", 1, *range(1, 9), 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for number in (5, 6, 7, 8):
        ops.sp(number, 3, -0.01)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-14, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static")
    assert ops.analyze(1) == 0
    point = triaxial_test(0.0, -0.01)
    assert point.stress[2] / 1e6 == pytest.approx(ops.eleResponse(1, "stresses")[2], rel=1e-10)
    assert point.strain[0] == pytest.approx(ops.nodeDisp(7, 1), rel=1e-10)


def _tangent_by_differences(strain, soft, step, law=LAW):
    columns, sets = [], set()
    for i in range(6):
        change = step * np.eye(6)[i]
        ahead, behind = update(strain + change, law, soft), update(strain - change, law, soft)
        columns.append((ahead.stress - behind.stress) / (2 * step))
        sets |= {ahead.active, behind.active}
    return np.stack(columns, axis=1), sets


def test_tangent_is_the_derivative_in_every_active_set():
    rng = np.random.default_rng(1)
    worst: dict[int, float] = {}
    for _ in range(600):
        size = 10.0 ** rng.uniform(-4, -2)
        strain = rng.normal(size=6) * size
        strain[:3] -= rng.choice([0, 1, 2]) * size * rng.random()
        soft = _softening(rng.choice([0.0, 1e-3]))
        result = update(strain, LAW, soft)
        numeric, sets = _tangent_by_differences(strain, soft, 1e-6 * size)
        if sets == {result.active}:
            error = np.abs(numeric - result.tangent).max() / E
            worst[result.active] = max(worst.get(result.active, 0.0), error)
    assert set(worst) == {0, CONE, 2, 6, 14, CONE | 2, CONE | 6}
    # Central differences are good to about 1e-8 here; near a vertex, to less.
    assert max(worst.values()) < 1e-6


@pytest.mark.parametrize("hardening", [300e6, -100e6])
def test_tangent_of_a_cone_that_hardens_or_softens(hardening):
    law = LAW._replace(hardening=hardening, least_cone=1e5)
    strain = np.array([-0.006, 0.001, 0.002, 0.001, -0.002, 0.003])
    result = update(strain, law, CONE_ONLY)
    numeric, sets = _tangent_by_differences(strain, CONE_ONLY, 1e-8, law)
    assert sets == {CONE}
    assert result.tangent == pytest.approx(numeric, abs=1e-6 * E)


@given(strains, sizes, kappas, st.tuples(*[st.floats(min_value=-1.0, max_value=1.0)] * 3))
def test_law_turns_with_the_axes(direction, size, kappa, turn):
    angle = np.linalg.norm(turn)
    cross = np.cross(np.eye(3), np.array(turn) / max(angle, 1e-12))
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    here = _tensor(size * direction)
    there = _components(rotation @ here @ rotation.T) * [1, 1, 1, 2, 2, 2]
    plain, turned = update(size * direction, LAW, _softening(kappa)), update(there, LAW, _softening(kappa))
    stress = _components(rotation @ plain.stress[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3) @ rotation.T)
    assert turned.stress == pytest.approx(stress, abs=1e-9 * FT + 1e-12 * E * size)
    assert turned.multipliers.sum() == pytest.approx(plain.multipliers.sum(), abs=1e-12 * size)


@given(strains, sizes)
def test_inelastic_strain_is_what_the_stress_leaves(direction, size):
    result = update(size * direction, LAW, _softening(0.0))
    elastic = np.linalg.solve(elasticity_matrix(MATERIAL), result.stress)
    assert size * direction - result.inelastic == pytest.approx(elastic, abs=1e-12 * size)


@pytest.mark.parametrize(
    "stress",
    [
        [0, 0, -1e7, 0, 0, 0],
        # The bound on s1 of these is beyond the strength, though s1 is not: they take the whole way.
        [0, 0, 0, 0.95 * FT, 0, 0],
        [0.9 * FT, 0.89 * FT, -1e6, 0, 0, 0],
    ],
)
def test_elastic_states(stress):
    D = elasticity_matrix(MATERIAL)
    result = update(np.linalg.solve(D, stress), LAW, _softening(0.0))
    assert result.active == 0
    assert result.stress == pytest.approx(stress, abs=1e-8 * FT)
    assert result.tangent == pytest.approx(D, abs=1e-12 * E)
    assert not result.multipliers.any()
    assert result.inelastic == pytest.approx(np.zeros(6), abs=1e-18)


@given(strains, sizes)
def test_infinite_ductility_freezes_the_strength(direction, size):
    # Frozen at what is left of a strength that softens, a point answers like one of that strength.
    kappa = 1.3 * DUCTILITY
    frozen = update(size * direction, LAW, Softening(FT * np.exp(-1.3), np.inf, 0.0, kappa))
    plastic = update(size * direction, LAW, Softening(FT, 1e12, FLOOR, 1.3e12))
    assert frozen.active == plastic.active
    assert frozen.stress == pytest.approx(plastic.stress, abs=1e-9 * FT + 1e-12 * E * size)
    assert principal(frozen.stress)[0] <= FT * np.exp(-1.3) + 1e-8 * FT + 1e-12 * E * size
    if frozen.active == 2:
        # A plane at rest lets no stress through along its normal: its tangent is singular there.
        assert abs(np.linalg.eigvalsh(frozen.tangent)).min() < 1e-9 * E


def test_apex_has_no_stiffness():
    result = update([1e-2, 1e-2, 1e-2, 1e-5, 0, 0], LAW, Softening(NEVER, np.inf, 0.0, 0.0))
    assert result.active == APEX | CONE
    apex = ORACLES["apex"]["mean_stress"]
    assert result.stress / 1e6 == pytest.approx([apex, apex, apex, 0, 0, 0], abs=5e-7)
    assert not result.tangent.any()


@given(strains, st.sampled_from([0, 1e-9, 1.0]))
def test_principal_axes(values, spread):
    tensor = _tensor(values)
    # Nearly equal values too, and a multiple of the identity.
    tensor = np.eye(3) * 0.7 + spread * tensor
    found, axes = np.empty(3), np.empty((3, 3))
    principal_axes(tensor.copy(), found, axes)
    assert found == pytest.approx(np.linalg.eigvalsh(tensor)[::-1], abs=1e-14)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-14)
    assert axes @ np.diag(found) @ axes.T == pytest.approx(tensor, abs=1e-14)
