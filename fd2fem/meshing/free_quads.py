"""Unstructured quadrilaterals on a wall with slanted or curved edges, by gmsh.

gmsh fills the wall with quadrilaterals and triangles of twice the size, which are then halved: so there are
quadrilaterals only, and every other corner of a curve need not be a corner of gmsh's elements.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.chains import Chain
from fd2fem.meshing.dividing import divide_chain
from fd2fem.meshing.quads import QuadMesh
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.sizes import SizeField
from fd2fem.meshing.smoothing import corner_quality, smooth

__all__ = ["ALGORITHMS", "best_quads", "halve", "quads_between"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Loops = list[list[int]]

ALGORITHMS = (6.0, 8.0, 5.0)
"""gmsh's ways to fill a surface: frontal Delaunay, the same for quadrilaterals, Delaunay."""
GOOD = 0.4
"""Sine of the worst corner from which on no other algorithm is tried."""
SAME_AREA = 1e-9
"""Part of the wall's area by which the quadrilaterals may differ from it."""
CORNERS = {2: 3, 3: 4}
"""Corners of gmsh's kinds of elements: triangles and quadrilaterals."""


def best_quads(attempts: Iterable[tuple[Sequence[Chain], SizeField]], *, enough: float) -> QuadMesh:
    """The first good quadrilaterals, or the best ones, on lines and sizes to try in turn.

    Each of gmsh's algorithms is tried until the worst corner is `GOOD`; the next attempt is made if none
    was `enough`.

    Raises
    ------
    MeshError
        If none fills the wall.
    """
    best: QuadMesh | None = None
    worst, refused = -np.inf, MeshError("There are no lines to mesh between.")
    for chains, field in attempts:
        for algorithm in ALGORITHMS:
            try:
                quads = quads_between(chains, field, algorithm=algorithm)
            except MeshError as error:
                refused = error
                continue
            quality = float(corner_quality(quads.points, quads.quads).min())
            if quality > worst:
                best, worst = quads, quality
            if worst >= max(GOOD, enough):
                return quads
        if best is not None and worst >= enough:
            return best
    if best is None:
        raise refused
    return best


def quads_between(chains: Sequence[Chain], field: SizeField, *, algorithm: float) -> QuadMesh:
    """Quadrilaterals that fill a wall, all corners of its chains among theirs.

    Parameters
    ----------
    chains : sequence of Chain
    field : SizeField
    algorithm : float
        One of `ALGORITHMS`.

    Raises
    ------
    MeshError
        If gmsh fails, or does not fill the wall.
    """
    nodes = [divide_chain(chain, field) for chain in chains]
    points, index = np.unique(np.vstack(nodes), axis=0, return_inverse=True)
    runs = np.split(index.reshape(-1), np.cumsum([len(run) for run in nodes])[:-1])
    lines = [np.column_stack([run[:-1:2], run[1::2], run[2::2]]) for run in runs]
    rims = np.vstack([line for line, chain in zip(lines, chains, strict=True) if not chain.level])
    every = np.vstack(lines)
    with gmsh_session({"Mesh.Algorithm": algorithm, "Mesh.RecombineAll": 1.0}) as gmsh:
        _describe(gmsh, points, every, _pieces(points, every, rims))
        inner, polygons = _generate(gmsh, len(points))
    fixed = len(points)
    points, quads = halve(np.vstack([points, inner]), polygons, middles=every)
    used, quads = np.unique(quads, return_inverse=True)
    quads, points = quads.reshape(-1, 4), points[used]
    points = smooth(points, quads, fixed=used < fixed)
    _check_area(QuadMesh(points, quads), chains)
    return QuadMesh(points, quads)


def _pieces(points: FloatArray, lines: IntArray, rims: IntArray) -> list[Loops]:
    """Loops of nodes about each piece of wall between the coarse `lines`, outer loop first.

    `rims` are those with wall on their left only: a piece that has one the other way round is none.
    """
    import shapely

    number = {tuple(point): k for k, point in enumerate(points.tolist())}
    backward = {(end, start) for start, _, end in rims.tolist()}
    pieces = []
    edges = np.asarray(shapely.linestrings(points[lines[:, [0, 2]]]))
    for polygon in shapely.get_parts(shapely.polygonize(edges)):
        loops = [
            [number[tuple(corner)] for corner in shapely.get_coordinates(ring)[:-1].tolist()]
            for ring in shapely.get_rings(polygon)
        ]
        if not shapely.is_ccw(shapely.get_exterior_ring(polygon)):
            loops[0].reverse()
        if backward.isdisjoint(pairwise([*loops[0], loops[0][0]])):
            pieces.append(loops)
    return pieces


