"""From voxels to solids: boundary representation, STEP, ANSYS neutral file and command deck.

Nothing heavy loads here; OpenCASCADE (by way of cadquery) loads when a STEP file is written or read.
"""

from fd2fem.solids.anf import write_anf
from fd2fem.solids.anf_reader import read_anf
from fd2fem.solids.apdl import write_apdl
from fd2fem.solids.brep import solid_from_voxels
from fd2fem.solids.cad import StepReport, cad_solid, check_step, write_step
from fd2fem.solids.loops import solid_volumes
from fd2fem.solids.options import SolidOptions
from fd2fem.solids.step_facade import facade_from_step
from fd2fem.solids.write import SolidReport, write_solid

__all__ = [
    "SolidOptions",
    "SolidReport",
    "StepReport",
    "cad_solid",
    "check_step",
    "facade_from_step",
    "read_anf",
    "solid_from_voxels",
    "solid_volumes",
    "write_anf",
    "write_apdl",
    "write_solid",
    "write_step",
]
