"""Tangent stiffness of masonry that cracks, by numba; incompatible modes condensed out."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.cracking import Chunk
from solvers.compiled.jit import compiled
from solvers.compiled.point_tangent import elastic_tangent
from solvers.compiled.return_map import PointLaw
from solvers.compiled.stiffness import elastic_matrix

__all__ = ["Condensed", "tangent_matrices"]

FloatArray = NDArray[np.float64]


class Condensed(NamedTuple):
    """Elements whose modes are condensed out.

    `matrices` (c, 3b, 3b), N/m; `forces` (c, 3b), N, out of balance of the modes included; `follow`
    (c, 3k, 3b) and `lag` (c, 3k): the modes change by -(lag + follow · change of displacement).
    """

    matrices: FloatArray
    forces: FloatArray
    follow: FloatArray
    lag: FloatArray


@compiled
def tangent_matrices(chunk: Chunk, law: PointLaw, forces: FloatArray, out: Condensed) -> None:
    """Tangent stiffness of a chunk's elements, and the forces (c, 3 (b + k)) with their modes condensed out.

    Where the cone yields, the tangent is not symmetric: its symmetric part is taken.
    """
    kept, rows = out.forces.shape[1], forces.shape[1]
    K, f, scratch = np.empty((rows, rows)), np.empty(rows), np.empty((rows, rows))
    elastic = np.empty((6, 6))
    elastic_tangent(law, elastic)
    for c in range(len(chunk.volumes)):
        found = 0
        for q in range(chunk.volumes.shape[1]):
            found |= chunk.active[c, q]
        if found:
            _yielding_matrix(chunk, c, elastic, K)
        else:
            elastic_matrix(chunk.gradients[c], chunk.volumes[c], law.lame, law.shear, scratch, K)
        for i in range(rows):
            f[i] = forces[c, i]
        _condense_modes(K, f, kept)
        for i in range(kept):
            out.forces[c, i] = f[i]
            for j in range(i + 1):
                out.matrices[c, i, j] = out.matrices[c, j, i] = K[i, j]
        for i in range(kept, rows):
            out.lag[c, i - kept] = f[i]
            for j in range(kept):
                out.follow[c, i - kept, j] = K[i, j]


@compiled
def _yielding_matrix(chunk: Chunk, c: int, elastic: FloatArray, K: FloatArray) -> None:
    """Symmetric part of an element's stiffness, some points of which yield."""
    K[:] = 0.0
    for q in range(chunk.volumes.shape[1]):
        D = chunk.tangents[c, q] if chunk.active[c, q] else elastic
        _add_tangent(chunk.gradients[c, q], chunk.volumes[c, q], D, K)
    for i in range(len(K)):
        for j in range(i):
            K[i, j] = K[j, i] = 0.5 * (K[i, j] + K[j, i])


@compiled
def _add_tangent(g: FloatArray, volume: float, D: FloatArray, K: FloatArray) -> None:
    """Add Bᵀ D B dV of a point."""
    size = len(g)
    DB = np.empty((6, 3 * size))
    for b in range(size):
        x, y, z = g[b, 0] * volume, g[b, 1] * volume, g[b, 2] * volume
        for r in range(6):
            DB[r, 3 * b] = D[r, 0] * x + D[r, 3] * y + D[r, 5] * z
            DB[r, 3 * b + 1] = D[r, 1] * y + D[r, 3] * x + D[r, 4] * z
            DB[r, 3 * b + 2] = D[r, 2] * z + D[r, 4] * y + D[r, 5] * x
    for a in range(size):
        x, y, z = g[a]
        for c in range(3 * size):
            K[3 * a, c] += x * DB[0, c] + y * DB[3, c] + z * DB[5, c]
            K[3 * a + 1, c] += y * DB[1, c] + x * DB[3, c] + z * DB[4, c]
            K[3 * a + 2, c] += z * DB[2, c] + y * DB[4, c] + x * DB[5, c]


@compiled
def _condense_modes(K: FloatArray, f: FloatArray, kept: int) -> None:
    """Eliminate the modes, in place: Gauss on the lower triangle, last first.

    Their rows then say how they follow: as `Condensed` has it.
    """
    rows = len(K)
    for pivot in range(rows - 1, kept - 1, -1):
        scale = 1.0 / K[pivot, pivot]
        for i in range(pivot):
            factor = K[pivot, i] * scale
            f[i] -= factor * f[pivot]
            for j in range(i + 1):
                K[i, j] -= factor * K[pivot, j]
    for row in range(kept, rows):
        for other in range(kept, row):
            f[row] -= K[row, other] * f[other]
            for j in range(kept):
                K[row, j] -= K[row, other] * K[other, j]
        scale = 1.0 / K[row, row]
        f[row] *= scale
        for j in range(kept):
            K[row, j] *= scale
