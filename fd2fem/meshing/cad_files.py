"""Solids from the files that CAD programs write, by gmsh's OpenCASCADE kernel, in metres."""

import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing.gluing import glue
from fd2fem.meshing.session import silent_stdout

__all__ = ["CAD_SETTINGS", "CAD_SUFFIXES", "load_solid"]

_FORMATS: Mapping[str, str] = MappingProxyType(
    {".step": "step", ".stp": "step", ".igs": "iges", ".iges": "iges", ".brep": "brep"}
)
CAD_SUFFIXES: tuple[str, ...] = tuple(_FORMATS)
"""Ends of the names of files that can be read."""
_SEWING = ("Geometry.OCCSewFaces", "Geometry.OCCMakeSolids")
CAD_SETTINGS: Mapping[str, float | str] = MappingProxyType(
    {"Geometry.OCCTargetUnit": "M", **dict.fromkeys(_SEWING, 0.0)}
)
"""Options of gmsh that a session needs to load a solid."""
FEW = 8
"""More solids than this are glued before they are joined, which would take minutes."""
LONGEST = 1000.0
"""A solid longer than this, m, is none in metres."""


def load_solid(gmsh: ModuleType, path: Path) -> float:
    """Load the solids of a file into gmsh's model, in metres, those that touch as one; their volume, m³.

    STEP and IGES files are converted from the unit that they declare; BREP files declare none and are
    taken to be in metres. Where a file has faces only, as most IGES files, they are sewn together.

    Parameters
    ----------
    gmsh : module
        In a session with `CAD_SETTINGS`, with an empty model.
    path : Path
        STEP, IGES or BREP.

    Raises
    ------
    InputError
        If the file is missing, of another format, truncated, or holds no solid, or several apart.
    MeshError
        If solids that touch cannot be joined.
    """
    kind = _checked_kind(path)
    if kind == "iges":
        _define_unit(gmsh)
    _import(gmsh, path, kind)
    if not gmsh.model.getEntities(3) and gmsh.model.getEntities(2):
        gmsh.clear()
        for name in _SEWING:
            gmsh.option.setNumber(name, 1.0)
        _import(gmsh, path, kind)
    solids = gmsh.model.getEntities(3)
    if not solids:
        found = "faces that do not close" if gmsh.model.getEntities(2) else "curves or points only"
        if not gmsh.model.getEntities():
            found = "nothing"
        msg = f"{path.name} holds no solid but {found}: export a closed solid."
        raise InputError(msg)
    box = gmsh.model.getBoundingBox(-1, -1)
    longest = max(box[k + 3] - box[k] for k in range(3))
    if longest > LONGEST:
        msg = f"{path.name} is {longest:.0f} m long: declare the unit of length, or export it in metres."
        raise InputError(msg)
    if len(solids) > 1:
        _join(gmsh, path, solids)
        pieces = len(gmsh.model.getEntities(3))
        if pieces > 1:
            msg = f"{path.name} holds {pieces} solids that do not touch: export the wall alone, or join them."
            raise InputError(msg)
    return float(sum(abs(gmsh.model.occ.getMass(*solid)) for solid in gmsh.model.getEntities(3)))


def _checked_kind(path: Path) -> str:
    """The format of a file that looks whole; OpenCASCADE reads on for ever in some that are not."""
    if path.suffix.lower() not in _FORMATS:
        msg = f"{path.name} is no CAD file that can be read: expected one of {', '.join(CAD_SUFFIXES)}."
        raise InputError(msg)
    if not path.is_file():
        msg = f"There is no file {path}: give a STEP, IGES or BREP file with a solid."
        raise InputError(msg)
    kind, data = _FORMATS[path.suffix.lower()], path.read_bytes()
    name = kind.upper()
    if not data.strip():
        msg = f"{path.name} is empty: export the solid again."
        raise InputError(msg)
    begins, ends = _LOOKS[kind]
    if not re.search(begins, data[:4096]):
        msg = f"{path.name} is not {'an' if kind == 'iges' else 'a'} {name} file: export the solid again."
        raise InputError(msg)
    if not re.search(ends, data[-4096:]):
        msg = f"{path.name} is cut short: its end as {name} file is missing; export the solid again."
        raise InputError(msg)
    return kind


_LOOKS: Mapping[str, tuple[bytes, bytes]] = MappingProxyType(
    {
        "step": (rb"ISO-10303-21", rb"END-ISO-10303-21\s*;"),
        # Lines of 80 columns, the 73rd of which names the section: S(tart) first, T(erminate) last.
        "iges": (rb"(?m)^[^\n]{72}S *0*1\s*$", rb"(?m)^S[^\n]{71}T *0*1\s*\Z"),
        # The last line names the shape itself, after the list of the parts of its outermost one.
        "brep": (rb"CASCADE Topology V\d", rb"\*\s*\n\s*\n[+-]\d+ \d+\s*\Z"),
    }
)
"""What each format begins and ends with."""


def _define_unit(gmsh: ModuleType) -> None:
    """Let OpenCASCADE know its setting of the unit, which it defines only once it deals with STEP."""
    with tempfile.TemporaryDirectory() as folder, silent_stdout():
        gmsh.model.occ.addPoint(0.0, 0.0, 0.0)
        gmsh.model.occ.synchronize()
        gmsh.write(str(Path(folder) / "point.step"))
        gmsh.clear()


def _import(gmsh: ModuleType, path: Path, kind: str) -> None:
    try:
        with silent_stdout():  # OpenCASCADE has its own ways to it
            gmsh.model.occ.importShapes(str(path), highestDimOnly=False, format=kind)
            gmsh.model.occ.synchronize()
    except Exception as error:  # gmsh raises nothing more specific
        if "Empty bounding box" in str(error):
            return  # nothing was found
        msg = f"{path.name} is not a {kind.upper()} file that can be read: {error}. Export it again."
        raise InputError(msg) from error


def _join(gmsh: ModuleType, path: Path, solids: list[tuple[int, int]]) -> None:
    """Let solids that touch become one."""
    try:
        if len(solids) > FEW:
            with tempfile.TemporaryDirectory() as folder:
                apart, joined = Path(folder) / "apart.brep", Path(folder) / "joined.brep"
                gmsh.write(str(apart))
                if glue(apart, joined):
                    gmsh.clear()
                    _import(gmsh, joined, "brep")
            solids = gmsh.model.getEntities(3)
        if len(solids) > 1:
            with silent_stdout():
                gmsh.model.occ.fuse(solids[:1], solids[1:])
                gmsh.model.occ.synchronize()
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"The {len(solids)} solids of {path.name} could not be joined: {error}. Join them in CAD."
        raise MeshError(msg) from error
