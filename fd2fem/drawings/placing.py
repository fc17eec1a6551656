"""From outlines as they were drawn to a facade whose lower left corner is (0, 0)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, Opening, OpeningKind, Storey
from fd2fem.model.checks import as_ring
from fd2fem.model.outlines import Outline

__all__ = ["DEFAULT_THICKNESS", "SAGITTA", "DrawnShape", "DrawnWall", "place_facade"]

DEFAULT_THICKNESS = 0.35
"""Thickness of a wall whose drawing does not say, m: one and a half bricks, the paper's buildings."""
SAGITTA = 0.001
"""Polygons of the same area leave the curves that they stand for by at most this, m."""
ON_GROUND = 1e-6
"""An opening this close to the ground is a door, m."""


@dataclass(frozen=True, eq=False)
class DrawnShape:
    """An opening as it was drawn, in metres; `kind` None where the drawing does not say."""

    outline: Outline
    kind: OpeningKind | None = None


@dataclass(frozen=True, eq=False)
class DrawnWall:
    """The wall as it was drawn, in metres.

    Its outer edge, its thickness at the ground, and from which heights up it has which other thickness.
    """

    outline: Outline
    thickness: float
    storeys: tuple[tuple[float, float], ...] = ()


def place_facade(
    wall: DrawnWall,
    shapes: Sequence[DrawnShape],
    *,
    source: str,
    frame: FacadeFrame | None,
    record: Mapping[str, Any],
) -> Facade:
    """Shift the wall to (0, 0) together with its openings, and number these in the given order.

    Parameters
    ----------
    wall : DrawnWall
    shapes : sequence of DrawnShape
        In the coordinates of the wall. Without a kind it is a door if it stands on the ground.
    source : str
        File that a message names.
    frame : FacadeFrame or None
        Where the (0, 0) of the drawing stands in the world; None: the facade frame is the world.
    record : mapping

    Raises
    ------
    InputError
        If an outline crosses itself, or openings leave the wall or touch, or storeys do not rise.
    """
    try:
        # Arcs come on outlines that are rings already, of which this changes no corner.
        outline = Outline(as_ring("outline", wall.outline.ring), wall.outline.arcs)
        x, z = outline.ring.min(axis=0).tolist()
        placed = outline.moved(-x, -z)
        return Facade(
            outline=placed.ring,
            thickness=wall.thickness,
            openings=tuple(_opening(i, shape, x, z) for i, shape in enumerate(shapes, start=1)),
            frame=FacadeFrame.identity() if frame is None else frame.moved(x, z),
            record=record,
            arcs=placed.arcs,
            storeys=tuple(Storey(level - z, thickness) for level, thickness in wall.storeys),
        )
    except InputError as error:
        msg = f"{source}: {error}"
        raise InputError(msg) from error


def _opening(number: int, shape: DrawnShape, x: float, z: float) -> Opening:
    """The opening in the frame whose origin is (x, z) in the drawing."""
    outline = shape.outline.moved(-x, -z)
    on_ground = bool(abs(outline.ring[:, 1].min(initial=np.inf)) < ON_GROUND)
    kind = shape.kind or (OpeningKind.DOOR if on_ground else OpeningKind.WINDOW)
    return Opening(number, kind, outline.ring, arcs=outline.arcs)
