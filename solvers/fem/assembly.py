"""Stiffness, body force and internal forces of a mesh of elastic elements.

scikit-fem's stock forms take 40 s for 200,000 unknowns; its shape functions in compiled loops over the
elements, added up onto a pattern that is found once, give the same matrix to round-off in a fraction of it.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError
from fd2fem.model.checks import as_array
from solvers.compiled.elastic import ElasticBody, element_forces
from solvers.compiled.jit import in_chunks
from solvers.compiled.pattern import Pattern, build_pattern
from solvers.compiled.stiffness import Rule, Sums, add_elements, elastic_matrices, element_volumes
from solvers.fem.elements import Space
from solvers.fem.rules import space_rule, stiffness_order
from solvers.materials import Material, lame_parameters

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["add_up", "body_force", "elastic_body", "internal_force", "point_volumes", "stiffness"]

FloatArray = NDArray[np.float64]


def elastic_body(space: Space, material: Material) -> ElasticBody:
    """A homogeneous body, for the compiled functions.

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    rule = space_rule(space, stiffness_order(space))
    point_volumes(space, rule)
    lame = lame_parameters(material)
    return ElasticBody(space.points, space.connectivity, rule, lame.first, lame.shear)


def point_volumes(space: Space, rule: Rule) -> FloatArray:
    """Volume (e, q), m³, that each point of a rule stands for.

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    volumes = np.empty((len(space.connectivity), len(rule.weights)))
    for part, some in in_chunks(
        len(volumes), lambda part: element_volumes(space.points, space.connectivity[part], rule)
    ):
        volumes[part] = some
    if not volumes.min() > 0.0:
        element = int(volumes.min(axis=1).argmin())
        corners = space.points[space.connectivity[element, : rule.geometry.shape[2]]]
        centre = ", ".join(f"{value:.4g}" for value in corners.mean(axis=0))
        msg = (
            f"Element {element} at ({centre}) m is folded or has no volume: "
            "its nodes must follow VTK's order and its corners be convex."
        )
        raise InputError(msg)
    return volumes


def add_up(body: ElasticBody, pattern: Pattern, imposed: FloatArray) -> Sums:
    """Stiffness matrix of a body on a pattern, and the pull of imposed displacements.

    Parameters
    ----------
    body : ElasticBody
    pattern : Pattern
    imposed : (3m,) float array, m
        Displacements of the prescribed components, 0 elsewhere.
    """
    count, nodes = body.connectivity.shape
    unknowns = 3 * len(body.points)
    sums = Sums(np.zeros(len(pattern.columns)), np.zeros(unknowns), np.zeros(unknowns))

    def elements(part: slice) -> FloatArray:
        matrices = np.empty((part.stop - part.start, 3 * nodes, 3 * nodes))
        connectivity = body.connectivity[part]
        elastic_matrices(body.points, connectivity, body.rule, body.lame, body.shear, matrices)
        return matrices

    for part, matrices in in_chunks(count, elements):
        at_rest = np.zeros(matrices.shape[:2])
        add_elements(matrices, at_rest, body.connectivity[part], pattern.rows, imposed, sums)
    return sums


def stiffness(space: Space, material: Material) -> "csr_array":
    """Stiffness matrix K of a homogeneous body, nothing prescribed.

    Parameters
    ----------
    space : Space
    material : Material

    Returns
    -------
    K : (3m, 3m) sparse array, N/m
        Components x, y, z of each point in turn.

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    body = elastic_body(space, material)
    nothing = np.zeros(space.unknowns, dtype=bool)
    pattern = build_pattern(space.connectivity, points=len(space.points), prescribed=nothing, upper=False)
    return pattern.matrix(add_up(body, pattern, np.zeros(space.unknowns)).values)


def internal_force(body: ElasticBody, displacement: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Forces that hold a body in a displaced state, computed from its stresses, without the matrix.

    Parameters
    ----------
    body : ElasticBody
    displacement : (m, 3) float array, m

    Returns
    -------
    force, bound : (m, 3) float array, N
        The sums over the elements; and the same with all terms taken positive.
    """
    count, nodes = body.connectivity.shape
    force, bound = np.zeros((2, len(body.points), 3))

    def elements(part: slice) -> FloatArray:
        both = np.zeros((2, part.stop - part.start, nodes, 3))
        element_forces(body, part.start, displacement, both[0], both[1])
        return both

    for part, both in in_chunks(count, elements):
        np.add.at(force, body.connectivity[part], both[0])
        np.add.at(bound, body.connectivity[part], both[1])
    return force, bound


def body_force(space: Space, force: ArrayLike) -> FloatArray:
    """Nodal forces of a constant force per volume.

    Parameters
    ----------
    space : Space
    force : (3,) array-like, N/m³

    Returns
    -------
    f : (3m,) float array, N

    Raises
    ------
    InputError
        If an element is folded or has no volume.
    """
    density = as_array("force", force, (3,))
    rule = space_rule(space, stiffness_order(space))
    share = np.zeros(len(space.points))
    np.add.at(share, space.connectivity, point_volumes(space, rule) @ rule.values)
    return np.outer(share, density).ravel()
