"""MKL PARDISO by way of the package pypardiso."""

import os
import sys
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError, InputError
from solvers.compiled.pattern import Pattern

__all__ = ["Pardiso", "too_large"]

FloatArray = NDArray[np.float64]


class Pardiso:
    """MKL PARDISO; orders the unknowns once."""

    name = "MKL PARDISO"
    refined = 1e-13

    def __init__(self, pattern: Pattern, *, positive: bool) -> None:
        from pypardiso import PyPardisoSolver

        self._pattern = pattern
        self._matrix: Any = None
        _name_mkl()
        # 2: symmetric, positive definite; -2: indefinite, as a cracked wall's tangent may be; 11: any.
        symmetric = 2 if positive else -2
        try:
            self._solver = PyPardisoSolver(mtype=symmetric if pattern.upper else 11)
        except (ImportError, OSError) as error:
            msg = "MKL, which pypardiso needs, cannot be loaded: install mkl, or choose solver 'superlu'."
            raise InputError(msg) from error

    def factorise(self, values: FloatArray) -> None:
        """Take new values (z,) of the pattern."""
        from scipy.sparse import csr_matrix

        ordered = self._matrix is not None
        rows = self._pattern.starts.astype(np.int32)
        shape = (self._pattern.unknowns,) * 2
        self._matrix = csr_matrix((values, self._pattern.columns, rows), shape=shape, copy=False)
        # 12: order and factorise; 22: factorise only.
        self._call(22 if ordered else 12, np.zeros(self._pattern.unknowns))

    def solve(self, load: FloatArray) -> FloatArray:
        """Solution (n,) for a right-hand side (n,)."""
        return self._call(33, np.ascontiguousarray(load))

    def _call(self, phase: int, load: FloatArray) -> FloatArray:
        # pypardiso's public functions order anew for every matrix, and compare it with the last one at every
        # solution; what they call in the end does neither.
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._solver.set_phase(phase)
        try:
            solution: FloatArray = self._solver._call_pardiso(self._matrix, load)
        except PyPardisoError as error:
            raise ConvergenceError(_pardiso_message(error.value, len(load))) from error
        return solution

    def __del__(self) -> None:
        # At the end of the process, the memory goes by itself and scipy may be gone.
        if self._matrix is not None and not sys.is_finalizing():
            self._solver.free_memory(everything=True)


def _name_mkl() -> None:
    """Tell pypardiso where MKL is: its own search starts compilers and takes a second or two."""
    if "PYPARDISO_MKL_RT" in os.environ:
        return
    try:
        installed = files("mkl") or []
    except PackageNotFoundError:
        return
    for file in installed:
        if file.name.startswith(("libmkl_rt.", "mkl_rt.")) and file.suffix != ".lib":
            os.environ["PYPARDISO_MKL_RT"] = str(Path(str(file.locate())).resolve())


def _pardiso_message(code: int, unknowns: int) -> str:
    """What PARDISO's error code means for a wall."""
    if code in {-2, -9, -10, -11}:
        return too_large(unknowns)
    if code in {-4, -7}:
        return (
            f"The stiffness of {unknowns} unknowns is singular (MKL PARDISO): "
            "the wall is not held well enough, or its elements are too distorted."
        )
    return f"MKL PARDISO failed on {unknowns} unknowns (its error {code})."


def too_large(unknowns: int) -> str:
    """What to do when the memory is short."""
    return f"Not enough memory to factorise {unknowns} unknowns: choose larger elements, or solver 'amg'."
