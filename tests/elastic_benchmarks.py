"""Classical benchmarks of linear elasticity; each returns its quantity in SI.

The grids are meant for 20-node hexahedra. 8-node ones with incompatible modes are half as large, so that they
have about as many nodes; tetrahedra are cut from the grid, six from a brick.
"""

from collections.abc import Sequence

import numpy as np
from mapped_grids import Mapping3, graded, mapped_mesh
from mapped_tetrahedra import mapped_tetrahedra
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers import AnalysisOptions, base_displacement
from solvers.fem.assembly import body_force, elastic_body
from solvers.fem.elements import HEXAHEDRON_CORNERS, ElementType, displacement_space
from solvers.fem.equilibrium import assemble, solve
from solvers.fem.facet_loads import pressure_forces
from solvers.fem.rules import stiffness_order
from solvers.fem.stress import nodal_stress, point_stress, principal_stress
from solvers.fem.thermal_loads import held_stress, thermal_forces
from solvers.materials import Material

FloatArray = NDArray[np.float64]

STEEL = Material(young=210e9, poisson=0.3, density=7850.0, source="NAFEMS")
QUADRATIC = ElementType.HEXAHEDRON20
NEAR = 1e-9


class Held:
    """Displacement components that are held at zero."""

    def __init__(self, mesh: VolumeMesh) -> None:
        self.nodes = mesh.nodes
        self.components = np.zeros((len(mesh.nodes), 3), dtype=bool)

    def plane(self, axis: int, value: float, *components: int) -> None:
        """Hold components of all nodes on a plane."""
        on = np.abs(self.nodes[:, axis] - value) < NEAR
        for component in components:
            self.components[on, component] = True


def grid_mesh(planes: Sequence[ArrayLike], mapping: Mapping3, element: ElementType) -> VolumeMesh:
    """Mesh of a mapped grid."""
    if element is ElementType.TETRA10:
        return mapped_tetrahedra(planes, mapping)
    if element is QUADRATIC:
        return mapped_mesh(planes, mapping, kind=ElementKind.HEXAHEDRON20)
    counts = [len(np.asarray(p)) for p in planes]
    halves = [
        np.interp(np.arange(2 * n - 1) / 2, np.arange(n), p) for n, p in zip(counts, planes, strict=True)
    ]
    return mapped_mesh(halves, mapping, kind=ElementKind.HEXAHEDRON)


def elastic_stress(mesh: VolumeMesh, force: FloatArray, held: Held, element: ElementType) -> FloatArray:
    """Stress (n, 6), Pa, at the nodes."""
    space = displacement_space(mesh, element)
    values = np.zeros((len(mesh.nodes), 3))
    state = solve(assemble(elastic_body(space, STEEL), force, prescribed=held.components, values=values))
    return nodal_stress(mesh, point_stress(space, STEEL, displacement=state.displacement))


def at_point(mesh: VolumeMesh, *where: float) -> int:
    """The node at a point."""
    distance = np.linalg.norm(mesh.nodes - where, axis=1)
    node = int(distance.argmin())
    assert distance[node] < NEAR
    return node


def elliptic_plate(layers: FloatArray, element: ElementType) -> VolumeMesh:
    """Quarter of a plate between the ellipses (2, 1) and (3.25, 2.75) m, with these planes across it, m."""

    def mapping(grid: FloatArray) -> FloatArray:
        u, angle, w = grid.T
        x, y = np.cos(angle) * (2.0 + 1.25 * u), np.sin(angle) * (1.0 + 1.75 * u)
        return np.column_stack([x, y, w])

    # Finer towards D, where the stress is wanted.
    planes = graded(0, 1, 10, 6.0), graded(0, np.pi / 2, 12, 6.0), layers
    return grid_mesh(planes, mapping, element)


def nafems_le1(element: ElementType = QUADRATIC) -> float:
    """Elliptic membrane under an outward pressure of 10 MPa: stress yy at D = (2, 0)."""
    mesh = elliptic_plate(np.array([0.0, 0.1]), element)
    held = Held(mesh)
    held.plane(0, 0.0, 0)
    held.plane(1, 0.0, 1)
    held.plane(2, 0.0, 2)
    stress = elastic_stress(mesh, pressure_forces(mesh, "u1", -10e6), held, element)
    return float(stress[at_point(mesh, 2.0, 0.0, 0.0), 1])