def _describe(gmsh: ModuleType, points: FloatArray, lines: IntArray, pieces: list[Loops]) -> None:
    """Tell gmsh the coarse lines, an edge of an element each, and the surfaces between them."""
    geo = gmsh.model.geo
    for k in np.unique(lines[:, [0, 2]]).tolist():
        geo.addPoint(*points[k], 0.0, tag=k + 1)
    tags: dict[tuple[int, int], int] = {}
    for start, _, end in lines.tolist():
        tag = geo.addLine(start + 1, end + 1)
        geo.mesh.setTransfiniteCurve(tag, 2)
        tags[start, end], tags[end, start] = tag, -tag
    for loops in pieces:
        geo.addPlaneSurface(
            [geo.addCurveLoop([tags[edge] for edge in pairwise([*loop, loop[0]])]) for loop in loops]
        )
    geo.synchronize()


def _generate(gmsh: ModuleType, count: int) -> tuple[FloatArray, list[IntArray]]:
    """Inner nodes (i, 2), numbered from `count`, and elements (p, 3) and (q, 4), counter-clockwise."""
    try:
        gmsh.model.mesh.generate(2)
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"gmsh could not mesh the wall: {error}. Try another element size or simplify the outline."
        raise MeshError(msg) from error
    kinds, _, corners = gmsh.model.mesh.getElements(2)
    inner, place, _ = gmsh.model.mesh.getNodes(2)
    at_point, _, _ = gmsh.model.mesh.getNodes(0)
    number = np.zeros(int(max(inner.max(initial=0), at_point.max())) + 1, dtype=np.intp)
    number[inner.astype(np.intp)] = count + np.arange(len(inner))
    for _, tag in gmsh.model.getEntities(0):
        number[gmsh.model.mesh.getNodes(0, tag)[0].astype(np.intp)] = tag - 1
    polygons = [
        number[nodes.astype(np.intp)].reshape(-1, CORNERS[int(kind)])
        for kind, nodes in zip(kinds, corners, strict=True)
    ]
    return place.reshape(-1, 3)[:, :2], polygons


def halve(
    points: FloatArray, polygons: Sequence[IntArray], *, middles: IntArray
) -> tuple[FloatArray, IntArray]:
    """Divide polygons into quadrilaterals, one at each of their corners.

    Parameters
    ----------
    points : (n, 2) float array, m
    polygons : sequence of (p, k) int arrays
        Corners of polygons of k corners each, all in one sense.
    middles : (l, 3) int array
        Start, middle and end of edges whose middle is one of the points.

    Returns
    -------
    points : (m, 2) float array, m
        The given ones, then the middles of the other edges, then of the polygons.
    quads : (q, 4) int array

    Examples
    --------
    >>> triangle = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])
    >>> _, quads = halve(triangle, [np.array([[0, 1, 2]])], middles=np.empty((0, 3), dtype=int))
    >>> quads.tolist()
    [[0, 3, 6, 4], [1, 5, 6, 3], [2, 4, 6, 5]]
    """
    sides = [np.sort(np.stack([p, np.roll(p, -1, axis=1)], axis=2), axis=2).reshape(-1, 2) for p in polygons]
    edges, index = np.unique(np.vstack(sides), axis=0, return_inverse=True)
    middle = len(points) + np.arange(len(edges))
    known = {(min(start, end), max(start, end)): between for start, between, end in middles.tolist()}
    for k, edge in enumerate(edges.tolist()):
        middle[k] = known.get(tuple(edge), middle[k])
    of_side = np.split(middle[index.reshape(-1)], np.cumsum([len(side) for side in sides])[:-1])
    parts, quads, count = [points, points[edges].mean(axis=1)], [], len(points) + len(edges)
    for corner, between in zip(polygons, of_side, strict=True):
        after = between.reshape(corner.shape)
        centre = np.broadcast_to(count + np.arange(len(corner))[:, None], corner.shape)
        quads.append(np.stack([corner, after, centre, np.roll(after, 1, axis=1)], axis=2).reshape(-1, 4))
        parts.append(points[corner].mean(axis=1))
        count += len(corner)
    return np.vstack(parts), np.vstack(quads)


def _check_area(mesh: QuadMesh, chains: Sequence[Chain]) -> None:
    """Raise unless the quadrilaterals fill the wall."""
    area = 0.0
    for chain in chains:
        (x, z), (following_x, following_z) = chain.corners[:-1].T, chain.corners[1:].T
        area += 0.0 if chain.level else 0.5 * float(np.sum(x * following_z - following_x * z))
    if abs(float(mesh.areas.sum()) - area) > SAME_AREA * area:
        msg = (
            f"The elements fill {mesh.areas.sum():.6g} m² of a wall of {area:.6g} m²: try another element "
            "size or simplify the outline."
        )
        raise MeshError(msg)
