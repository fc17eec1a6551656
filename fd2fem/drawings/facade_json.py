"""The facade.json file: what a reconstruction writes and every later step reads."""

import math
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from fd2fem.drawings.placing import DEFAULT_THICKNESS
from fd2fem.errors import InputError
from fd2fem.model import (
    Arc,
    EdgeSigma,
    Facade,
    FacadeFrame,
    FilledHole,
    Opening,
    OpeningKind,
    Storey,
    rectangle,
)

if TYPE_CHECKING:
    from fd2fem.drawings.schemas import FacadeFile, StoredArc, StoredOpening

__all__ = ["SCHEMA", "facade_from_dict", "facade_to_dict"]

SCHEMA = "fd2fem/facade-1"
FACADE_KEYS = (
    "schema",
    "units",
    "frame",
    "length",
    "height",
    "thickness",
    "storeys",
    "opening_area",
    "outline",
    "arcs",
    "openings",
    "filled_holes",
)
"""The keys that the facade itself fills; all others are its record."""
ROUNDING_M, ROUNDING_M2 = 1e-3, 1e-2
"""A size in the file may differ this much from its outline: another program may have rounded it."""


def facade_to_dict(facade: Facade) -> dict[str, Any]:
    """Return the content of a facade.json, in plain Python types.

    `facade.record` fills the keys after the openings; where it lacks one of the file's own ("points",
    "options", "timings_s", "version"), that is empty, or the version of this program. A number that is
    NaN or infinite becomes null, for JSON has none.

    The arcs of an outline say which of its corners, from "first" to "last", both counted from 0, stand for a
    piece of an ellipse with the given centre and radii along x and z; "storeys" are where the thickness
    changes, from below.

    Raises
    ------
    InputError
        If the record uses a key of the facade itself, or holds a value that JSON cannot.

    Examples
    --------
    >>> facade = Facade(rectangle(0, 0, 4, 3), 0.35, record={"warnings": []})
    >>> content = facade_to_dict(facade)
    >>> content["schema"], content["outline"][2], content["warnings"]
    ('fd2fem/facade-1', [4.0, 3.0], [])
    """
    taken = [key for key in facade.record if key in FACADE_KEYS]
    if taken:
        msg = f"Invalid 'record': {', '.join(map(repr, taken))} is a key of the facade itself."
        raise InputError(msg)
    x, y, z = facade.frame.axes
    content = {
        "schema": SCHEMA,
        "units": "m",
        "frame": {"origin": facade.frame.origin, "x": x, "y": y, "z": z},
        "length": facade.length,
        "height": facade.height,
        "thickness": facade.thickness,
        "storeys": [{"z": storey.z, "thickness": storey.thickness} for storey in facade.storeys],
        "opening_area": facade.opening_area,
        "outline": facade.outline,
        "arcs": [_arc_to_dict(arc) for arc in facade.arcs],
        "openings": [_opening_to_dict(opening) for opening in facade.openings],
        "filled_holes": [
            {"outline": hole.outline, "area": hole.area, "reason": hole.reason, "evidence": hole.evidence}
            for hole in facade.filled_holes
        ],
        **{"points": {}, "options": {}, "timings_s": {}, "version": version("fd2fem")},
        **facade.record,
    }
    return {key: _plain(key, value) for key, value in content.items()}


def _opening_to_dict(opening: Opening) -> dict[str, Any]:
    sigma = opening.sigma
    return {
        "id": opening.id,
        "kind": opening.kind.value,
        "x": opening.x,
        "z": opening.z,
        "width": opening.width,
        "height": opening.height,
        "area": opening.area,
        "outline": opening.outline,
        "arcs": [_arc_to_dict(arc) for arc in opening.arcs],
        "confidence": opening.confidence,
        "evidence": opening.evidence,
        "sigma": {"left": sigma.left, "right": sigma.right, "bottom": sigma.bottom, "top": sigma.top},
    }


def _arc_to_dict(arc: Arc) -> dict[str, Any]:
    return {"first": arc.first, "last": arc.last, "centre": (arc.x, arc.z), "radii": (arc.a, arc.b)}


