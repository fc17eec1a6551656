"""The face of the wall: where a wall that bulges leaves its plane, and how deep a point lies behind it.

Over the plane goes a thin plate, the smoothest surface through the points of the face. It starts as the
plane and takes in what lies close before or behind it; as it bends, it reaches the points beside, so that a
bulge is followed as far as it goes smoothly. What steps (frames, courses, a neighbour's wall) never comes
close to it and has no say.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import splu

from fd2fem.model import FacadePoints
from fd2fem.model.frame import OutOfPlane
from fd2fem.reconstruction.walls import NEAR_PLANE, robust_scatter

__all__ = ["depth_behind", "facade_depth", "fit_relief"]

FloatArray = NDArray[np.float64]

CELL = 0.25
"""Distance between the values of the map, m; more on a wall that would need many of them."""
VALUES = 2000
"""About so many values make a map."""
POINTS = 40_000
"""So many points show the face."""
FULL = 20.0
"""Points in a cell beyond so many count no more: they crowd near the scanner."""
SHORTEST = 1.5
"""Waves of the face shorter than this, m, are smoothed away: joints and stones are no bow."""
LOOSE = 1e-5
"""Pull of the plane on a value that no point holds, in shares of a full cell's."""
ROUNDS = 10
"""Most rounds of taking in and bending."""
SETTLED = 2e-5
"""The face has come to rest when no value moves more than this, m."""
FLAT = 0.002
"""A face that nowhere leaves its plane farther is that plane, m."""
FARTHEST = 0.5
"""A face leaves its plane by less, m."""
NARROWEST = 0.012
"""Points so close to the face always count, m."""


def facade_depth(points: FacadePoints, local: FloatArray) -> FloatArray:
    """How deep points lie behind the wall's face.

    Parameters
    ----------
    points : FacadePoints
    local : (m, 3) float array, m
        Facade frame.

    Returns
    -------
    (m,) float array, m
        Negative before the face. Beyond the map its rim goes on, and where the face was not seen, the
        nearest value of it.

    Examples
    --------
    >>> from fd2fem.model import FacadeFrame
    >>> wall = FacadePoints(
    ...     xz=np.zeros((0, 2)), depth=np.zeros(0), front=[], behind=[], scanners=[],
    ...     frame=FacadeFrame.identity(), rms=0.0, spacing=1.0, ground=None, outside_by="",
    ...     relief=OutOfPlane(np.zeros(2), 1.0, np.array([[0.0, 0.0], [0.1, 0.1]])),
    ... )
    >>> facade_depth(wall, np.array([[0.5, 0.3, 0.2]])).round(6).tolist()
    [0.25]
    """
    return depth_behind(points.relief, local)


def depth_behind(relief: OutOfPlane, local: FloatArray) -> FloatArray:
    """How deep points (m, 3), m, lie behind the face that a map describes, (m,) m."""
    values = relief.values
    if not np.nanmax(np.abs(values)) > 0.0:
        return np.array(local[:, 1])
    unseen = np.isnan(values)
    if unseen.any():
        nearest = ndimage.distance_transform_edt(unseen, return_distances=False, return_indices=True)
        values = values[tuple(nearest)]
    places = (local[:, [0, 2]] - relief.low) / relief.cell
    face = ndimage.map_coordinates(values, places.T, order=1, mode="nearest", prefilter=False)
    depth: FloatArray = local[:, 1] - face
    return depth


