"""Stresses and forces of elastic elements whose nodes moved, compiled by numba."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.stiffness import Rule, condense, elastic_matrix, element_gradients, element_nodes

__all__ = ["ElasticBody", "element_forces", "element_stresses"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


class ElasticBody(NamedTuple):
    """`points` (m, 3), m; `connectivity` (e, b); `rule` of the stiffness; Lamé's parameters, Pa."""

    points: FloatArray
    connectivity: IntArray
    rule: Rule
    lame: float
    shear: float


@compiled
def _moved(body: ElasticBody, e: int, displacement: FloatArray) -> FloatArray:
    """Displacements (b + k, 3), m, of an element's functions, its k incompatible modes included."""
    count, modes = body.rule.gradients.shape[2], body.rule.modes.shape[2]
    moved = np.zeros((count + modes, 3))
    for b in range(count):
        for i in range(3):
            moved[b, i] = displacement[body.connectivity[e, b], i]
    if modes:
        # The modes are free of forces: what their elimination left in their rows tells how far they go.
        rows = 3 * (count + modes)
        nodes = element_nodes(body.points, body.connectivity, e, body.rule.geometry.shape[2])
        gradients = np.empty((len(body.rule.weights), count + modes, 3))
        volumes = np.empty(len(body.rule.weights))
        element_gradients(nodes, body.rule, gradients, volumes)
        K, u = np.empty((rows, rows)), moved.reshape(rows)
        elastic_matrix(gradients, volumes, body.lame, body.shear, np.empty((rows, rows)), K)
        condense(K, 3 * count)
        for row in range(3 * count, rows):
            total = 0.0
            for j in range(row):
                total += K[row, j] * u[j]
            u[row] = -total / K[row, row]
    return moved


@compiled
def _stress(g: FloatArray, moved: FloatArray, lame: float, shear: float, stress: FloatArray) -> None:
    """Stress (6,) from the gradients (b, 3) and displacements (b, 3) of a point."""
    xx = yy = zz = xy = yz = xz = 0.0
    for b in range(len(g)):
        x, y, z = g[b, 0], g[b, 1], g[b, 2]
        u, v, w = moved[b, 0], moved[b, 1], moved[b, 2]
        xx += x * u
        yy += y * v
        zz += z * w
        xy += y * u + x * v
        yz += z * v + y * w
        xz += z * u + x * w
    pressure = lame * (xx + yy + zz)
    stress[0] = pressure + 2.0 * shear * xx
    stress[1] = pressure + 2.0 * shear * yy
    stress[2] = pressure + 2.0 * shear * zz
    stress[3], stress[4], stress[5] = shear * xy, shear * yz, shear * xz


@compiled
def element_stresses(
    body: ElasticBody,
    rule: Rule,
    start: int,
    displacement: FloatArray,
    stress: FloatArray,
    volume: FloatArray,
) -> None:
    """Stress (c, q, 6), Pa, and volume (c, q), m³, at the points of a rule, for elements from `start` on."""
    size = body.rule.gradients.shape[2] + body.rule.modes.shape[2]
    gradients = np.empty((len(rule.weights), size, 3))
    for c in range(len(stress)):
        nodes = element_nodes(body.points, body.connectivity, start + c, rule.geometry.shape[2])
        element_gradients(nodes, rule, gradients, volume[c])
        moved = _moved(body, start + c, displacement)
        for q in range(len(rule.weights)):
            _stress(gradients[q], moved, body.lame, body.shear, stress[c, q])


@compiled
def element_forces(
    body: ElasticBody, start: int, displacement: FloatArray, forces: FloatArray, bounds: FloatArray
) -> None:
    """Add the nodal forces (c, b, 3), N, of elements from `start` on; and the sums of their terms' sizes.

    The bounds, the same sums with every factor taken positive, tell what rounding may leave of forces that
    should cancel.
    """
    rule = body.rule
    count, size = rule.gradients.shape[2], rule.gradients.shape[2] + rule.modes.shape[2]
    gradients, volumes = np.empty((len(rule.weights), size, 3)), np.empty(len(rule.weights))
    positive, sizes = np.empty((size, 3)), np.empty((size, 3))
    stress, largest = np.empty(6), np.empty(6)
    for c in range(len(forces)):
        nodes = element_nodes(body.points, body.connectivity, start + c, rule.geometry.shape[2])
        element_gradients(nodes, rule, gradients, volumes)
        moved = _moved(body, start + c, displacement)
        _positive(moved, sizes)
        for q in range(len(volumes)):
            _stress(gradients[q], moved, body.lame, body.shear, stress)
            _add_forces(gradients[q, :count], stress, volumes[q], forces[c])
            _positive(gradients[q], positive)
            _stress(positive, sizes, body.lame, body.shear, largest)
            _add_forces(positive[:count], largest, volumes[q], bounds[c])


@compiled
def _positive(values: FloatArray, sizes: FloatArray) -> None:
    for b in range(len(values)):
        for i in range(3):
            sizes[b, i] = abs(values[b, i])


@compiled
def _add_forces(g: FloatArray, stress: FloatArray, volume: float, forces: FloatArray) -> None:
    """Add Bᵀ s dV of a point to the forces (b, 3)."""
    for b in range(len(forces)):
        x, y, z = g[b, 0] * volume, g[b, 1] * volume, g[b, 2] * volume
        forces[b, 0] += stress[0] * x + stress[3] * y + stress[5] * z
        forces[b, 1] += stress[1] * y + stress[3] * x + stress[4] * z
        forces[b, 2] += stress[2] * z + stress[4] * y + stress[5] * x
