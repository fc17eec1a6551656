"""The wall as one CAD solid in metres: from the full voxels to STEP, which is read back and checked."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.errors import InputError, NumericsError
from fd2fem.model import VoxelModel
from fd2fem.model.checks import as_array, check_positive
from fd2fem.solids.grid import full_voxels
from fd2fem.solids.occ import read_shape, write_shape

if TYPE_CHECKING:
    from cadquery import Solid, Vector
    from shapely import LinearRing, Polygon

__all__ = ["StepReport", "cad_solid", "check_step", "write_step"]

FloatArray = NDArray[np.float64]

SAME = 1e-6
"""Largest relative difference of volume or extent between a solid and its STEP file."""


@dataclass(frozen=True)
class StepReport:
    """What a STEP file holds.

    Attributes
    ----------
    volume : float, m³
    extent : tuple of three floats, m
        Of the bounding box in x, y and z.
    faces : int
    valid : bool
        Whether OpenCASCADE finds topology and geometry sound.
    """

    volume: float
    extent: tuple[float, float, float]
    faces: int
    valid: bool


def cad_solid(voxels: VoxelModel) -> "Solid":
    """One solid from the full voxels: their union, extruded along +y by the thickness.

    Edges between neighbours vanish, so that front and back are one face each.

    Parameters
    ----------
    voxels : VoxelModel

    Returns
    -------
    solid : cadquery.Solid
        Facade frame, m.

    Raises
    ------
    InputError
        If no voxel is full, two overlap, or the wall falls into pieces or hangs together by an edge.
    NumericsError
        If OpenCASCADE makes no sound solid of it.
    """
    from cadquery import Solid, Vector, Wire

    polygon = _wall(voxels)
    _check_pinches(polygon)
    outer, *inner = (
        Wire.makePolygon(_vectors(ring), close=True) for ring in (polygon.exterior, *polygon.interiors)
    )
    solid = Solid.extrudeLinear(outer, inner, Vector(0.0, voxels.thickness, 0.0))
    if not solid.isValid():
        msg = f"OpenCASCADE made no sound solid of {len(voxels.state)} voxels; check them for slivers."
        raise NumericsError(msg)
    return solid


def write_step(shape: "Solid", path: Path, *, name: str = "facade") -> None:
    """Write a shape in metres as a STEP file (AP214) that declares metres.

    Parameters
    ----------
    shape : cadquery.Solid
        Coordinates in m.
    path : Path
        Written in place; an existing file is replaced.
    name : str
        Of the product, printable ASCII.

    Raises
    ------
    NumericsError
        If the file cannot be written.
    """
    write_shape(shape, path, name=name)


def check_step(path: Path, *, volume: float, extent: ArrayLike) -> StepReport:
    """Read a STEP file back and hold it against what it should be.

    Parameters
    ----------
    path : Path
    volume : float, m³
    extent : (3,) array-like, m
        Of the bounding box in x, y and z.

    Returns
    -------
    report : StepReport

    Raises
    ------
    InputError
        If the file cannot be read.
    NumericsError
        If volume or extent differ by more than 1e-6, relative, or the shape is not sound.
    """
    expected = as_array("extent", extent, (3,))
    shape = read_shape(path)
    box = shape.BoundingBox()
    report = StepReport(
        volume=float(shape.Volume()),
        extent=(float(box.xlen), float(box.ylen), float(box.zlen)),
        faces=len(shape.Faces()),
        valid=bool(shape.isValid()),
    )
    if not report.valid:
        msg = f"{path.name}: the solid read back is not sound (OpenCASCADE's own check)."
        raise NumericsError(msg)
    _check_same(f"{path.name}: the volume", report.volume, check_positive("volume", volume))
    for axis, have, want in zip("xyz", report.extent, expected.tolist(), strict=True):
        _check_same(f"{path.name}: the extent in {axis}", have, want)
    return report


def _check_same(what: str, have: float, want: float) -> None:
    if not abs(have - want) <= SAME * abs(want):
        msg = f"{what} reads back as {have:.9g}, expected {want:.9g} (metres)."
        raise NumericsError(msg)


def _wall(voxels: VoxelModel) -> "Polygon":
    """Union of the full voxels in x and z."""
    import shapely

    grid = full_voxels(voxels)
    low = np.column_stack([grid.x[grid.lower[:, 0]], grid.z[grid.lower[:, 1]]])
    high = np.column_stack([grid.x[grid.upper[:, 0]], grid.z[grid.upper[:, 1]]])
    union = shapely.union_all(shapely.box(*low.T, *high.T))
    if isinstance(union, shapely.Polygon):
        return union
    pieces = sorted(shapely.get_parts(union), key=lambda piece: float(piece.area))
    x, z = pieces[0].bounds[:2]
    msg = (
        f"The wall falls into {len(pieces)} pieces, the smallest of {pieces[0].area:.4f} m² at "
        f"x = {x:.3f}, z = {z:.3f}: join them, or remove the loose ones."
    )
    raise InputError(msg)


def _corners(ring: "LinearRing") -> FloatArray:
    """Corners of a ring of horizontal and vertical edges, without the points inside an edge."""
    points: FloatArray = np.asarray(ring.coords)[:-1]
    back, ahead = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turns = back[:, 0] * ahead[:, 1] != back[:, 1] * ahead[:, 0]
    corners: FloatArray = points[turns]
    return corners


def _check_pinches(polygon: "Polygon") -> None:
    """Raise if rings meet in a point: the solid would hang together by an edge without thickness."""
    points = np.concatenate([_corners(ring) for ring in (polygon.exterior, *polygon.interiors)])
    distinct, count = np.unique(points, axis=0, return_counts=True)
    if (count > 1).any():
        x, z = distinct[count > 1][0]
        msg = (
            f"Full voxels meet only at their edge at x = {x:.3f}, z = {z:.3f}: fill or empty a "
            "neighbour there, a solid cannot hang together by an edge."
        )
        raise InputError(msg)


def _vectors(ring: "LinearRing") -> Sequence["Vector"]:
    from cadquery import Vector

    return [Vector(x, 0.0, z) for x, z in _corners(ring).tolist()]
