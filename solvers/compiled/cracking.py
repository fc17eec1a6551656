"""States of the integration points, element forces and tangent stiffness of masonry that cracks, by numba.

The incompatible modes of eight-node hexahedra are unknowns of their element alone. Their equations are solved
along with the mesh's: each iteration condenses them out and keeps what is needed to follow the displacements.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.point_tangent import point_tangent
from solvers.compiled.point_update import PointState, elastic_stress, return_point, stays_elastic
from solvers.compiled.return_map import PLANES, PointLaw, Softening
from solvers.compiled.stiffness import Rule, element_gradients, element_nodes
from solvers.compiled.workspace import Workspace, new_workspace

__all__ = [
    "Body",
    "Chunk",
    "Motion",
    "PointFields",
    "Strengths",
    "add_forces",
    "chunk_of",
    "point_forces",
    "update_points",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
ByteArray = NDArray[np.uint8]


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

    `gradients` (c, q, b + k, 3), 1/m, those of the modes last; `volumes` (c, q), m³; `strains` (c, q, 6);
    `active` (c, q), the active sets, 0 where a point is elastic; `tangents` (c, q, 6, 6), Pa, where it is
    not. A chunk without room for tangents is one whose forces alone are wanted.
    """

    start: int
    gradients: FloatArray
    volumes: FloatArray
    strains: FloatArray
    active: ByteArray
    tangents: FloatArray


def chunk_of(body: Body, part: slice, *, tangents: bool) -> Chunk:
    """Arrays for the elements of a slice, to be filled; `tangents`: whether there is room for those."""
    count, points = part.stop - part.start, len(body.rule.weights)
    size = body.rule.gradients.shape[2] + body.rule.modes.shape[2]
    return Chunk(
        part.start,
        np.empty((count, points, size, 3)),
        np.empty((count, points)),
        np.empty((count, points, 6)),
        np.empty((count, points), dtype=np.uint8),
        np.empty((count if tangents else 0, points, 6, 6)),
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
    for c in range(len(chunk.volumes)):
        nodes = element_nodes(body.points, body.connectivity, chunk.start + c, body.rule.geometry.shape[2])
        element_gradients(nodes, body.rule, chunk.gradients[c], chunk.volumes[c])
    _strains(body.connectivity, motion, chunk)
    _respond(body.law, strengths, before, after, chunk, stabiliser)


@compiled
def _strains(connectivity: IntArray, motion: Motion, chunk: Chunk) -> None:
    """Strains at the points of a chunk's elements."""
    start, gradients, volumes, strains, _, _ = chunk
    displacement, amplitudes = motion
    count, size = connectivity.shape[1], gradients.shape[2]
    moved = np.empty((size, 3))
    for c in range(len(volumes)):
        for i in range(3):
            for b in range(count):
                moved[b, i] = displacement[connectivity[start + c, b], i]
            for b in range(count, size):
                moved[b, i] = amplitudes[start + c, 3 * (b - count) + i]
        for q in range(volumes.shape[1]):
            xx = yy = zz = xy = yz = xz = 0.0
            for b in range(size):
                x, y, z = gradients[c, q, b, 0], gradients[c, q, b, 1], gradients[c, q, b, 2]
                u, v, w = moved[b, 0], moved[b, 1], moved[b, 2]
                xx += x * u
                yy += y * v
                zz += z * w
                xy += y * u + x * v
                yz += z * v + y * w
                xz += z * u + x * w
            strains[c, q, 0], strains[c, q, 1], strains[c, q, 2] = xx, yy, zz
            strains[c, q, 3], strains[c, q, 4], strains[c, q, 5] = xy, yz, xz


@compiled
def _respond(
    law: PointLaw,
    strengths: Strengths,
    before: PointFields,
    after: PointFields,
    chunk: Chunk,
    stabiliser: float,
) -> None:
    """States, active sets and tangents at the strains of a chunk."""
    # Arrays by name: an attribute of a record or a view of a row would be counted, by all threads in turn,
    # which takes longer than an elastic point's arithmetic.
    start, _, volumes, strains, active, tangents = chunk
    inelastic, crack, kappa, cone, _ = before
    new_inelastic, new_crack, new_kappa, new_cone, new_stress = after
    tensile, ductility, floor = strengths
    work = new_workspace()
    for c in range(len(volumes)):
        e = start + c
        for q in range(volumes.shape[1]):
            soft = Softening(tensile[e, q], ductility[e], floor, kappa[e, q])
            stress = elastic_stress(
                law,
                strains[c, q, 0] - inelastic[e, q, 0],
                strains[c, q, 1] - inelastic[e, q, 1],
                strains[c, q, 2] - inelastic[e, q, 2],
                strains[c, q, 3] - inelastic[e, q, 3],
                strains[c, q, 4] - inelastic[e, q, 4],
                strains[c, q, 5] - inelastic[e, q, 5],
            )
            active[c, q] = 0
            new_kappa[e, q], new_cone[e, q] = kappa[e, q], cone[e, q]
            for r in range(6):
                new_stress[e, q, r] = stress[r]
                new_inelastic[e, q, r] = inelastic[e, q, r]
                new_crack[e, q, r] = crack[e, q, r]
            if stays_elastic(stress, law, soft, cone[e, q]):
                continue
            state = PointState(inelastic[e, q], kappa[e, q], cone[e, q])
            active[c, q], now = return_point(strains[c, q], state, law, soft, work)
            _remember(active[c, q], after, e, q, work)
            if active[c, q] and len(tangents):
                point_tangent(active[c, q], now, soft, work)
                _stabilise(law, stabiliser, work)
                tangents[c, q] = work.tangent


@compiled
def _remember(active: int, after: PointFields, e: int, q: int, work: Workspace) -> None:
    """Add what a point did to the state that it had."""
    g, modes = work.g, work.modes
    after.kappa[e, q] += g[1] + g[2] + g[3]
    after.cone[e, q] += g[0]
    for r in range(6):
        after.stress[e, q, r], after.inelastic[e, q, r] = work.stress[r], work.inelastic[r]
        if active & PLANES:
            opened = g[1] * modes[0, r] + g[2] * modes[1, r] + g[3] * modes[2, r]
            after.crack[e, q, r] += (1.0 if r < 3 else 2.0) * opened


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
    start, gradients, volumes, _, _, _ = chunk
    for c in range(len(volumes)):
        for q in range(volumes.shape[1]):
            volume, e = volumes[c, q], start + c
            xx, yy, zz = volume * stress[e, q, 0], volume * stress[e, q, 1], volume * stress[e, q, 2]
            xy, yz, xz = volume * stress[e, q, 3], volume * stress[e, q, 4], volume * stress[e, q, 5]
            for b in range(gradients.shape[2]):
                x, y, z = gradients[c, q, b, 0], gradients[c, q, b, 1], gradients[c, q, b, 2]
                forces[c, 3 * b] += xx * x + xy * y + xz * z
                forces[c, 3 * b + 1] += yy * y + xy * x + yz * z
                forces[c, 3 * b + 2] += zz * z + yz * y + xz * x


@compiled
def add_forces(forces: FloatArray, connectivity: IntArray, total: FloatArray) -> None:
    """Add the forces (c, >= 3b) of elements, N, to those of the points (3m,); the modes' stay aside."""
    for c in range(len(connectivity)):
        for b in range(connectivity.shape[1]):
            for i in range(3):
                total[3 * connectivity[c, b] + i] += forces[c, 3 * b + i]
