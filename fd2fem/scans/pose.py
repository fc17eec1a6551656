"""Where a scan says that its scanner stood, and whether to believe it."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.scans.raw import UNKNOWN

__all__ = ["rotation_of_quaternion", "trusted_position"]

FloatArray = NDArray[np.float64]

FARTHEST = 500.0
"""No scanner of facades measures farther, m."""
NEAREST = 0.25
"""No such scanner measures nearer, m."""
STRAYS = 3
"""So many points may nevertheless be nearer."""
WHOLE = 10.0
"""Offsets of coordinates are multiples of this, m; places where somebody set up a tripod are not."""


def trusted_position(position: FloatArray, points: FloatArray, *, turned: bool) -> FloatArray:
    """Return the position of a scanner, or NaN if it cannot be one.

    Programs that join or shift scans write poses too: the identity, or the offset that they took off the
    coordinates. Such a pose is not turned and moves by whole tens of metres; it is believed only where
    it does not move at all, and no point is nearer to the origin than a scanner can measure.

    Parameters
    ----------
    position : (3,) float array, m
        Where the pose puts the origin of the scan.
    points : (n, 3) float array, m
        The scan, in the same frame.
    turned : bool
        Whether the pose rotates.

    Returns
    -------
    (3,) float array, m

    Examples
    --------
    >>> wall = np.array([[700_000.0, 5_400_000.0, 10.0], [700_005.0, 5_400_000.0, 22.0]])
    >>> trusted_position(np.zeros(3), wall, turned=False).tolist()
    [nan, nan, nan]
    >>> trusted_position(np.array([700_002.5, 5_399_990.0, 11.6]), wall, turned=False).tolist()
    [700002.5, 5399990.0, 11.6]
    """
    unknown = np.array(UNKNOWN)
    if not len(points) or not np.isfinite(position).all():
        return unknown
    # Axis by axis: the points are millions.
    distance = np.sqrt(sum(np.square(points[:, axis] - position[axis]) for axis in range(3)))
    if np.median(distance) > FARTHEST:
        return unknown
    if not turned and (position % WHOLE == 0.0).all():
        near = np.count_nonzero(distance < NEAREST)
        return unknown if position.any() or near > STRAYS else position
    return position


def rotation_of_quaternion(quaternion: FloatArray) -> FloatArray:
    """Rotation matrix of a quaternion w, x, y, z, which need not have length 1.

    Parameters
    ----------
    quaternion : (4,) float array
        Not zero.

    Returns
    -------
    (3, 3) float array
        Multiplies columns.

    Examples
    --------
    A quarter turn about z takes x to y:

    >>> (rotation_of_quaternion(np.array([1.0, 0.0, 0.0, 1.0])) @ [1, 0, 0]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """
    from scipy.spatial.transform import Rotation

    matrix: FloatArray = Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_matrix()
    return matrix
