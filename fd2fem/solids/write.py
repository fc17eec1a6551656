"""All files of a solid, held against one another."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import NumericsError
from fd2fem.model import Facade, LoadCase, SolidModel, VoxelModel, WallCells
from fd2fem.solids.anf import write_anf
from fd2fem.solids.anf_reader import read_anf
from fd2fem.solids.apdl import write_apdl
from fd2fem.solids.brep import solid_from_cells, solid_from_voxels
from fd2fem.solids.cad import (
    StepReport,
    cad_cells,
    cad_wall,
    check_step,
    face_groups,
    wall_extent,
    write_brep,
    write_iges,
    write_step,
)
from fd2fem.solids.joints import check_joined
from fd2fem.solids.loops import solid_volumes
from fd2fem.solids.options import SolidForm, SolidOptions
from fd2fem.solids.settlement_deck import write_settlement_deck

if TYPE_CHECKING:
    from cadquery import Shape

__all__ = ["SolidReport", "write_solid"]

FloatArray = NDArray[np.float64]

EXACT = 1e-9
"""Largest relative difference of volume between the facade, its cells and the neutral file."""
MOVED = 1e-6
"""Cells may have an edge of the facade this far, m, from where it is: dividing a wall makes edges one that
are closer."""


@dataclass(frozen=True)
class SolidReport:
    """What was written.

    Attributes
    ----------
    step, anf, apdl : str
        Names of the files: STEP, neutral file, deck of APDL commands.
    settlement : str or None
        Name of the settlement deck.
    also : tuple of str
        Names of the further CAD files.
    volume, cells_volume, step_volume, anf_volume : float, m³
        Of the facade, of its cells, and as the files read back.
    extent : tuple of three floats, m
        Of the bounding box in x, y and z.
    step_solids, step_faces : int
    keypoints, lines, areas, volumes : int
        Of the neutral file and the deck.
    """

    step: str
    anf: str
    apdl: str
    settlement: str | None
    also: tuple[str, ...]
    volume: float
    cells_volume: float
    step_volume: float
    anf_volume: float
    extent: tuple[float, float, float]
    step_solids: int
    step_faces: int
    keypoints: int
    lines: int
    areas: int
    volumes: int


def write_solid(
    facade: Facade,
    cells: VoxelModel | WallCells,
    folder: Path,
    *,
    options: SolidOptions,
    case: LoadCase | None = None,
) -> SolidReport:
    """Write facade.step, facade.anf, facade_apdl.inp and what else is asked for, and read the first two back.

    All are in metres. STEP comes from the facade itself (or, as `options.form` says, from its cells), the
    neutral file and the decks from the cells.

    Parameters
    ----------
    facade : Facade
    cells : VoxelModel or WallCells
        A division of the facade; of voxels only the full ones count.
    folder : Path
        Must exist; files of these names in it are replaced.
    options : SolidOptions
    case : LoadCase, optional
        If given, facade_settlement.inp is written, which analyses the neutral file's solid under it.

    Returns
    -------
    report : SolidReport

    Raises
    ------
    InputError
        If the cells make no solid: there are none, two overlap, the wall falls into pieces.
    NumericsError
        If the volume of the cells is not the facade's (1e-9 relative, beside what edges moved that lie
        within 1e-6 m of others), or a file reads back with another volume (1e-9 relative for the neutral
        file, 1e-6 for STEP), another extent or other counts, or is not sound.
    """
    solid = _solid(cells)
    volume = float(solid_volumes(solid).sum())
    _check_volume(facade, solid, volume)
    step, also = _write_cad(facade, solid, folder, options)
    anf_volume = _write_neutral_file(solid, folder / "facade.anf", volume, options.anf_order)
    write_apdl(solid, folder / "facade_apdl.inp")
    if case is not None:
        write_settlement_deck(folder / "facade_settlement.inp", case, solid, strength=options.strength)
    return SolidReport(
        step="facade.step",
        anf="facade.anf",
        apdl="facade_apdl.inp",
        settlement=None if case is None else "facade_settlement.inp",
        also=also,
        volume=facade.volume,
        cells_volume=volume,
        step_volume=step.volume,
        anf_volume=anf_volume,
        extent=step.extent,
        step_solids=step.solids,
        step_faces=step.faces,
        keypoints=len(solid.keypoints),
        lines=len(solid.lines),
        areas=len(solid.areas),
        volumes=len(solid.volumes),
    )


def _solid(cells: VoxelModel | WallCells) -> SolidModel:
    """The boundary representation of cells that hang together."""
    if isinstance(cells, WallCells):
        return solid_from_cells(cells)
    solid = solid_from_voxels(cells)
    check_joined(solid)
    return solid


def _check_volume(facade: Facade, solid: SolidModel, volume: float) -> None:
    """Raise if cells of this volume, m³, are not the facade."""
    rings = [facade.outline, *(opening.outline for opening in facade.openings)]
    edges = sum(float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum()) for ring in rings)
    edges += facade.length * len(facade.storeys)
    thickness = max(band.thickness for band in facade.bands)
    allowed = EXACT * facade.volume + _moved(facade, solid) * edges * thickness
    if not abs(volume - facade.volume) <= allowed:
        msg = (
            f"The cells of the neutral file have {volume:.12g} m³, the facade has {facade.volume:.12g} m³: "
            "divide the facade so that its cells fill it."
        )
        raise NumericsError(msg)


def _moved(facade: Facade, solid: SolidModel) -> float:
    """How far, m, a solid has corners and levels of the facade from where they are; at most `MOVED`."""
    from scipy.spatial import cKDTree

    corners = np.concatenate([facade.outline, *(opening.outline for opening in facade.openings)])
    points = solid.keypoints[:, [0, 2]]
    distances, _ = cKDTree(points).query(corners)
    levels = np.array([storey.z for storey in facade.storeys])
    rows = np.unique(points[:, 1])
    off = np.append(distances, np.abs(rows[:, None] - levels).min(axis=0))
    return float(off[off <= MOVED].max(initial=0.0))


def _write_cad(
    facade: Facade, solid: SolidModel, folder: Path, options: SolidOptions
) -> tuple[StepReport, tuple[str, ...]]:
    """Write facade.step and the further formats; what STEP reads back as, and the names of the others."""
    shape, solids, extent = _shape(facade, solid, options.form)
    step = folder / "facade.step"
    write_step(shape, step, name=options.step_name, faces=face_groups(shape, facade))
    report = check_step(step, volume=facade.volume, extent=extent, solids=solids)
    writers = {"iges": write_iges, "brep": write_brep}
    names = tuple(f"facade.{suffix}" for suffix in options.also)
    for suffix, name in zip(options.also, names, strict=True):
        writers[suffix](shape, folder / name)
        check_step(folder / name, volume=facade.volume, extent=extent, solids=solids)
    return report, names


def _shape(facade: Facade, solid: SolidModel, form: SolidForm) -> tuple["Shape", int, FloatArray]:
    """What a form holds, and how many solids of what extent (3,), m, that is."""
    if form is SolidForm.MERGED:
        return cad_wall(facade), 1, wall_extent(facade)
    return cad_cells(solid), len(solid.volumes), np.ptp(solid.keypoints, axis=0)


def _write_neutral_file(solid: SolidModel, path: Path, volume: float, order: int) -> float:
    """Write a neutral file and return the volume, m³, that it reads back with."""
    write_anf(solid, path, order=order)
    read = read_anf(path)
    found = float(solid_volumes(read).sum())
    counts = [(len(s.keypoints), len(s.lines), len(s.areas), len(s.volumes)) for s in (solid, read)]
    if abs(found - volume) > EXACT * volume or counts[0] != counts[1]:
        msg = (
            f"{path.name} reads back as {found:.12g} m³ in {counts[1][3]} volumes, "
            f"expected {volume:.12g} m³ in {counts[0][3]}."
        )
        raise NumericsError(msg)
    return found
