"""Benchmarks of structures that crack or yield; each returns its quantity in SI."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from mapped_grids import graded, joined, mapped_mesh
from material_point import LAW, MASONRY, MATERIAL, NEVER, cone_value
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh
from solvers.compiled.cracking import Body, Motion, PointFields, Strengths
from solvers.compiled.pattern import build_pattern
from solvers.compiled.stiffness import Rule, element_gradients, element_volumes
from solvers.fem.assembly import elastic_body
from solvers.fem.elements import STIFFNESS_ORDER, displacement_space
from solvers.fem.equilibrium import assemble, solve
from solvers.fem.facet_loads import pressure_forces
from solvers.fem.rules import element_rule, incompatible_rule
from solvers.fem.stress import point_stress, principal_stress
from solvers.masonry import FLOOR, MasonryLaw, point_law
from solvers.materials import Material
from solvers.steps.nonlinear import apply_settlement, at_rest
from solvers.steps.stepping import Snapshot, SteppingOptions
from solvers.steps.supports import Support
from solvers.steps.wall_model import Tangent, WallModel

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def loaded_model(
    mesh: VolumeMesh, material: Material, law: MasonryLaw, held: BoolArray, force: FloatArray | None = None
) -> WallModel:
    """A body whose components `held` (n, 3) are prescribed, under nodal forces (3n,), N."""
    hexahedron20 = mesh.kind is ElementKind.HEXAHEDRON20
    rule: Rule = element_rule(mesh.kind, STIFFNESS_ORDER[mesh.kind]) if hexahedron20 else incompatible_rule()
    points, elements = mesh.nodes.copy(), mesh.elements.copy()
    prescribed = held.ravel()
    return WallModel(
        body=Body(points, elements, rule, point_law(material, law)),
        pattern=build_pattern(elements, points=len(points), prescribed=prescribed, upper=False),
        support=Support(
            points=np.flatnonzero(held.any(axis=1)),
            prescribed=prescribed,
            springs=np.zeros(held.size),
            lifts=False,
        ),
        weight=np.zeros(held.size) if force is None else force,
        volumes=element_volumes(points, elements, rule),
    )


def nodal_forces(model: WallModel, stress: FloatArray) -> FloatArray:
    """Forces (n, 3), N, that hold a body with stresses (e, q, 6), Pa, in its points: the sum of Bᵀ s dV."""
    body, forces = model.body, np.zeros((len(model.body.points), 3))
    count, modes = body.rule.gradients.shape[2], body.rule.modes.shape[2]
    g, volumes = np.empty((len(body.rule.weights), count + modes, 3)), np.empty(len(body.rule.weights))
    tensors = stress[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*stress.shape[:2], 3, 3)
    for nodes, tensor in zip(body.connectivity, tensors, strict=True):
        element_gradients(body.points[nodes], body.rule, g, volumes)
        forces[nodes] += np.einsum("q,qbj,qij->bi", volumes, g[:, :count], tensor)
    return forces


@dataclass(frozen=True)
class BarResult:
    """Energy per crack area, J/m²: dissipated in the points, and the work of the force at the end."""

    dissipated: float
    work: float


WEAK = 0.05
"""Part of its strength, and with it of its energy, that one element has already lost: it cracks first."""


def crack_band_bar(band: float, options: SteppingOptions) -> BarResult:
    """A bar of cubes `band` wide and 200 mm long, pulled until it is broken."""
    count = round(0.2 / band)
    planes = np.linspace(0, 0.2, count + 1), [0, band], [0, band]
    mesh = mapped_mesh(planes, lambda grid: grid, kind=ElementKind.HEXAHEDRON)
    x, y, z = mesh.nodes.T
    held = np.column_stack([(x == 0) | (x == x.max()), y == 0, z == 0])
    material = replace(MATERIAL, poisson=0.0)
    model = loaded_model(mesh, material, MASONRY, held)
    start = at_rest(model)
    ductility = MASONRY.fracture_energy / (band * MASONRY.tensile_strength)
    start.fields.kappa[0] = start.kappa_before[0] = -np.log(1.0 - WEAK) * ductility
    # Where the strength has come down to its floor.
    stretch = 7.0 * ductility * band

    def ground(share: float) -> FloatArray:
        moved = np.zeros_like(mesh.nodes)
        moved[:, 0] = np.where(x == x.max(), share * stretch, 0.0)
        return moved[model.support.points]

    states = list(apply_settlement(model, MASONRY, ground, options=options, start=start))
    end = x == x.max()
    pull = np.array([nodal_forces(model, state.fields.stress)[end, 0].sum() for state in states])
    moved = np.array([state.share * stretch for state in states])
    work = float(np.trapezoid(pull, moved))
    last = states[-1].history[-1]
    lost = WEAK * MASONRY.fracture_energy
    area = band**2
    return BarResult(last.dissipated_energy / area + lost, (work - last.strain_energy) / area + lost)


INNER, OUTER = 0.1, 0.5


def sphere_radii(front: float, radial: int) -> FloatArray:
    """Radii of the shells of elements: as many within `front` as beyond, where they grow outwards."""
    return np.concatenate([np.linspace(INNER, front, radial + 1), graded(front, OUTER, radial + 1, 3.0)[1:]])


def sphere_mesh(radii: FloatArray, around: int) -> VolumeMesh:
    """An eighth of a hollow sphere, a cube's corner: three patches of 20-node hexahedra.

    Groups "w0" and "w1" are its inner and outer face.
    """

    def patch(axis: int) -> VolumeMesh:
        def mapping(grid: FloatArray) -> FloatArray:
            ones = np.ones(len(grid))
            # Equal angles; the corner of the cube is at (1, 1, 1).
            direction = np.column_stack([ones, np.tan(grid[:, 0]), np.tan(grid[:, 1])])
            direction /= np.linalg.norm(direction, axis=1)[:, None]
            return np.asarray(np.roll(direction, axis, axis=1) * grid[:, 2:])

        angles = np.linspace(0, np.pi / 4, around + 1)
        return mapped_mesh((angles, angles, radii), mapping, kind=ElementKind.HEXAHEDRON20)

    return joined(*(patch(axis) for axis in range(3)))


def uncracked(model: WallModel) -> Strengths:
    """Strengths of a body that yields but does not crack."""
    tensile = np.full(model.volumes.shape, NEVER)
    return Strengths(tensile, np.full(len(tensile), np.inf), FLOOR)


def radial_mean(mesh: VolumeMesh, displacement: FloatArray, group: str) -> float:
    """Mean outward displacement, m, of a face of the sphere: work of a unit pressure over the face's area."""
    force = np.abs(pressure_forces(mesh, group, 1.0).reshape(-1, 3))
    area = float((force * mesh.nodes).sum()) / float(np.linalg.norm(mesh.nodes[mesh.group_nodes(group)[0]]))
    return float((force * displacement).sum()) / area


