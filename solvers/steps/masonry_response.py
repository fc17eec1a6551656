"""The response of a wall that was analysed in steps."""

from dataclasses import asdict
from typing import Any

import numpy as np

from fd2fem.model import Response
from solvers.damage.record import damage_record
from solvers.fem.feet import foot_records
from solvers.fem.stress import PointStress, StressMeasures, principal_stress, stress_measures
from solvers.ground.settlement import settlement_record
from solvers.steps.course import Course, ground_forces
from solvers.steps.step_analysis import StepAnalysis
from solvers.steps.stepping import LoadStep, Snapshot
from solvers.steps.wall_state import WallState

__all__ = ["masonry_response", "snap_warning"]

SNAP = 0.05
"""Part of the work above which energy that no strain or crack accounts for is told of."""


def masonry_response(analysis: StepAnalysis, view: WallState, last: Snapshot, course: Course) -> Response:
    """Response from the last state.

    Parameters
    ----------
    analysis : StepAnalysis
    view : WallState
        Of the snapshot `last`.
    last : Snapshot
    course : Course
        Up to it.
    """
    model, options, record = analysis.tangent.model, analysis.options, view.record
    measures, strength = _measures(analysis, last), analysis.law.tensile_strength
    opening = view.cracks.opening
    damage = damage_record(analysis.mesh, options, view.displacement, opening if options.masonry else None)
    weight = abs(float(model.weight[2::3].sum()))
    return Response(
        mesh=analysis.mesh,
        displacement=view.displacement,
        stress=view.stress,
        principal_stress=principal_stress(view.stress),
        reaction=np.array(record.reaction),
        weight=weight,
        max_displacement=float(np.linalg.norm(view.displacement, axis=1).max()),
        max_principal_stress=max(step.max_principal_stress for step in last.history),
        final_principal_stress=record.max_principal_stress,
        p95_principal_stress=measures.p95,
        p99_principal_stress=measures.p99,
        rms_stress=measures.rms,
        strain_energy=record.strain_energy,
        dissipated_energy=record.dissipated_energy,
        max_crack_opening=float(opening.max()),
        damage_class=damage.get("crack_class", -1),
        dofs=analysis.space.unknowns,
        solver=_solver_record(analysis, last)
        | {"warnings": [*analysis.warnings, *snap_warning(last.history)]},
        crack_opening=opening,
        crack_normal=view.cracks.normal,
        dissipation=view.dissipation,
        largest_stress=np.minimum(course.largest_stress, strength),
        feet=foot_records(analysis.feet, ground_forces(last, model), weight=weight),
        history=_history(analysis, last, course),
        damage=damage,
    )


def snap_warning(history: tuple[LoadStep, ...]) -> tuple[str, ...]:
    """A warning if much of the work went neither into strain nor into cracks: they ran, and set it free."""
    free = np.array([s.external_work - s.strain_energy - s.dissipated_energy for s in history])
    work = history[-1].external_work
    if not free[-1] > SNAP * work:
        return ()
    share = history[1 + int(np.diff(free).argmax())].share
    return (
        f"{100.0 * free[-1] / work:.0f} % of the work of weight and ground was set free as motion, most "
        f"of it at {100.0 * share:.1f} % of the settlement: cracks ran there at once, or the steps are too "
        "large (try more); beyond, the wall is in one of several states that it may jump to",
    )


def _history(analysis: StepAnalysis, last: Snapshot, course: Course) -> tuple[dict[str, Any], ...]:
    """What each step found, with the ground's settlement, m, and the forces on the feet, N; JSON values."""
    deepest = max(0.0, float(-analysis.settled[:, 2].min()))
    return tuple(
        asdict(step)
        | {"settlement": step.share * deepest, "reaction": list(step.reaction), "feet": forces.tolist()}
        for step, forces in zip(last.history, course.feet, strict=True)
    )


def _measures(analysis: StepAnalysis, last: Snapshot) -> StressMeasures:
    """What of the stresses converges with the mesh."""
    model, space = analysis.tangent.model, analysis.space
    location = model.body.rule.values @ space.points[space.connectivity]
    points = PointStress(stress=last.fields.stress, volume=model.volumes, location=location)
    thickness = float(np.ptp(analysis.mesh.nodes[:, 1]))
    return stress_measures(points, above=float(space.points[space.base, 2].min()) + thickness)


def _solver_record(analysis: StepAnalysis, last: Snapshot) -> dict[str, Any]:
    """How the response was computed, as JSON values."""
    model, options, history = analysis.tangent.model, analysis.options, last.history
    weight = -model.weight.reshape(-1, 3).sum(axis=0)
    scale = max(float(np.linalg.norm(weight)), float(np.finfo(float).tiny))
    difference = float(np.linalg.norm(np.array(history[-1].reaction) - weight))
    return {
        "name": analysis.tangent.solver_name,
        "law": "Drucker-Prager with a softening tensile cut-off" if options.masonry else "linear elastic",
        "element": analysis.space.element.value,
        "unknowns": model.pattern.unknowns,
        "relative_residual": history[-1].residual,
        "imbalance": difference / scale if scale > 1.0 else 0.0,
        "steps": len(history) - 1,
        "iterations": sum(step.iterations for step in history),
        "max_principal_stress_at_points_pa": history[-1].max_principal_stress,
        "max_principal_stress_of_all_steps_pa": max(step.max_principal_stress for step in history),
        "band_m": [float(model.band.min()), float(model.band.max())],
        "material": asdict(options.material),
        "masonry": asdict(options.masonry) if options.masonry else None,
        "base": asdict(options.base),
        "stepping": asdict(options.stepping),
        "settlement": settlement_record(options.settlement),
        "gravity": options.gravity,
    }
