"""States of the integration points, element forces and tangent stiffness of masonry that cracks, by numba.

The incompatible modes of eight-node hexahedra are unknowns of their element alone. Their equations are solved
along with the mesh's: each iteration condenses them out and keeps what is needed to follow the displacements.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.point_update import PointState, Workspace, new_workspace, update_point
from solvers.compiled.return_map import CONE, PLANES, PointLaw, Softening
from solvers.compiled.stiffness import Rule, elastic_matrix, element_gradients, element_nodes

__all__ = [
    "Body",
    "Chunk",
    "Condensed",
    "Motion",
    "PointFields",
    "Strengths",
    "add_forces",
    "chunk_of",
    "point_forces",
    "tangent_matrices",
    "update_points",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
ByteArray = NDArray[np.uint8]

ELASTIC, ASSOCIATED, NON_ASSOCIATED = 0, 1, 2
"""What happens in an element: nothing yields; cracks alone; the cone, whose tangent is not symmetric."""


class Body(NamedTuple):
    """`points` (m, 3), m; `connectivity` (e, b); the `rule` of its elements; the `law` of its material."""

    points: FloatArray
    connectivity: IntArray
    rule: Rule
    law: PointLaw


class Motion(NamedTuple):
    """`displacement` (m, 3), m; `modes` (e, 3 k), the amplitudes of k incompatible modes, m."""

    displacement: FloatArray
    modes: FloatArray


class PointFields(NamedTuple):
    """What the integration points remember, and the stress in them.

    `inelastic` (e, q, 6), the strain that is not elastic; `crack` (e, q, 6), the part of it that opens
    cracks; `kappa` and `cone` (e, q), the multipliers' sums; `stress` (e, q, 6), Pa.
    """

    inelastic: FloatArray
    crack: FloatArray
    kappa: FloatArray
    cone: FloatArray
    stress: FloatArray


class Strengths(NamedTuple):
    """`tensile` (e, q), Pa, at kappa = 0, falling with kappa by `ductility` (e,) down to the part `floor`.

    With an infinite ductility the strengths are frozen, whatever kappa is.
    """

    tensile: FloatArray
    ductility: FloatArray
    floor: float


class Chunk(NamedTuple):
    """The elements from `start` on, as the points' update leaves them.

    `gradients` (c, q, b + k, 3), 1/m, those of the modes last; `volumes` (c, q), m³; `tangents`
    (c, q, 6, 6), Pa, and `yields` (c,), which of ELASTIC, ASSOCIATED and NON_ASSOCIATED.
    """

    start: int
    gradients: FloatArray
    volumes: FloatArray
    tangents: FloatArray
    yields: ByteArray


class Condensed(NamedTuple):
    """Elements whose modes are condensed out.

    `matrices` (c, 3b, 3b), N/m; `forces` (c, 3b), N, out of balance of the modes included; `follow`
    (c, 3k, 3b) and `lag` (c, 3k): the modes change by -(lag + follow · change of displacement).
    """

    matrices: FloatArray
    forces: FloatArray
    follow: FloatArray
    lag: FloatArray


def chunk_of(body: Body, part: slice) -> Chunk:
    """Arrays for the elements of a slice, to be filled."""
    count, points = part.stop - part.start, len(body.rule.weights)
    size = body.rule.gradients.shape[2] + body.rule.modes.shape[2]
    return Chunk(
        part.start,
        np.empty((count, points, size, 3)),
        np.empty((count, points)),
        np.empty((count, points, 6, 6)),
        np.empty(count, dtype=np.uint8),
    )


@compiled
def update_points(
    body: Body,
    strengths: Strengths,
    motion: Motion,
    before: PointFields,
    after: PointFields,
    chunk: Chunk,
    stabiliser: float,
) -> None:
    """State of the points of a chunk's elements at a motion.

    `after` receives it. The tangents, not the stresses, gain `stabiliser` times the elastic one where a point
    yields.
    """
    count = body.rule.gradients.shape[2]
    moved, strain, work = np.empty((chunk.gradients.shape[2], 3)), np.empty(6), new_workspace()
    for c in range(len(chunk.volumes)):
        e = chunk.start + c
        nodes = element_nodes(body.points, body.connectivity, e, body.rule.geometry.shape[2])
        element_gradients(nodes, body.rule, chunk.gradients[c], chunk.volumes[c])
        for b in range(count):
            moved[b] = motion.displacement[body.connectivity[e, b]]
        for b in range(count, len(moved)):
            moved[b] = motion.modes[e, 3 * (b - count) : 3 * (b - count) + 3]
        yields = ELASTIC
        for q in range(chunk.volumes.shape[1]):
            _strain(chunk.gradients[c, q], moved, strain)
            soft = Softening(
                strengths.tensile[e, q], strengths.ductility[e], strengths.floor, before.kappa[e, q]
            )
            state = PointState(before.inelastic[e, q], before.kappa[e, q], before.cone[e, q])
            active = update_point(strain, state, body.law, soft, work)
            _remember(active, before, after, e, q, work)
            if active:
                _stabilise(body.law, stabiliser, work)
                yields = NON_ASSOCIATED if active & CONE else max(yields, ASSOCIATED)
            chunk.tangents[c, q] = work.tangent
        chunk.yields[c] = yields


@compiled
def _strain(g: FloatArray, moved: FloatArray, strain: FloatArray) -> None:
    """Strain (6,) from displacements (b, 3)."""
    strain[:] = 0.0
    for b in range(len(g)):
        x, y, z = g[b]
        u, v, w = moved[b]
        strain[0] += x * u
        strain[1] += y * v
        strain[2] += z * w
        strain[3] += y * u + x * v
        strain[4] += z * v + y * w
        strain[5] += z * u + x * w


@compiled
def _remember(active: int, before: PointFields, after: PointFields, e: int, q: int, work: Workspace) -> None:
    """Write the new state of a point."""
    after.stress[e, q] = work.stress
    after.inelastic[e, q] = work.inelastic
    after.crack[e, q] = before.crack[e, q]
    after.kappa[e, q] = before.kappa[e, q] + work.g[1] + work.g[2] + work.g[3]
    after.cone[e, q] = before.cone[e, q] + work.g[0]
    if active & PLANES:
        for i in range(3):
            for r in range(6):
                after.crack[e, q, r] += (1.0 if r < 3 else 2.0) * work.g[i + 1] * work.modes[i, r]


@compiled
def _stabilise(law: PointLaw, part: float, work: Workspace) -> None:
    for i in range(3):
        for j in range(3):
            work.tangent[i, j] += part * law.lame
        work.tangent[i, i] += part * 2.0 * law.shear
        work.tangent[i + 3, i + 3] += part * law.shear


@compiled
def point_forces(chunk: Chunk, stress: FloatArray, forces: FloatArray) -> None:
    """Forces (c, 3 (b + k)), N, of the stress (e, q, 6), Pa, in a chunk's elements; the modes' last."""
    forces[:] = 0.0
    for c in range(len(chunk.volumes)):
        for q in range(chunk.volumes.shape[1]):
            s = stress[chunk.start + c, q]
            for b in range(chunk.gradients.shape[2]):
                x, y, z = chunk.gradients[c, q, b]
                volume = chunk.volumes[c, q]
                forces[c, 3 * b] += volume * (s[0] * x + s[3] * y + s[5] * z)
                forces[c, 3 * b + 1] += volume * (s[1] * y + s[3] * x + s[4] * z)
                forces[c, 3 * b + 2] += volume * (s[2] * z + s[4] * y + s[5] * x)


@compiled
def add_forces(forces: FloatArray, connectivity: IntArray, total: FloatArray) -> None:
    """Add the forces (c, >= 3b) of elements, N, to those of the points (3m,); the modes' stay aside."""
    for c in range(len(connectivity)):
        for b in range(connectivity.shape[1]):
            for i in range(3):
                total[3 * connectivity[c, b] + i] += forces[c, 3 * b + i]


