"""How an elastic wall's figures change as its elements are halved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.model import ElementKind, VolumeMesh
from solvers.fem.assembly import body_force, elastic_body
from solvers.fem.connectivity import FACETS
from solvers.fem.elements import HEXAHEDRON_CORNERS, ElementType, displacement_space, shape_functions
from solvers.fem.equilibrium import assemble, solve
from solvers.fem.stress import PointStress, point_stress, principal_stress, stress_measures
from solvers.ground.settlement import Settlement, base_displacement
from solvers.materials import Material
from structural.walls import PAPER, TROUGH, Case

FloatArray = NDArray[np.float64]

GRAVITY = 9.81
QUANTITIES = {
    "energy": "strain energy, J",
    "displacement": "largest displacement, mm",
    "thrust": "horizontal force under the left half, kN",
    "p99": "σ1, 99 % by volume, MPa",
    "rms": "σ1, root mean square, MPa",
    "box": "σ1 of the mean stress in the box, MPa",
    "peak": "largest σ1 at a point, MPa",
}


def halved(mesh: VolumeMesh) -> VolumeMesh:
    """Every 8-node hexahedron cut into eight by its trilinear map, with the group "base"."""
    import skfem

    lattice = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    values, _ = shape_functions(skfem.ElementHex1(), HEXAHEDRON_CORNERS, lattice.T)
    nodes = (values @ mesh.nodes[mesh.elements]).reshape(-1, 3)
    step = float(np.ptp(nodes, axis=0).max()) * 1e-8
    _, first, number = np.unique(
        np.round(nodes / step + 0.123).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    number = number.reshape(len(mesh.elements), 3, 3, 3)
    corners = HEXAHEDRON_CORNERS.astype(int)
    parts = [
        np.stack([number[:, i + a, j + b, k + c] for a, b, c in corners], axis=-1)
        for i, j, k in np.ndindex(2, 2, 2)
    ]
    elements = np.concatenate(parts)
    points = nodes[first]
    facets = elements[:, FACETS[mesh.kind]].reshape(-1, 4)
    base = facets[(points[facets][..., 2] < points[:, 2].min() + 1e-9).all(axis=1)]
    return VolumeMesh(points, elements, ElementKind.HEXAHEDRON, {"base": base})


def measure(
    mesh: VolumeMesh, settlement: Settlement, element: ElementType, box: FloatArray
) -> dict[str, float]:
    """Figures of an elastic wall tied to the ground, named as in `QUANTITIES`, in the units given there.

    Parameters
    ----------
    mesh : VolumeMesh
    settlement : Settlement
    element : ElementType
    box : (2, 3) float array, m
        Its corners.
    """
    material = Material()
    space = displacement_space(mesh, element)
    ends = float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
    held, moved = np.zeros((len(space.points), 3), dtype=bool), np.zeros((len(space.points), 3))
    held[space.base] = True
    moved[space.base] = base_displacement(settlement, space.points[space.base], extent=ends)
    force = body_force(space, [0.0, 0.0, -material.density * GRAVITY])
    state = solve(assemble(elastic_body(space, material), force, prescribed=held, values=moved))
    points = point_stress(space, material, displacement=state.displacement)
    settled = stress_measures(points, above=float(np.ptp(mesh.nodes[:, 1])))
    left = space.points[:, 0] < sum(ends) / 2
    return {
        "energy": state.strain_energy,
        "displacement": 1e3 * float(np.linalg.norm(state.displacement, axis=1).max()),
        "thrust": 1e-3 * float(state.reaction[left, 0].sum()),
        "p99": settled.p99 / 1e6,
        "rms": settled.rms / 1e6,
        "box": box_stress(points, box) / 1e6,
        "peak": float(principal_stress(points.stress)[..., 0].max()) / 1e6,
    }


def box_stress(points: PointStress, box: FloatArray) -> float:
    """σ1 of the mean stress in a box, Pa."""
    centre = points.location.mean(axis=1)
    inside = ((centre > box[0]) & (centre < box[1])).all(axis=1)
    mean = np.average(points.stress[inside].reshape(-1, 6), axis=0, weights=points.volume[inside].ravel())
    return float(principal_stress(mean)[0])


def element_box(mesh: VolumeMesh, x: float, z: float) -> FloatArray:
    """Corners (2, 3), m, of a box as large as the element at (x, z), and as thick as the wall."""
    ends = mesh.nodes[mesh.elements]
    low, high = ends.min(axis=1), ends.max(axis=1)
    at = (low[:, 0] < x) & (x < high[:, 0]) & (low[:, 2] < z) & (z < high[:, 2])
    box = np.array([low[at][0], high[at][0]])
    box[:, 1] = mesh.nodes[:, 1].min(), mesh.nodes[:, 1].max()
    return box


def observed_order(values: Sequence[float]) -> float:
    """Order of the last three values of a sequence on halved meshes; nan where they do not approach a limit.

    >>> round(observed_order([1.0 + 4.0, 1.0 + 1.0, 1.0 + 0.25]), 12)
    2.0
    """
    before, last = values[-2] - values[-3], values[-1] - values[-2]
    ratio = before / last if last else np.inf
    return float(np.log2(ratio)) if ratio > 1.0 else float("nan")


def grid_convergence_index(values: Sequence[float]) -> float:
    """Uncertainty of the last value, relative to it: 1.25 |e| / (2^p - 1) (Roache 1994), p as observed.

    >>> round(grid_convergence_index([5.0, 2.0, 1.25]), 12)
    0.25
    """
    order = observed_order(values)
    change = abs((values[-1] - values[-2]) / values[-1])
    return 1.25 * change / (2.0**order - 1.0)


@dataclass(frozen=True)
class Study:
    """A wall whose elements are halved; the box is an element of the coarsest mesh."""

    title: str
    case: Case
    element: ElementType
    corner: tuple[float, float]
    meshes: int


def run_study(study: Study) -> list[dict[str, float]]:
    """Figures on each mesh."""
    mesh = mesh_facade(study.case.facade(), options=MeshOptions(size=study.case.size))
    box, found = element_box(mesh, *study.corner), []
    for level in range(study.meshes):
        if level:
            mesh = halved(mesh)
        found.append(measure(mesh, study.case.settlement, study.element, box))
    return found


def study_table(found: Sequence[Mapping[str, float]]) -> str:
    """A table of Markdown."""
    heads = ["h", "h/2", "h/4", "h/8"][: len(found)]
    lines = [
        f"| | {' | '.join(heads)} | order | index |",
        f"|---|{'---:|' * (len(heads) + 2)}",
    ]
    for key, name in QUANTITIES.items():
        values = [figures[key] for figures in found]
        order, index = observed_order(values), grid_convergence_index(values)
        last = f"{order:.2f} | {100 * index:.2g} %" if np.isfinite(order) else "none | none"
        lines.append(f"| {name} | {' | '.join(f'{value:.5g}' for value in values)} | {last} |")
    return "\n".join(lines)


STUDY_TEXT = """\
Two elastic walls, tied to the ground; every element of the first mesh is cut into eight, and again.
"Order" is p of the last three meshes, log2 of the ratio of their differences; "index" is the grid
convergence index of the finest, 1.25 |e| / (2^p - 1) with the relative difference e to the one before
(Roache 1994). "None": the three do not come closer to one another, or not from one side. The box is an
element of the first mesh at a window's lower left corner, some 0.5 m wide.