def fit_relief(local: FloatArray, *, farthest: float = NEAR_PLANE) -> OutOfPlane:
    """Bend the plane to the face of the wall.

    Parameters
    ----------
    local : (m, 3) float array, m
        Points near the wall's plane, facade frame, in random order; more than one.
    farthest : float, m
        Points farther from the face have no say, where their scatter is not smaller anyway.
    """
    local = local[:POINTS]
    xz, depth = local[:, [0, 2]], local[:, 1]
    low, high = xz.min(axis=0), xz.max(axis=0)
    cell = max(CELL, float(np.sqrt((high - low).prod() / VALUES)))
    # Cells are counted from the frame's origin, and half a cell is left around the points.
    low, last = np.floor(low / cell - 0.5), np.ceil(high / cell + 0.5)
    grid = _Grid(xz / cell - low, (int(last[0] - low[0]) + 1, int(last[1] - low[1]) + 1))
    stiff = FULL * (SHORTEST / cell / (2.0 * np.pi)) ** 4 * _bending(grid.shape)
    stiff += sparse.eye_array(grid.size) * (LOOSE * FULL)
    # All points have a say at first: they lie on the face, but for stray ones.
    face, reach = np.zeros(grid.size), FARTHEST
    for _ in range(ROUNDS):
        off = depth - grid.read(face)
        near = np.abs(off) < reach
        if near.sum() < 3:
            break
        pull = grid.share * np.where(near, (1.0 - (off / reach) ** 2) ** 2, 0.0)
        bent = splu((grid.table(pull) + stiff).tocsc(), permc_spec="MMD_AT_PLUS_A").solve(
            grid.spread(pull * depth)
        )
        moved, face = np.abs(grid.read(bent - face)[near]).max(), bent
        reach = float(np.clip(4.0 * robust_scatter(depth - grid.read(face)), NARROWEST, farthest))
        if moved < SETTLED:
            break
    seen = grid.spread((np.abs(depth - grid.read(face)) < reach).astype(np.float64)) > 0.0
    # Beyond the points, the plate may swing out farther than they do.
    face = np.clip(face, depth.min(), depth.max())
    if np.abs(face[seen]).max(initial=0.0) < FLAT:
        face = np.zeros(grid.size)
    return OutOfPlane(low * cell, cell, np.where(seen, face, np.nan).reshape(grid.shape))


class _Grid:
    """Bilinear interpolation between the values of a map at fixed places (m, 2), in cells."""

    def __init__(self, places: FloatArray, shape: tuple[int, int]) -> None:
        self.shape, self.size = shape, shape[0] * shape[1]
        whole = places.astype(np.intp)
        (x, z), first = (places - whole).T, whole[:, 0] * shape[1] + whole[:, 1]
        self.corner = np.array([0, 1, shape[1], shape[1] + 1])
        self.first = first
        self.part = np.array([(1.0 - x) * (1.0 - z), (1.0 - x) * z, x * (1.0 - z), x * z])
        # Points beyond a full cell's share its weight.
        count = np.bincount(first)
        self.share, self.held = np.minimum(1.0, FULL / count[first]), np.flatnonzero(count)

    def read(self, values: FloatArray) -> FloatArray:
        """The map (size,) at the places."""
        read: FloatArray = np.zeros(len(self.first))
        for corner, part in zip(self.corner, self.part, strict=True):
            read += part * values[self.first + corner]
        return read

    def spread(self, values: FloatArray) -> FloatArray:
        """Transpose of `read`: the sum of what each place gives to each value of the map."""
        total = np.zeros(self.size)
        for corner, part in zip(self.corner, self.part, strict=True):
            total += np.bincount(self.first + corner, part * values, minlength=self.size)
        return total

    def table(self, pull: FloatArray) -> sparse.csc_array:
        """Normal equations (size, size) of the places with weights `pull`."""
        cells = self.held
        rows, columns, values = [], [], []
        for one, part in zip(self.corner, self.part, strict=True):
            for other, another in zip(self.corner, self.part, strict=True):
                rows.append(cells + one)
                columns.append(cells + other)
                values.append(np.bincount(self.first, pull * part * another)[cells])
        place = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csc_array((np.concatenate(values), place), shape=(self.size, self.size))


def _bending(shape: tuple[int, int]) -> sparse.csc_array:
    """Bending energy (nx·nz, nx·nz) of a thin plate on a grid of unit cells: f_xx² + 2 f_xz² + f_zz²."""
    nx, nz = shape
    along = sparse.kron(_differences(nx, 2), sparse.eye_array(nz))
    up = sparse.kron(sparse.eye_array(nx), _differences(nz, 2))
    twist = sparse.kron(_differences(nx, 1), _differences(nz, 1))
    return sparse.csc_array(along.T @ along + up.T @ up + 2.0 * twist.T @ twist)


def _differences(size: int, order: int) -> sparse.csr_array:
    """First or second differences of `size` values."""
    row = {1: [-1.0, 1.0], 2: [1.0, -2.0, 1.0]}[order]
    shape = (max(size - order, 0), size)
    return sparse.csr_array(sparse.diags_array(row, offsets=list(range(order + 1)), shape=shape))
