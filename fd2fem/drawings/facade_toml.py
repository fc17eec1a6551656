"""A drawing as TOML: the wall, and a list of openings.

::

    name = "Gable end"
    source = "survey of 2019, sheet 4"
    units = "m"                     # or "mm", for every length in the file
    length = 4.95                   # or outline = [[x, z], ...]
    height = 12.16
    thickness = 0.35                # at the ground; this where it is not given

    [frame]                         # optional
    origin = [674321.0, 5403210.0, 512.0]   # where the drawing's (0, 0) stands in the world
    heading = 30.0                  # of the wall's x axis, degrees anticlockwise from east

    [[storeys]]                     # optional, from below: from z up, the wall has this thickness;
    z = 3.2                         # its front is flush, its back steps
    thickness = 0.24

    [[openings]]
    kind = "door"                   # or "window"; where not given, a door if it stands on the ground
    x = 0.425                       # lower left corner; or outline = [[x, z], ...]
    z = 0.0
    width = 4.10                    # overall
    height = 2.956                  # overall, to the crown of a curved head
    head = {shape = "arc", rise = 0.4}      # optional: "arc", "elliptical", "pointed" or "gabled"

    [[openings]]
    shape = "ellipse"               # a circle where it is as wide as high
    x = 2.0                         # lower left corner of its rectangle
    z = 8.0
    width = 0.9
    height = 0.9

The rise of a head is the height of its crown above the ends of the jambs. An arc rises by at most half of the
width, which is its rise where none is given: a round head. Half an ellipse and a gable rise by any height; a
pointed head, of two arcs about centres at the height of the jambs' ends, by half of the width or more.

An outline may bend: a third number at a corner, [x, z, bulge], makes the edge to the next corner an arc of a
circle, as in a CAD polyline. It is the tangent of a quarter of the arc's angle, 1 for half a circle, and
positive where the arc turns to the left, which bulges outward where the corners run counter-clockwise.

Curves become polygons of exactly their area, which leave them by at most 1 mm; the facade's arcs say which
corners stand for which curve.
"""

import tomllib
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.drawings.bulges import bulged_outline
from fd2fem.drawings.placing import DEFAULT_THICKNESS, SAGITTA, DrawnShape, DrawnWall, place_facade
from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, OpeningKind, rectangle
from fd2fem.model.heads import Head, HeadKind, head_outline
from fd2fem.model.outlines import Outline, Oval, oval_outline

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
        In place of the file's at the ground; its storeys keep theirs.

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
    return place_facade(
        _wall(drawing, thickness),
        [_shape(drawing, number, source) for number in range(len(drawing.openings))],
        source=source,
        frame=_frame(drawing, drawing.frame) if drawing.frame else None,
        record={key: value for key in ("name", "source") if (value := getattr(drawing, key))},
    )


def _metres(drawing: "DrawingFile", values: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64) / PER_METRE[drawing.units]


def _rectangle(drawing: "DrawingFile", *sizes: float | None) -> NDArray[np.float64]:
    """Corners (4, 2), m, of a rectangle whose sizes the schema has found to be there."""
    return _metres(drawing, rectangle(*(size for size in sizes if size is not None)))


def _wall(drawing: "DrawingFile", thickness: float | None) -> DrawnWall:
    """The wall; `thickness`, m, in place of the drawing's."""
    if thickness is None:
        given = drawing.thickness
        thickness = DEFAULT_THICKNESS if given is None else float(_metres(drawing, given))
    if drawing.outline is not None:
        outline = _bent(drawing, drawing.outline)
    else:
        outline = Outline(_rectangle(drawing, 0.0, 0.0, drawing.length, drawing.height))
    storeys = [_metres(drawing, [storey.z, storey.thickness]).tolist() for storey in drawing.storeys]
    return DrawnWall(outline, thickness, tuple((level, thick) for level, thick in storeys))


def _shape(drawing: "DrawingFile", number: int, source: str) -> DrawnShape:
    """One of the openings, counted from 0; a message names the file `source`."""
    opening = drawing.openings[number]
    try:
        outline = _outline(drawing, opening)
    except InputError as error:
        msg = f"{source}: opening {number + 1}: {error}"
        raise InputError(msg) from error
    return DrawnShape(outline, OpeningKind(opening.kind) if opening.kind else None)


def _outline(drawing: "DrawingFile", opening: "DrawnOpening") -> Outline:
    if opening.outline is not None:
        return _bent(drawing, opening.outline)
    corners = _rectangle(drawing, opening.x, opening.z, opening.width, opening.height)
    (left, bottom), (right, top) = corners[[0, 2]].tolist()
    if opening.shape == "ellipse":
        a, b = (right - left) / 2.0, (top - bottom) / 2.0
        oval = Oval(left + a, bottom + b, a, b, 0.0, 2.0 * np.pi)
        return oval_outline(oval, tolerance=SAGITTA)
    if opening.head is None:
        return Outline(corners)
    rise = float(_metres(drawing, opening.head.rise_over(opening.width or 0.0) or 0.0))
    head = Head(HeadKind(opening.head.shape), springing=top - rise, crown=top)
    return head_outline(head, left, right, bottom, SAGITTA)


def _bent(drawing: "DrawingFile", corners: list[list[float]]) -> Outline:
    """Outline of corners [x, z] or [x, z, bulge]."""
    bulges = [corner[2] if len(corner) > 2 else 0.0 for corner in corners]
    return bulged_outline(_metres(drawing, [corner[:2] for corner in corners]), bulges, tolerance=SAGITTA)


def _frame(drawing: "DrawingFile", frame: "DrawnFrame") -> FacadeFrame:
    """Frame whose x axis has the heading, with z up and so y = z × x into the wall."""
    c, s = np.cos(np.radians(frame.heading)), np.sin(np.radians(frame.heading))
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return FacadeFrame(_metres(drawing, frame.origin), axes)
