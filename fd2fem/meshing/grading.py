"""A lattice divided towards the corners of the openings."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.lattice import Lattice, fill_runs
from fd2fem.meshing.options import ROUND_UP_FROM
from fd2fem.meshing.sizes import GROWTH

__all__ = ["grade_lattice"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEPS = 256
"""Steps of the integral of 1 / size over a macro column or row."""


def grade_lattice(
    lattice: Lattice, corners: FloatArray, *, size: float, corner_size: float, pier_elements: int
) -> Lattice:
    """Divide the lattice into cells of a single element each.

    Columns and rows beside one of the `corners` (n, 2) are about `corner_size` wide and grow from there by
    `GROWTH` of the way, to `size`, all in m; along whole grid lines, since the mesh is structured.
    """
    grow = {"size": size, "corner_size": corner_size}
    x = _cuts(lattice.columns, corners[:, 0], lattice.wall.T, least=pier_elements, **grow)
    z = _cuts(lattice.rows, corners[:, 1], lattice.wall, least=pier_elements, **grow)
    across, up = _weights(x), _weights(z)
    return Lattice(
        points=np.einsum("ai,bj,ijk->abk", across, up, lattice.points),
        columns=across @ lattice.columns,
        rows=up @ lattice.rows,
        wall=lattice.wall.repeat([len(cut) - 1 for cut in x], axis=0).repeat(
            [len(cut) - 1 for cut in z], axis=1
        ),
    )


def _cuts(
    lines: FloatArray,
    corners: FloatArray,
    wall: BoolArray,
    *,
    size: float,
    corner_size: float,
    least: int,
) -> list[FloatArray]:
    """Where each gap between grid lines is cut, as parts of it from 0 to 1."""
    fine = (
        lines[np.unique(np.abs(corners[:, None] - lines[None]).argmin(axis=1))] if len(corners) else lines[:0]
    )
    at = np.linspace(0.0, 1.0, STEPS + 1)
    totals = []
    for start, end in pairwise(lines.tolist()):
        away = np.abs(start + at * (end - start) - fine[:, None]).min(axis=0, initial=np.inf)
        density = (end - start) / np.minimum(size, corner_size + GROWTH * away)
        totals.append(np.r_[0.0, np.cumsum((density[1:] + density[:-1]) / (2.0 * STEPS))])
    count = np.array([max(1, int(total[-1] + 1.0 - ROUND_UP_FROM)) for total in totals], dtype=np.intp)
    fill_runs(count, np.diff(lines), wall, least=least)
    return [
        np.interp(np.linspace(0.0, total[-1], number + 1), total, at)
        for total, number in zip(totals, count.tolist(), strict=True)
    ]


def _weights(cuts: list[FloatArray]) -> FloatArray:
    """Weights (new lines, old lines) of the straight interpolation between grid lines."""
    weights = np.zeros((sum(len(cut) - 1 for cut in cuts) + 1, len(cuts) + 1))
    line = 0
    for number, cut in enumerate(cuts):
        rows = line + np.arange(len(cut))
        weights[rows, number], weights[rows, number + 1] = 1.0 - cut, cut
        line += len(cut) - 1
    return weights
