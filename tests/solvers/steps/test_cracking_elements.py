"""Bars of every kind of element, pulled until they are broken: the energy that a crack takes per area."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from exported_meshes import tetrahedra
from mapped_grids import mapped_mesh
from masonry_benchmarks import MASONRY, WEAK, nodal_forces
from material_point import MATERIAL

from fd2fem.model import ElementKind
from solvers.compiled.cracking import Body
from solvers.compiled.pattern import build_pattern
from solvers.compiled.stiffness import element_volumes
from solvers.fem.elements import ElementType, displacement_space
from solvers.fem.rules import space_rule, stiffness_order
from solvers.masonry import point_law, softening_strain
from solvers.steps.nonlinear import apply_settlement, at_rest
from solvers.steps.stepping import SteppingOptions
from solvers.steps.supports import Support
from solvers.steps.wall_model import WallModel

LENGTH, SIDE = 0.2, 0.1
OPTIONS = SteppingOptions(steps=40, tolerance=1e-5)


@dataclass(frozen=True)
class Broken:
    """Energies per area, J/m², and the widest crack, m."""

    dissipated: float
    work: float
    opening: float


def _bar(kind, across):
    """Cubes, or cubes cut into tetrahedra, so many along each side of the section."""
    planes = np.linspace(0, LENGTH, 2 * across + 1), *[np.linspace(0, SIDE, across + 1)] * 2
    if kind is not ElementKind.TETRA10:
        return mapped_mesh(planes, lambda grid: grid, kind=kind)
    return tetrahedra(mapped_mesh(planes, lambda grid: grid, kind=ElementKind.HEXAHEDRON))


def _model(mesh, held, material):
    space = displacement_space(mesh, ElementType.INCOMPATIBLE)
    rule = space_rule(space, stiffness_order(space))
    prescribed = held.ravel()
    return WallModel(
        body=Body(space.points, space.connectivity, rule, point_law(material, MASONRY)),
        pattern=build_pattern(
            space.connectivity, points=len(space.points), prescribed=prescribed, upper=False
        ),
        support=Support(np.flatnonzero(held.any(axis=1)), prescribed, np.zeros(held.size), lifts=False),
        weight=np.zeros(held.size),
        volumes=element_volumes(space.points, space.connectivity, rule),
    )


def _pull(kind, across):
    """Pull a bar whose middle layer of elements has already lost a little of its strength."""
    mesh = _bar(kind, across)
    x, y, z = mesh.nodes.T
    end = x == LENGTH
    model = _model(mesh, np.column_stack([(x == 0) | end, y == 0, z == 0]), replace(MATERIAL, poisson=0.0))
    start, ductility = at_rest(model), softening_strain(MASONRY, model.band)
    centres = mesh.nodes[mesh.elements, 0].mean(axis=1)
    weak = np.abs(centres - (LENGTH - SIDE / across) / 2) < SIDE / across / 2
    lost = -np.log(1.0 - WEAK) * ductility[weak, None]
    start.fields.kappa[weak] = start.kappa_before[weak] = lost
    # Where exp(-7) of the strength is left.
    stretch = 7.0 * MASONRY.fracture_energy / MASONRY.tensile_strength

    def ground(share):
        moved = np.zeros_like(mesh.nodes)
        moved[end, 0] = share * stretch
        return moved[model.support.points]

    states = list(apply_settlement(model, MASONRY, ground, options=OPTIONS, start=start))
    pull = [nodal_forces(model, state.fields.stress)[end, 0].sum() for state in states]
    work = np.trapezoid(pull, [state.share * stretch for state in states])
    last = states[-1].history[-1]
    before = WEAK * MASONRY.fracture_energy * (model.volumes.sum(axis=1) / model.band)[weak].sum()
    energies = np.array([last.dissipated_energy, work - last.strain_energy]) + before
    return Broken(*(energies / SIDE**2), last.max_crack_opening)


@pytest.mark.parametrize("across", [1, 2])
@pytest.mark.parametrize("kind", [ElementKind.HEXAHEDRON, ElementKind.HEXAHEDRON20])
def test_a_crack_through_hexahedra_takes_the_fracture_energy(kind, across):
    bar = _pull(kind, across)
    assert bar.dissipated == pytest.approx(MASONRY.fracture_energy, rel=0.01)
    # The force's work, by trapezia between the steps: independent of the first.
    assert bar.work == pytest.approx(MASONRY.fracture_energy, rel=0.05)
    # All of the way is the crack's.
    stretch = 7.0 * MASONRY.fracture_energy / MASONRY.tensile_strength
    assert bar.opening == pytest.approx(stretch, rel=0.02)


def test_a_crack_through_tetrahedra_takes_the_same_whatever_their_size():
    coarse, fine = (_pull(ElementKind.TETRA10, across) for across in (1, 2))
    assert fine.dissipated == pytest.approx(coarse.dissipated, rel=0.01)
    for bar in (coarse, fine):
        assert bar.work == pytest.approx(bar.dissipated, rel=0.05)