def thick_sphere(pressure: float, front: float, *, radial: int, around: int) -> float:
    """Displacement, m, of the outer face of a hollow sphere under inner pressure, in one step.

    The material yields up to the radius `front`, m, where elements end, since strains have a kink there.
    """
    mesh = sphere_mesh(sphere_radii(front, radial), around)
    force = pressure_forces(mesh, "w0", pressure)
    model = loaded_model(mesh, MATERIAL, MASONRY, np.abs(mesh.nodes) < 1e-12, force)
    (state,) = equilibrium_path(model, uncracked(model), [1.0])
    return radial_mean(mesh, state.displacement, "w1")


@dataclass(frozen=True)
class SphereState:
    """A sphere whose inner face is pushed out: inner pressure, Pa, and displacement of the outer face, m."""

    pressure: float
    outer: float


def pushed_sphere(pushes: Sequence[float], front: float, *, radial: int, around: int) -> list[SphereState]:
    """A hollow sphere whose inner face moves outwards by each of these, m, one after the other."""
    mesh = sphere_mesh(sphere_radii(front, radial), around)
    inner = mesh.group_nodes("w0")
    held = np.abs(mesh.nodes) < 1e-12
    held[inner] = True
    model = loaded_model(mesh, MATERIAL, MASONRY, held)
    unit = np.zeros_like(mesh.nodes)
    unit[inner] = mesh.nodes[inner] / INNER
    ground = pushes[-1] * unit[model.support.points]
    found = []
    for state in equilibrium_path(model, uncracked(model), np.divide(pushes, pushes[-1]), ground):
        forces = nodal_forces(model, state.fields.stress)
        work = float((forces * unit).sum())
        area = np.pi * INNER**2 / 2
        found.append(SphereState(work / area, radial_mean(mesh, state.displacement, "w1")))
    return found


def first_yield(*, radial: int, around: int) -> float:
    """Pressure, Pa, at which a hollow sphere begins to yield, from its elastic stresses."""
    mesh = sphere_mesh(graded(INNER, OUTER, 2 * radial, 8.0), around)
    space = displacement_space(mesh)
    held, zeros = np.abs(mesh.nodes) < 1e-12, np.zeros_like(mesh.nodes)
    force = pressure_forces(mesh, "w0", 1.0)
    state = solve(assemble(elastic_body(space, MATERIAL), force, prescribed=held, values=zeros))
    points = point_stress(space, MATERIAL, displacement=state.displacement)
    near = np.linalg.norm(points.location, axis=2)
    within = near < 1.1 * INNER
    # The cone is alpha I1 + sqrt(J2) = k; I1 is the same everywhere, the deviator goes with 1 / r³.
    used = [cone_value(row) + LAW.cone for row in principal_stress(points.stress[within])]
    slope, rest = np.polyfit(near[within] ** -3, used, 1)
    return float(LAW.cone / (slope * INNER**-3 + rest))


