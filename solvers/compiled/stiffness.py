"""Element stiffness and forces, compiled by numba, added up onto a fixed pattern.

Elements are computed in chunks, side by side, and added one after the other: the sums do not depend on the
number of cores.

Eight-node hexahedra may carry three incompatible modes per direction, 1 - xi², 1 - eta², 1 - zeta², whose
gradients are taken with the Jacobian of the centre so that the patch test holds (Taylor et al. 1976); they
are condensed out of each element. Without them the element locks in bending.

References
----------
R. L. Taylor, P. J. Beresford, E. L. Wilson, "A non-conforming element for stress analysis", Int. J. Numer.
Methods Eng. 10, 1976.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled

__all__ = [
    "Rows",
    "Rule",
    "Sums",
    "add_elements",
    "condense",
    "elastic_matrices",
    "elastic_matrix",
    "element_gradients",
    "element_nodes",
    "element_volumes",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]


class Rows(NamedTuple):
    """The arrays of a :class:`~solvers.compiled.pattern.Pattern`."""

    equation: Int32Array
    starts: Int64Array
    columns: Int32Array


class Sums(NamedTuple):
    """Sums over the elements of a mesh.

    `values` (z,), the entries of the pattern; `forces` (3m,), N; `pull` (3m,), N, what imposed displacements
    alone do to the free ones.
    """

    values: FloatArray
    forces: FloatArray
    pull: FloatArray


class Rule(NamedTuple):
    """Shape functions of a reference element at the points of a quadrature rule, as arrays.

    `weights` (q,); `values` (q, b) and `gradients` (q, 3, b) of the displacements; `geometry` (q, 3, g) of
    the functions that map the element's g mesh nodes; `modes` (q, 3, m), gradients of the incompatible modes,
    and `centre` (3, g), of the geometry at the element's centre.
    """

    weights: FloatArray
    values: FloatArray
    gradients: FloatArray
    geometry: FloatArray
    modes: FloatArray
    centre: FloatArray


@compiled
def _jacobian(nodes: FloatArray, tables: FloatArray, q: int, inverse: FloatArray) -> float:
    """Determinant of dx/dxi from nodes (g, 3) and gradients (3, g) at point q; dxi/dx, space first."""
    ax = ay = az = bx = by = bz = cx = cy = cz = 0.0
    for n in range(tables.shape[2]):
        a, b, c = tables[q, 0, n], tables[q, 1, n], tables[q, 2, n]
        x, y, z = nodes[n, 0], nodes[n, 1], nodes[n, 2]
        ax += a * x
        ay += a * y
        az += a * z
        bx += b * x
        by += b * y
        bz += b * z
        cx += c * x
        cy += c * y
        cz += c * z
    inverse[0, 0], inverse[1, 0], inverse[2, 0] = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    inverse[0, 1], inverse[1, 1], inverse[2, 1] = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    inverse[0, 2], inverse[1, 2], inverse[2, 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    determinant = ax * inverse[0, 0] + ay * inverse[1, 0] + az * inverse[2, 0]
    for i in range(3):
        for j in range(3):
            inverse[i, j] /= determinant
    return float(determinant)


@compiled
def element_gradients(nodes: FloatArray, rule: Rule, gradients: FloatArray, volumes: FloatArray) -> None:
    """Gradients (q, b + m, 3), 1/m, at an element's points, and the volumes (q,), m³, that they stand for.

    Those of the m incompatible modes come last; a folded element has a volume that is not positive.
    """
    # Arrays by name, not by the rule's attributes and no views of them: each would be counted, which takes
    # longer than the arithmetic.
    weights, _, functions, geometry, modes, centre = rule
    inverse, at_centre = np.empty((3, 3)), np.empty((3, 3))
    count, more = functions.shape[2], modes.shape[2]
    at_middle = _jacobian(nodes, centre.reshape(1, 3, centre.shape[1]), 0, at_centre) if more else 0.0
    for q in range(len(weights)):
        determinant = _jacobian(nodes, geometry, q, inverse)
        volumes[q] = determinant * weights[q]
        for b in range(count):
            x, y, z = functions[q, 0, b], functions[q, 1, b], functions[q, 2, b]
            for j in range(3):
                gradients[q, b, j] = inverse[j, 0] * x + inverse[j, 1] * y + inverse[j, 2] * z
        for b in range(more):
            x, y, z = modes[q, 0, b], modes[q, 1, b], modes[q, 2, b]
            for j in range(3):
                gradients[q, count + b, j] = (at_middle / determinant) * (
                    at_centre[j, 0] * x + at_centre[j, 1] * y + at_centre[j, 2] * z
                )


@compiled
def element_nodes(points: FloatArray, connectivity: IntArray, e: int, count: int) -> FloatArray:
    """The first `count` nodes of an element, which carry its geometry: (g, 3), m."""
    nodes = np.empty((count, 3))
    for n in range(count):
        for i in range(3):
            nodes[n, i] = points[connectivity[e, n], i]
    return nodes


@compiled
def element_volumes(points: FloatArray, connectivity: IntArray, rule: Rule) -> FloatArray:
    """Volumes (e, q), m³, that the integration points stand for; not positive where an element is folded."""
    weights, _, _, geometry, _, _ = rule
    volumes, inverse = np.empty((len(connectivity), len(weights))), np.empty((3, 3))
    for e in range(len(connectivity)):
        nodes = element_nodes(points, connectivity, e, geometry.shape[2])
        for q in range(len(weights)):
            volumes[e, q] = _jacobian(nodes, geometry, q, inverse) * weights[q]
    return volumes


@compiled
def elastic_matrices(
    points: FloatArray, connectivity: IntArray, rule: Rule, lame: float, shear: float, matrices: FloatArray
) -> None:
    """Stiffness (c, 3b, 3b), N/m, of some elements of an isotropic material."""
    count, modes = rule.gradients.shape[2], rule.modes.shape[2]
    size = count + modes
    gradients, volumes = np.empty((len(rule.weights), size, 3)), np.empty(len(rule.weights))
    products, K = np.empty((3 * size, 3 * size)), np.empty((3 * size, 3 * size))
    for e in range(len(connectivity)):
        nodes = element_nodes(points, connectivity, e, rule.geometry.shape[2])
        element_gradients(nodes, rule, gradients, volumes)
        if modes:
            elastic_matrix(gradients, volumes, lame, shear, products, K)
            condense(K, 3 * count)
            for i in range(3 * count):
                for j in range(3 * count):
                    matrices[e, i, j] = K[i, j]
        else:
            elastic_matrix(gradients, volumes, lame, shear, products, matrices[e])


@compiled
def elastic_matrix(
    gradients: FloatArray, volumes: FloatArray, lame: float, shear: float, products: FloatArray, K: FloatArray
) -> None:
    """Stiffness of an element: blocks lame P + shear (Pᵀ + tr P I), where P = sum of ga gbᵀ dV.

    The products P of all pairs of functions are one update per point, a sixth of the work of Bᵀ D B.
    """
    points, size, _ = gradients.shape
    g = gradients.reshape(points, 3 * size)
    for row in range(3 * size):
        first = row - row % 3
        # Views that start where the loop does, so that it becomes one of vector instructions.
        total = products[row, first:]
        for column in range(len(total)):
            total[column] = 0.0
        for q in range(points):
            factor, others = volumes[q] * g[q, row], g[q, first:]
            for column in range(len(total)):
                total[column] += factor * others[column]
    for a in range(0, 3 * size, 3):
        for b in range(a, 3 * size, 3):
            trace = products[a, b] + products[a + 1, b + 1] + products[a + 2, b + 2]
            for i in range(3):
                for j in range(3):
                    value = lame * products[a + i, b + j] + shear * products[a + j, b + i]
                    value += shear * trace if i == j else 0.0
                    K[a + i, b + j] = value
                    K[b + j, a + i] = value


@compiled
def condense(K: FloatArray, kept: int) -> None:
    """Eliminate the unknowns from `kept` on, in place, last first: Gauss on a symmetric stiffness."""
    for pivot in range(len(K) - 1, kept - 1, -1):
        for i in range(pivot):
            factor = K[i, pivot] / K[pivot, pivot]
            if factor != 0.0:
                for j in range(pivot):
                    K[i, j] -= factor * K[pivot, j]


@compiled
def add_elements(
    matrices: FloatArray,
    forces: FloatArray,
    connectivity: IntArray,
    rows: Rows,
    imposed: FloatArray,
    sums: Sums,
) -> None:
    """Add element matrices (c, 3b, 3b) and forces (c, 3b) to the sums over the mesh.

    `imposed` (3m,), m, are displacements of the prescribed components, which pull at the free ones.
    """
    equation, starts, columns = rows
    values, total, pull = sums
    width = 3 * connectivity.shape[1]
    dofs, equations = np.empty(width, dtype=np.int64), np.empty(width, dtype=np.int64)
    for e in range(len(connectivity)):
        held, matrix = False, matrices[e]
        for i in range(width):
            dofs[i] = 3 * connectivity[e, i // 3] + i % 3
            equations[i] = equation[dofs[i]]
            held |= equations[i] < 0
            total[dofs[i]] += forces[e, i]
        if held:
            _add_pull(matrix, dofs, equations, imposed, pull)
        for a in range(0, width, 3):
            for b in range(0, width, 3):
                _add_block(matrix, equations, a, b, starts, columns, values)


@compiled
def _add_pull(
    matrix: FloatArray, dofs: Int64Array, equations: Int64Array, imposed: FloatArray, pull: FloatArray
) -> None:
    """Add the forces on the free displacements of an element that its prescribed ones cause."""
    for j in range(len(dofs)):
        if equations[j] < 0:
            for i in range(len(dofs)):
                pull[dofs[i]] += matrix[i, j] * imposed[dofs[j]]


@compiled
def _add_block(
    matrix: FloatArray,
    equations: Int64Array,
    a: int,
    b: int,
    starts: Int64Array,
    columns: Int32Array,
    values: FloatArray,
) -> None:
    """Add the block of two points, whose first components are the element's unknowns a and b.

    The columns of a point follow one another, and end equally far from the ends of the rows of another
    point: one search is enough for all nine.
    """
    first_row, first_column = -1, -1
    for i in range(2, -1, -1):
        first_row = equations[a + i] if equations[a + i] >= 0 else first_row
        first_column = equations[b + i] if equations[b + i] >= 0 else first_column
    # In an upper triangle the first entry of a row is its diagonal.
    if first_row < 0 or first_column < columns[starts[first_row]]:
        return
    end = starts[first_row + 1]
    left = end - _find(columns, starts[first_row], end, first_column)
    for i in range(3):
        row = equations[a + i]
        if row < 0:
            continue
        smallest, place = columns[starts[row]], starts[row + 1] - left
        for j in range(3):
            column = equations[b + j]
            if column >= smallest:
                values[place + column - first_column] += matrix[a + i, b + j]


@compiled
def _find(columns: Int32Array, low: int, high: int, column: int) -> int:
    """Place of `column` among the ascending columns[low:high]."""
    while high - low > 1:
        middle = (low + high) // 2
        if columns[middle] <= column:
            low = middle
        else:
            high = middle
    return low
