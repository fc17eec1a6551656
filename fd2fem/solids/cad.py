"""The wall in CAD: the one solid or its cells, their files in metres, and what these read back as."""

from dataclasses import dataclass
from pathlib import Path

from numpy.typing import ArrayLike

from fd2fem.errors import NumericsError
from fd2fem.model.checks import as_array, check_positive
from fd2fem.solids.cad_files import write_brep, write_iges, write_step
from fd2fem.solids.cell_solids import cad_cells
from fd2fem.solids.face_names import face_groups
from fd2fem.solids.occ import read_shape
from fd2fem.solids.rims import wall_extent
from fd2fem.solids.wall_solid import cad_wall

__all__ = [
    "StepReport",
    "cad_cells",
    "cad_wall",
    "check_step",
    "face_groups",
    "wall_extent",
    "write_brep",
    "write_iges",
    "write_step",
]

SAME = 1e-6
"""Largest relative difference of volume or extent between a solid and its file."""
LOOSE = 1e-6
"""Boxes of OpenCASCADE are wider than the solid by the tolerance of its edges, which IGES loosens, m."""


@dataclass(frozen=True)
class StepReport:
    """What a CAD file holds.

    Attributes
    ----------
    volume : float, m³
    extent : tuple of three floats, m
        Of the bounding box in x, y and z.
    solids, faces : int
    valid : bool
        Whether OpenCASCADE finds topology and geometry sound.
    """

    volume: float
    extent: tuple[float, float, float]
    solids: int
    faces: int
    valid: bool


def check_step(path: Path, *, volume: float, extent: ArrayLike, solids: int = 1) -> StepReport:
    """Read a STEP, IGES or BREP file back and hold it against what it should be.

    Parameters
    ----------
    path : Path
    volume : float, m³
    extent : (3,) array-like, m
        Of the bounding box in x, y and z.
    solids : int
        How many it should hold.

    Returns
    -------
    report : StepReport

    Raises
    ------
    InputError
        If the file cannot be read.
    NumericsError
        If the volume differs by more than 1e-6, relative, or the extent by that and a micrometre, if there
        are more or fewer solids, or if the shape is not sound.
    """
    expected = as_array("extent", extent, (3,))
    shape = read_shape(path)
    box = shape.BoundingBox()
    report = StepReport(
        volume=float(shape.Volume()),
        extent=(float(box.xlen), float(box.ylen), float(box.zlen)),
        solids=len(shape.Solids()),
        faces=len(shape.Faces()),
        valid=bool(shape.isValid()),
    )
    if not report.valid:
        msg = f"{path.name}: the solid read back is not sound (OpenCASCADE's own check)."
        raise NumericsError(msg)
    if report.solids != solids:
        msg = f"{path.name} reads back with {report.solids} solids in it, expected {solids}."
        raise NumericsError(msg)
    _check_same(f"{path.name}: the volume", report.volume, check_positive("volume", volume), 0.0)
    for axis, have, want in zip("xyz", report.extent, expected.tolist(), strict=True):
        _check_same(f"{path.name}: the extent in {axis}", have, want, LOOSE)
    return report


def _check_same(what: str, have: float, want: float, loose: float) -> None:
    if not abs(have - want) <= SAME * abs(want) + loose:
        msg = f"{what} reads back as {have:.9g}, expected {want:.9g} (metres)."
        raise NumericsError(msg)
