"""The fixed pattern of a stiffness matrix: found once, filled as often as needed.

Prescribed displacements have no equation, so nothing is cut out of the matrix later. Rows are those of free
displacements, components x, y, z of each point in turn, and columns ascend.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from solvers.compiled.jit import compiled
from solvers.compiled.stiffness import Rows

if TYPE_CHECKING:
    from scipy.sparse import bsr_matrix, csr_array, csr_matrix

__all__ = ["Pattern", "build_pattern", "whole"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Pattern:
    """Compressed rows of the free displacements' stiffness.

    Attributes
    ----------
    equation : (3m,) int32 array
        Number of each displacement component's equation, -1 where it is prescribed.
    starts : (n + 1,) int64 array
        Where each row begins.
    columns : (z,) int32 array
    upper : bool
        Whether only the columns from the diagonal on are kept: the matrix is symmetric.
    """

    equation: Int32Array
    starts: Int64Array
    columns: Int32Array
    upper: bool

    @property
    def unknowns(self) -> int:
        """Number of equations."""
        return len(self.starts) - 1

    @property
    def diagonal(self) -> Int64Array:
        """Place of each row's diagonal entry among the columns."""
        if self.upper:
            return self.starts[:-1]
        row = np.repeat(np.arange(self.unknowns), np.diff(self.starts))
        return np.flatnonzero(self.columns == row)

    @property
    def rows(self) -> Rows:
        """The arrays, for the compiled functions."""
        return Rows(self.equation, self.starts, self.columns)

    def matrix(self, values: FloatArray) -> "csr_array":
        """The matrix with these values (z,), without a copy."""
        from scipy.sparse import csr_array

        shape = (self.unknowns, self.unknowns)
        return csr_array((values, self.columns, self.starts), shape=shape, copy=False)


def build_pattern(
    connectivity: NDArray[np.intp], *, points: int, prescribed: BoolArray, upper: bool
) -> Pattern:
    """Pattern of a mesh.

    Parameters
    ----------
    connectivity : (e, b) int array
        Points of each element.
    points : int
        Their number m.
    prescribed : (3m,) bool array
        Components that are not unknown.
    upper : bool
        Keep the upper triangle only.

    Examples
    --------
    >>> pattern = build_pattern(
    ...     np.array([[0, 1]]), points=2, prescribed=np.array([1, 1, 1, 0, 0, 1], dtype=bool), upper=True
    ... )
    >>> pattern.equation.tolist(), pattern.starts.tolist(), pattern.columns.tolist()
    ([-1, -1, -1, 0, 1, -1], [0, 2, 3], [0, 1, 1])
    """
    equation = np.where(prescribed, -1, np.cumsum(~prescribed) - 1).astype(np.int32)
    members = connectivity.astype(np.int32)
    elements = np.argsort(members.ravel(), kind="stable").astype(np.int32) // np.int32(members.shape[1])
    first = np.concatenate([[0], np.cumsum(np.bincount(members.ravel(), minlength=points))])
    starts = np.zeros(int(equation.max(initial=-1)) + 2, dtype=np.int64)
    _count_columns(members, elements, first, equation, upper, starts)
    np.cumsum(starts, out=starts)
    columns = np.empty(int(starts[-1]), dtype=np.int32)
    _fill_columns(members, elements, first, equation, upper, starts, columns)
    return Pattern(equation=equation, starts=starts, columns=columns, upper=upper)


@compiled
def _neighbours(
    point: int,
    members: Int32Array,
    elements: Int32Array,
    first: Int64Array,
    seen: Int32Array,
    found: Int32Array,
) -> int:
    """Points that share an element with a point, into `found`; their number."""
    count = 0
    for k in range(first[point], first[point + 1]):
        for b in range(members.shape[1]):
            other = members[elements[k], b]
            if seen[other] != point:
                seen[other] = point
                found[count] = other
                count += 1
    return count


@compiled
def _sort(found: Int32Array, count: int) -> None:
    """Sort the first entries by insertion: they are few, and numba's own sort takes seconds to compile."""
    for i in range(1, count):
        value, j = found[i], i
        while j > 0 and found[j - 1] > value:
            found[j] = found[j - 1]
            j -= 1
        found[j] = value


