"""How likely a head of given shape is, given the wall's points above an opening.

Points on a wall are a sample of even density with none inside an opening. So the likelihood of a head, given
the points, grows with the area that it leaves without points and falls with each point inside it, which must
then be a stray one: log L = density x area - STRAY x points inside + constant. The points are sorted into
columns, and a column that has passed its lowest few points counts no more, neither way: a keystone or dirt
then costs no more than a few strays.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.heads import HeadKind
from fd2fem.reconstruction.curves import head_rise
from fd2fem.reconstruction.profiles import outermost
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["Columns", "Fit", "Hidden", "head_columns", "most_likely"]

FloatArray = NDArray[np.float64]
Hidden = Callable[[FloatArray], NDArray[np.bool_]]

STRAY = 4.0
"""Logarithm of how much rarer strays inside an opening are than points on the wall."""
LOWEST = 3
"""So many of a column's lowest points count: more in one column are one thing, as a keystone or dirt."""
PROBES = (1.0, 2.0, 3.0, 4.0, 6.0)
"""A column shows no head if something hides a place so many spacings below its lowest point."""


@dataclass(frozen=True, eq=False)
class Columns:
    """What the wall shows of a head, column by column.

    Attributes
    ----------
    u, z : (m,) float arrays
        The lowest wall points of each column: place between the jambs, -1 to 1, and height, m.
    middle, lowest, highest : (c,) float arrays
        Columns that show the head: place, -1 to 1, and heights of the lowest and highest of these, m.
    count : int
        Number of columns, hidden ones too.
    density : float, 1/m
        Points on the wall per metre of a column's height.
    half : float, m
        Half of the opening's width.
    """

    u: FloatArray
    z: FloatArray
    middle: FloatArray
    lowest: FloatArray
    highest: FloatArray
    count: int
    density: float
    half: float


@dataclass(frozen=True)
class Fit:
    """The most likely head of one shape."""

    kind: HeadKind
    rise: float
    springing: float
    likelihood: float

    @property
    def crown(self) -> float:
        """Height of the highest point, m."""
        return self.springing + self.rise


def head_columns(
    wall_xz: FloatArray,
    jambs: tuple[float, float],
    middle: float,
    sampling: Sampling,
    hidden: Hidden | None,
) -> Columns:
    """Sort the points into columns about a spacing wide; those right beside the jambs say nothing."""
    spacing = sampling.spacing
    half, centre = (jambs[1] - jambs[0]) / 2.0, (jambs[0] + jambs[1]) / 2.0
    clear = half - min(max(spacing / 4.0, 2.0 * sampling.noise, 0.01), 0.2 * half)
    count = int(np.clip(2.0 * clear / spacing, 4, 64))
    inside = (np.abs(wall_xz[:, 0] - centre) < clear) & (wall_xz[:, 1] > middle)
    x, z = wall_xz[inside, 0] - centre, wall_xz[inside, 1]
    column = np.minimum(((x + clear) / (2.0 * clear) * count).astype(np.intp), count - 1)
    kept, first, last = outermost(column, -z, count, LOWEST)
    lowest, highest = -first, -last
    place = (np.arange(count) + 0.5) / count * 2.0 * clear - clear
    shows = np.isfinite(lowest)
    if hidden is not None:
        # Below the lowest point lies the opening, or a shadow that hides where the wall ends.
        start = np.where(shows, lowest, middle)
        for step in PROBES:
            shows &= ~hidden(np.column_stack([place + centre, start - step * spacing]))
    return Columns(
        u=x[kept] / half,
        z=z[kept],
        middle=place[shows] / half,
        lowest=lowest[shows],
        highest=highest[shows],
        count=count,
        density=_density(wall_xz, spacing) * 2.0 * clear / count,
        half=half,
    )


def _density(wall_xz: FloatArray, spacing: float) -> float:
    """Points per square metre of wall here: the median over cells that hold any."""
    cell = 3.0 * spacing
    index = np.floor((wall_xz - wall_xz.min(axis=0, initial=np.inf)) / cell).astype(np.intp)
    if not len(index):
        return 1.0 / spacing**2
    counts = np.bincount(index[:, 0] * (index[:, 1].max() + 1) + index[:, 1])
    return float(np.median(counts[counts > 0])) / cell**2


def most_likely(columns: Columns, kind: HeadKind, rises: FloatArray) -> Fit:
    """The best springing for each rise, and the best of these.

    As the springing rises, each column gains until it has passed its last point, and loses at each point.
    """
    rise = rises[:, None]
    passing = columns.z - head_rise(kind, columns.u, rise=rise, half=columns.half)
    ending = columns.highest - head_rise(kind, columns.middle, rise=rise, half=columns.half)
    event = np.concatenate([passing, ending], axis=1)
    if not event.size:
        return Fit(kind, 0.0, 0.0, 0.0)
    order = np.argsort(event, axis=1)
    springing = np.take_along_axis(event, order, axis=1)
    is_point = order < passing.shape[1]
    passed = np.cumsum(is_point, axis=1) - is_point
    active = len(columns.middle) - np.cumsum(~is_point, axis=1) + ~is_point
    gain = np.cumsum(active[:, 1:] * np.diff(springing, axis=1), axis=1)
    # From a common level: the lowest event of each rise, and what lies under its curve.
    start = columns.density * (len(columns.middle) * springing[:, 0] - ending.sum(axis=1))
    likelihood = start[:, None] - STRAY * passed
    likelihood[:, 1:] += columns.density * gain
    best = np.unravel_index(int(np.argmax(likelihood)), likelihood.shape)
    return Fit(kind, float(rises[best[0]]), float(springing[best]), float(likelihood[best]))