def nafems_le10(element: ElementType = QUADRATIC) -> float:
    """Thick elliptic plate under a pressure of 1 MPa on its top: stress yy at D = (2, 0, 0.6)."""
    # Finer towards both faces: stresses are extrapolated to them.
    half = graded(0, 0.3, 5, 0.15)
    mesh = elliptic_plate(0.3 + np.concatenate([-half[::-1], half[1:]]), element)
    held = Held(mesh)
    held.plane(0, 0.0, 0)
    held.plane(1, 0.0, 1)
    outer = mesh.group_nodes("u1")
    held.components[outer, :2] = True
    held.components[outer[np.abs(mesh.nodes[outer, 2] - 0.3) < NEAR], 2] = True
    stress = elastic_stress(mesh, pressure_forces(mesh, "w1", 1e6), held, element)
    return float(stress[at_point(mesh, 2.0, 0.0, 0.6), 1])


def nafems_le11(element: ElementType = QUADRATIC) -> float:
    """Cylinder, taper and sphere heated by r + z: stress zz at A = (1, 0, 0)."""
    # Inner and outer contour (r, z) at v = 0 to 4: two arcs about the origin, then straight lines.
    corner = np.sqrt(0.5)
    lines = {
        False: np.array([[corner, corner], [corner, (corner + 1.79) / 2], [corner, 1.79]]),
        True: np.array([[1.2124356, 0.7], [1.1062178, 1.045], [1.0, 1.39], [1.0, 1.79]]),
    }

    def contour(v: FloatArray, outer: bool) -> FloatArray:
        arc, radius, end = (1.0, 1.4, np.pi / 6) if outer else (2.0, 1.0, np.pi / 4)
        angle = np.minimum(v / arc, 1.0) * end
        points = lines[outer]
        straight = [np.interp(v - arc, np.arange(len(points)), points[:, i]) for i in range(2)]
        on_arc = radius * np.cos(angle), radius * np.sin(angle)
        return np.column_stack([np.where(v <= arc, a, s) for a, s in zip(on_arc, straight, strict=True)])

    def mapping(grid: FloatArray) -> FloatArray:
        u, v, angle = grid.T
        section = (1 - u)[:, None] * contour(v, False) + u[:, None] * contour(v, True)
        return np.column_stack([section[:, 0] * np.cos(angle), section[:, 0] * np.sin(angle), section[:, 1]])

    along = np.concatenate([graded(0, 1, 8, 4.0), np.linspace(1, 4, 13)[1:]])
    # u, angle, v is right-handed.
    swapped = lambda grid: mapping(grid[:, [0, 2, 1]])  # noqa: E731
    mesh = grid_mesh((graded(0, 1, 6, 3.0), np.linspace(0, np.pi / 2, 9), along), swapped, element)
    held = Held(mesh)
    held.plane(0, 0.0, 0)
    held.plane(1, 0.0, 1)
    held.plane(2, 0.0, 2)
    held.plane(2, 1.79, 2)
    space = displacement_space(mesh, element)
    temperature = np.hypot(*mesh.nodes[:, :2].T) + mesh.nodes[:, 2]
    force = thermal_forces(space, STEEL, temperature, expansion=2.3e-4)
    zeros = np.zeros((len(mesh.nodes), 3))
    state = solve(assemble(elastic_body(space, STEEL), force, prescribed=held.components, values=zeros))
    points = point_stress(space, STEEL, displacement=state.displacement)
    points.stress[:] += held_stress(space, STEEL, temperature, expansion=2.3e-4)
    return float(nodal_stress(mesh, points)[at_point(mesh, 1.0, 0.0, 0.0), 2])


PLATE_HALF = 0.5
"""Half the thickness of the plate with a hole, over the hole's radius; it is in plane strain."""


