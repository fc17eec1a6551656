"""From cells to solids: boundary representation, STEP, ANSYS neutral file and command decks.

Nothing heavy loads here; OpenCASCADE (by way of cadquery) loads when a STEP file is written or read.
"""

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
from fd2fem.solids.occ import CAD_SUFFIXES
from fd2fem.solids.options import SolidForm, SolidOptions, Strength
from fd2fem.solids.settlement_deck import write_settlement_deck
from fd2fem.solids.step_facade import facade_from_step
from fd2fem.solids.write import SolidReport, write_solid

__all__ = [
    "CAD_SUFFIXES",
    "SolidForm",
    "SolidOptions",
    "SolidReport",
    "StepReport",
    "Strength",
    "cad_cells",
    "cad_wall",
    "check_joined",
    "check_step",
    "facade_from_step",
    "face_groups",
    "read_anf",
    "solid_from_cells",
    "solid_from_voxels",
    "solid_volumes",
    "wall_extent",
    "write_anf",
    "write_apdl",
    "write_brep",
    "write_iges",
    "write_settlement_deck",
    "write_solid",
    "write_step",
]
