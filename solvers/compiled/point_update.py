"""Stress and consistent tangent at a point in space, compiled by numba.

Strain, stress and tangent are ordered xx, yy, zz, xy, yz, xz, with engineering shear strains. The return map
works in the principal axes of the trial strain, which are those of the stress as well.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.return_map import (
    APEX,
    CONE,
    PLANES,
    ROOT3,
    PointLaw,
    Softening,
    principal_return,
    strength,
    strength_slope,
)

__all__ = ["PointState", "Workspace", "new_workspace", "principal_axes", "update_point"]

FloatArray = NDArray[np.float64]

ROW = np.array([0, 1, 2, 0, 1, 0])
COLUMN = np.array([0, 1, 2, 1, 2, 2])
"""Tensor indices of the six components."""
TIE = 1e-12
"""Trial stresses closer than this part of the bulk modulus are equal."""


class PointState(NamedTuple):
    """What a point remembers: inelastic strain (6,), sums of the planes' and of the cone's multipliers."""

    inelastic: FloatArray
    kappa: float
    cone: float


class Workspace(NamedTuple):
    """Arrays that `update_point` writes to, made once per thread.

    `stress` (6,), Pa; `tangent` (6, 6), Pa; `inelastic` (6,), the new inelastic strain; `g` (4,), the
    multipliers of the cone and of the three planes; the others are scratch.
    """

    stress: FloatArray
    tangent: FloatArray
    inelastic: FloatArray
    g: FloatArray
    tensor: FloatArray
    axes: FloatArray
    values: FloatArray
    trial: FloatArray
    principal: FloatArray
    modes: FloatArray
    stiffness: FloatArray


@compiled
def new_workspace() -> Workspace:
    """Workspace for one thread."""
    return Workspace(
        np.zeros(6),
        np.zeros((6, 6)),
        np.zeros(6),
        np.zeros(4),
        np.zeros((3, 3)),
        np.zeros((3, 3)),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
        np.zeros((3, 6)),
        np.zeros((3, 3)),
    )


@compiled
def principal_axes(tensor: FloatArray, values: FloatArray, axes: FloatArray) -> None:
    """Eigenvalues, descending, and eigenvectors (columns) of a symmetric tensor (3, 3), in its place.

    Cyclic Jacobi rotations: for three by three as fast as the closed form, and exact for equal values too.
    """
    for i in range(3):
        for j in range(3):
            axes[i, j] = 1.0 if i == j else 0.0
    for _ in range(30):
        off = tensor[0, 1] ** 2 + tensor[0, 2] ** 2 + tensor[1, 2] ** 2
        if off <= 1e-34 * (tensor[0, 0] ** 2 + tensor[1, 1] ** 2 + tensor[2, 2] ** 2 + off):
            break
        for p in range(2):
            for q in range(p + 1, 3):
                if tensor[p, q] != 0.0:
                    _rotate(tensor, axes, p, q)
    for i in range(3):
        values[i] = tensor[i, i]
    _sort(values, axes)


@compiled
def _sort(values: FloatArray, axes: FloatArray) -> None:
    """Descending, the axes with them."""
    for last in (2, 1):
        for i in range(last):
            if values[i] < values[i + 1]:
                values[i], values[i + 1] = values[i + 1], values[i]
                for r in range(3):
                    axes[r, i], axes[r, i + 1] = axes[r, i + 1], axes[r, i]


@compiled
def _rotate(tensor: FloatArray, axes: FloatArray, p: int, q: int) -> None:
    """One Jacobi rotation that makes the component p, q vanish."""
    theta = (tensor[q, q] - tensor[p, p]) / (2.0 * tensor[p, q])
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    t = -t if theta < 0.0 else t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for r in range(3):
        a, b = tensor[r, p], tensor[r, q]
        tensor[r, p], tensor[r, q] = c * a - s * b, s * a + c * b
    for r in range(3):
        a, b = tensor[p, r], tensor[q, r]
        tensor[p, r], tensor[q, r] = c * a - s * b, s * a + c * b
        a, b = axes[r, p], axes[r, q]
        axes[r, p], axes[r, q] = c * a - s * b, s * a + c * b


@compiled
def update_point(
    strain: FloatArray, state: PointState, law: PointLaw, soft: Softening, work: Workspace
) -> int:
    """Stress, tangent, inelastic strain and multipliers at a strain (6,); returns the active set."""
    if _stays_elastic(strain, state, law, soft, work):
        return 0
    for r in range(6):
        i, j = ROW[r], COLUMN[r]
        value = (strain[r] - state.inelastic[r]) * (1.0 if r < 3 else 0.5)
        work.tensor[i, j] = work.tensor[j, i] = value
        work.inelastic[r] = state.inelastic[r]
    trace = work.tensor[0, 0] + work.tensor[1, 1] + work.tensor[2, 2]
    principal_axes(work.tensor, work.values, work.axes)
    for i in range(3):
        work.trial[i] = law.lame * trace + 2.0 * law.shear * work.values[i]
    active, now = _return(state, law, soft, work)
    _spread(law, work)
    _principal_tangent(active, now, soft, work)
    _spatial_tangent(law, work)
    return active


@compiled
def _stays_elastic(
    strain: FloatArray, state: PointState, law: PointLaw, soft: Softening, work: Workspace
) -> bool:
    """Whether a bound on the first principal stress, without its axes, shows that nothing yields."""
    mean, j2 = 0.0, 0.0
    for r in range(6):
        elastic = strain[r] - state.inelastic[r]
        work.stress[r] = law.shear * elastic * (2.0 if r < 3 else 1.0)
        mean += elastic * (law.bulk - 2.0 * law.shear / 3.0) if r < 3 else 0.0
    for r in range(3):
        work.stress[r] += mean
    mean = (work.stress[0] + work.stress[1] + work.stress[2]) / 3.0
    for r in range(3):
        j2 += 0.5 * (work.stress[r] - mean) ** 2 + work.stress[r + 3] ** 2
    root_j2 = np.sqrt(j2)
    cone = max(law.cone + law.hardening * state.cone, law.least_cone)
    if 3.0 * law.alpha * mean + root_j2 > cone or mean + 2.0 / ROOT3 * root_j2 > strength(soft, 0.0):
        return False
    for i in range(4):
        work.g[i] = 0.0
    for r in range(6):
        work.inelastic[r] = state.inelastic[r]
        for c in range(6):
            work.tangent[r, c] = law.lame if r < 3 and c < 3 else 0.0
        work.tangent[r, r] += law.shear * (2.0 if r < 3 else 1.0)
    return True


@compiled
def _spread(law: PointLaw, work: Workspace) -> None:
    """Stress and inelastic strain in space: what of the strain is not elastic is inelastic."""
    young = 9.0 * law.bulk * law.shear / (3.0 * law.bulk + law.shear)
    poisson = 0.5 * law.lame / (law.lame + law.shear)
    total = work.principal[0] + work.principal[1] + work.principal[2]
    for r in range(6):
        work.stress[r] = 0.0
    for a in range(3):
        elastic = ((1.0 + poisson) * work.principal[a] - poisson * total) / young
        for r in range(6):
            work.modes[a, r] = work.axes[ROW[r], a] * work.axes[COLUMN[r], a]
            work.stress[r] += work.principal[a] * work.modes[a, r]
            work.inelastic[r] += (1.0 if r < 3 else 2.0) * (work.values[a] - elastic) * work.modes[a, r]


@compiled
def _return(state: PointState, law: PointLaw, soft: Softening, work: Workspace) -> tuple[int, PointLaw]:
    """Return map with the cone as strong as it is now; where it softens past its least, at the least."""
    if law.hardening == 0.0:
        return principal_return(work.trial, law, soft, work.principal, work.g), law
    now = _with_cone(law, max(law.cone + law.hardening * state.cone, law.least_cone), law.hardening)
    active = principal_return(work.trial, now, soft, work.principal, work.g)
    if now.cone + law.hardening * work.g[0] < law.least_cone:
        now = _with_cone(law, law.least_cone, 0.0)
        active = principal_return(work.trial, now, soft, work.principal, work.g)
    return active, now


@compiled
def _with_cone(law: PointLaw, cone: float, hardening: float) -> PointLaw:
    return PointLaw(law.alpha, cone, law.eta, hardening, law.least_cone, law.shear, law.bulk, law.lame)


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
    tangent, T, shear = work.tangent, work.stiffness, np.empty(6)
    for r in range(6):
        for c in range(6):
            tangent[r, c] = 0.0
            for a in range(3):
                for b in range(3):
                    tangent[r, c] += T[a, b] * work.modes[a, r] * work.modes[b, c]
    for a, b in ((0, 1), (0, 2), (1, 2)):
        apart = work.trial[a] - work.trial[b]
        if abs(apart) < TIE * law.bulk:
            stiffness = 0.5 * (T[a, a] - T[a, b])
        else:
            stiffness = law.shear * (work.principal[a] - work.principal[b]) / apart
        for r in range(6):
            i, j = ROW[r], COLUMN[r]
            shear[r] = work.axes[i, a] * work.axes[j, b] + work.axes[j, a] * work.axes[i, b]
        for r in range(6):
            for c in range(6):
                tangent[r, c] += stiffness * shear[r] * shear[c]
