"""The return map in principal axes: closed forms, and the principles that its answer must obey."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from material_point import DUCTILITY, LAW, MASONRY, MATERIAL, NEVER, cone_value

from solvers.compiled.return_map import (
    APEX,
    CONE,
    PLANES,
    Softening,
    principal_return,
    strength,
    strength_slope,
)
from solvers.masonry import FLOOR, MasonryLaw, point_law

ORACLES = tomllib.loads((Path(__file__).parents[2] / "oracles" / "masonry.toml").read_text(encoding="utf-8"))
FT = MASONRY.tensile_strength
ASSOCIATED = point_law(MATERIAL, MasonryLaw(dilatancy_angle=35.0))
FROZEN = Softening(FT, np.inf, 0.0, 0.0)
TENSILE_SETS = [0, 2, 6, 14]
ALL_SETS = {0, CONE, 2, 6, 14, CONE | 2, CONE | 6}

# Elastic principal stresses, Pa, of all sizes: a wall's are a few MPa, a bad iteration's may be thousands.
exponents = st.floats(min_value=4.0, max_value=9.0)
directions = st.tuples(*[st.floats(min_value=-1.0, max_value=1.0)] * 3).filter(
    lambda v: max(map(abs, v)) > 0.1
)
kappas = st.floats(min_value=0.0, max_value=10 * DUCTILITY)


def _trial(direction, exponent):
    return np.sort(np.array(direction) * 10.0**exponent)[::-1].copy()


def _return(trial, law=LAW, soft=FROZEN):
    stress, multipliers = np.full(3, np.nan), np.full(4, np.nan)
    active = principal_return(np.array(trial, dtype=float), law, soft, stress, multipliers)
    return active, stress, multipliers


def _softening(kappa):
    return Softening(FT, DUCTILITY, FLOOR, kappa)


def test_strength_and_its_slope():
    soft = Softening(2e6, 1e-3, 1e-2, 5e-4)
    assert strength(soft, 5e-4) == pytest.approx(2e6 / np.e)
    assert strength_slope(soft, 5e-4) == pytest.approx(-2e9 / np.e)
    assert strength(soft, 5e-3) == 2e4
    assert strength_slope(soft, 5e-3) == 0.0
    assert strength(FROZEN, 5e-3) == FT
    assert strength_slope(FROZEN, 5e-3) == 0.0


def test_one_plane_takes_the_excess():
    # By hand: x = (tr1 - ft) / (lambda + 2 G), the other stresses fall by lambda x.
    active, stress, g = _return([3e6, 1e6, -1e6])
    x = (3e6 - FT) / (LAW.lame + 2 * LAW.shear)
    assert active == 2
    assert stress == pytest.approx([FT, 1e6 - LAW.lame * x, -1e6 - LAW.lame * x], rel=1e-13)
    assert g == pytest.approx([0, x, 0, 0])


def test_all_round_tension_ends_in_the_vertex():
    # By hand: tr - K (g1 + g2 + g3) = ft, each a third.
    active, stress, g = _return([4e6, 4e6, 4e6])
    assert active == PLANES
    assert stress == pytest.approx([FT] * 3, rel=1e-13)
    assert g[1:] == pytest.approx([(4e6 - FT) / (3 * LAW.bulk)] * 3)


def test_edge_of_cone_and_two_planes():
    active, stress, _ = _return([6e7, 6e7, -4e7])
    assert active == CONE | 6
    assert stress[:2] == pytest.approx([FT, FT], rel=1e-12)
    assert stress[2] / 1e6 == pytest.approx(ORACLES["corner"]["least_stress"], abs=5e-5)


def test_apex_where_no_plane_is_in_the_way():
    active, stress, _ = _return([1e8, 1e8 - 1e5, 1e8 - 2e5], soft=Softening(NEVER, np.inf, 0.0, 0.0))
    assert active == APEX | CONE
    assert stress / 1e6 == pytest.approx([ORACLES["apex"]["mean_stress"]] * 3, abs=5e-7)


def test_softening_ends_in_the_state_that_it_describes():
    # One scalar equation, solved here by bisection.
    trial, soft = 5e6, _softening(2e-4)
    low, high = 0.0, trial / (LAW.lame + 2 * LAW.shear)
    for _ in range(200):
        x = 0.5 * (low + high)
        excess = trial - (LAW.lame + 2 * LAW.shear) * x - FT * np.exp(-(2e-4 + x) / DUCTILITY)
        low, high = (x, high) if excess > 0 else (low, x)
    active, stress, g = _return([trial, 0.0, -1e6], soft=soft)
    assert active == 2
    assert g[1] == pytest.approx(x, rel=1e-12)
    assert stress[0] == pytest.approx(FT * np.exp(-(2e-4 + x) / DUCTILITY), rel=1e-12)


@given(directions, exponents, kappas)
@example((1.0, 0.2, -1.0), 8.5, 0.0)
@example((1.0, 0.99, -1.0), 8.0, 2e-3)
@example((0.1, -1.0, -1.0), 7.8, 0.0)
def test_conditions_of_kuhn_and_tucker(direction, exponent, kappa):
    trial = _trial(direction, exponent)
    active, stress, g = _return(trial, soft=_softening(kappa))
    left = FT * max(np.exp(-(kappa + g[1:].sum()) / DUCTILITY), FLOOR)
    # Rounding is that of the trial stress.
    slack = 1e-9 * FT + 1e-12 * np.abs(trial).max()
    assert active in ALL_SETS
    assert (g >= -1e-14 * np.abs(trial).max() / LAW.shear).all()
    assert stress.max() <= left + slack
    assert cone_value(stress) <= slack
    assert (g[1:] == 0.0).tolist() == [not active & (2 << i) for i in range(3)]
    for i in range(3):
        if active & (2 << i):
            assert stress[i] == pytest.approx(left, abs=slack)
    if active & CONE:
        assert cone_value(stress) == pytest.approx(0.0, abs=slack)
    else:
        assert g[0] == 0.0


@given(directions, exponents, kappas)
def test_flow_follows_koiter(direction, exponent, kappa):
    trial = _trial(direction, exponent)
    _, stress, g = _return(trial, soft=_softening(kappa))
    deviator = stress - stress.mean()
    root_j2 = np.sqrt(0.5 * (deviator**2).sum())
    flow = g[1:] + g[0] * (deviator / (2 * root_j2) + LAW.eta if g[0] else 0.0)
    elastic = LAW.lame * flow.sum() + 2 * LAW.shear * flow
    assert trial - elastic == pytest.approx(stress, abs=1e-9 * FT + 1e-11 * np.abs(trial).max())


@given(directions, exponents, directions, st.floats(min_value=0.0, max_value=1.0))
def test_associated_return_is_the_closest_admissible_stress(direction, exponent, other, share):
    # Of a convex domain: (t - s) : C : (trial - s) <= 0 for all admissible t, and for s alone.
    trial = _trial(direction, exponent)
    _, stress, _ = _return(trial, law=ASSOCIATED)
    towards = np.array(other) * 1e9
    # The domain holds the origin, so that some share of any stress is in it; find the largest by bisection.
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = (middle * towards).max() <= FT and cone_value(middle * towards, ASSOCIATED) <= 0.0
        low, high = (middle, high) if inside else (low, middle)
    admissible = share * low * towards
    E, nu = MATERIAL.young, MATERIAL.poisson
    released = ((1 + nu) * (trial - stress) - nu * (trial - stress).sum()) / E
    away = admissible - stress
    assert away @ released <= 1e-10 * np.linalg.norm(away) * np.linalg.norm(released) + 1e-9


def test_random_trials_reach_every_active_set():
    rng = np.random.default_rng(0)
    trials = np.sort(rng.normal(size=(2000, 3)) * 10.0 ** rng.uniform(5, 9, size=(2000, 1)))[:, ::-1]
    assert {_return(trial, soft=_softening(0.0))[0] for trial in trials} == ALL_SETS
