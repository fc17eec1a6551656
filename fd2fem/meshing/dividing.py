"""Nodes along the lines of a wall: every corner, and more where edges are long."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.chains import Chain
from fd2fem.meshing.sizes import SizeField

__all__ = ["divide_chain"]

FloatArray = NDArray[np.float64]

LONG = 1.5
"""An edge longer than so many elements is divided; shorter ones are an element's edge each."""
STEPS = 128
"""Steps of the integral of 1 / size along an edge."""


def divide_chain(chain: Chain, field: SizeField) -> FloatArray:
    """Nodes (2 m + 1, 2), m, along a chain, all its corners among them.

    Their number is such that every other one can be the middle of an edge that is later halved.

    Examples
    --------
    >>> wall = Chain(np.array([[0.0, 0.0], [1.0, 0.0]]), ring=0, level=False)
    >>> field = SizeField(np.empty((0, 2)), np.empty(0), largest=0.25)
    >>> divide_chain(wall, field)[:, 0].tolist()
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """
    corners = chain.corners
    long = chain.steps > LONG * field.at((corners[1:] + corners[:-1]) / 2.0)
    if len(long) == 1:
        long[0] = True
    nodes, run = [corners[:1]], [corners[:1]]
    for (start, end), divided in zip(pairwise(corners), long.tolist(), strict=True):
        if divided:
            nodes += [*_even(run)[1:], _divide_edge(start, end, field)[1:]]
            run = [end[None]]
        else:
            run.append(end[None])
    return np.vstack([*nodes, *_even(run)[1:]])


def _even(run: list[FloatArray]) -> list[FloatArray]:
    """The same corners (1, 2); if their edges are odd in number, the longest is halved."""
    if len(run) % 2:
        return run
    corners = np.vstack(run)
    longest = int(np.argmax(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    middle = (corners[longest] + corners[longest + 1]) / 2.0
    return [*run[: longest + 1], middle[None], *run[longest + 1 :]]


def _divide_edge(start: FloatArray, end: FloatArray, field: SizeField) -> FloatArray:
    """Nodes from `start` to `end`: an even number of steps, about as long as the field says."""
    at = np.linspace(0.0, 1.0, STEPS + 1)
    density = float(np.linalg.norm(end - start)) / field.at(start + at[:, None] * (end - start))
    count = np.r_[0.0, np.cumsum((density[1:] + density[:-1]) / (2.0 * STEPS))]
    number = 2 * max(1, round(float(count[-1]) / 2.0))
    nodes = start + np.interp(np.linspace(0.0, count[-1], number + 1), count, at)[:, None] * (end - start)
    nodes[0], nodes[-1] = start, end
    return np.asarray(nodes)
