"""The straight pieces that a wall's end is made of, looked at from one side: first guesses of its edges."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model import Side
from fd2fem.reconstruction.outline_edges import Edge, WallPoints
from fd2fem.reconstruction.profiles import Profile, piecewise_lines

__all__ = ["corner_notch", "side_edge", "top_edges"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEP = 0.1
"""Least height of a feature of the skyline, m ..."""
STEP_SPACINGS = 3.0
"""... and in point spacings."""
PRICE = 50.0
"""Of a piece of the skyline, in squares of a third of the least feature."""
SHORT, STEEP = 4, 1.0
"""A piece of so few columns with such a slope is a step."""
STEPPED = 2.0
"""A column on a step is farther from its neighbours than these from theirs, by such a factor."""
PARALLEL = 0.05
"""Difference of slope from which two pieces meet in a corner."""
LEAN = 2.0
"""A piece is level, or upright, unless its ends differ by so many spacings."""
STEEPEST_END = 0.36
"""Largest lean of an end, about 20 degrees."""
HIDDEN = 0.25
"""Weight of a row whose end something hides."""
LEAST_END = 1.0
"""Shortest piece of a wall's end, m."""
NOTCH = (1.0, 0.5)
"""Least width and height of a missing lower corner, m ..."""
NOTCH_COLUMNS = 10
"""Columns at the corner that tell the height of a notch."""
NOTCH_UNSEEN = 2.0
"""... and the least height where no scanner position tells whether a car hid it."""


@dataclass(frozen=True)
class _Line:
    """A piece of the skyline: z = level + slope x from `start` to `end`, m; points lie off by `miss`."""

    slope: float
    level: float
    start: float
    end: float
    miss: float

    def height(self, x: Any) -> Any:
        """Height at x, m."""
        return self.level + self.slope * x


def least_step(wall: WallPoints) -> float:
    """Least height of a feature of the skyline, m."""
    return max(STEP, STEP_SPACINGS * wall.sampling.spacing)


def side_edge(wall: WallPoints, seen: Profile, side: Side) -> Edge:
    """The straight line that most of one end of the wall follows; another, further out, if long enough.

    Lines through pairs of rows are tried; the winner is fitted to the rows that agree with it.
    """
    sign = 1.0 if side is Side.RIGHT else -1.0
    spacing = wall.sampling.spacing
    shown = np.isfinite(seen.least)
    z, reach = seen.along[shown], seen.least[shown]
    if len(z) < 3:
        return Edge((sign, 0.0), float(sign * wall.xz[0 if sign < 0 else -1, 0]), side.value)
    # Where a neighbour stands forward, no row knows what it hides; that the wall reaches so far, all know.
    weight = np.where(seen.known[shown], 1.0, HIDDEN)
    some = np.unique(np.linspace(0, len(z) - 1, 40).astype(np.intp))
    first, second = (index.ravel() for index in np.meshgrid(some, some))
    apart = np.where(first == second, np.inf, z[second] - z[first])
    lean = (reach[second] - reach[first]) / apart
    usable = (np.abs(lean) < STEEPEST_END) & (first <= second)
    first, lean = first[usable], lean[usable]
    off = reach - reach[first][:, None] - lean[:, None] * (z - z[first][:, None])
    near = max(2.0 * spacing, 0.04)
    fits = np.abs(off) < near
    count = fits @ weight
    # Rows that reach farther speak against a line; among equals, the upright one wins.
    best = int(np.argmax(count - (off > near).sum(axis=1) - 0.02 * len(z) * (lean != 0.0)))
    size = float(np.median(np.diff(seen.along)))
    beyond = off[best]
    further = (fits @ (weight * beyond) > wall.min_feature * count) & (count * size > LEAST_END)
    if further.any():
        best = int(np.argmax(np.where(further, count, 0)))
    chosen = fits[best]
    slope, level = np.polyfit(z[chosen] - z[chosen].mean(), reach[chosen], 1) if lean[best] else (0.0, 0.0)
    if abs(slope) * np.ptp(z[chosen]) < LEAN * spacing:
        return Edge((sign, 0.0), float(np.median(reach[chosen])), side.value)
    normal = np.array([sign, -slope]) / np.hypot(1.0, slope)
    through = np.array([sign * level, z[chosen].mean()])
    return Edge((float(normal[0]), float(normal[1])), float(normal @ through), side.value)


