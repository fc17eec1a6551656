"""Settlement of a wall that cracks: self-weight first, then the ground moves in steps.

References
----------
J. Oliver, A. E. Huespe, J. C. Cante, "An implicit/explicit integration scheme to increase computability of
non-linear material and contact/friction problems", Comput. Methods Appl. Mech. Eng. 197, 2008.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError
from solvers.compiled.cracking import Motion, PointFields, Strengths
from solvers.masonry import FLOOR, MasonryLaw, softening_strain
from solvers.steps.step_record import step_record
from solvers.steps.stepping import Snapshot, StepMode, SteppingOptions, at_rest
from solvers.steps.wall_model import Balance, Tangent, WallModel

__all__ = ["apply_settlement", "at_rest"]

FloatArray = NDArray[np.float64]

DIVERGED = 1e6
"""An iteration whose unbalanced force is so many times the reactions will not come back."""
FEWEST = 0.2
"""Part of an equal step down to which a step is cut for the sake of its error alone."""
EXACT = 1e-2
"""Part of the tolerance for forces out of balance, below which no more is asked of a state."""
NEAR = 0.1
"""An iteration that leaves more than this part of the forces out of balance creeps: more bring little."""
REST = 1e-3
"""Largest movement in the last iteration, relative to the displacement, of a wall that has come to rest."""
GROWTH = 1.5
"""A step that was cut grows back by this factor, as long as it goes well."""
SEARCHES, SLACK = 10, 0.5
"""How often a step of Newton's method is changed that goes too far: at whose end the forces out of balance
push back with more than this part of what they pulled with."""


def apply_settlement(
    model: WallModel,
    law: MasonryLaw,
    ground: Callable[[float], FloatArray],
    *,
    options: SteppingOptions,
    start: Snapshot | None = None,
    tangent: Tangent | None = None,
) -> Iterator[Snapshot]:
    """States of equilibrium: under the weight alone, then after each step of the settlement.

    Parameters
    ----------
    model : WallModel
    law : MasonryLaw
    ground : callable
        Displacement (k, 3), m, of the ground under the base's points when a share (0 to 1) of the settlement
        is applied.
    options : SteppingOptions
    start : Snapshot, optional
        Where to go on; by default the wall at rest.
    tangent : Tangent, optional
        Of the model, with the solver to use and the clock to run; by default a new one.

    Yields
    ------
    Snapshot

    Raises
    ------
    ConvergenceError
        If the smallest step finds no equilibrium: the wall does not stand, or the step's size is at fault.
    """
    stepper = _Stepper(tangent or Tangent(model), law, ground, options)
    state = at_rest(model) if start is None else start
    if not state.history:
        standing = stepper.try_step(state, 0.0)
        if standing is None:
            msg = "The wall does not stand under its own weight: check its base, strength and density."
            raise ConvergenceError(msg)
        state = standing
        yield state
    while state.share < 1.0 - 1e-12:
        size = min(state.next_size, 1.0 - state.share)
        following = stepper.try_step(state, size)
        if following is None:
            state = replace(state, next_size=size / 2.0)
            if state.next_size * options.steps < options.smallest:
                msg = (
                    f"No equilibrium was found past {100 * state.share:.2f} % of the settlement: more steps, "
                    "smaller elements or a larger fracture energy may help; or the wall falls."
                )
                raise ConvergenceError(msg)
            continue
        state = following
        yield state


class _Trial(NamedTuple):
    """What a step starts from and where the ground (k, 3), m, has moved."""

    ground: FloatArray
    strengths: Strengths
    before: PointFields


@dataclass(frozen=True, eq=False)
class _Found:
    """A state of equilibrium: motion, state of the points, balance and iterations."""

    motion: Motion
    fields: PointFields
    balance: Balance
    iterations: int


class _Stepper:
    """One step after the other on a wall."""

    def __init__(
        self,
        tangent: Tangent,
        law: MasonryLaw,
        ground: Callable[[float], FloatArray],
        options: SteppingOptions,
    ) -> None:
        self.tangent, self.model, self.ground, self.options = tangent, tangent.model, ground, options
        self.tensile = law.tensile_strength
        self.ductility = softening_strain(law, self.model.band)

    def try_step(self, state: Snapshot, size: float) -> Snapshot | None:
        """As `step`; None as well where the equations have no solution."""
        try:
            return self.step(state, size)
        except ConvergenceError:
            return None

    def step(self, state: Snapshot, size: float) -> Snapshot | None:
        """The next state of equilibrium; None if there is none to be found, or too large an error."""
        last = state.share if state.history else 0.0
        share = last + size
        frozen = self._strengths(state, size)
        trial = _Trial(self.ground(share), frozen, state.fields)
        self.tangent.let_go(state.motion, self.ground(last))
        found = self._equilibrium(trial, state.motion, self.ground(last))
        if found is None:
            return None
        fields, excess = found.fields, 0.0
        if self.options.mode is StepMode.IMPLEX:
            # What is remembered softens as it should; the stress stays the one that is in equilibrium.
            fields = _copy(state.fields)
            self.tangent.balance(found.motion, *trial._replace(strengths=self._softening()), fields)
            fields = fields._replace(stress=found.fields.stress, kappa=self._shared(fields.kappa))
            difference = (frozen.tensile - self._tensile(fields.kappa)) / self.tensile
            excess = float(difference.max(initial=0.0))
            # A point that begins to crack was not foretold to, however small the step.
            known = float(difference[state.fields.kappa > 0.0].max(initial=0.0))
            if known > self.options.largest_change and size * self.options.steps > FEWEST:
                return None
        equal = 1.0 / self.options.steps
        record, dissipated, force = step_record(
            self.model, state, fields, found.motion, found.balance, self._softening()
        )
        return Snapshot(
            motion=found.motion,
            fields=fields,
            kappa_before=state.fields.kappa,
            dissipated=dissipated,
            force=force,
            size=size,
            next_size=min(GROWTH * size, equal) if size else equal,
            history=(
                *state.history,
                replace(record, share=share, iterations=found.iterations, strength_error=excess),
            ),
        )

    def _shared(self, kappa: FloatArray) -> FloatArray:
        """Mean of an element's points, for each of them: the band is as wide as the element.

        With a strength of their own, points would soften one after the other, and a crack that opens in half
        of an element takes half of its energy: incompatible modes allow that.
        """
        share = self.model.volumes / self.model.volumes.sum(axis=1, keepdims=True)
        return np.broadcast_to((share * kappa).sum(axis=1, keepdims=True), kappa.shape).copy()

    def _strengths(self, state: Snapshot, size: float) -> Strengths:
        """Tensile strengths for the step: softening in it, or frozen at what the last step foretells."""
        if self.options.mode is StepMode.IMPLICIT:
            return self._softening()
        growth = size / state.size if state.size > 0.0 else 0.0
        foretold = state.fields.kappa + growth * (state.fields.kappa - state.kappa_before)
        return Strengths(self._tensile(foretold), np.full(len(self.ductility), np.inf), 0.0)

    def _softening(self) -> Strengths:
        return Strengths(np.full(self.model.volumes.shape, self.tensile), self.ductility, FLOOR)

    def _tensile(self, kappa: FloatArray) -> FloatArray:
        """Tensile strength that is left at each point, Pa."""
        decay = np.exp(-kappa / self.ductility[:, None])
        left: FloatArray = self.tensile * np.maximum(decay, FLOOR)
        return left

    def _equilibrium(self, trial: _Trial, motion: Motion, rested_on: FloatArray) -> _Found | None:
        """Newton's method from the last motion, which rested on the ground as it was."""
        after, balance = _copy(trial.before), None
        for iteration in range(1, self.options.max_iterations + 1):
            ground = rested_on if balance is None else trial.ground
            self.tangent.assemble(motion, *trial, after, rested_on=ground)
            change = self.tangent.newton_change()
            last, before = motion, balance
            motion, balance = self._search(trial, motion, change, after, balance)
            if self._balanced(before, balance, rests=_rests(last, motion)):
                return _Found(motion, after, balance, iteration)
            if not balance.residual < DIVERGED * balance.scale:
                return None
        return None

    def _balanced(self, before: Balance | None, balance: Balance, *, rests: bool) -> bool:
        """Whether the forces balance, no better balance is near, and the wall has come to rest.

        Where it falls, or torn parts hang on next to nothing, the forces left over are small as well, but
        each iteration moves it on.
        """
        allowed = self.options.tolerance * balance.scale
        if balance.residual > allowed or before is None:
            return balance.residual <= EXACT * allowed
        creeps = balance.residual > NEAR * before.residual
        return balance.residual <= EXACT * allowed or (creeps and rests)

    def _search(
        self, trial: _Trial, motion: Motion, change: Motion, after: PointFields, last: Balance | None
    ) -> tuple[Motion, Balance]:
        """Go along a step of Newton's method as far as the forces out of balance pull.

        Where they push back at its end, the place where their work vanishes is enclosed by regula falsi and
        bisection in turn.
        """
        reached = _along(motion, change, 1.0)
        balance = self.tangent.balance(reached, *trial, after)
        start = last.power(change) if last is not None else 0.0
        low, at_low, high, at_high = 0.0, start, 1.0, balance.power(change)
        if start <= 0.0 or at_high >= -SLACK * start:
            return reached, balance
        for trip in range(SEARCHES):
            share = 0.5 if trip % 2 else min(max(at_low / (at_low - at_high), 0.1), 0.9)
            part = low + (high - low) * share
            reached = _along(motion, change, part)
            balance = self.tangent.balance(reached, *trial, after)
            power = balance.power(change)
            if abs(power) <= SLACK * start:
                break
            if power < 0.0:
                high, at_high = part, power
            else:
                low, at_low = part, power
        return reached, balance


def _rests(last: Motion, motion: Motion) -> bool:
    """Whether a wall hardly moved from the last motion to this one."""
    moved = float(np.abs(motion.displacement - last.displacement).max())
    return moved <= REST * float(np.abs(motion.displacement).max())


def _along(motion: Motion, change: Motion, part: float) -> Motion:
    return Motion(motion.displacement + part * change.displacement, motion.modes + part * change.modes)


def _copy(fields: PointFields) -> PointFields:
    return PointFields(*(array.copy() for array in fields))
