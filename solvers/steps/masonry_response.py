"""The response of a wall that was analysed in steps."""

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Response, VolumeMesh
from solvers.damage.bays import bay_strain
from solvers.damage.classes import assess_damage, assessment_to_dict
from solvers.damage.cracks import crack_widths
from solvers.damage.equivalent_beam import beam_check_to_dict, equivalent_beam_check
from solvers.fem.elements import Space
from solvers.fem.stress import PointStress, StressMeasures, principal_stress, stress_measures
from solvers.ground.settlement import settlement_record
from solvers.options import AnalysisOptions
from solvers.steps.stepping import Snapshot
from solvers.steps.wall_model import Tangent, WallModel
from solvers.steps.wall_state import WallState

__all__ = ["damage_record", "masonry_response"]

FloatArray = NDArray[np.float64]


def masonry_response(
    mesh: VolumeMesh,
    space: Space,
    tangent: Tangent,
    options: AnalysisOptions,
    view: WallState,
    last: Snapshot,
    warnings: tuple[str, ...],
) -> Response:
    """Response from the last state.

    Parameters
    ----------
    mesh : VolumeMesh
    space : Space
    tangent : Tangent
    options : AnalysisOptions
    view : WallState
        Of the snapshot `last`.
    last : Snapshot
    warnings : tuple of str
    """
    model, record = tangent.model, view.record
    principal = principal_stress(view.stress)
    measures = _measures(mesh, space, model, last)
    damage = damage_record(mesh, options, view.displacement, view.cracks.opening)
    return Response(
        mesh=mesh,
        displacement=view.displacement,
        stress=view.stress,
        principal_stress=principal,
        reaction=np.array(record.reaction),
        weight=abs(float(model.weight[2::3].sum())),
        max_displacement=float(np.linalg.norm(view.displacement, axis=1).max()),
        max_principal_stress=view.largest_stress,
        p95_principal_stress=measures.p95,
        p99_principal_stress=measures.p99,
        rms_stress=measures.rms,
        strain_energy=record.strain_energy,
        dissipated_energy=record.dissipated_energy,
        max_crack_opening=float(view.cracks.opening.max()),
        damage_class=damage["crack_class"] if options.masonry else -1,
        dofs=space.unknowns,
        solver=_solver_record(space, tangent, options, last) | {"warnings": list(warnings)},
        crack_opening=view.cracks.opening,
        crack_normal=view.cracks.normal,
        dissipation=view.dissipation,
        history=tuple(asdict(step) | {"reaction": list(step.reaction)} for step in last.history),
        damage=damage,
    )


def _measures(mesh: VolumeMesh, space: Space, model: WallModel, last: Snapshot) -> StressMeasures:
    """What of the stresses converges with the mesh."""
    location = model.body.rule.values @ space.points[space.connectivity]
    points = PointStress(stress=last.fields.stress, volume=model.volumes, location=location)
    thickness = float(np.ptp(mesh.nodes[:, 1]))
    return stress_measures(points, above=float(space.points[space.base, 2].min()) + thickness)


def damage_record(
    mesh: VolumeMesh, options: AnalysisOptions, displacement: FloatArray, opening: FloatArray
) -> dict[str, Any]:
    """Classes of damage by strain and by cracks, with the equivalent beam beside them, as JSON values.

    Parameters
    ----------
    mesh : VolumeMesh
    options : AnalysisOptions
    displacement : (n, 3) float array, m
    opening : (e,) float array, m
        Of the cracks.
    """
    widths = crack_widths(mesh, opening)
    damage = assess_damage(
        tensile_strain=bay_strain(mesh, displacement),
        crack_widths=widths if len(widths) else opening.max(keepdims=True),
    )
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    beam = equivalent_beam_check(
        options.settlement,
        extent=(float(low[0]), float(high[0])),
        height=float(high[2] - low[2]),
        poisson=options.material.poisson,
        e_over_g=2.0 * (1.0 + options.material.poisson),
    )
    return assessment_to_dict(damage) | {
        "visible_cracks": len(widths),
        "equivalent_beam": beam_check_to_dict(beam),
    }


def _solver_record(
    space: Space, tangent: Tangent, options: AnalysisOptions, last: Snapshot
) -> dict[str, Any]:
    """How the response was computed, as JSON values."""
    model, history = tangent.model, last.history
    weight = -model.weight.reshape(-1, 3).sum(axis=0)
    scale = max(float(np.linalg.norm(weight)), float(np.finfo(float).tiny))
    difference = float(np.linalg.norm(np.array(history[-1].reaction) - weight))
    return {
        "name": tangent.solver_name,
        "law": "Drucker-Prager with a softening tensile cut-off" if options.masonry else "linear elastic",
        "element": space.element.value,
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