def _plain(key: str, value: Any) -> Any:
    """Return `value` in the types that JSON has."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(name): _plain(f"{key}.{name}", entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(key, entry) for entry in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, str):
        return str(value)
    msg = f"Invalid '{key}': JSON cannot hold a {type(value).__name__}."
    raise InputError(msg)


def facade_from_dict(data: Any, *, source: str) -> Facade:
    """Facade of the content of a facade.json.

    Parameters
    ----------
    data : mapping
        As `facade_to_dict` returns it. Needs schema, units, openings, and the outline or length and
        height; everything else may be missing, but arcs need the outline whose corners they count. Keys
        that the facade does not know become its record.
    source : str
        File that a message names.

    Raises
    ------
    InputError
        If the schema is another, a key is missing or wrong, or sizes contradict the outline.
    """
    from fd2fem.drawings.schemas import FacadeFile, validate

    if not isinstance(data, Mapping) or "schema" not in data:
        msg = f"{source} is not a facade: it has no key 'schema' with the value '{SCHEMA}'."
        raise InputError(msg)
    if data["schema"] != SCHEMA:
        msg = f"{source} is not a facade: its schema is {str(data['schema'])[:60]!r}, expected '{SCHEMA}'."
        raise InputError(msg)
    file = validate(FacadeFile, {key: data[key] for key in FACADE_KEYS if key in data}, source=source)
    record = {key: value for key, value in data.items() if key not in FACADE_KEYS}
    try:
        facade = _facade(file, record)
        _check_sizes(file, facade)
    except InputError as error:
        msg = f"{source}: {error}"
        raise InputError(msg) from error
    return facade


def _facade(file: "FacadeFile", record: Mapping[str, Any]) -> Facade:
    frame = FacadeFrame.identity()
    if file.frame is not None:
        frame = FacadeFrame(np.array(file.frame.origin), np.array([file.frame.x, file.frame.y, file.frame.z]))
    outline = file.outline if file.outline is not None else _rectangle(0, 0, file.length, file.height)
    return Facade(
        outline=np.array(outline, dtype=np.float64),
        thickness=DEFAULT_THICKNESS if file.thickness is None else file.thickness,
        openings=tuple(_opening(number, entry) for number, entry in enumerate(file.openings, start=1)),
        filled_holes=tuple(
            FilledHole(np.array(hole.outline), hole.reason, hole.evidence) for hole in file.filled_holes
        ),
        frame=frame,
        record=record,
        arcs=_arcs(file.arcs),
        storeys=tuple(Storey(storey.z, storey.thickness) for storey in file.storeys),
    )


def _opening(number: int, entry: "StoredOpening") -> Opening:
    outline = entry.outline
    if outline is None:
        outline = _rectangle(entry.x, entry.z, entry.width, entry.height)
    return Opening(
        id=number if entry.id is None else entry.id,
        kind=OpeningKind(entry.kind),
        outline=np.array(outline, dtype=np.float64),
        confidence=entry.confidence,
        evidence=entry.evidence,
        sigma=EdgeSigma(**entry.sigma.model_dump()),
        arcs=_arcs(entry.arcs),
    )


def _arcs(entries: "Sequence[StoredArc]") -> tuple[Arc, ...]:
    return tuple(Arc(entry.first, entry.last, *entry.centre, *entry.radii) for entry in entries)


def _rectangle(*sizes: float | None) -> list[list[float]]:
    """Corners of a rectangle whose sizes the schema has found to be there."""
    corners: list[list[float]] = rectangle(*(size for size in sizes if size is not None)).tolist()
    return corners


def _check_sizes(file: "FacadeFile", facade: Facade) -> None:
    """Raise if a size was changed and the outline, which counts, was not."""
    _check_size("", "length", file.length, facade.length, ROUNDING_M)
    _check_size("", "height", file.height, facade.height, ROUNDING_M)
    for entry, opening in zip(file.openings, facade.openings, strict=True):
        for key in ("x", "z", "width", "height"):
            _check_size(
                f"opening {opening.id}: ", key, getattr(entry, key), getattr(opening, key), ROUNDING_M
            )
        _check_size(f"opening {opening.id}: ", "area", entry.area, opening.area, ROUNDING_M2)
    _check_size("", "opening_area", file.opening_area, facade.opening_area, ROUNDING_M2)


def _check_size(where: str, key: str, given: float | None, found: float, tolerance: float) -> None:
    if given is not None and abs(given - found) > tolerance:
        msg = f"{where}'{key}' is {given:.6g}, but the outlines say {found:.6g}: correct one of them."
        raise InputError(msg)
