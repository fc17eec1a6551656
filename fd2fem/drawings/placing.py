"""From polygons as they were drawn to a facade whose lower left corner is (0, 0)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, Opening, OpeningKind
from fd2fem.model.checks import as_ring

__all__ = ["DEFAULT_THICKNESS", "DrawnShape", "place_facade"]

DEFAULT_THICKNESS = 0.35
"""Thickness of a wall whose drawing does not say, m: one and a half bricks, the paper's buildings."""
ON_GROUND = 1e-6
"""An opening this close to the ground is a door, m."""


@dataclass(frozen=True, eq=False)
class DrawnShape:
    """An opening as it was drawn: `outline` (k, 2), m; `kind` None where the drawing does not say."""

    outline: NDArray[np.float64]
    kind: OpeningKind | None = None


def place_facade(
    outline: NDArray[np.float64],
    shapes: Sequence[DrawnShape],
    *,
    source: str,
    thickness: float,
    frame: FacadeFrame | None,
    record: Mapping[str, Any],
) -> Facade:
    """Shift the wall to (0, 0) together with its openings, and number these in the given order.

    Parameters
    ----------
    outline : (k, 2) float array, m
    shapes : sequence of DrawnShape
        In the coordinates of `outline`. Without a kind it is a door if it stands on the ground.
    source : str
        File that a message names.
    thickness : float, m
    frame : FacadeFrame or None
        Where the (0, 0) of the drawing stands in the world; None: the facade frame is the world.
    record : mapping

    Raises
    ------
    InputError
        If an outline crosses itself, or openings leave the wall or touch.
    """
    try:
        wall = as_ring("outline", outline)
        corner = wall.min(axis=0)
        return Facade(
            outline=wall - corner,
            thickness=thickness,
            openings=tuple(_opening(i, shape, corner) for i, shape in enumerate(shapes, start=1)),
            frame=FacadeFrame.identity() if frame is None else frame.moved(*corner.tolist()),
            record=record,
        )
    except InputError as error:
        msg = f"{source}: {error}"
        raise InputError(msg) from error


def _opening(number: int, shape: DrawnShape, corner: NDArray[np.float64]) -> Opening:
    outline = shape.outline - corner
    on_ground = bool(abs(outline[:, 1].min()) < ON_GROUND)
    return Opening(number, shape.kind or (OpeningKind.DOOR if on_ground else OpeningKind.WINDOW), outline)
