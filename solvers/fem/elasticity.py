"""Linear elastic analysis of a facade: self-weight, and a base that the ground moves."""

import time
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError
from fd2fem.model import Response, VolumeMesh
from solvers.damage.record import damage_record
from solvers.fem.assembly import body_force, elastic_body
from solvers.fem.connectivity import check_supported
from solvers.fem.elements import ElementType, Space, displacement_space
from solvers.fem.equilibrium import Equilibrium, assemble, solve
from solvers.fem.feet import foot_records, wall_feet
from solvers.fem.stress import nodal_stress, point_stress, principal_stress, stress_measures
from solvers.ground.settlement import base_displacement, settlement_record
from solvers.options import AnalysisOptions, element_of

__all__ = ["analyse"]

LARGEST_IMBALANCE = 1e-8
"""Difference of the reaction from the weight, relative to the weight, above which a result is refused."""

ELEMENT_NAMES = {
    ElementType.HEXAHEDRON20: "20-node serendipity hexahedron",
    ElementType.INCOMPATIBLE: "8-node hexahedron with incompatible modes",
    ElementType.HEXAHEDRON8: "8-node hexahedron (locks in bending)",
    ElementType.TETRA10: "10-node tetrahedron",
}

FloatArray = NDArray[np.float64]


def analyse(mesh: VolumeMesh, *, options: AnalysisOptions | None = None) -> Response:
    """Linear elastic response to self-weight and then to the settlement of the base.

    The wall stands on a base at rest under its weight; then the base moves. Being linear, the sum of
    the two states is found in one solve.

    Parameters
    ----------
    mesh : VolumeMesh
        With a group "base".
    options : AnalysisOptions, optional
        By default the material and the settlement of the paper's Building 1.

    Returns
    -------
    response : Response

    Raises
    ------
    InputError
        If the mesh has no base, a part of it is loose, an element is folded, or the settlement is not
        of a plausible size.
    ConvergenceError
        If the solution leaves a residual, or the reaction does not balance the weight.

    Notes
    -----
    Small displacements and rotations; the stiffness is integrated by 27 points in a 20-node hexahedron, 8 in
    one of 8 nodes, 4 in a tetrahedron.
    """
    options = options or AnalysisOptions()
    check_supported(mesh)
    space = displacement_space(mesh, element_of(mesh.kind, options))
    ends = float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
    moved = base_displacement(options.settlement, space.points[space.base], extent=ends)
    prescribed, values = np.zeros((len(space.points), 3), dtype=bool), np.zeros((len(space.points), 3))
    prescribed[space.base], values[space.base] = True, moved

    start = time.perf_counter()
    force = body_force(space, [0.0, 0.0, -options.material.density * options.gravity])
    body = elastic_body(space, options.material)
    equations = assemble(body, force, prescribed=prescribed, values=values)
    assembled = time.perf_counter()
    state = solve(equations, solver=options.solver)
    solved = time.perf_counter()
    points = point_stress(space, options.material, displacement=state.displacement)
    stress = nodal_stress(mesh, points)
    principal = principal_stress(stress)
    thickness = float(np.ptp(mesh.nodes[:, 1]))
    measures = stress_measures(points, above=float(space.points[space.base, 2].min()) + thickness)
    ended = time.perf_counter()

    weight = abs(float(force[2::3].sum()))
    displacement = state.displacement[: len(mesh.nodes)]
    return Response(
        mesh=mesh,
        displacement=displacement,
        stress=stress,
        principal_stress=principal,
        reaction=state.reaction.sum(axis=0),
        weight=weight,
        max_displacement=float(np.linalg.norm(displacement, axis=1).max()),
        max_principal_stress=float(principal[:, 0].max()),
        p95_principal_stress=measures.p95,
        p99_principal_stress=measures.p99,
        rms_stress=measures.rms,
        strain_energy=state.strain_energy,
        dofs=space.unknowns,
        solver=_solver_record(space, state, options) | {"imbalance": _check_balance(state, weight)},
        feet=foot_records(wall_feet(mesh, space), state.reaction[space.base], weight=weight),
        damage=damage_record(mesh, options, displacement),
        timings={"assemble": assembled - start, "solve": solved - assembled, "stress": ended - solved},
    )


def _check_balance(state: Equilibrium, weight: float) -> float:
    """Distance of the reaction from the weight, relative to the weight.

    A weight of nothing, or less than rounding can tell from nothing, is replaced by the smallest one that
    the test is meaningful for.
    """
    scale = max(weight, state.round_off / LARGEST_IMBALANCE)
    difference = float(np.linalg.norm(state.reaction.sum(axis=0) - [0.0, 0.0, weight]))
    imbalance = difference / scale if scale > 0.0 else difference
    if not imbalance <= LARGEST_IMBALANCE:
        msg = (
            f"The reaction at the base differs from the weight of {weight:.6g} N by {imbalance:.2g} of it "
            f"(at most {LARGEST_IMBALANCE:.0e}): the solution is not in equilibrium."
        )
        raise ConvergenceError(msg)
    return imbalance


def _solver_record(space: Space, state: Equilibrium, options: AnalysisOptions) -> dict[str, Any]:
    """How the response was computed, as JSON values."""
    return {
        "name": state.solver,
        "law": "linear elastic",
        "element": ELEMENT_NAMES[space.element],
        "unknowns": space.unknowns - 3 * len(space.base),
        "relative_residual": state.relative_residual,
        "material": asdict(options.material),
        "settlement": settlement_record(options.settlement),
        "gravity": options.gravity,
    }
