"""The face of a wall in a sample of the scan: its plane, its bow, and the scatter of its points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.model import FacadeFrame
from fd2fem.model.frame import OutOfPlane
from fd2fem.reconstruction.patches import connected_face
from fd2fem.reconstruction.pavement import Pavement, find_pavement
from fd2fem.reconstruction.relief import depth_behind, fit_relief
from fd2fem.reconstruction.thinning import Sample, chunks, pick
from fd2fem.reconstruction.walls import MIN_POINTS, NEAR_PLANE, largest_part, robust_scatter, wall_density

__all__ = [
    "Box",
    "Face",
    "change_frame",
    "find_face",
    "frame_of",
    "frame_through",
    "turn_relief",
]

FloatArray = NDArray[np.float64]
Box = tuple[FloatArray, FloatArray]

BESIDE = 0.12
"""The face and its bow lie so near the plane, m."""
ENOUGH = 100_000
"""So many points of the sample show the face."""
REFITS = 6
"""Times that the plane is fitted anew to what lies in a band that was given."""
NARROW, WIDE = 0.015, 0.06
"""Limits of the band, m."""
SCATTERS = 4.0
"""Half width of the band in standard deviations of the points' depth."""


@dataclass(frozen=True, eq=False)
class Face:
    """The face of the wall as the sample shows it.

    Attributes
    ----------
    frame : FacadeFrame
    relief : OutOfPlane
    band : float, m
        Points so close to the face are on the wall.
    scatter : float, m
        Of their depth.
    local : (k, 3) float array, m
        The sample in the frame.
    depth : (k,) float array, m
        Of the sample behind the face.
    xz : (w, 2) float array, m
        Some of the sample that lie on the wall.
    spacing : float, m
        Typical distance between neighbours of the sample on the wall.
    pavement : Pavement or None
        ``None`` where the scan does not show it.
    """

    frame: FacadeFrame
    relief: OutOfPlane
    band: float
    scatter: float
    local: FloatArray
    depth: FloatArray
    xz: FloatArray
    spacing: float
    pavement: Pavement | None

    @property
    def box(self) -> Box:
        """Lower and upper corner of the wall in the sample, m."""
        x, z = self.xz.T
        return np.array([x.min(), z.min()]), np.array([x.max(), z.max()])


