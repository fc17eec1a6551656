"""A drawing as TOML: the wall, and a list of rectangles.

::

    name = "Gable end"
    source = "survey of 2019, sheet 4"
    units = "m"                     # or "mm", for every length in the file
    length = 4.95                   # or outline = [[x, z], ...]
    height = 12.16
    thickness = 0.35                # this where it is not given

    [frame]                         # optional
    origin = [674321.0, 5403210.0, 512.0]   # where the drawing's (0, 0) stands in the world
    heading = 30.0                  # of the wall's x axis, degrees anticlockwise from east

    [[openings]]
    kind = "door"                   # or "window"; where not given, a door if it stands on the ground
    x = 0.425                       # lower left corner; or outline = [[x, z], ...]
    z = 0.0
    width = 4.10
    height = 2.956
"""

import tomllib
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.drawings.placing import DEFAULT_THICKNESS, DrawnShape, place_facade
from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, OpeningKind, rectangle

if TYPE_CHECKING:
    from fd2fem.drawings.schemas import DrawingFile, DrawnFrame, DrawnOpening

__all__ = ["facade_from_toml"]

PER_METRE = {"m": 1.0, "mm": 1000.0}


def facade_from_toml(text: str, *, source: str, thickness: float | None = None) -> Facade:
    r"""Facade of a TOML drawing.

    Parameters
    ----------
    text : str
        Content of the file.
    source : str
        File that a message names.
    thickness : float, m, or None
        In place of the file's.

    Raises
    ------
    InputError
        If it is not TOML, not a facade, has an unknown key or an impossible size.

    Examples
    --------
    >>> text = "length = 3\nheight = 4\nopenings = [{x = 1, z = 1, width = 1, height = 2}]"
    >>> facade_from_toml(text, source="wall.toml").opening_area
    2.0
    """
    from fd2fem.drawings.schemas import DrawingFile, validate

    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        msg = f"{source} is not TOML: {error}."
        raise InputError(msg) from error
    if not data.keys() & {"outline", "length", "height"}:
        msg = f"{source} is not a facade: it has neither 'length' and 'height' nor 'outline'."
        raise InputError(msg)
    drawing = validate(DrawingFile, data, source=source)
    if thickness is None and drawing.thickness is not None:
        thickness = float(_metres(drawing, drawing.thickness))
    return place_facade(
        _wall(drawing),
        [_shape(drawing, opening) for opening in drawing.openings],
        source=source,
        thickness=DEFAULT_THICKNESS if thickness is None else thickness,
        frame=_frame(drawing, drawing.frame) if drawing.frame else None,
        record={key: value for key in ("name", "source") if (value := getattr(drawing, key))},
    )


def _metres(drawing: "DrawingFile", values: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64) / PER_METRE[drawing.units]


def _rectangle(*sizes: float | None) -> NDArray[np.float64]:
    """Corners of a rectangle whose sizes the schema has found to be there."""
    return rectangle(*(size for size in sizes if size is not None))


def _wall(drawing: "DrawingFile") -> NDArray[np.float64]:
    if drawing.outline is not None:
        return _metres(drawing, drawing.outline)
    return _metres(drawing, _rectangle(0.0, 0.0, drawing.length, drawing.height))


def _shape(drawing: "DrawingFile", opening: "DrawnOpening") -> DrawnShape:
    if opening.outline is not None:
        outline = _metres(drawing, opening.outline)
    else:
        outline = _metres(drawing, _rectangle(opening.x, opening.z, opening.width, opening.height))
    return DrawnShape(outline, OpeningKind(opening.kind) if opening.kind else None)


def _frame(drawing: "DrawingFile", frame: "DrawnFrame") -> FacadeFrame:
    """Frame whose x axis has the heading, with z up and so y = z × x into the wall."""
    c, s = np.cos(np.radians(frame.heading)), np.sin(np.radians(frame.heading))
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return FacadeFrame(_metres(drawing, frame.origin), axes)
