"""CAD files of solids in metres: STEP, IGES and OpenCASCADE's own BREP."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fd2fem.errors import InputError, NumericsError
from fd2fem.solids.occ import quiet_metres

if TYPE_CHECKING:
    from cadquery import Shape

__all__ = ["write_brep", "write_iges", "write_step"]

METRE = 1000.0
"""In OpenCASCADE's own unit, mm."""


def write_step(shape: "Shape", path: Path, *, name: str = "facade", faces: Sequence[str | None] = ()) -> None:
    """Write a shape in metres as a STEP file (AP214) that declares metres.

    Parameters
    ----------
    shape : cadquery.Shape
        One or several solids; coordinates in m.
    path : Path
        Written in place; an existing file is replaced.
    name : str
        Of the product and its solid, printable ASCII; several solids are numbered.
    faces : sequence of str or None
        Name of each of `shape.Faces()`, such as `face_groups` finds; none at all names none.

    Raises
    ------
    InputError
        If there are names, but not one for each face.
    NumericsError
        If the file cannot be written.
    """
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPConstruct import STEPConstruct
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    named = _named(shape, name, faces)
    with quiet_metres():
        writer = STEPControl_Writer()
        done = writer.Transfer(shape.wrapped, STEPControl_AsIs) == IFSelect_RetDone
        if done:
            _name_product(writer.Model(), name)
            finder = writer.WS().TransferWriter().FinderProcess()
            for part, text in named:
                entity = STEPConstruct.FindEntity_s(finder, part.wrapped)
                if entity is not None:
                    entity.SetName(_text(text))
            done = writer.Write(str(path)) == IFSelect_RetDone
    if not done:
        raise _unwritten(path, "STEP")


def write_iges(shape: "Shape", path: Path) -> None:
    """Write solids in metres as an IGES 5.3 file of boundary representations that declares metres.

    Of whole ellipses OpenCASCADE makes splines there, so their edges are halved: these stay ellipses.

    Parameters
    ----------
    shape : cadquery.Shape
        Coordinates in m.
    path : Path
        Written in place; an existing file is replaced.

    Raises
    ------
    NumericsError
        If the file cannot be written.
    """
    from OCP.IGESControl import IGESControl_Writer

    with quiet_metres():
        writer = IGESControl_Writer("M", 1)
        section = writer.Model().GlobalSection()
        section.SetCascadeUnit(METRE)  # else it takes the coordinates for millimetres
        section.SetAuthorName(_text(""))  # else it is the account's name
        section.SetFileName(_text(path.name))
        writer.Model().SetGlobalSection(section)
        done = writer.AddShape(_with_halved_ellipses(shape))
        writer.ComputeModel()
        done = done and writer.Write(str(path))
    if not done:
        raise _unwritten(path, "IGES")


def write_brep(shape: "Shape", path: Path) -> None:
    """Write a shape in OpenCASCADE's own format, which keeps shared faces but has no units and names.

    Parameters
    ----------
    shape : cadquery.Shape
    path : Path
        Written in place; an existing file is replaced.

    Raises
    ------
    NumericsError
        If the file cannot be written.
    """
    from OCP.BRepTools import BRepTools

    with quiet_metres():
        done = BRepTools.Write_s(shape.wrapped, str(path))
    if not done:
        raise _unwritten(path, "BREP")


def _with_halved_ellipses(shape: "Shape") -> Any:
    """The shape with its closed edges in two, if there are ellipses among these."""
    from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideClosedEdges

    if not any(edge.geomType() == "ELLIPSE" and edge.IsClosed() for edge in shape.Edges()):
        return shape.wrapped
    division = ShapeUpgrade_ShapeDivideClosedEdges(shape.wrapped)
    division.SetNbSplitPoints(1)
    return division.Result() if division.Perform() else shape.wrapped


def _named(shape: "Shape", name: str, faces: Sequence[str | None]) -> list[tuple["Shape", str]]:
    """Solids and faces with their names; those without are left out."""
    solids, parts = shape.Solids(), shape.Faces()
    if faces and len(faces) != len(parts):
        msg = f"Invalid 'faces': {len(faces)} names for {len(parts)} faces."
        raise InputError(msg)
    names = [name] if len(solids) == 1 else [f"{name} {number + 1}" for number in range(len(solids))]
    named = list(zip(solids, names, strict=True))
    return named + [(part, str(text)) for part, text in zip(parts, faces, strict=False) if text is not None]


def _name_product(model: Any, name: str) -> None:
    """Name the product; OpenCASCADE's own setting for this appends a running number."""
    for index in range(1, model.NbEntities() + 1):
        entity = model.Value(index)
        if entity.DynamicType().Name() == "StepBasic_Product":
            entity.SetId(_text(name))
            entity.SetName(_text(name))


def _text(text: str) -> Any:
    from OCP.TCollection import TCollection_HAsciiString

    return TCollection_HAsciiString(text)


def _unwritten(path: Path, kind: str) -> NumericsError:
    return NumericsError(
        f"{path}: the {kind} file could not be written; check that its folder exists and has room."
    )
