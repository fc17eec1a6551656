"""Analysis of a wall in steps: masonry that cracks, or a base that follows the ground through springs."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from fd2fem.errors import ConvergenceError
from fd2fem.model import ElementKind, Response, VolumeMesh
from solvers.fem.connectivity import check_supported
from solvers.fem.feet import wall_feet
from solvers.ground.settlement import base_displacement
from solvers.masonry import MasonryLaw, check_band
from solvers.options import AnalysisOptions, element_of
from solvers.steps.course import Course, followed
from solvers.steps.masonry_response import masonry_response
from solvers.steps.nonlinear import apply_settlement
from solvers.steps.restart import fingerprint, read_state, write_state
from solvers.steps.step_analysis import StepAnalysis
from solvers.steps.stepping import Snapshot
from solvers.steps.supports import BaseKind
from solvers.steps.wall import wall_model
from solvers.steps.wall_model import Tangent, WallModel
from solvers.steps.wall_state import WallState, wall_state

__all__ = ["StepAnalysis", "analyse_steps", "prepare", "snapshots"]

UNBREAKABLE = MasonryLaw(
    tensile_strength=1e30, cohesion=1e30, fracture_energy=1e30, source="none: the wall is elastic"
)
TETRAHEDRA = (
    "cracks run zigzag through tetrahedra and take up to 15 % less than the fracture energy, in bending a "
    "third less: take hexahedra where cracks matter"
)
LARGEST_IMBALANCE = 1e-3
"""Difference of the reaction from the weight, relative to the weight, above which a result is refused."""
LEAST = 1.0
"""A wall that weighs less, N, and is pressed by less, is taken to carry nothing."""


def prepare(mesh: VolumeMesh, *, options: AnalysisOptions) -> StepAnalysis:
    """Check a wall and set up its equations.

    Raises
    ------
    InputError
        If the mesh has no base, a part of it is loose, an element is folded, or the settlement is not of a
        plausible size or does not cover the base.
    """
    check_supported(mesh)
    law = options.masonry or UNBREAKABLE
    if options.masonry is None and options.base.kind is not BaseKind.NO_TENSION:
        options = replace(options, stepping=replace(options.stepping, steps=1))
    model, space = wall_model(
        mesh,
        material=options.material,
        law=law,
        gravity=options.gravity,
        base=options.base,
        element=element_of(mesh.kind, options),
    )
    ends = float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
    return StepAnalysis(
        mesh=mesh,
        options=options,
        law=law,
        space=space,
        tangent=Tangent(model, solver=options.solver),
        feet=wall_feet(mesh, space),
        settled=base_displacement(options.settlement, space.points[space.base], extent=ends),
        warnings=_warnings(mesh, options, model),
    )


def _warnings(mesh: VolumeMesh, options: AnalysisOptions, model: WallModel) -> tuple[str, ...]:
    """What must be said of elements that are to crack."""
    if options.masonry is None:
        return ()
    wide = check_band(options.material, options.masonry, model.band)
    return (*wide, TETRAHEDRA) if mesh.kind is ElementKind.TETRA10 else wide


def snapshots(analysis: StepAnalysis, *, state: Path | None = None) -> Iterator[Snapshot]:
    """The states of an analysis, one after the other.

    Parameters
    ----------
    analysis : StepAnalysis
    state : Path, optional
        File that each step is written to. If it exists, the analysis goes on from there, and the first state
        is the one that was read.

    Raises
    ------
    InputError
        If the file is damaged, or belongs to another mesh or other options.
    ConvergenceError
        If a step finds no equilibrium.
    """
    for snapshot, _ in _states(analysis, state):
        yield snapshot


def _states(analysis: StepAnalysis, state: Path | None) -> Iterator[tuple[Snapshot, Course]]:
    """As `snapshots`, with the course up to each state."""
    key = fingerprint(analysis.tangent.model, analysis.settled, analysis.options)
    start, course = None, None
    if state is not None and state.exists():
        start, course = read_state(state, key)
        yield start, course
    steps = apply_settlement(
        analysis.tangent.model,
        analysis.law,
        lambda share: share * analysis.settled,
        options=analysis.options.stepping,
        start=start,
        tangent=analysis.tangent,
    )
    for snapshot in steps:
        course = followed(course, snapshot, analysis.tangent.model, analysis.feet)
        if state is not None:
            write_state(state, snapshot, course, key)
        yield snapshot, course


def analyse_steps(
    mesh: VolumeMesh,
    *,
    options: AnalysisOptions,
    state: Path | None = None,
    on_step: Callable[[WallState], None] | None = None,
) -> Response:
    """Response to self-weight and then to the settlement, applied in steps.

    Parameters
    ----------
    mesh : VolumeMesh
        With a group "base".
    options : AnalysisOptions
    state : Path, optional
        File that each step is written to, and from which a stopped analysis goes on with the same answer. The
        caller removes it when the results are safe.
    on_step : callable, optional
        Called with the state of the wall after each step.

    Returns
    -------
    response : Response

    Raises
    ------
    InputError
        If the mesh, the settlement or the file at `state` is at fault.
    ConvergenceError
        If a step finds no equilibrium; says how much of the settlement was reached.
    """
    begin = time.perf_counter()
    analysis = prepare(mesh, options=options)
    found: tuple[Snapshot, Course] | None = None
    for found in _states(analysis, state):
        if on_step is not None:
            on_step(_view(analysis, found[0]))
    if found is None or found[0].share < 1.0 - 1e-12:
        msg = "The analysis ended before the whole settlement was applied."
        raise ConvergenceError(msg)
    last, course = found
    _check_balance(analysis, last)
    begin_results = time.perf_counter()
    response = masonry_response(analysis, _view(analysis, last), last, course)
    clock, end = analysis.tangent.clock, time.perf_counter()
    parts = {"material": clock.material, "assembly": clock.assembly, "solve": clock.solve}
    results = end - begin_results
    other = end - begin - results - sum(parts.values())
    return replace(response, timings=parts | {"results": results, "other": other})


def _view(analysis: StepAnalysis, snapshot: Snapshot) -> WallState:
    return wall_state(analysis.mesh, analysis.space, analysis.tangent.model, analysis.law, snapshot)


def _check_balance(analysis: StepAnalysis, last: Snapshot) -> None:
    """Refuse a result whose reaction does not balance the weight."""
    weight = -analysis.tangent.model.weight.reshape(-1, 3).sum(axis=0)
    difference = float(np.linalg.norm(np.array(last.history[-1].reaction) - weight))
    forces = float(np.abs(last.force - analysis.tangent.model.weight).sum())
    if difference > LARGEST_IMBALANCE * max(float(np.linalg.norm(weight)), forces, LEAST):
        msg = (
            f"The reaction at the base differs from the weight of {weight[2]:.6g} N by {difference:.2g} N: "
            "the solution is not in equilibrium."
        )
        raise ConvergenceError(msg)
