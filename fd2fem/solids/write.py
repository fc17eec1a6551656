"""All files of a solid, held against one another."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fd2fem.errors import NumericsError
from fd2fem.model import VoxelModel
from fd2fem.solids.anf import write_anf
from fd2fem.solids.anf_reader import read_anf
from fd2fem.solids.apdl import write_apdl
from fd2fem.solids.brep import solid_from_voxels
from fd2fem.solids.cad import cad_solid, check_step, write_step
from fd2fem.solids.loops import solid_volumes
from fd2fem.solids.options import SolidOptions

__all__ = ["SolidReport", "write_solid"]

EXACT = 1e-9
"""Largest relative difference of volume between the voxels and the neutral file."""


@dataclass(frozen=True)
class SolidReport:
    """What was written.

    Attributes
    ----------
    step, anf, apdl : str
        Names of the files: STEP, neutral file, deck of APDL commands.
    volume, step_volume, anf_volume : float, m³
        Of the full voxels, and as the files read back.
    extent : tuple of three floats, m
        Of the bounding box in x, y and z.
    step_faces : int
    keypoints, lines, areas, volumes : int
        Of the neutral file and the deck.
    """

    step: str
    anf: str
    apdl: str
    volume: float
    step_volume: float
    anf_volume: float
    extent: tuple[float, float, float]
    step_faces: int
    keypoints: int
    lines: int
    areas: int
    volumes: int


def write_solid(voxels: VoxelModel, folder: Path, *, options: SolidOptions) -> SolidReport:
    """Write facade.step, facade.anf and facade_apdl.inp, in metres, and read the first two back.

    Parameters
    ----------
    voxels : VoxelModel
        Only the full ones count.
    folder : Path
        Must exist; files of these names in it are replaced.
    options : SolidOptions

    Returns
    -------
    report : SolidReport

    Raises
    ------
    InputError
        If the voxels make no solid: none is full, two overlap, the wall falls into pieces.
    NumericsError
        If a file reads back with another volume (1e-9 relative for the neutral file, 1e-6 for STEP),
        another extent or other counts, or is not sound.
    """
    step, anf, apdl = (folder / name for name in ("facade.step", "facade.anf", "facade_apdl.inp"))
    solid = solid_from_voxels(voxels)
    extent = np.ptp(solid.keypoints, axis=0)
    write_step(cad_solid(voxels), step, name=options.step_name)
    checked = check_step(step, volume=voxels.volume, extent=extent)
    write_anf(solid, anf, order=options.anf_order)
    write_apdl(solid, apdl)
    read = read_anf(anf)
    anf_volume = float(solid_volumes(read).sum())
    counts = [(len(s.keypoints), len(s.lines), len(s.areas), len(s.volumes)) for s in (solid, read)]
    if abs(anf_volume - voxels.volume) > EXACT * voxels.volume or counts[0] != counts[1]:
        msg = (
            f"{anf.name} reads back as {anf_volume:.12g} m³ in {counts[1][3]} volumes, "
            f"expected {voxels.volume:.12g} m³ in {counts[0][3]}."
        )
        raise NumericsError(msg)
    return SolidReport(
        step.name,
        anf.name,
        apdl.name,
        volume=voxels.volume,
        step_volume=checked.volume,
        anf_volume=anf_volume,
        extent=checked.extent,
        step_faces=checked.faces,
        keypoints=counts[0][0],
        lines=counts[0][1],
        areas=counts[0][2],
        volumes=counts[0][3],
    )
