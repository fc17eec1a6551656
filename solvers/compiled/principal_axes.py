"""Principal axes of a symmetric tensor, compiled by numba."""

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled

__all__ = ["principal_axes"]

FloatArray = NDArray[np.float64]


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
