"""A wall as its load steps see it, its forces in some state, and Newton's method."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.cracking import (
    Body,
    Motion,
    PointFields,
    Strengths,
    add_forces,
    chunk_of,
    point_forces,
    update_points,
)
from solvers.compiled.jit import in_chunks
from solvers.compiled.pattern import Pattern
from solvers.compiled.stiffness import Sums, add_elements
from solvers.compiled.tangents import Condensed, tangent_matrices
from solvers.fem.connectivity import rigid_motions
from solvers.fem.linear_solvers import LinearSolver, SolverName, checked_solve, make_solver
from solvers.steps.supports import Support, lifted, spring_forces

__all__ = ["Balance", "Clock", "Tangent", "WallModel"]

FloatArray = NDArray[np.float64]

TETRAHEDRON_BAND, TETRAHEDRON_NODES = 2.04, 10
ROUND_OFF = 1e-6
"""Forces this small, relative to a stiffness of the wall times its displacement, cannot be told from none."""
STABILISER = 1e-6
"""Part of the elastic stiffness added to the tangent, which a wide crack would leave singular; the forces,
and with them the answer, stay what they are."""


@dataclass(frozen=True, eq=False)
class WallModel:
    """What stays the same through the steps.

    Attributes
    ----------
    body : Body
    pattern : Pattern
    support : Support
    weight : (3m,) float array, N
        Nodal forces of the self-weight.
    volumes : (e, q) float array, m³
        That the integration points stand for.
    """

    body: Body
    pattern: Pattern
    support: Support
    weight: FloatArray
    volumes: FloatArray

    @property
    def band(self) -> FloatArray:
        """Width (e,), m, of the band that a crack takes in each element: the cube root of its volume.

        In a tetrahedron, the edge of the regular one of that volume: one strength serves all of the element.
        """
        factor = TETRAHEDRON_BAND if self.body.connectivity.shape[1] == TETRAHEDRON_NODES else 1.0
        widths: FloatArray = factor * np.cbrt(self.volumes.sum(axis=1))
        return widths


@dataclass
class Clock:
    """Seconds spent on the points' states, on matrices and sums, and on the linear equations."""

    material: float = 0.0
    assembly: float = 0.0
    solve: float = 0.0


@dataclass(frozen=True, eq=False)
class Balance:
    """How far a wall is from equilibrium.

    Attributes
    ----------
    held : (3m,) float array, N
        Forces of the ground on the wall, through prescribed displacements and springs.
    unbalanced : (3m,) float array, N
        Forces that nothing balances; 0 at the prescribed displacements.
    modes : (e, 3k) float array, N
        The same of the incompatible modes.
    scale : float, N
        Norm of `held`; where nothing presses or pulls, what rounding makes of the displacement.
    """

    held: FloatArray
    unbalanced: FloatArray
    modes: FloatArray
    scale: float

    @property
    def residual(self) -> float:
        """Norm of all forces out of balance, N."""
        return float(np.hypot(np.linalg.norm(self.unbalanced), np.linalg.norm(self.modes)))

    def power(self, change: Motion) -> float:
        """Work of the forces out of balance on a change of the motion, J: its sign says whether to go on."""
        return float(
            self.unbalanced @ change.displacement.ravel() + self.modes.ravel() @ change.modes.ravel()
        )