def frame_of(on_plane: FloatArray, inward: FloatArray) -> FacadeFrame:
    """The frame with a given origin and y axis: x is level, z goes up the wall."""
    right = np.cross(inward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return FacadeFrame(on_plane, np.array([right, inward, np.cross(right, inward)]))


def frame_through(local: FloatArray, frame: FacadeFrame) -> FacadeFrame:
    """The frame of the least-squares plane through points of a wall, its origin moved square to the wall.

    Parameters
    ----------
    local : (m, 3) float array, m
    frame : FacadeFrame
        In which the points are given, nearly that of the wall.
    """
    middle = np.array([column.mean() for column in local.T])
    squares = np.zeros((3, 3))
    for part in chunks(len(local)):
        away = local[part].T - middle[:, None]
        squares += away @ away.T
    normal = np.linalg.eigh(squares)[1][:, 0]
    normal *= np.sign(normal[1])
    origin = np.array([0.0, middle @ normal / normal[1], 0.0])
    return frame_of(origin @ frame.axes + frame.origin, normal @ frame.axes)


def in_frame(sample: Sample, frame: FacadeFrame) -> FloatArray:
    """The points of a sample in the facade frame (k, 3), m."""
    local: FloatArray = (frame.axes @ sample.points.T).T
    local += (sample.centre - frame.origin) @ frame.axes.T
    return local


def change_frame(local: FloatArray, old: FacadeFrame, new: FacadeFrame) -> FloatArray:
    """Points (m, 3), m, of one frame in another one near it."""
    moved: FloatArray = ((new.axes @ old.axes.T) @ local.T).T
    moved += (old.origin - new.origin) @ new.axes.T
    return moved


def turn_relief(relief: OutOfPlane, old: FacadeFrame, new: FacadeFrame) -> OutOfPlane:
    """The same face as a map over another plane, which crosses the old one at a tiny angle."""
    i, j = np.indices(relief.values.shape)
    x, z = relief.low[0] + relief.cell * i, relief.low[1] + relief.cell * j
    places = np.stack([x, relief.values, z], axis=-1).reshape(-1, 3)
    return OutOfPlane(
        relief.low, relief.cell, change_frame(places, old, new)[:, 1].reshape(relief.values.shape)
    )


def find_face(
    sample: Sample, frame: FacadeFrame, box: Box, *, scanners: FloatArray, band: float | None
) -> Face:
    """Fit the plane and the bow of a wall to a sample of the scan.

    Parameters
    ----------
    sample : Sample
    frame : FacadeFrame
        A first guess.
    box : two (2,) float arrays, m
        Lower and upper corner of the wall in that frame.
    scanners : (s, 3) float array, m
        World frame.
    band : float or None, m
        Half width of the band of the wall's points; ``None``: from their scatter.

    Raises
    ------
    ReconstructionError
        If too few points lie on the plane.
    """
    local = in_frame(sample, frame)
    near = _near_plane(local, box, BESIDE)
    part = connected_face(near, box, frame.to_facade(scanners))
    if len(part) < MIN_POINTS:
        msg = f"No wall found: the best plane holds {len(part)} points, expected at least {MIN_POINTS}."
        raise ReconstructionError(msg)
    near = pick(near, part)
    plane = frame_through(near, frame)
    near, local, frame = change_frame(near, frame, plane), change_frame(local, frame, plane), plane
    if band is not None and band > BESIDE / 2.0:
        near, local, frame = _through_layers(near, local, frame, band)
    relief = fit_relief(near, farthest=max(NEAR_PLANE, 0.0 if band is None else band / 2.0))
    depth = depth_behind(relief, local)
    scatter = robust_scatter(depth[np.abs(depth) < NEAR_PLANE])
    width = float(np.clip(SCATTERS * scatter, NARROW, WIDE)) if band is None else band
    pavement = find_pavement(local, _box(near))
    xz, share = _on_wall(local, (np.abs(depth) < width), pavement, scatter)
    xz = pick(xz, largest_part(xz, around=near[:, [0, 2]]))
    spacing = float(np.sqrt(share / wall_density(xz)))
    return Face(frame, relief, width, scatter, local, depth, xz, spacing, pavement)


def _through_layers(
    near: FloatArray, local: FloatArray, frame: FacadeFrame, band: float
) -> tuple[FloatArray, FloatArray, FacadeFrame]:
    """The plane through all that lies in the band about it: a wall's pilasters, panels and set-backs.

    Returns the points near it and the sample in its frame, and the frame.
    """
    for _ in range(REFITS):
        wide = _near_plane(local, _box(near), band)
        near = pick(wide, largest_part(wide[:, [0, 2]], around=near[:, [0, 2]]))
        plane = frame_through(near, frame)
        near, local, frame = change_frame(near, frame, plane), change_frame(local, frame, plane), plane
    return near, local, frame


def _near_plane(local: FloatArray, box: Box, width: float) -> FloatArray:
    """Some points of the sample within a width, m, of its plane and above the pavement before a box."""
    beside = np.abs(local[:, 1]) < width
    pavement = find_pavement(local, box)
    if pavement is not None:
        beside &= pavement.clear_of(local, 0.0)
    return pick(local, np.flatnonzero(beside)[:ENOUGH])


def _box(local: FloatArray) -> Box:
    """Lower and upper corner of some points, m."""
    x, _, z = local.T
    return np.array([x.min(), z.min()]), np.array([x.max(), z.max()])


def _on_wall(
    local: FloatArray, in_band: NDArray[np.bool_], pavement: Pavement | None, scatter: float
) -> tuple[FloatArray, float]:
    """Some of the points in the band above the pavement, and the share of all of these."""
    if pavement is not None:
        in_band = in_band & pavement.clear_of(local, scatter)
    chosen = np.flatnonzero(in_band)
    return pick(local[:, [0, 2]], chosen[:ENOUGH]), min(1.0, ENOUGH / max(len(chosen), 1))
