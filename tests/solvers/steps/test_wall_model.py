"""Newton's method on a small wall: what is computed anew, and what is not."""

import numpy as np
import pytest

from solvers.compiled.cracking import Motion, PointFields, Strengths
from solvers.masonry import FLOOR, MasonryLaw, softening_strain
from solvers.materials import Material
from solvers.steps.stepping import at_rest
from solvers.steps.supports import BaseOptions
from solvers.steps.wall import wall_model
from solvers.steps.wall_model import Tangent

LAW = MasonryLaw()


@pytest.fixture
def model(grid):
    mesh = grid(np.arange(4), [0, 0.4], np.arange(4), warp=0.03)
    wall, _ = wall_model(mesh, material=Material(), law=LAW, gravity=9.81, base=BaseOptions())
    return wall


def _strengths(model):
    return Strengths(
        np.full(model.volumes.shape, LAW.tensile_strength), softening_strain(LAW, model.band), FLOOR
    )


def _stretched(model, strain):
    """A motion that pulls the wall apart along z, by more at one end."""
    x, _, z = model.body.points.T
    displacement = np.zeros_like(model.body.points)
    displacement[:, 2] = strain * z * x
    return Motion(displacement, at_rest(model).motion.modes)


def _blank(fields):
    return PointFields(*(np.full_like(array, np.nan) for array in fields))


@pytest.mark.parametrize(("strain", "cracked"), [(1e-5, False), (1e-3, True)])
def test_forces_alone_leave_the_state_that_forces_and_stiffness_leave(model, strain, cracked):
    tangent, before = Tangent(model), at_rest(model).fields
    ground = np.zeros((len(model.support.points), 3))
    with_stiffness, alone = _blank(before), _blank(before)
    motion = _stretched(model, strain)
    tangent.assemble(motion, ground, _strengths(model), before, with_stiffness)
    tangent.balance(motion, ground, _strengths(model), before, alone)
    for one, other in zip(with_stiffness, alone, strict=True):
        assert np.isfinite(one).all()
        assert np.array_equal(one, other)
    assert (alone.kappa > 0.0).any() == cracked
    assert (alone.kappa == 0.0).any()


def test_a_point_that_yielded_in_vain_is_as_it_was(model):
    """An iteration that went too far leaves nothing behind."""
    tangent, before = Tangent(model), at_rest(model).fields
    ground, after = np.zeros((len(model.support.points), 3)), _blank(before)
    tangent.balance(_stretched(model, 1e-3), ground, _strengths(model), before, after)
    assert after.crack.any()
    tangent.balance(_stretched(model, 1e-6), ground, _strengths(model), before, after)
    for name in ("inelastic", "crack", "kappa", "cone"):
        assert not getattr(after, name).any()


def test_a_stiffness_that_stays_is_factorised_once(model, monkeypatch):
    tangent, before = Tangent(model), at_rest(model).fields
    ground, after = np.zeros((len(model.support.points), 3)), _blank(before)
    factorised, factorise = [], tangent._solver.factorise
    monkeypatch.setattr(
        tangent._solver, "factorise", lambda values: (factorised.append(1), factorise(values))
    )
    changes = []
    for strain in (1e-6, 2e-6, 1e-3, 1e-6):
        tangent.assemble(_stretched(model, strain), ground, _strengths(model), before, after)
        changes.append(tangent.newton_change().displacement)
    # Elastic twice, cracked, and elastic again.
    assert len(factorised) == 3
    # Each arrives at the same place, the weight's, from where it was.
    arrived = [_stretched(model, strain).displacement + changes[i] for i, strain in enumerate((1e-6, 2e-6))]
    assert np.abs(arrived[0] - arrived[1]).max() < 1e-9 * np.abs(arrived[0]).max()
    assert np.abs(changes[3] - changes[0]).max() < 1e-9 * np.abs(changes[0]).max()
