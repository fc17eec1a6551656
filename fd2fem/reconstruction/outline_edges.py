"""Straight pieces of a wall's outline: where each one is, whether it is level or upright, how they close."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.reconstruction.beside_curves import sampled_edge
from fd2fem.reconstruction.sampling import Sampling

__all__ = ["REACH", "Edge", "WallPoints", "close", "measured", "without_parallels", "without_slivers"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

REACH = 8.0
"""Depth of wall, in point spacings, that an edge's position is read from."""
SHALLOW = 2.0
"""A strip of wall between an edge and a gap that is so many spacings deep still tells where the edge is."""
CLEAR = 6.0
"""An edge's ends are left out by so many spacings, or by a fifth of its length."""
TURN_SIGMAS, TURN_SPACINGS = 3.0, 1.5
"""An edge leans if its ends differ by more than so many standard errors and so many spacings."""
TURN_LIMIT = 4.0
"""... and by no more than so many spacings, where it was first taken as upright or level."""


@dataclass(frozen=True, eq=False)
class WallPoints:
    """What the pieces are measured with.

    Attributes
    ----------
    xz : (n, 2) float array, m
        The wall's points, sorted by x.
    sampling : Sampling
    gaps : list of (k, 2) float arrays, m
        Outlines of openings, of filled occlusions and of what else is no edge.
    min_feature : float, m
        Narrower features are left out.
    """

    xz: FloatArray
    sampling: Sampling
    gaps: list[FloatArray]
    min_feature: float


@dataclass(frozen=True)
class Edge:
    """A straight line that bounds the wall.

    Attributes
    ----------
    normal : pair of float
        Unit vector out of the wall; exactly along an axis for an upright or level edge.
    offset : float, m
        Of the line from the origin, along the normal.
    kind : str
    sigma : float, m
        Standard error of the offset.
    """

    normal: tuple[float, float]
    offset: float
    kind: str
    sigma: float = np.inf

    @property
    def exact(self) -> bool:
        """Whether the edge is upright or level."""
        return 0.0 in self.normal


def close(chain: list[Edge]) -> FloatArray:
    """Corners (k, 2) of a closed chain of edges, m: edge i runs from corner i to the next one.

    Raises
    ------
    ReconstructionError
        If neighbours are parallel.

    Examples
    --------
    >>> box = [Edge((0.0, -1.0), 0.0, ""), Edge((1.0, 0.0), 3.0, ""), Edge((0.0, 1.0), 2.0, "")]
    >>> close([*box, Edge((-1.0, 0.0), 0.0, "")]).tolist()
    [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]]
    """
    corners = []
    for before, after in zip([chain[-1], *chain[:-1]], chain, strict=True):
        (a, b), (c, d) = before.normal, after.normal
        cross = a * d - b * c
        if abs(cross) < 1e-6:
            msg = "Neighbouring edges of the wall's outline are parallel: its points show no corner there."
            raise ReconstructionError(msg)
        x = (before.offset * d - b * after.offset) / cross
        z = (a * after.offset - c * before.offset) / cross
        corners.append((x + 0.0, z + 0.0))
    return np.array(corners)


def without_slivers(chain: list[Edge], least: float) -> list[Edge]:
    """Leave out edges of the top that are shorter than `least`, m, or run backwards, while a ring remains.

    Examples
    --------
    >>> top = [Edge((0.0, 1.0), 2.0, "top"), Edge((-1.0, 0.0), -2.99, "step"), Edge((0.0, 1.0), 1.5, "top")]
    >>> chain = [Edge((0.0, -1.0), 0.0, "bottom"), Edge((1.0, 0.0), 3.0, "right"), *top[::-1]]
    >>> [edge.kind for edge in without_slivers([*chain, Edge((-1.0, 0.0), 0.0, "left")], 0.1)]
    ['bottom', 'right', 'top', 'left']
    """
    while True:
        ring = close(chain)
        side = np.roll(ring, -1, axis=0) - ring
        forward = [-edge.normal[1] * x + edge.normal[0] * z for edge, (x, z) in zip(chain, side, strict=True)]
        short = [
            number
            for number, edge in enumerate(chain)
            if forward[number] < least and edge.kind in {"top", "step"} and _removable(chain, number)
        ]
        if not short:
            return chain
        number = min(short, key=lambda short_one: forward[short_one])
        drop = {number}
        if chain[number].kind == "top" and chain[number - 1].kind == "step":
            drop.add(number - 1)
        elif chain[number].kind == "top" and chain[number + 1].kind == "step":
            drop.add(number + 1)
        chain = [edge for index, edge in enumerate(chain) if index not in drop]


def _removable(chain: list[Edge], number: int) -> bool:
    """Whether a top remains without this edge, and its neighbours are not parallel then."""
    if chain[number].kind == "top":
        return sum(edge.kind == "top" for edge in chain) > 1
    (a, b), (c, d) = chain[number - 1].normal, chain[(number + 1) % len(chain)].normal
    return abs(a * d - b * c) > 0.05


