"""The storeys of a CAD solid: plane faces at its back, one above the other."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Band

if TYPE_CHECKING:
    from cadquery import Face

__all__ = ["back_bands", "face_normal", "face_point", "is_plane"]

FloatArray = NDArray[np.float64]

PARALLEL = 1e-6
"""Directions whose unit vectors differ by less than this are one."""
SAME = 1e-5
"""Depths and heights that differ by less, m, are one."""


def back_bands(faces: Iterable["Face"], front: "Face", height: float) -> tuple[Band, ...]:
    """Bands of a wall from the faces that lie opposite its front, or none where these do not stack.

    Parameters
    ----------
    faces : iterable of cadquery.Face
        Vertical plane ones; those that do not look away from the front are passed over.
    front : cadquery.Face
    height : float, m
        Of the wall, which the bands must fill.
    """
    normal, point = face_normal(front), face_point(front)
    ground = min(float(vertex.Z) for vertex in front.Vertices())
    spans: list[tuple[float, float, float]] = []
    for face in faces:
        if np.abs(face_normal(face) + normal).max() < PARALLEL:
            depth = float(np.dot(normal, point - face_point(face)))
            spans.append((*_reach(face, ground), depth))
    bands: list[Band] = []
    for low, high, depth in sorted(spans):
        top = bands[-1].high if bands else 0.0
        if bands and abs(bands[-1].thickness - depth) < SAME and low < top + SAME:
            bands[-1] = Band(bands[-1].low, max(top, high), bands[-1].thickness)
        elif abs(low - top) < SAME:
            bands.append(Band(low, high, round(depth, 9)))
        else:
            return ()
    # A curved top may rise above its corners.
    return tuple(bands) if bands and bands[-1].high < height + SAME else ()


def _reach(face: "Face", ground: float) -> tuple[float, float]:
    """Heights of the lowest and highest corner of a face above the ground, m."""
    heights = [float(vertex.Z) - ground for vertex in face.Vertices()]
    return round(min(heights), 9), round(max(heights), 9)


def is_plane(face: "Face") -> bool:
    """Whether a face is plane; also where a file has it as a spline."""
    from OCP.gp import gp_Pln
    from OCP.ShapeAnalysis import ShapeAnalysis_CanonicalRecognition

    if face.geomType() == "PLANE":
        return True
    return bool(ShapeAnalysis_CanonicalRecognition(face.wrapped).IsPlane(PARALLEL, gp_Pln()))


def face_normal(face: "Face") -> FloatArray:
    """Outward unit normal of a plane face, exactly horizontal where it nearly is."""
    normal = np.array(face.normalAt().toTuple())
    if abs(normal[2]) < PARALLEL:
        normal[2] = 0.0
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit


def face_point(face: "Face") -> FloatArray:
    """The centre of a face, m."""
    return np.array(face.Center().toTuple())
