"""How large tetrahedra may be along the curves of a solid: small at bends and across narrow walls."""

from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.options import LARGEST, MOST_ELEMENTS, OF_SIDE, OF_THICKNESS

__all__ = ["FLATTENING", "Curve", "default_solid_size", "set_sizes", "solid_curves"]

FloatArray = NDArray[np.float64]

FLATTENING = 50.0
"""Facets leave a curved surface by no more than the element size over this."""
SAMPLES = 33
"""Places at which each curve is looked at."""
LEVEL = 1e-3
"""A face is upright if its normal rises less than this."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of the solid, at `parameter` (s,): `points` (s, 3), m; `bend` (s,), its curvature, 1/m."""

    tag: int
    parameter: FloatArray
    points: FloatArray
    bend: FloatArray


def solid_curves(gmsh: ModuleType) -> tuple[Curve, ...]:
    """The curves of gmsh's model, sampled."""
    curves = []
    for _, tag in gmsh.model.getEntities(1):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, tag)
        at = np.linspace(low, high, SAMPLES)
        points = np.reshape(gmsh.model.getValue(1, tag, at), (-1, 3))
        straight = gmsh.model.getType(1, tag) == "Line"
        bend = np.zeros(SAMPLES) if straight else np.abs(gmsh.model.getCurvature(1, tag, at))
        curves.append(Curve(tag, at, points, bend))
    return tuple(curves)


def default_solid_size(gmsh: ModuleType, curves: tuple[Curve, ...], *, volume: float) -> float:
    """Element size, m, where none is asked for: the rule of :func:`default_size`, by the solid's measures.

    Its thickness is its volume over half of the area of its largest upright plane face and all those
    parallel to it.
    """
    points = np.vstack([curve.points for curve in curves])
    wanted = min(LARGEST, OF_SIDE * float(np.ptp(points[:, 2])))
    wall = _wall_planes(gmsh)
    if wall is not None:
        wanted = min(wanted, OF_THICKNESS * volume / (0.5 * wall.area))
        wanted = min(wanted, OF_SIDE * float(np.ptp(points @ wall.along)))
    return float(max(wanted, (volume / MOST_ELEMENTS) ** (1.0 / 3.0)))


def set_sizes(gmsh: ModuleType, curves: tuple[Curve, ...], *, size: float, pier_elements: int) -> None:
    """Tell gmsh how long edges of elements may be along the curves.

    No longer than `size`; than keeps chords within `size` / 50 of a bend; than fits `pier_elements` times
    across the wall between its edges and those of its openings.
    """
    gaps = _gaps(gmsh, {curve.tag: curve.points for curve in curves}, reach=pier_elements * size)
    for curve in curves:
        chord = np.sqrt(8.0 * size / FLATTENING / np.maximum(curve.bend, 1e-9))
        wanted = np.minimum(size, np.minimum(chord, gaps[curve.tag] / pier_elements))
        gmsh.model.mesh.setSizeAtParametricPoints(1, curve.tag, curve.parameter, wanted)


@dataclass(frozen=True, eq=False)
class _WallPlanes:
    """The largest upright plane face and those parallel to it.

    `faces`: their tags; `area`, m²; `along` (3,): level unit vector in them.
    """

    faces: list[int]
    area: float
    along: FloatArray


def _wall_planes(gmsh: ModuleType) -> _WallPlanes | None:
    faces, normals, areas = [], [], []
    for kind, face in gmsh.model.getEntities(2):
        if gmsh.model.getType(kind, face) == "Plane":
            low, _ = gmsh.model.getParametrizationBounds(kind, face)
            normal = gmsh.model.getNormal(face, low)
            if abs(normal[2]) < LEVEL:
                faces.append(face)
                normals.append(normal)
                areas.append(gmsh.model.occ.getMass(kind, face))
    if not faces:
        return None
    wall = normals[int(np.argmax(areas))]
    parallel = np.flatnonzero(np.abs(np.array(normals) @ wall) > 1.0 - LEVEL)
    return _WallPlanes(
        [faces[k] for k in parallel], float(np.array(areas)[parallel].sum()), np.cross(wall, [0.0, 0.0, 1.0])
    )


def _gaps(gmsh: ModuleType, points: dict[int, FloatArray], *, reach: float) -> dict[int, FloatArray]:
    """Room (s,) across the wall, m, from each curve's points to other curves; infinite beyond `reach`."""
    import shapely

    gaps = {tag: np.full(SAMPLES, np.inf) for tag in points}
    wall = _wall_planes(gmsh)
    if wall is None:
        return gaps
    axes = np.array([wall.along, [0.0, 0.0, 1.0]])
    for face in wall.faces:
        tags = [tag for _, tag in gmsh.model.getBoundary([(2, face)], oriented=False)]
        ends = {tag: set(gmsh.model.getAdjacencies(1, tag)[1].tolist()) for tag in tags}
        flat = {tag: points[tag] @ axes.T for tag in tags}
        for tag in tags:
            others = [shapely.LineString(flat[k]) for k in tags if ends[k].isdisjoint(ends[tag])]
            if not others:
                continue
            links = shapely.shortest_line(shapely.points(flat[tag]), shapely.MultiLineString(others))
            near = np.flatnonzero(shapely.length(links) < reach)
            for k in near.tolist():
                foot = shapely.get_coordinates(links[k])[1] - flat[tag][k]
                if gmsh.model.isInside(2, face, points[tag][k] + foot @ axes / 2.0):
                    gaps[tag][k] = min(gaps[tag][k], float(np.hypot(*foot)))
    return gaps