Theory: at a right-angled re-entrant corner stresses grow as r^(-0.4555) (Williams 1952), whatever the
element. So energy, displacements and forces converge with 2 x 0.5445 = 1.09 in the end, and with more as
long as smooth parts of the error rule; a mean stress next to the corner as the displacements do; root
mean square and 99 %, which sample a field and leave the base out, by no single power. The largest σ1 has
no limit.
"""
STUDIES = (
    Study(
        "Building 1's stand-in under the paper's settlement, 20-node hexahedra, h = 0.5 m",
        Case("building1", 0.5, PAPER),
        ElementType.HEXAHEDRON20,
        (0.7, 3.6),
        3,
    ),
    Study(
        "The same, 8-node hexahedra with incompatible modes",
        Case("building1", 0.5, PAPER),
        ElementType.INCOMPATIBLE,
        (0.7, 3.6),
        3,
    ),
    Study(
        "A wall of 9 x 6 x 0.35 m with six windows and no door, over a trough of"
        " i = 5 m and 1 % volume loss, 20-node hexahedra, h = 0.5 m",
        Case("trough", 0.5, TROUGH),
        ElementType.HEXAHEDRON20,
        (0.75, 0.75),
        3,
    ),
    Study(
        "The same, 8-node hexahedra with incompatible modes",
        Case("trough", 0.5, TROUGH),
        ElementType.INCOMPATIBLE,
        (0.75, 0.75),
        3,
    ),
)
