"""Consistent tangent at a point in space, compiled by numba.

References
----------
E. A. de Souza Neto, D. Peric, D. R. J. Owen, "Computational Methods for Plasticity", 2008, chapter 8 and
appendix A.
"""

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.return_map import APEX, CONE, PLANES, PointLaw, Softening, strength_slope
from solvers.compiled.workspace import COLUMN, ROW, Workspace

__all__ = ["elastic_tangent", "point_tangent"]

FloatArray = NDArray[np.float64]

TIE = 1e-12
"""Trial stresses closer than this part of the bulk modulus are equal."""


@compiled
def elastic_tangent(law: PointLaw, tangent: FloatArray) -> None:
    """Elastic stiffness (6, 6), Pa."""
    for r in range(6):
        for c in range(6):
            tangent[r, c] = law.lame if r < 3 and c < 3 else 0.0
        tangent[r, r] += law.shear * (2.0 if r < 3 else 1.0)


@compiled
def point_tangent(active: int, now: PointLaw, soft: Softening, work: Workspace) -> None:
    """Consistent tangent of the point that `return_point` has just treated, into `work.tangent`."""
    _principal_tangent(active, now, soft, work)
    _spatial_tangent(now, work)


@compiled
def _principal_tangent(active: int, law: PointLaw, soft: Softening, work: Workspace) -> None:
    """Consistent tangent in principal axes, Xi - Xi M (Nt Xi M + H)^-1 Nt Xi, into `work.stiffness`."""
    Xi = work.stiffness
    for i in range(3):
        for j in range(3):
            elastic = law.lame + (2.0 * law.shear if i == j else 0.0)
            Xi[i, j] = 0.0 if active & APEX else elastic
    if active == 0 or active & APEX:
        return
    M, N, bends = np.zeros((3, 4)), np.zeros((3, 4)), np.zeros((4, 4))
    count = 0
    if active & CONE:
        _bend(law, work)
        mean = (work.principal[0] + work.principal[1] + work.principal[2]) / 3.0
        root_j2 = _root_j2(work.principal)
        for i in range(3):
            M[i, 0] = (work.principal[i] - mean) / (2.0 * root_j2) + law.eta
            N[i, 0] = (work.principal[i] - mean) / (2.0 * root_j2) + law.alpha
        bends[0, 0] = law.hardening
        count = 1
    slope = strength_slope(soft, work.g[1] + work.g[2] + work.g[3]) if active & PLANES else 0.0
    for a in range(count, 4):
        for b in range(count, 4):
            bends[a, b] = slope
    for i in range(3):
        if active & (2 << i):
            M[i, count] = N[i, count] = 1.0
            count += 1
    _project(Xi, M, N, bends, count)


@compiled
def _project(Xi: FloatArray, M: FloatArray, N: FloatArray, bends: FloatArray, count: int) -> None:
    """Take the `count` active modes out of a stiffness Xi (3, 3), in place."""
    out, on = np.zeros((3, 4)), np.zeros((4, 3))
    for i in range(3):
        for a in range(count):
            for j in range(3):
                out[i, a] += Xi[i, j] * M[j, a]
                on[a, i] += N[j, a] * Xi[j, i]
    for a in range(count):
        for b in range(count):
            for i in range(3):
                bends[a, b] += N[i, a] * out[i, b]
    _invert(bends, count)
    for i in range(3):
        for j in range(3):
            for a in range(count):
                for b in range(count):
                    Xi[i, j] -= out[i, a] * bends[a, b] * on[b, j]


@compiled
def _invert(A: FloatArray, n: int) -> None:
    """Invert the leading n x n part in place, by Gauss-Jordan with complete pivoting on the diagonal."""
    done = np.zeros(4, dtype=np.bool_)
    for _ in range(n):
        pivot = -1
        for i in range(n):
            if not done[i] and (pivot < 0 or abs(A[i, i]) > abs(A[pivot, pivot])):
                pivot = i
        done[pivot] = True
        scale = 1.0 / A[pivot, pivot]
        A[pivot, pivot] = 1.0
        for j in range(n):
            A[pivot, j] *= scale
        for i in range(n):
            if i != pivot:
                factor = A[i, pivot]
                A[i, pivot] = 0.0
                for j in range(n):
                    A[i, j] -= factor * A[pivot, j]


@compiled
def _root_j2(stress: FloatArray) -> float:
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    return float(np.sqrt(0.5 * ((stress[0] - mean) ** 2 + (stress[1] - mean) ** 2 + (stress[2] - mean) ** 2)))


@compiled
def _bend(law: PointLaw, work: Workspace) -> None:
    """Xi = (De^-1 + g H)^-1 with the second derivative H of sqrt(J2), into `work.stiffness`."""
    young = 9.0 * law.bulk * law.shear / (3.0 * law.bulk + law.shear)
    poisson = 0.5 * law.lame / (law.lame + law.shear)
    mean = (work.principal[0] + work.principal[1] + work.principal[2]) / 3.0
    root_j2 = _root_j2(work.principal)
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            fall = (work.principal[i] - mean) * (work.principal[j] - mean) / (2.0 * root_j2**2)
            curvature = (same - 1.0 / 3.0 - fall) / (2.0 * root_j2)
            work.stiffness[i, j] = ((1.0 + poisson) * same - poisson) / young + work.g[0] * curvature
    _invert(work.stiffness, len(work.stiffness))


@compiled
def _spatial_tangent(law: PointLaw, work: Workspace) -> None:
    """Turn the tangent from principal axes into space; shear stiffnesses follow the turning axes."""
    tangent, T, axes, modes = work.tangent, work.stiffness, work.axes, work.modes
    turned, shear = np.empty((3, 6)), np.empty(6)
    for a in range(3):
        for c in range(6):
            turned[a, c] = T[a, 0] * modes[0, c] + T[a, 1] * modes[1, c] + T[a, 2] * modes[2, c]
    for r in range(6):
        for c in range(6):
            tangent[r, c] = (
                modes[0, r] * turned[0, c] + modes[1, r] * turned[1, c] + modes[2, r] * turned[2, c]
            )
    for a, b in ((0, 1), (0, 2), (1, 2)):
        apart = work.trial[a] - work.trial[b]
        if abs(apart) < TIE * law.bulk:
            stiffness = 0.5 * (T[a, a] - T[a, b])
        else:
            stiffness = law.shear * (work.principal[a] - work.principal[b]) / apart
        for r in range(6):
            i, j = ROW[r], COLUMN[r]
            shear[r] = axes[i, a] * axes[j, b] + axes[j, a] * axes[i, b]
        for r in range(6):
            for c in range(6):
                tangent[r, c] += stiffness * shear[r] * shear[c]