@compiled
def _count_columns(
    members: Int32Array,
    elements: Int32Array,
    first: Int64Array,
    equation: Int32Array,
    upper: bool,
    starts: Int64Array,
) -> None:
    """Number of entries of row i into starts[i + 1]."""
    points = len(first) - 1
    seen = np.full(points, -1, dtype=np.int32)
    found = np.empty(points, dtype=np.int32)
    for point in range(points):
        count = _neighbours(point, members, elements, first, seen, found)
        for row in equation[3 * point : 3 * point + 3]:
            if row < 0:
                continue
            for other in found[:count]:
                for column in equation[3 * other : 3 * other + 3]:
                    if column >= row or (column >= 0 and not upper):
                        starts[row + 1] += 1


@compiled
def _fill_columns(
    members: Int32Array,
    elements: Int32Array,
    first: Int64Array,
    equation: Int32Array,
    upper: bool,
    starts: Int64Array,
    columns: Int32Array,
) -> None:
    """Columns of each row, ascending: equations follow the points."""
    points = len(first) - 1
    seen = np.full(points, -1, dtype=np.int32)
    found = np.empty(points, dtype=np.int32)
    for point in range(points):
        count = _neighbours(point, members, elements, first, seen, found)
        _sort(found, count)
        for row in equation[3 * point : 3 * point + 3]:
            if row < 0:
                continue
            place = starts[row]
            for other in found[:count]:
                for column in equation[3 * other : 3 * other + 3]:
                    if column >= row or (column >= 0 and not upper):
                        columns[place] = column
                        place += 1


def whole(
    pattern: Pattern, values: FloatArray, dtype: type[np.floating] = np.float64
) -> "bsr_matrix | csr_matrix":
    """The matrix with both triangles, columns ascending; in 3 x 3 blocks if no point is held in part."""
    from scipy.sparse import bsr_matrix, csr_matrix

    size = pattern.unknowns
    if not pattern.upper:
        return csr_matrix((values.astype(dtype), pattern.columns, pattern.starts), shape=(size, size))
    free = (pattern.equation >= 0).reshape(-1, 3)
    block = 3 if (free.all(axis=1) == free.any(axis=1)).all() else 1
    starts = _block_starts(pattern.starts, pattern.columns, block)
    columns = np.empty(int(starts[-1]), dtype=np.int32)
    blocks = np.empty((len(columns), block, block), dtype=dtype)
    _mirror(pattern.starts, pattern.columns, values, starts, columns, blocks)
    if block == 1:
        return csr_matrix((blocks.ravel(), columns, starts), shape=(size, size))
    return bsr_matrix((blocks, columns, starts), shape=(size, size))


@compiled
def _block_starts(upper_starts: Int64Array, upper_columns: Int32Array, block: int) -> Int64Array:
    """Where the rows of blocks begin in a matrix with both triangles."""
    starts = np.zeros((len(upper_starts) - 1) // block + 1, dtype=np.int64)
    for row in range(len(starts) - 1):
        for k in range(upper_starts[block * row], upper_starts[block * row + 1], block):
            column = upper_columns[k] // block
            starts[row + 1] += 1
            if column != row:
                starts[column + 1] += 1
    for row in range(len(starts) - 1):
        starts[row + 1] += starts[row]
    return starts


@compiled
def _mirror(
    upper_starts: Int64Array,
    upper_columns: Int32Array,
    values: FloatArray,
    starts: Int64Array,
    columns: Int32Array,
    blocks: FloatArray,
) -> None:
    """Fill both triangles: by the time that a row's own blocks come, those left of them are there."""
    place, block = starts[:-1].copy(), blocks.shape[1]
    for row in range(len(place)):
        first = upper_starts[block * row]
        count = (upper_starts[block * row + 1] - first) // block
        for k in range(count):
            column = upper_columns[first + block * k] // block
            here, there = place[row], place[column]
            columns[here] = column
            columns[there] = row
            for i in range(block):
                # The blocks of all rows end where the rows end; of the one on the diagonal, a half is kept.
                begin = upper_starts[block * row + i + 1] - block * (count - k)
                for j in range(i if row == column else 0, block):
                    blocks[here, i, j] = values[begin + j]
                    blocks[there, j, i] = values[begin + j]
            place[row] += 1
            if column != row:
                place[column] += 1