class PathState(NamedTuple):
    """Displacement (n, 3), m, and state of the points."""

    displacement: FloatArray
    fields: PointFields


def equilibrium_path(
    model: WallModel, strengths: Strengths, shares: Sequence[float], ground: FloatArray | None = None
) -> Iterator[PathState]:
    """States of a model whose forces, and movements (k, 3) of its support, come share by share.

    Newton's method.
    """
    start: Snapshot = at_rest(model)
    motion, before = start.motion, start.fields
    moved = np.zeros((len(model.support.points), 3)) if ground is None else ground
    tangent = Tangent(model)
    free = model.pattern.equation >= 0
    for share in shares:
        tangent.model = replace(model, weight=share * model.weight)
        after = PointFields(*(field.copy() for field in before))
        for iteration in range(100):
            tangent.assemble(motion, share * moved, strengths, before, after)
            unbalanced = np.linalg.norm(tangent.unbalanced[free])
            # What is prescribed has moved after the first step only; its reactions are out of balance here.
            scale = max(np.linalg.norm(tangent.model.weight), np.linalg.norm(tangent.unbalanced))
            if iteration and unbalanced <= 1e-8 * scale:
                break
            change = tangent.newton_change()
            motion = Motion(motion.displacement + change.displacement, motion.modes + change.modes)
        else:
            message = f"no equilibrium at {share}: {unbalanced} N"
            raise AssertionError(message)
        before = after
        yield PathState(motion.displacement, before)


CONCRETE = Material(young=30e9, poisson=0.18, density=2400.0, source="Petersson 1981")
CONCRETE_LAW = MasonryLaw(
    tensile_strength=3.33e6, fracture_energy=137.0, cohesion=1e8, source="Petersson 1981; it does not yield"
)


@dataclass(frozen=True, eq=False)
class BeamCurve:
    """Deflection, m, under the load, and the load, N, of every step."""

    deflection: FloatArray
    load: FloatArray

    def at(self, deflection: float) -> float:
        """Load at a deflection, N."""
        return float(np.interp(deflection, self.deflection, self.load))


def petersson_beam(options: SteppingOptions, *, band: float = 0.01, deflection: float = 0.8e-3) -> BeamCurve:
    """Notched beam of 2 x 0.2 x 0.05 m in three-point bending, plane strain.

    One layer of cubes, `band` wide, at the crack; forces are those of a beam 50 mm thick.
    """
    side = np.concatenate([-graded(band / 2, 1.0, 14, 14.0)[::-1], graded(band / 2, 1.0, 14, 14.0)])
    high = np.concatenate([np.linspace(0, 0.1, 6), np.linspace(0.1, 0.2, round(0.1 / band) + 1)[1:]])
    mesh = mapped_mesh((side, [0.0, band], high), lambda grid: grid, kind=ElementKind.HEXAHEDRON)
    mesh = without(mesh, lambda centre: (np.abs(centre[:, 0]) < band / 2) & (centre[:, 2] < 0.1))
    x, _, z = mesh.nodes.T
    ends = (np.abs(np.abs(x) - 1.0) < 1e-9) & (z < 1e-9)
    loaded = (np.abs(x) < band) & (z > 0.2 - 1e-9)
    held = np.zeros((len(x), 3), dtype=bool)
    held[:, 1], held[ends | loaded, 2], held[loaded, 0] = True, True, True
    model = loaded_model(mesh, CONCRETE, CONCRETE_LAW, held)

    def ground(share: float) -> FloatArray:
        moved = np.zeros_like(mesh.nodes)
        moved[loaded, 2] = -share * deflection
        return moved[model.support.points]

    states = list(apply_settlement(model, CONCRETE_LAW, ground, options=options))
    load = [nodal_forces(model, state.fields.stress)[ends, 2].sum() for state in states]
    shares = np.array([state.share for state in states])
    return BeamCurve(shares * deflection, np.array(load) * 0.05 / band)


def without(mesh: VolumeMesh, drop: Callable[[FloatArray], BoolArray]) -> VolumeMesh:
    """A mesh less the elements whose centres are picked."""
    elements = mesh.elements[~drop(mesh.nodes[mesh.elements].mean(axis=1))]
    used, numbered = np.unique(elements, return_inverse=True)
    return VolumeMesh(mesh.nodes[used], numbered.reshape(elements.shape), mesh.kind, {})
