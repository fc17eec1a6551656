"""How large elements may be along the lines of a wall: small where there is little room, and growing."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.meshing.chains import GENTLE, Chain, turns
from fd2fem.model import Facade, OpeningKind

if TYPE_CHECKING:
    import shapely

__all__ = ["GROWTH", "SizeField", "opening_corners", "size_field"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

GROWTH = 0.3
"""Elements grow by this part of the way from where they must be smaller."""
APART = 4.0
"""Lines that meet are near each other only where the way round by their corner is so many times longer."""
LEVEL_ELEMENTS = 2
"""Elements between an edge and a storey's level, whose nodes do not stand opposite one another."""
LEAST = 0.04
"""Part of the asked size below which elements are not made for lack of room."""
LEAST_IN_WEDGE = 0.2
"""The same between two lines that meet: closer to their corner there is ever less room."""
ON_GROUND = 1e-5
"""A corner this close to the ground, m, stands on it."""
TOUCHING = 1e-9
"""Lines closer than this, m, are one."""
SAMPLE = 0.5
"""Edges are looked at every so many element sizes."""


@dataclass(frozen=True, eq=False)
class SizeField:
    """Element size anywhere in the plane: the least of `largest` and of `size` at each source, grown.

    `places` (s, 2), `size` (s,), m; sizes hold as far as `around` from their places and grow from there.
    """

    places: FloatArray
    size: FloatArray
    largest: float
    around: float = 0.0

    def at(self, points: FloatArray) -> FloatArray:
        """Size (n,) at `points` (n, 2)."""
        wanted = np.full(len(points), self.largest)
        if not len(self.places):
            return wanted
        for part in np.array_split(np.arange(len(points)), len(points) * len(self.places) // 2_000_000 + 1):
            away = np.linalg.norm(points[part, None] - self.places[None], axis=2) - self.around
            wanted[part] = np.minimum(wanted[part], (self.size + GROWTH * np.maximum(away, 0.0)).min(axis=1))
        return wanted


def opening_corners(facade: Facade) -> FloatArray:
    """Corners (n, 2), m, of the openings, where stress peaks: not their curves' own, nor a door's feet.

    Examples
    --------
    >>> from fd2fem.model import Opening, rectangle
    >>> door = Opening(1, OpeningKind.DOOR, rectangle(1, 0, 1, 2))
    >>> opening_corners(Facade(rectangle(0, 0, 4, 3), 0.4, (door,))).tolist()
    [[2.0, 2.0], [1.0, 2.0]]
    """
    found = [np.empty((0, 2))]
    for opening in facade.openings:
        sharp = np.abs(turns(opening.outline)) > GENTLE
        if opening.kind is OpeningKind.DOOR:
            sharp &= opening.outline[:, 1] > facade.outline[:, 1].min() + ON_GROUND
        found.append(opening.outline[sharp])
    return np.vstack(found)


@dataclass(frozen=True, eq=False)
class _Places:
    """Where the chains are looked at: `points` (n, 2), `chain` (n,), way `along` it (n,), `normal` (n, 2)."""

    points: FloatArray
    chain: IntArray
    along: FloatArray
    normal: FloatArray

    def at(self, index: IntArray) -> "_Places":
        """Some of the places."""
        return _Places(self.points[index], self.chain[index], self.along[index], self.normal[index])


@dataclass(frozen=True, eq=False)
class _Edges:
    """Edges of the chains: `start` (e, 2), `vector` (e, 2) to the end, `chain` (e,), `along` it (e,)."""

    start: FloatArray
    vector: FloatArray
    chain: IntArray
    along: FloatArray


def size_field(
    chains: Sequence[Chain],
    *,
    size: float,
    pier_elements: int,
    corners: FloatArray | None = None,
    corner_size: float | None = None,
) -> SizeField:
    """Size of the elements of a wall.

    As asked, but so that `pier_elements` lie between a line and the next one across the wall, and no more
    than the edges of curves are long.

    Parameters
    ----------
    chains : sequence of Chain
    size : float, m
    pier_elements : int
    corners : (n, 2) array, m, optional
        Where elements are to be `corner_size`.
    corner_size : float, m, optional
    """
    places = _sample(chains, spacing=SAMPLE * size)
    room = _room(chains, places, reach=pier_elements * size, pier_elements=pier_elements)
    near = room < size
    sources, wanted = [places.points[near]], [room[near]]
    for chain in chains:
        middle = (chain.corners[1:] + chain.corners[:-1]) / 2.0
        short = (chain.steps < size) & (len(chain.steps) > 1)
        sources.append(middle[short])
        wanted.append(chain.steps[short])
    if corner_size is not None and corners is not None:
        sources.append(corners)
        wanted.append(np.full(len(corners), corner_size))
    return SizeField(np.vstack(sources), np.concatenate(wanted), size, around=SAMPLE * size / 2.0)


def _sample(chains: Sequence[Chain], *, spacing: float) -> _Places:
    """Places along the chains about `spacing` apart, their ends included."""
    points, numbers, ways, normals = [], [], [], []
    for number, chain in enumerate(chains):
        way = np.r_[0.0, np.cumsum(chain.steps)]
        at = np.linspace(0.0, way[-1], max(2, int(way[-1] / spacing) + 2))
        edge = np.clip(np.searchsorted(way, at, side="right") - 1, 0, len(way) - 2)
        along = np.diff(chain.corners, axis=0)[edge] / chain.steps[edge, None]
        place = chain.corners[edge] + (at - way[edge])[:, None] * along
        left = np.column_stack([-along[:, 1], along[:, 0]])
        for normal in (left, -left) if chain.level else (left,):
            points.append(place)
            numbers.append(np.full(len(at), number))
            ways.append(at)
            normals.append(normal)
    return _Places(np.vstack(points), np.concatenate(numbers), np.concatenate(ways), np.vstack(normals))


def _room(chains: Sequence[Chain], places: _Places, *, reach: float, pier_elements: int) -> FloatArray:
    """Element size (n,) for which there is room at each place; infinite where the next line is far off.

    `pier_elements` fit between two edges of the wall, `LEVEL_ELEMENTS` between an edge and a storey's level.
    """
    import shapely

    edges = _edges(chains)
    ends = np.stack([edges.start, edges.start + edges.vector], axis=1)
    tree = shapely.STRtree(np.asarray(shapely.linestrings(ends)))
    straight = _straight_across(places, edges, tree, reach)
    strange = _other_rings(chains, places, edges, tree, reach)
    here, edge = (np.concatenate([straight[k], strange[k]]) for k in (0, 1))
    foot = np.vstack([straight[2], strange[2]])
    way = edges.along[edge] + np.linalg.norm(foot - edges.start[edge], axis=1)
    there = _Places(foot, edges.chain[edge], way, places.normal[here])
    distance = np.linalg.norm(foot - places.points[here], axis=1)
    around, meet = _way_round(chains, places.at(here), there)
    apart = (distance > TOUCHING) & (around > APART * distance)
    level = np.array([chain.level for chain in chains])
    beside_level = level[places.chain[here]] | level[there.chain]
    room = np.full(len(places.points), np.inf)
    wanted = distance / np.where(beside_level, LEVEL_ELEMENTS, pier_elements)
    wanted = np.maximum(wanted, np.where(meet, LEAST_IN_WEDGE, LEAST) * reach / pier_elements)
    np.minimum.at(room, here[apart], wanted[apart])
    return room


def _straight_across(
    places: _Places, edges: _Edges, tree: "shapely.STRtree", reach: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Places, the edges that their normals meet within `reach`, and where (k, 2)."""
    import shapely

    rays = shapely.linestrings(np.stack([places.points, places.points + reach * places.normal], axis=1))
    here, edge = tree.query(rays, predicate="intersects")
    normal, along = places.normal[here], edges.vector[edge]
    slope = normal[:, 0] * along[:, 1] - normal[:, 1] * along[:, 0]
    meets = slope != 0.0
    here, edge, normal, along, slope = (part[meets] for part in (here, edge, normal, along, slope))
    offset = edges.start[edge] - places.points[here]
    distance = (offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0]) / slope
    return here, edge, places.points[here] + distance[:, None] * normal


def _other_rings(
    chains: Sequence[Chain], places: _Places, edges: _Edges, tree: "shapely.STRtree", reach: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Places, the edges of other rings within `reach` of them, and their nearest points (k, 2)."""
    import shapely

    here, edge = tree.query(shapely.points(places.points), predicate="dwithin", distance=reach)
    ring = np.array([chain.ring for chain in chains])
    other = ring[places.chain[here]] != ring[edges.chain[edge]]
    here, edge = here[other], edge[other]
    along, offset = edges.vector[edge], places.points[here] - edges.start[edge]
    part = np.einsum("ki,ki->k", offset, along) / np.einsum("ki,ki->k", along, along)
    return here, edge, edges.start[edge] + np.clip(part, 0.0, 1.0)[:, None] * along


def _edges(chains: Sequence[Chain]) -> _Edges:
    return _Edges(
        start=np.vstack([chain.corners[:-1] for chain in chains]),
        vector=np.vstack([np.diff(chain.corners, axis=0) for chain in chains]),
        chain=np.repeat(np.arange(len(chains)), [len(chain.steps) for chain in chains]),
        along=np.concatenate([np.r_[0.0, np.cumsum(chain.steps)[:-1]] for chain in chains]),
    )


def _way_round(chains: Sequence[Chain], here: _Places, there: _Places) -> tuple[FloatArray, BoolArray]:
    """Way (k,) from one place to the other along their line, or by the corner where their lines meet.

    Infinite where these do not; and whether they do.
    """
    ends = np.array([[chain.corners[0], chain.corners[-1]] for chain in chains])
    whole = np.array([chain.steps.sum() for chain in chains])
    closed = (ends[:, 0] == ends[:, 1]).all(axis=1)
    around = np.full(len(here.chain), np.inf)
    same = here.chain == there.chain
    meet = np.zeros(len(here.chain), dtype=bool)
    way = np.abs(here.along - there.along)
    around[same] = way[same]
    ring = same & closed[here.chain]
    around[ring] = np.minimum(way[ring], whole[here.chain[ring]] - way[ring])
    for own in (0, 1):
        for other in (0, 1):
            corner = ends[here.chain, own]
            shared = (corner == ends[there.chain, other]).all(axis=1) & ~same
            detour = np.linalg.norm(here.points - corner, axis=1) + np.linalg.norm(
                there.points - corner, axis=1
            )
            around[shared] = np.minimum(around[shared], detour[shared])
            meet |= shared
    return around, meet