class Tangent:
    """Newton's method on a wall.

    It keeps the large arrays and the order of the equations from one iteration to the next.

    Attributes
    ----------
    model : WallModel
    clock : Clock
    unbalanced : (3m,) float array, N
        Weight minus the forces of elements and springs in the state that was assembled, the modes condensed
        out: zero at the free displacements in equilibrium, minus the reaction at the prescribed ones.
    """

    def __init__(self, model: WallModel, *, solver: SolverName = SolverName.AUTO) -> None:
        self.model, self.clock = model, Clock()
        count, nodes = model.body.connectivity.shape
        modes, unknowns = 3 * model.body.rule.modes.shape[2], len(model.weight)
        self._sums = Sums(np.zeros(len(model.pattern.columns)), np.zeros(unknowns), np.zeros(unknowns))
        self._follow, self._lag = np.zeros((count, modes, 3 * nodes)), np.zeros((count, modes))
        self._imposed, self.unbalanced = np.zeros(unknowns), np.zeros(unknowns)
        self._free = model.pattern.equation >= 0
        self._stiffness = float(model.body.law.shear * np.cbrt(model.volumes.sum()))
        self._factorised = np.zeros(0)
        self._loose = np.zeros(len(model.support.points), dtype=bool)
        motions = rigid_motions(model.body.points)[self._free]
        self._solver: LinearSolver = make_solver(solver, model.pattern, motions=motions)

    @property
    def solver_name(self) -> str:
        """What solves the equations."""
        return self._solver.name

    def let_go(self, motion: Motion, ground: FloatArray) -> None:
        """Hold nothing along the ground, from now on, where the base has lifted off it at a motion.

        Within a step this must not change: where a joint closes, its shear would jump, and Newton's method
        with it.
        """
        self._loose = lifted(self.model.support, motion.displacement, ground)

    def balance(
        self,
        motion: Motion,
        ground: FloatArray,
        strengths: Strengths,
        before: PointFields,
        after: PointFields,
    ) -> Balance:
        """Forces at a motion, without the tangent; the parameters are those of `assemble`."""
        body = self.model.body
        width = 3 * body.connectivity.shape[1]
        total, modes = np.zeros(len(self.model.weight)), np.empty_like(motion.modes)

        def elements(part: slice) -> tuple[FloatArray, float, float]:
            start = time.perf_counter()
            chunk = chunk_of(body, part, tangents=False)
            update_points(body, strengths, motion, before, after, chunk, STABILISER)
            middle = time.perf_counter()
            forces = np.empty((len(chunk.volumes), 3 * chunk.gradients.shape[2]))
            point_forces(chunk, after.stress, forces)
            return forces, middle - start, time.perf_counter() - middle

        start, material, assembly = time.perf_counter(), 0.0, 0.0
        for part, (forces, first, second) in in_chunks(len(body.connectivity), elements):
            begin = time.perf_counter()
            add_forces(forces, body.connectivity[part], total)
            modes[part] = -forces[:, width:]
            material, assembly = material + first, assembly + second + time.perf_counter() - begin
        self._book(time.perf_counter() - start, material, assembly)
        springs, _ = spring_forces(self.model.support, motion.displacement, ground, loose=self._loose)
        unbalanced = self.model.weight - total - springs
        held = np.where(self._free, 0.0, -unbalanced) - springs
        least = ROUND_OFF * self._stiffness * float(np.abs(motion.displacement).max())
        scale = max(float(np.linalg.norm(held)), least)
        return Balance(held, np.where(self._free, unbalanced, 0.0), modes, scale)

    def assemble(
        self,
        motion: Motion,
        ground: FloatArray,
        strengths: Strengths,
        before: PointFields,
        after: PointFields,
        *,
        rested_on: FloatArray | None = None,
    ) -> None:
        """Forces and stiffness at a motion.

        Parameters
        ----------
        motion : Motion
        ground : (k, 3) float array, m
            Displacement of the ground under the base's points; those prescribed are yet to move there.
        strengths : Strengths
        before : PointFields
            State of the points at the end of the last step.
        after : PointFields
            Receives their new state.
        rested_on : (k, 3) float array, m, optional
            Where the ground was when the springs last held or let go; by default at `ground`.
        """
        body, sums, rows = self.model.body, self._sums, self.model.pattern.rows
        count, width = len(body.connectivity), 3 * body.connectivity.shape[1]
        for array in sums:
            array[:] = 0.0
        self._imposed = self._steps_to(motion, ground)

        def elements(part: slice) -> tuple[Condensed, float, float]:
            start = time.perf_counter()
            chunk = chunk_of(body, part, tangents=True)
            update_points(body, strengths, motion, before, after, chunk, STABILISER)
            middle = time.perf_counter()
            size = len(chunk.volumes)
            forces = np.empty((size, 3 * chunk.gradients.shape[2]))
            point_forces(chunk, after.stress, forces)
            matrices, condensed = np.empty((size, width, width)), np.empty((size, width))
            out = Condensed(matrices, condensed, self._follow[part], self._lag[part])
            tangent_matrices(chunk, body.law, forces, out)
            return out, middle - start, time.perf_counter() - middle

        start, material, assembly = time.perf_counter(), 0.0, 0.0
        for part, (out, first, second) in in_chunks(count, elements):
            begin = time.perf_counter()
            add_elements(out.matrices, out.forces, body.connectivity[part], rows, self._imposed, sums)
            material, assembly = material + first, assembly + second + time.perf_counter() - begin
        self._book(time.perf_counter() - start, material, assembly)
        springs, stiffness = spring_forces(
            self.model.support, motion.displacement, ground, loose=self._loose, rested_on=rested_on
        )
        self.unbalanced = self.model.weight - sums.forces - springs
        self._stiffen(stiffness)

    def newton_change(self) -> Motion:
        """Change of the motion in one iteration from the state that was assembled.

        Raises
        ------
        ConvergenceError
            If the tangent is singular.
        """
        start = time.perf_counter()
        load = (self.unbalanced - self._sums.pull)[self._free]
        change = self._imposed.copy()
        if len(load):
            values = self._sums.values
            # As long as nothing cracks, the matrix stays what it was, to the last digit.
            if not np.array_equal(values, self._factorised):
                self._factorised = np.zeros(0)
                self._solver.factorise(values)
                self._factorised = values.copy()
            change[self._free] = checked_solve(self._solver, self.model.pattern, values, load).solution
        self.clock.solve += time.perf_counter() - start
        connectivity = self.model.body.connectivity
        local = change.reshape(-1, 3)[connectivity].reshape(len(connectivity), -1)
        modes = -self._lag - np.einsum("eij,ej->ei", self._follow, local)
        return Motion(change.reshape(-1, 3), modes)

    def _book(self, elapsed: float, material: float, assembly: float) -> None:
        """Share out the time of a pass over the elements, on several cores, by what the cores did."""
        share = material / (material + assembly)
        self.clock.material += share * elapsed
        self.clock.assembly += (1.0 - share) * elapsed

    def _steps_to(self, motion: Motion, ground: FloatArray) -> FloatArray:
        """How far the prescribed displacements have yet to go, (3m,), m."""
        support = self.model.support
        steps = np.zeros_like(motion.displacement)
        steps[support.points] = ground - motion.displacement[support.points]
        return np.where(support.prescribed, steps.ravel(), 0.0)

    def _stiffen(self, springs: FloatArray) -> None:
        """Add the springs to the diagonal."""
        pattern = self.model.pattern
        held = np.flatnonzero((springs > 0.0) & self._free)
        self._sums.values[pattern.diagonal[pattern.equation[held]]] += springs[held]
