"""Quadrature rules of the compiled kernels, from scikit-fem's shape functions."""

import numpy as np

from fd2fem.model import ElementKind
from solvers.compiled.stiffness import Rule
from solvers.fem.elements import (
    HEXAHEDRON_CORNERS,
    STIFFNESS_ORDER,
    STRESS_ORDER,
    ElementType,
    Space,
    shape_functions,
    tabulate,
)

__all__ = ["element_rule", "incompatible_rule", "space_rule", "stiffness_order", "trilinear_rule"]


def stiffness_order(space: Space) -> int:
    """Polynomial degree that the stiffness is integrated to: 27, 8 or 4 points, as CalculiX does."""
    return STRESS_ORDER[space.kind] if space.element.eight_nodes else STIFFNESS_ORDER[space.kind]


def space_rule(space: Space, order: int) -> Rule:
    """Rule of a space's elements that is exact to the polynomial degree `order`."""
    if space.element is ElementType.INCOMPATIBLE:
        return incompatible_rule(order)
    if space.element is ElementType.HEXAHEDRON8:
        return trilinear_rule(order)
    return element_rule(space.kind, order)


def element_rule(kind: ElementKind, order: int) -> Rule:
    """Displacements of the element's full set of nodes (20 in a hexahedron), no incompatible modes.

    Parameters
    ----------
    kind : ElementKind
    order : int
        Polynomial degree that the rule is exact to.
    """
    table = tabulate(kind, order)
    return Rule(
        weights=table.weights,
        values=np.ascontiguousarray(table.values),
        gradients=np.ascontiguousarray(table.gradients),
        geometry=np.ascontiguousarray(table.geometry_gradients),
        modes=np.zeros((len(table.weights), 3, 0)),
        centre=np.zeros((3, table.geometry_gradients.shape[2])),
    )


def trilinear_rule(order: int = STRESS_ORDER[ElementKind.HEXAHEDRON]) -> Rule:
    """The 8-node hexahedron, by default at 2 x 2 x 2 points."""
    import skfem
    from skfem.quadrature import get_quadrature

    element = skfem.ElementHex1()
    points, weights = get_quadrature(element, order)
    values, gradients = shape_functions(element, HEXAHEDRON_CORNERS, points)
    gradients = np.ascontiguousarray(gradients)
    return Rule(
        weights=weights,
        values=np.ascontiguousarray(values),
        gradients=gradients,
        geometry=gradients,
        modes=np.zeros((len(weights), 3, 0)),
        centre=np.ascontiguousarray((2.0 * HEXAHEDRON_CORNERS - 1.0).T / 4.0),
    )


def incompatible_rule(order: int = STRESS_ORDER[ElementKind.HEXAHEDRON]) -> Rule:
    """The 8-node hexahedron with incompatible modes, by default at 2 x 2 x 2 points.

    Examples
    --------
    >>> rule = incompatible_rule()
    >>> rule.gradients.shape, rule.modes.shape, float(rule.weights.sum().round(12))
    ((8, 3, 8), (8, 3, 3), 1.0)
    """
    import skfem
    from skfem.quadrature import get_quadrature

    points, weights = get_quadrature(skfem.ElementHex1(), order)
    # 1 - xi² with xi = 2 s - 1 on scikit-fem's reference cube, 0 <= s <= 1.
    modes = np.zeros((len(weights), 3, 3))
    for axis in range(3):
        modes[:, axis, axis] = -4.0 * (2.0 * points[axis] - 1.0)
    return trilinear_rule(order)._replace(modes=modes)
