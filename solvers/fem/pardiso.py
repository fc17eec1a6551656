"""MKL PARDISO by way of the package pypardiso."""

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ConvergenceError, InputError
from solvers.compiled.pattern import Pattern

__all__ = ["Pardiso", "too_large"]

FloatArray = NDArray[np.float64]

POSITIVE, SYMMETRIC, ANY = 2, -2, 11
"""MKL's types of matrices: symmetric and positive definite, symmetric, any."""
SETTINGS = {
    POSITIVE: {1: 1, 2: 3},
    SYMMETRIC: {1: 1, 2: 3, 10: 8, 21: 1},
    ANY: {1: 1, 2: 3, 10: 13, 11: 1, 13: 1},
}
"""By type, the settings that MKL's documentation gives as its own.

1: they are given; 2: nested dissection, on all cores; 10: pivots smaller than 10 to minus this are moved; 11
and 13: scaling and matching; 21: 2 x 2 pivots. Not given, they would be the same, but a solution would take
four times as long.
"""
SINGULAR = {-4, -7}


class Pardiso:
    """MKL PARDISO; orders the unknowns once.

    A symmetric matrix goes to Cholesky, which is faster, until one comes that is not positive definite, as a
    cracked wall's tangent may be; this one and all others go to LDLᵀ. Where `positive` promises that
    there is none, such a matrix is refused.
    """

    name = "MKL PARDISO"
    refined = 1e-13

    def __init__(self, pattern: Pattern, *, positive: bool) -> None:
        self._pattern, self._positive = pattern, positive
        self._matrix: Any = None
        self._start(POSITIVE if pattern.upper else ANY)

    def _start(self, kind: int) -> None:
        """A solver of a type of matrix, which has yet to order the unknowns."""
        _prepare_mkl()
        self._kind, self._ordered = kind, False
        try:
            # The import looks for MKL as well.
            from pypardiso import PyPardisoSolver

            self._solver = PyPardisoSolver(mtype=kind)
        except (ImportError, OSError) as error:
            msg = "MKL, which pypardiso needs, cannot be loaded: install mkl, or choose solver 'superlu'."
            raise InputError(msg) from error
        for number, value in SETTINGS[kind].items():
            self._solver.set_iparm(number, value)

    def factorise(self, values: FloatArray) -> None:
        """Take new values (z,) of the pattern."""
        from scipy.sparse import csr_matrix

        rows = self._pattern.starts.astype(np.int32)
        shape = (self._pattern.unknowns,) * 2
        self._matrix = csr_matrix((values, self._pattern.columns, rows), shape=shape, copy=False)
        error = self._factorise()
        if error in SINGULAR and self._kind == POSITIVE and not self._positive:
            self._solver.free_memory(everything=True)
            self._start(SYMMETRIC)
            error = self._factorise()
        if error:
            raise ConvergenceError(_pardiso_message(error, self._pattern.unknowns))

    def _factorise(self) -> int:
        """PARDISO's error, 0 if there is none."""
        from pypardiso.pardiso_wrapper import PyPardisoError

        try:
            # 12: order and factorise; 22: factorise only.
            self._call(22 if self._ordered else 12, np.zeros(self._pattern.unknowns))
        except PyPardisoError as error:
            return int(error.value)
        self._ordered = True
        return 0

    def solve(self, load: FloatArray) -> FloatArray:
        """Solution (n,) for a right-hand side (n,)."""
        from pypardiso.pardiso_wrapper import PyPardisoError

        try:
            return self._call(33, np.ascontiguousarray(load))
        except PyPardisoError as error:
            raise ConvergenceError(_pardiso_message(error.value, len(load))) from error

    def _call(self, phase: int, load: FloatArray) -> FloatArray:
        # pypardiso's public functions order anew for every matrix, and compare it with the last one at every
        # solution; what they call in the end does neither.
        self._solver.set_phase(phase)
        solution: FloatArray = self._solver._call_pardiso(self._matrix, load)
        return solution

    def __del__(self) -> None:
        # At the end of the process, the memory goes by itself and scipy may be gone.
        if self._matrix is not None and not sys.is_finalizing():
            self._solver.free_memory(everything=True)


def _prepare_mkl() -> None:
    """Before MKL is loaded: ask it for the same digits in every run, and tell pypardiso where it is.

    The digits depend on the order of sums, which would change with how arrays lie in memory and with the
    threads' timing. pypardiso's own search starts compilers and takes a second or two.
    """
    from importlib.metadata import PackageNotFoundError, files

    os.environ.setdefault("MKL_CBWR", "AUTO")
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
