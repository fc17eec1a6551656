"""OpenCASCADE's global state, kept in hand, and its readers.

OpenCASCADE works in millimetres and prints to standard output unless told otherwise, for the whole
process. `quiet_metres` sets both for a while; files are read and written inside of it.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fd2fem.errors import Fd2femError, InputError

if TYPE_CHECKING:
    from cadquery import Shape

__all__ = ["CAD_SUFFIXES", "quiet_metres", "read_shape"]

SEW = 1e-5
"""Faces whose edges are this close, m, are neighbours, where a file does not say."""


@contextmanager
def quiet_metres() -> Iterator[None]:
    """Work in metres, write metres, print nothing; afterwards everything is as before."""
    from OCP.IGESControl import IGESControl_Controller
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_Controller

    for controller in (STEPControl_Controller, IGESControl_Controller):
        controller.Init_s()  # defines the settings, which otherwise cannot be set
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    settings = dict.fromkeys(("xstep.cascade.unit", "write.step.unit", "write.iges.unit"), "M")
    # Several solids are one product: not an assembly of as many.
    numbers = {"write.step.assembly": 0}
    before = {name: Interface_Static.CVal_s(name) for name in settings}
    numbers_before = {name: Interface_Static.IVal_s(name) for name in numbers}
    try:
        for printer in printers:
            messenger.RemovePrinter(printer)
        for name, value in settings.items():
            Interface_Static.SetCVal_s(name, value)
        for name, number in numbers.items():
            Interface_Static.SetIVal_s(name, number)
        yield
    finally:
        for name, value in before.items():
            Interface_Static.SetCVal_s(name, value)
        for name, number in numbers_before.items():
            Interface_Static.SetIVal_s(name, number)
        for printer in printers:
            messenger.AddPrinter(printer)


def read_shape(path: Path) -> "Shape":
    """Read a STEP, IGES or BREP file, told apart by the name's ending.

    STEP and IGES come in metres, whatever unit they declare; BREP declares none and is taken as it is.
    Surfaces that are not joined to solids, as many programs write IGES, are sewn together if they close.

    Parameters
    ----------
    path : Path
        Ending in .step, .stp, .iges, .igs or .brep.

    Returns
    -------
    shape : cadquery.Shape

    Raises
    ------
    InputError
        If it cannot be read, is of another kind, or holds no geometry.
    """
    from cadquery import Shape

    if not path.is_file():
        msg = f"{path}: no such file; give the path of a STEP, IGES or BREP file."
        raise InputError(msg)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        msg = f"{path.name}: '{path.suffix}' is not a CAD format that can be read; use {', '.join(_READERS)}."
        raise InputError(msg)
    with quiet_metres():
        try:
            shape = reader(path)
        except Fd2femError:
            raise
        except Exception as error:  # OpenCASCADE's have no base of their own
            msg = f"{path.name} cannot be read, OpenCASCADE stumbles over it ({error}); export it anew."
            raise InputError(msg) from error
        if shape is None or shape.IsNull():
            msg = f"{path.name} holds no geometry; export a solid."
            raise InputError(msg)
        found = Shape.cast(shape)
        return found if found.Solids() or not found.Shells() + found.Faces() else _sewn(found)


def _read_step(path: Path) -> Any:
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        msg = f"{path.name} is not a whole STEP file (ISO 10303-21); export it anew."
        raise InputError(msg)
    reader.TransferRoots()
    return reader.OneShape() if reader.NbShapes() else None


def _read_iges(path: Path) -> Any:
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.IGESControl import IGESControl_Reader

    reader = IGESControl_Reader()
    if not _is_whole_iges(path) or reader.ReadFile(str(path)) != IFSelect_RetDone:
        msg = f"{path.name} is not a whole IGES file; export it anew."
        raise InputError(msg)
    reader.TransferRoots()
    return reader.OneShape() if reader.NbShapes() else None


def _is_whole_iges(path: Path) -> bool:
    """Whether the last line counts the lines of the other sections right (IGES 5.3, 2.2.4.6).

    Of files that are cut off, OpenCASCADE's reader dies.
    """
    lines = path.read_text(encoding="latin-1").splitlines()
    sections = Counter(line[72:73] for line in lines)
    last = lines[-1] if lines else ""
    counted = re.findall(r"([SGDP]) *(\d+)", last[:72])
    return last[72:73] == "T" and all(sections[section] == int(count) for section, count in counted)


def _read_brep(path: Path) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    shape, content = TopoDS_Shape(), path.read_bytes()
    # Of other files OpenCASCADE complains aloud. The last line of a whole one says which shape it is about.
    is_whole = b"CASCADE Topology V" in content[:200] and re.search(rb"\*\s+[+-]\d+ \d+\s*$", content[-50:])
    if not (is_whole and BRepTools.Read_s(shape, str(path), BRep_Builder())) or shape.IsNull():
        msg = f"{path.name} is not a whole BREP file of OpenCASCADE; export it anew."
        raise InputError(msg)
    return shape


_READERS: dict[str, Callable[[Path], Any]] = {
    ".step": _read_step,
    ".stp": _read_step,
    ".iges": _read_iges,
    ".igs": _read_iges,
    ".brep": _read_brep,
}
CAD_SUFFIXES = tuple(_READERS)
"""Endings of the files that `read_shape` reads."""


def _sewn(shape: "Shape") -> "Shape":
    """Loose faces joined to a solid, or the shape itself if they do not close."""
    from cadquery import Compound, Shape
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
    from OCP.BRepLib import BRepLib

    sewing = BRepBuilderAPI_Sewing(SEW)
    for face in shape.Faces():
        sewing.Add(face.wrapped)
    sewing.Perform()
    solids = []
    for shell in Shape.cast(sewing.SewedShape()).Shells():
        if shell.wrapped.Closed():
            solid = BRepBuilderAPI_MakeSolid(shell.wrapped).Solid()
            BRepLib.OrientClosedSolid_s(solid)
            solids.append(Shape.cast(solid))
    return Compound.makeCompound(solids) if solids else shape