def kirsch(element: ElementType = QUADRATIC) -> float:
    """Plate with a hole of the radius 1 m, pulled along x by 1 Pa far away: largest stress at the hole.

    The exact displacements are imposed at four radii, so that the plate is infinite.
    """

    def mapping(grid: FloatArray) -> FloatArray:
        radius, angle, y = grid.T
        return np.column_stack([radius * np.cos(angle), y, radius * np.sin(angle)])

    planes = graded(1.0, 4.0, 12, 10.0), [0.0, PLATE_HALF], np.linspace(0, np.pi / 2, 17)
    swapped = lambda grid: mapping(grid[:, [0, 2, 1]])  # noqa: E731
    mesh = grid_mesh(planes, swapped, element)
    held, exact = Held(mesh), _kirsch_displacement(mesh.nodes)
    held.components[:, 1] = True
    held.plane(0, 0.0, 0)
    held.plane(2, 0.0, 2)
    held.components[mesh.group_nodes("u1")] = True
    values = np.where(held.components, exact, 0.0)
    space = displacement_space(mesh, element)
    equations = assemble(
        elastic_body(space, STEEL), np.zeros(3 * len(values)), prescribed=held.components, values=values
    )
    state = solve(equations)
    stress = nodal_stress(mesh, point_stress(space, STEEL, displacement=state.displacement))
    return float(stress[at_point(mesh, 0.0, 0.0, 1.0), 0])


def _kirsch_displacement(nodes: FloatArray) -> FloatArray:
    """Displacement (n, 3) of Kirsch's solution: unit stress along x, unit radius, plane strain."""
    r, angle = np.hypot(nodes[:, 0], nodes[:, 2]), np.arctan2(nodes[:, 2], nodes[:, 0])
    kappa, shear = 3.0 - 4.0 * STEEL.poisson, STEEL.young / (2.0 * (1.0 + STEEL.poisson))
    cosine, sine, cosine3, sine3 = np.cos(angle), np.sin(angle), np.cos(3 * angle), np.sin(3 * angle)
    x = r * (kappa + 1) * cosine + 2 / r * ((1 + kappa) * cosine + cosine3) - 2 / r**3 * cosine3
    z = r * (kappa - 3) * sine + 2 / r * ((1 - kappa) * sine + sine3) - 2 / r**3 * sine3
    return np.asarray(np.column_stack([x, np.zeros_like(x), z]) / (8.0 * shear))


def patch_test(inner: ArrayLike, element: ElementType) -> FloatArray:
    """Stress (e, q, 6), Pa, in the cube of MacNeal and Harder with these inner nodes (8, 3), E = 1 MPa.

    A warped brick inside, one more between it and each side of the unit cube.
    """
    sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    # Seen from inside, an outer side runs clockwise about its outward normal: it is its brick's bottom.
    around = [[*side[::-1], *(8 + np.array(side[::-1]))] for side in sides]
    mesh = VolumeMesh(
        np.vstack([HEXAHEDRON_CORNERS, inner]),
        np.array([np.arange(8, 16), *around]),
        ElementKind.HEXAHEDRON,
        {"base": np.array([[0, 3, 2, 1]])},
    )
    space = displacement_space(mesh, element)
    outside = ((space.points < NEAR) | (space.points > 1 - NEAR)).any(axis=1)
    exact = 1e-3 * space.points @ np.array([[2, 1, 1], [1, 2, 1], [1, 1, 2]]) / 2
    material = Material(young=1e6, poisson=0.25)
    held = np.repeat(outside[:, None], 3, axis=1)
    state = solve(assemble(elastic_body(space, material), np.zeros(held.size), prescribed=held, values=exact))
    return point_stress(space, material, displacement=state.displacement).stress