def without_parallels(chain: list[Edge]) -> list[Edge]:
    """Leave out a top edge that turned out to run on from the one before."""
    kept = [chain[0]]
    for edge in chain[1:]:
        (a, b), (c, d) = kept[-1].normal, edge.normal
        if not (edge.kind == kept[-1].kind == "top" and abs(a * d - b * c) < 0.02):
            kept.append(edge)
    return kept


def measured(edge: Edge, start: FloatArray, end: FloatArray, wall: WallPoints) -> Edge:
    """Move an edge between two corners to where the points beside it say that it is, and turn it if need be.

    Parameters
    ----------
    edge : Edge
    start, end : (2,) float arrays, m
        Its corners.
    wall : WallPoints
    """
    spacing = wall.sampling.spacing
    inward, along, reach, (first, last) = _beside(edge, start, end, wall)
    if len(inward) < 4:
        return replace(edge, sigma=min(edge.sigma, 2.0 * spacing))
    offset, sigma = sampled_edge(inward, along, wall.sampling, reach)
    moved = replace(edge, offset=edge.offset - offset, sigma=sigma)
    length, middle = last - first, (first + last) / 2.0
    if length < 10.0 * spacing:
        return moved
    halves = [
        sampled_edge(inward[half], along[half], wall.sampling, reach)
        for half in (along < middle, along >= middle)
    ]
    change = halves[1][0] - halves[0][0]
    error = float(np.hypot(halves[0][1], halves[1][1]))
    # Half a length apart, so the ends differ by twice as much.
    sigmas = TURN_SIGMAS if edge.exact else 2.0
    if abs(2.0 * change) <= max(sigmas * 2.0 * error, TURN_SPACINGS * spacing if edge.exact else 0.0):
        return _straightened(moved, length, TURN_SPACINGS * spacing, middle)
    if edge.exact and abs(2.0 * change) > TURN_LIMIT * spacing:
        # More would have shown in the profile: one half is hidden or has something on it.
        return moved
    lean = change / (length / 2.0)
    turned = _turned(edge, lean, (halves[0][0] + halves[1][0]) / 2.0, middle)
    return _straightened(replace(turned, sigma=sigma), length, TURN_SPACINGS * spacing, middle)


def _turned(edge: Edge, lean: float, inward: float, middle: float) -> Edge:
    """The edge through a point that lies `inward` of its middle, turned by a slope into the wall."""
    normal = np.array(edge.normal)
    along = np.array([-normal[1], normal[0]])
    through = (edge.offset - inward) * normal + middle * along
    direction = normal + lean * along
    direction /= np.hypot(*direction)
    return replace(edge, normal=(float(direction[0]), float(direction[1])), offset=float(direction @ through))


def _straightened(edge: Edge, length: float, limit: float, middle: float) -> Edge:
    """The edge upright or level, if its ends then move by less than a limit."""
    normal = np.array(edge.normal)
    axis = int(np.argmax(np.abs(normal)))
    if abs(normal[1 - axis] / normal[axis]) * length > limit:
        return edge
    through = edge.offset * normal + middle * np.array([-normal[1], normal[0]])
    sign = float(np.sign(normal[axis]))
    exact = (sign, 0.0) if axis == 0 else (0.0, sign)
    return replace(edge, normal=exact, offset=sign * float(through[axis]))


def _beside(
    edge: Edge, start: FloatArray, end: FloatArray, wall: WallPoints
) -> tuple[FloatArray, FloatArray, float, tuple[float, float]]:
    """Wall points beside an edge: distance into the wall, place along the edge; how deep; the edge's span."""
    spacing = wall.sampling.spacing
    normal = np.array(edge.normal)
    tangent = np.array([-normal[1], normal[0]])
    first, last = sorted((float(start @ tangent), float(end @ tangent)))
    clear = min(CLEAR * spacing, 0.2 * (last - first))
    first, last = first + clear, last - clear
    reach = max(REACH * spacing, 0.1)
    strip = np.array([start, end, start - reach * normal, end - reach * normal])
    low, high = strip[:, 0].min() - 4.0 * spacing, strip[:, 0].max() + 4.0 * spacing
    near = wall.xz[slice(*np.searchsorted(wall.xz[:, 0], [low, high]))]
    inward, along = edge.offset - near @ normal, near @ tangent
    inside = (inward > -4.0 * spacing) & (inward < reach) & (along > first) & (along < last)
    inward, along = inward[inside], along[inside]
    free, depth = np.ones(len(inward), dtype=bool), reach
    for ring in wall.gaps:
        deep, place = edge.offset - ring @ normal, ring @ tangent
        if deep.min() > reach or deep.max() < 0.0 or place.max() < first or place.min() > last:
            continue
        free &= (along < place.min() - 3.0 * spacing) | (along > place.max() + 3.0 * spacing)
        depth = min(depth, float(deep.min()) - spacing)
    if np.count_nonzero(free) > 0.4 * len(free) or depth < SHALLOW * spacing:
        return inward[free], along[free], reach, (first, last)
    shallow = inward < depth
    return inward[shallow], along[shallow], depth, (first, last)
