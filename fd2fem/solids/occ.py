"""OpenCASCADE's global state, kept in hand: its unit of length and what it prints.

OpenCASCADE works in millimetres and prints to standard output unless told otherwise, for the whole
process. The functions here set both for the time of one call.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fd2fem.errors import InputError, NumericsError

if TYPE_CHECKING:
    from cadquery import Shape

__all__ = ["read_shape", "write_shape"]


@contextmanager
def _quiet_metres() -> Iterator[None]:
    """Work in metres, write metres, print nothing; afterwards everything is as before."""
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_Controller

    STEPControl_Controller.Init_s()  # defines the settings, which otherwise cannot be set
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    settings = {"xstep.cascade.unit": "M", "write.step.unit": "M"}
    before = {name: Interface_Static.CVal_s(name) for name in settings}
    try:
        for printer in printers:
            messenger.RemovePrinter(printer)
        for name, value in settings.items():
            Interface_Static.SetCVal_s(name, value)
        yield
    finally:
        for name, value in before.items():
            Interface_Static.SetCVal_s(name, value)
        for printer in printers:
            messenger.AddPrinter(printer)


def write_shape(shape: "Shape", path: Path, *, name: str) -> None:
    """Write a shape whose coordinates are metres as a STEP file that says so.

    Parameters
    ----------
    shape : cadquery.Shape
    path : Path
    name : str
        Of the product and its solid.

    Raises
    ------
    NumericsError
        If OpenCASCADE cannot write it.
    """
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    with _quiet_metres():
        writer = STEPControl_Writer()
        done = writer.Transfer(shape.wrapped, STEPControl_AsIs) == IFSelect_RetDone
        if done:
            _rename(writer.Model(), name)
            done = writer.Write(str(path)) == IFSelect_RetDone
    if not done:
        msg = f"{path}: the STEP file could not be written; check that its folder exists and has room."
        raise NumericsError(msg)


def _rename(model: Any, name: str) -> None:
    """Name the product and its solid; OpenCASCADE's own setting for this appends a running number."""
    from OCP.TCollection import TCollection_HAsciiString

    text = TCollection_HAsciiString(name)
    for index in range(1, model.NbEntities() + 1):
        entity = model.Value(index)
        kind = entity.DynamicType().Name()
        if kind == "StepBasic_Product":
            entity.SetId(text)
        if kind in {"StepBasic_Product", "StepShape_ManifoldSolidBrep"}:
            entity.SetName(text)


def read_shape(path: Path) -> "Shape":
    """Read a STEP file, in metres whatever unit it declares.

    Parameters
    ----------
    path : Path

    Returns
    -------
    shape : cadquery.Shape

    Raises
    ------
    InputError
        If it cannot be read, is not STEP, or holds no geometry.
    """
    from cadquery import Shape
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    if not path.is_file():
        msg = f"{path}: no such file; give the path of a STEP file."
        raise InputError(msg)
    with _quiet_metres():
        reader = STEPControl_Reader()
        if reader.ReadFile(str(path)) != IFSelect_RetDone:
            msg = f"{path.name} is not a whole STEP file (ISO 10303-21); export it anew."
            raise InputError(msg)
        reader.TransferRoots()
        shape = reader.OneShape() if reader.NbShapes() else None
    if shape is None or shape.IsNull():
        msg = f"{path.name} holds no geometry; export a solid."
        raise InputError(msg)
    return Shape.cast(shape)