def top_edges(
    wall: WallPoints, seen: Profile, between: tuple[float, float], *, sure: bool
) -> tuple[list[Edge], list[FloatArray]]:
    """Top edges and the steps between them.

    Parameters
    ----------
    wall : WallPoints
    seen : Profile
        Of the top.
    between : pair of float, m
        The wall's ends.
    sure : bool
        Whether the profile knows what was hidden; where not, dips up to a third of the wall's length are
        taken for shadows.

    Returns
    -------
    edges : list of Edge
        From the left.
    aside : list of (4, 2) float arrays, m
        Strips of the edges at chimneys, gaps and hidden places, whose points say nothing of them.
    """
    size = float(np.median(np.diff(seen.along)))
    inside = (seen.along > between[0] + size / 2.0) & (seen.along < between[1] - size / 2.0)
    x, z, known = seen.along[inside], seen.reach[inside], seen.known[inside]
    if np.count_nonzero(known) < 3:
        level = float(np.median(seen.reach[seen.known])) if seen.known.any() else float(wall.xz[:, 1].max())
        return [Edge((0.0, 1.0), level, "top")], []
    z = np.interp(x, x[known], z[known])
    least = max(3, int(np.ceil(wall.min_feature / size)))
    narrow = _narrow(z, least + 1, least + 1 if sure else max(least + 1, len(z) // 3), least_step(wall))
    weight = known & ~narrow & ~_on_steps(z, least_step(wall))
    if np.count_nonzero(weight) < least:
        weight = known
    aside = _strips(x, z, ~weight, size)
    if np.ptp(ndimage.median_filter(z[weight], size=5, mode="nearest")) < LEAN * wall.sampling.spacing:
        return [Edge((0.0, 1.0), float(np.median(z[weight])), "top")], aside
    pieces = piecewise_lines(
        x, z, weight.astype(np.float64), sigma=least_step(wall) / 3.0, least=least, price=PRICE
    )
    lines = _merged(x, z, weight, pieces, (least_step(wall), LEAN * wall.sampling.spacing))
    lines = _meeting(x, weight, _without_steep(x, z, lines))
    return _with_steps(lines, wall), aside


def _strips(x: FloatArray, z: FloatArray, aside: BoolArray, size: float) -> list[FloatArray]:
    """A strip along the skyline for each run of columns, from the column before it to the one after it."""
    label, count = ndimage.label(aside)
    strips = []
    for number in range(1, count + 1):
        run = np.flatnonzero(label == number)
        before, after = max(run[0] - 1, 0), min(run[-1] + 1, len(z) - 1)
        left, right = x[run[0]] - size / 2.0, x[run[-1]] + size / 2.0
        low = (z[before] if run[0] else z[after], z[after] if run[-1] < len(z) - 1 else z[before])
        strips.append(
            np.array(
                [
                    [left, low[0] - size],
                    [right, low[1] - size],
                    [right, low[1] + size],
                    [left, low[0] + size],
                ]
            )
        )
    return strips


def _with_steps(lines: list[_Line], wall: WallPoints) -> list[Edge]:
    """Edges along lines, and a step between two that do not meet about where one gives way to the other."""
    edges: list[Edge] = []
    for number, line in enumerate(lines):
        if number:
            before = lines[number - 1]
            left, right = before.height(before.end), line.height(before.end)
            unlike = abs(before.slope - line.slope)
            meet = abs(left - right) < max(least_step(wall), wall.min_feature / 2.0 * unlike)
            if not meet or unlike < PARALLEL:
                sign = 1.0 if left > right else -1.0
                edges.append(Edge((sign, 0.0), sign * before.end, "step"))
        scale = float(np.hypot(1.0, line.slope))
        normal = (-line.slope / scale, 1.0 / scale) if line.slope else (0.0, 1.0)
        edges.append(Edge(normal, line.level / scale, "top"))
    return edges


def _narrow(z: FloatArray, peak: int, gap: int, step: float) -> BoolArray:
    """Columns of peaks and gaps that are narrower than so many columns."""
    # Beyond its ends there is no wall: a low end is no gap, and a high one may be a narrow peak.
    margin = max(peak, gap)
    padded = np.pad(z, margin, constant_values=float(z.min()) - 1e3)
    opened = ndimage.grey_opening(padded, size=peak)
    peaks = padded - opened > step
    # Peaks first, or what lies between two of them would be a gap, and none would be left.
    padded = np.where(peaks, opened, padded)
    gaps = ndimage.grey_closing(padded, size=gap) - padded > step
    narrow: BoolArray = (peaks | gaps)[margin:-margin]
    return narrow


def _on_steps(z: FloatArray, step: float) -> BoolArray:
    """Columns that a step runs through: far from both neighbours, while these keep to theirs."""
    fall = np.diff(z, prepend=z[0], append=z[-1])
    size = np.abs(fall)
    within, after = size[:-1], size[1:]
    beside = np.maximum(np.append(0.0, size[:-2]), np.append(size[2:], 0.0))
    on_step: BoolArray = (fall[:-1] * fall[1:] > 0.0) & (
        np.minimum(within, after) > np.maximum(step, STEPPED * beside)
    )
    return on_step


def _merged(
    x: FloatArray,
    z: FloatArray,
    weight: BoolArray,
    pieces: list[tuple[int, int]],
    limits: tuple[float, float],
) -> list[_Line]:
    """A line for each piece, where one line for two neighbours misses by less than half of a step."""
    step, slack = limits
    joined = True
    while joined and len(pieces) > 1:
        joined = False
        for number in range(len(pieces) - 1):
            whole = (pieces[number][0], pieces[number + 1][1])
            if _line(x, z, weight, whole, slack).miss < step / 2.0:
                pieces = [*pieces[:number], whole, *pieces[number + 2 :]]
                joined = True
                break
    return [_line(x, z, weight, piece, slack) for piece in pieces]


def _line(x: FloatArray, z: FloatArray, weight: BoolArray, piece: tuple[int, int], slack: float) -> _Line:
    """The line along a piece, level unless its ends differ by more than `slack`, m."""
    start, stop = piece
    size = float(x[1] - x[0])
    use = np.arange(start, stop)[weight[start:stop]]
    if len(use) < 2:
        use = np.arange(start, stop)
    slope, level = np.polyfit(x[use], z[use], 1)
    if abs(slope) * (x[stop - 1] - x[start]) < slack:
        slope, level = 0.0, float(np.median(z[use]))
    miss = float(np.quantile(np.abs(z[use] - slope * x[use] - level), 0.9))
    return _Line(
        float(slope), float(level), float(x[start]) - size / 2.0, float(x[stop - 1]) + size / 2.0, miss
    )


def _without_steep(x: FloatArray, z: FloatArray, lines: list[_Line]) -> list[_Line]:
    """Leave out short steep pieces: the columns about a step, taken for a slope."""
    size = float(x[1] - x[0])
    for number in range(len(lines) - 2, 0, -1):
        line, before, after = lines[number], lines[number - 1], lines[number + 1]
        if line.end - line.start > (SHORT + 0.5) * size or abs(line.slope) < STEEP:
            continue
        about = np.flatnonzero((x > line.start) & (x < line.end))
        left = np.abs(z[about] - before.height(x[about]))
        right = np.abs(z[about] - after.height(x[about]))
        split = int(np.argmin(np.insert(np.cumsum(left - right), 0, 0.0)))
        lines = [
            *lines[: number - 1],
            replace(before, end=line.start + size * split),
            *lines[number + 1 :],
        ]
    return lines


def _meeting(x: FloatArray, weight: BoolArray, lines: list[_Line]) -> list[_Line]:
    """Where the columns between two pieces say nothing, each ends as near to where they meet as it can."""
    ended = []
    half = float(x[1] - x[0]) / 2.0
    for line, after in pairwise(lines):
        first = last = int(np.searchsorted(x, line.end))
        while first > 0 and not weight[first - 1]:
            first -= 1
        while last < len(x) and not weight[last]:
            last += 1
        end = line.end
        if last > first and abs(line.slope - after.slope) > PARALLEL:
            meet = (after.level - line.level) / (line.slope - after.slope)
            end = float(np.clip(meet, x[first] - half, x[last - 1] + half))
        ended.append(replace(line, end=end))
    return [*ended, lines[-1]]


def corner_notch(
    wall: WallPoints,
    seen: Profile,
    bottom: float,
    between: tuple[float, float],
    side: Side,
    *,
    sure: bool,
) -> list[Edge]:
    """Underside and flank of a missing lower corner, the underside first; none if the corner is there."""
    sign = 1.0 if side is Side.RIGHT else -1.0
    inside = np.flatnonzero((seen.along > between[0]) & (seen.along < between[1]))
    order = inside[::-1] if sign > 0 else inside
    above = -seen.reach[order] - bottom
    least = NOTCH[1] if sure else NOTCH_UNSEEN
    gone = seen.known[order] & (above > least)
    # An opening beside the missing corner is another matter: the notch ends where its height changes.
    if gone.any():
        level = float(np.median(above[np.flatnonzero(gone)[:NOTCH_COLUMNS]]))
        gone &= np.abs(above - level) < least_step(wall)
    run = int(np.argmin(gone | ~seen.known[order])) if len(order) and not gone.all() else 0
    shown = np.flatnonzero(gone[:run])
    size = float(np.median(np.diff(seen.along)))
    if len(shown) < 0.6 * run or len(shown) * size < NOTCH[0] or run > 0.8 * len(order):
        return []
    height = above[shown]
    if np.quantile(height, 0.9) - np.quantile(height, 0.1) > least_step(wall):
        return []
    at = float(seen.along[order[run - 1]] + (-sign) * size / 2.0)
    return [
        Edge((0.0, -1.0), -(bottom + float(np.median(height))), "notch"),
        Edge((sign, 0.0), sign * at, "notch"),
    ]
