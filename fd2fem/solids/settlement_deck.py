"""A Mechanical APDL deck that analyses the wall: self-weight, then the settlement of its base.

The deck reads the neutral file, so nothing of the geometry stands in it but the extent of the base. What the
base does is in three tables, one for each direction, over x (and y, where that matters) and TIME.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import LoadCase, SolidModel
from fd2fem.solids.loops import solid_volumes
from fd2fem.solids.options import Strength
from fd2fem.solids.settlement_text import HEADER, MATERIAL, MESH, RESULTS, SOLUTION

__all__ = ["write_settlement_deck"]

FloatArray = NDArray[np.float64]

STRAIGHT = 1e-6
"""A table leaves the given movement by no more than this, m, halfway between its points."""
ALONG = (17, 33, 65, 129, 257, 513)
"""Points that a table may have along the base; the most, if none makes it straight between them."""
ACROSS = (2, 3, 5, 9)
"""Points that it may have through the wall, unless the movement is the same all the way."""
TIMES = ((1, 0), (2, 1), (3, 2))
"""Places and times of a table's columns or planes: the base moves from the second time to the third."""
ON_GROUND = 1e-6
"""The base are the points this close, m, to the lowest ones; the deck selects its nodes alike."""
TABLES = ("UXBASE", "UYBASE", "UZBASE")


@dataclass(frozen=True, eq=False)
class _Base:
    """Movement (nx, ny, 3), m, of the base at points `x` along it and `y` through the wall, m."""

    x: FloatArray
    y: FloatArray
    movement: FloatArray


def write_settlement_deck(
    path: Path, case: LoadCase, solid: SolidModel, *, strength: Strength, neutral_file: str = "facade.anf"
) -> None:
    """Write a deck that settles the wall in two load steps, in N, m, kg, s.

    In the first step the wall gets its weight while its base is held, in the second the base moves as
    `case.base` says. A switch in the deck chooses between a linear elastic material, two nonlinear ones on
    SOLID185, and SOLID65.

    Parameters
    ----------
    path : Path
        Written in place; an existing file is replaced.
    case : LoadCase
    solid : SolidModel
        What the neutral file holds: facade frame, m, the base at the lowest z.
    strength : Strength
    neutral_file : str
        Name of the file that the deck reads, beside it.

    Raises
    ------
    InputError
        If the movement of the base is not finite.
    """
    base = _sampled(case, solid)
    depths = np.unique(solid.keypoints[:, 1])
    values = {
        "file": Path(neutral_file).stem,
        "suffix": Path(neutral_file).suffix.removeprefix("."),
        "young": case.young,
        "poisson": case.poisson,
        "density": case.density,
        "gravity": case.gravity,
        "cohesion": strength.cohesion,
        "friction": strength.friction,
        "dilatancy": strength.dilatancy,
        "tension": strength.tension,
        "compression": strength.compression,
        # Two elements through the thinnest part of the wall.
        "size": float(depths[1] - depths[0]) / 2.0,
        "volume": float(solid_volumes(solid).sum()),
        "volumes": len(solid.volumes),
    }
    parts = [HEADER, MATERIAL, MESH, *_tables(base), SOLUTION, RESULTS]
    path.write_text("".join(parts).format(**values), encoding="ascii", newline="\n")


def _sampled(case: LoadCase, solid: SolidModel) -> _Base:
    """Movement of the base at as many points as it takes to be straight between them."""
    low = float(solid.keypoints[:, 2].min())
    ground = solid.keypoints[solid.keypoints[:, 2] < low + ON_GROUND]
    (left, _, _), (right, back, _) = ground.min(axis=0), ground.max(axis=0)
    for along in ALONG:
        moved = _movement(case, np.linspace(left, right, 2 * along - 1), np.linspace(0.0, back, 3), low)
        if _straight(moved, 0):
            break
    x, y = np.linspace(left, right, along), np.zeros(1)
    if np.ptp(moved, axis=1).max() > STRAIGHT:
        for across in ACROSS:
            if _straight(_movement(case, x, np.linspace(0.0, back, 2 * across - 1), low), 1):
                break
        y = np.linspace(0.0, back, across)
    return _Base(x, y, _movement(case, x, y, low))


def _straight(values: FloatArray, axis: int) -> bool:
    """Whether every second value along an axis is the mean of its neighbours, nearly."""
    v = np.moveaxis(values, axis, 0)
    return bool(np.abs(v[1::2] - (v[:-1:2] + v[2::2]) / 2.0).max() <= STRAIGHT)


def _movement(case: LoadCase, x: FloatArray, y: FloatArray, z: float) -> FloatArray:
    """Movement (nx, ny, 3), m, of points of the base."""
    points = np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x)), np.full(len(x) * len(y), z)])
    moved = np.asarray(case.base(points), dtype=np.float64)
    if moved.shape != points.shape or not np.isfinite(moved).all():
        msg = "The movement of the base must be three finite numbers for each point: correct the settlement."
        raise InputError(msg)
    return moved.reshape(len(x), len(y), 3)


def _tables(base: _Base) -> Iterator[str]:
    """A table for each direction."""
    yield "! ---------------------------------------------------------------- movement of the base, m\n"
    for direction, name in enumerate(TABLES):
        values = base.movement[:, :, direction].tolist()
        if len(base.y) == 1:
            yield from _flat_table(name, base.x.tolist(), [value for (value,) in values])
        else:
            yield from _deep_table(name, base.x.tolist(), base.y.tolist(), values)


def _flat_table(name: str, xs: list[float], values: list[float]) -> Iterator[str]:
    """Rows x, columns TIME 0, 1 (at rest) and 2 (moved)."""
    yield f"*DIM,{name},TABLE,{len(xs)},3,1,X,TIME\n"
    yield from (f"{name}(0,{column})={time}\n" for column, time in TIMES)
    for row, (x, value) in enumerate(zip(xs, values, strict=True), start=1):
        yield f"{name}({row},0)={x}\n"
        yield f"{name}({row},1)=0\n{name}({row},2)=0\n{name}({row},3)={value}\n"


def _deep_table(name: str, xs: list[float], ys: list[float], values: list[list[float]]) -> Iterator[str]:
    """Rows x, columns y, planes TIME 0, 1 (at rest) and 2 (moved)."""
    yield f"*DIM,{name},TABLE,{len(xs)},{len(ys)},3,X,Y,TIME\n"
    for plane, time in TIMES:
        yield f"{name}(0,0,{plane})={time}\n"
        yield from (f"{name}(0,{column},{plane})={y}\n" for column, y in enumerate(ys, start=1))
        for row, (x, line) in enumerate(zip(xs, values, strict=True), start=1):
            yield f"{name}({row},0,{plane})={x}\n"
            for column, value in enumerate(line, start=1):
                yield f"{name}({row},{column},{plane})={value if time == 2 else 0}\n"