def cantilever(element: ElementType, count: int) -> float:
    """Tip deflection of a beam of `count` elements over its depth, over Timoshenko's.

    Cubes, but for two more elements across; ν = 0; a load spread over the length, which is ten depths:
    q L⁴ / 8 E I + q L² / 2 κ G A, κ = 5/6.
    """
    length, depth, width, load = 10.0, 1.0, 0.5, 1000.0
    material = Material(young=STEEL.young, poisson=0.0)
    planes = np.linspace(0, depth, count + 1), [0.0, width], np.linspace(0, length, 10 * count + 1)
    if element is ElementType.TETRA10:
        mesh = mapped_tetrahedra(planes, lambda grid: grid)
    else:
        mesh = mapped_mesh(planes, lambda grid: grid, kind=ElementKind.HEXAHEDRON)
    space = displacement_space(mesh, element)
    held, zeros = np.zeros((len(space.points), 3), dtype=bool), np.zeros((len(space.points), 3))
    held[space.base] = True
    force = body_force(space, [load / (depth * width), 0.0, 0.0])
    state = solve(assemble(elastic_body(space, material), force, prescribed=held, values=zeros))
    inertia, shear = width * depth**3 / 12, material.young / 2
    bent = load * length**4 / (8 * material.young * inertia)
    sheared = load * length**2 / (2 * 5 / 6 * shear * depth * width)
    tip = state.displacement[np.abs(space.points[:, 2] - length) < NEAR, 0].mean()
    return float(tip / (bent + sheared))


def wall_state(
    mesh: VolumeMesh, options: AnalysisOptions, places: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Displacement (n, 3), m, at the nodes of a settled wall, and stress (k, 6), Pa, at integration points.

    The points are those nearest to `places` (k, 3).
    """
    material, x = options.material, mesh.nodes[:, 0]
    space = displacement_space(mesh, options.element or QUADRATIC)
    held, moved = np.zeros((len(space.points), 3), dtype=bool), np.zeros((len(space.points), 3))
    held[space.base] = True
    ends = float(x.min()), float(x.max())
    moved[space.base] = base_displacement(options.settlement, space.points[space.base], extent=ends)
    force = body_force(space, [0.0, 0.0, -material.density * options.gravity])
    state = solve(assemble(elastic_body(space, material), force, prescribed=held, values=moved))
    points = point_stress(space, material, displacement=state.displacement, order=stiffness_order(space))
    distance = np.linalg.norm(points.location.reshape(-1, 1, 3) - places, axis=2)
    assert distance.min(axis=0).max() < 1e-5
    return state.displacement[: len(mesh.nodes)], points.stress.reshape(-1, 6)[distance.argmin(axis=0)]


def corner_growth(divisions: int) -> float:
    """By how much the peak stress at a re-entrant corner grows when the elements are halved.

    An L of 2 x 2 m in plane strain, its arms `divisions` elements wide at first, pulled at both ends.
    """
    peaks = [_corner_peak(divisions), _corner_peak(2 * divisions)]
    return peaks[1] / peaks[0]


def _corner_peak(divisions: int) -> float:
    """Largest first principal stress at an integration point of the L, Pa."""
    planes = np.linspace(0, 2, 2 * divisions + 1)
    square = mapped_mesh((planes, [0, 1 / divisions], planes), lambda grid: grid, kind=ElementKind.HEXAHEDRON)
    centre = square.nodes[square.elements].mean(axis=1)
    elements = square.elements[(centre[:, 0] < 1) | (centre[:, 2] < 1)]
    used, numbered = np.unique(elements, return_inverse=True)
    nodes, numbered = square.nodes[used], numbered.reshape(elements.shape)
    base = {"base": numbered[:1, :4]}
    mesh = VolumeMesh(nodes, numbered, ElementKind.HEXAHEDRON, base)
    held, values = Held(mesh), np.zeros((len(nodes), 3))
    held.components[:, 1] = True
    for axis in (0, 2):
        held.plane(axis, 0.0, axis)
        held.plane(axis, 2.0, axis)
        values[np.abs(nodes[:, axis] - 2.0) < NEAR, axis] = 1e-3
    space = displacement_space(mesh, ElementType.INCOMPATIBLE)
    state = solve(
        assemble(elastic_body(space, STEEL), np.zeros(values.size), prescribed=held.components, values=values)
    )
    stress = point_stress(space, STEEL, displacement=state.displacement).stress
    return float(principal_stress(stress)[..., 0].max())