@compiled
def tangent_matrices(
    chunk: Chunk, law: PointLaw, forces: FloatArray, symmetric: bool, out: Condensed
) -> None:
    """Tangent stiffness of a chunk's elements, and the forces (c, 3 (b + k)) with their modes condensed out.

    Where the cone yields, the tangent is not symmetric; its symmetric part is taken if that is asked for.
    """
    kept, rows = out.forces.shape[1], forces.shape[1]
    K, f, scratch = np.empty((rows, rows)), np.empty(rows), np.empty((rows, rows))
    for c in range(len(chunk.volumes)):
        if chunk.yields[c] == ELASTIC:
            elastic_matrix(chunk.gradients[c], chunk.volumes[c], law.lame, law.shear, scratch, K)
        else:
            K[:] = 0.0
            for q in range(chunk.volumes.shape[1]):
                _add_tangent(chunk.gradients[c, q], chunk.volumes[c, q], chunk.tangents[c, q], K)
        if symmetric and chunk.yields[c] == NON_ASSOCIATED:
            for i in range(rows):
                for j in range(i):
                    K[i, j] = K[j, i] = 0.5 * (K[i, j] + K[j, i])
        f[:] = forces[c]
        if rows > kept:
            _condense_modes(K, f, kept)
            out.follow[c] = K[kept:, :kept]
            out.lag[c] = f[kept:]
        out.matrices[c] = K[:kept, :kept]
        out.forces[c] = f[:kept]


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
    """Eliminate the modes, in place: Gauss-Jordan on their rows, which then say how they follow."""
    rows = len(K)
    for pivot in range(kept, rows):
        scale = 1.0 / K[pivot, pivot]
        for j in range(rows):
            K[pivot, j] *= scale
        f[pivot] *= scale
        for i in range(rows):
            factor = K[i, pivot]
            if i != pivot and factor != 0.0:
                for j in range(rows):
                    K[i, j] -= factor * K[pivot, j]
                f[i] -= factor * f[pivot]
