"""Facade to hexahedra: quadrilaterals on its front, swept through its thickness."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.lattice import Lattice, build_lattice, count_divisions
from fd2fem.meshing.options import DEFAULT_OPTIONS, MeshOptions
from fd2fem.meshing.quads import FLATTENING, QuadMesh, free_quads, lattice_quads
from fd2fem.meshing.quality import element_aspects, element_volumes, scaled_jacobians
from fd2fem.meshing.walls import WallRings, is_rectilinear, wall_rings
from fd2fem.model import ElementKind, Facade, VolumeMesh

__all__ = ["mesh_facade"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

SHARED_LINE = 0.43
"""Edges closer than this part of the element size share a grid line. A little under one half, which is
where the differences between dimensions on drawings tend to lie: a millimetre must not decide."""
FINER = (1.0, 0.5, 0.25, 0.125, 0.0)
"""Parts of that tolerance to try in turn, until the elements are good enough; 0 skews none."""
SMALLER = (1.0, 0.8, 0.64, 0.5)
"""Parts of the element size to try in turn where edges are slanted or curved."""
MAX_ASPECT = 1000.0
"""Longest over shortest edge of an element beyond which the stiffness matrix is not worth solving."""
FACING = 0.25
"""A facet of the outline faces up, or down, if its normal rises more than this (15°), else sideways."""


def mesh_facade(facade: Facade, *, options: MeshOptions = DEFAULT_OPTIONS) -> VolumeMesh:
    """All-hexahedra mesh of a facade, with the groups of :data:`~fd2fem.model.GROUPS`.

    Where all edges are horizontal or vertical the mesh is block-structured and exact: edges of openings
    that almost line up share a grid line that passes through each of them, so that two facades which
    differ by millimetres have the same numbers of elements wherever possible. Otherwise it is
    unstructured, and follows curved edges to within a fiftieth of the element size; where that makes too
    bad an element, smaller sizes are tried, down to half. Either is swept through the thickness in equal
    layers (`MeshOptions.layers_through`).

    Groups: base, on the ground at z = 0; top, on the outline facing up by more than 15° (gables and
    steps too); left and right, on the outline facing -x and +x; front, y = 0; back, y = thickness.
    Reveals and the undersides of projections are in none.

    Parameters
    ----------
    facade : Facade
    options : MeshOptions

    Raises
    ------
    MeshError
        If no mesh is as good as `options.min_scaled_jacobian`, or an element would be a sliver.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> mesh = mesh_facade(Facade(outline=rectangle(0, 0, 4, 3), thickness=0.5))
    >>> mesh.elements.shape, {name: len(facets) for name, facets in mesh.groups.items()}["base"]
    ((384, 8), 32)
    """
    rings = wall_rings(facade)
    if not is_rectilinear(rings):
        return _free(facade, rings, options=options)
    quads = _structured(rings, options=options)
    mesh = _sweep(quads, facade, layers=options.layers_through(facade.thickness))
    _check(mesh, facade, rectilinear=True, options=options)
    return mesh


def _free(facade: Facade, rings: WallRings, *, options: MeshOptions) -> VolumeMesh:
    """The first unstructured mesh that is good enough; the error of the asked size if none is."""
    layers = options.layers_through(facade.thickness)
    refused = []
    for part in SMALLER:
        finer = replace(options, size=part * options.size)
        try:
            mesh = _sweep(free_quads(rings, options=finer), facade, layers=layers)
            _check(mesh, facade, rectilinear=False, options=finer)
        except MeshError as error:
            refused.append(error)
        else:
            return mesh
    raise refused[0]


def _structured(rings: WallRings, *, options: MeshOptions) -> QuadMesh:
    """Quadrilaterals on the first lattice that is good enough; the last one has right angles only."""
    lattice: Lattice
    for part in FINER:
        lattice = build_lattice(rings, tolerance=part * SHARED_LINE * options.size)
        if lattice.min_scaled_jacobian() >= options.min_scaled_jacobian:
            break
    columns, rows = count_divisions(lattice, size=options.size, pier_elements=options.pier_elements)
    return lattice_quads(lattice, columns, rows)


def _sweep(quads: QuadMesh, facade: Facade, *, layers: int) -> VolumeMesh:
    """Hexahedra between y = 0 and y = thickness.

    Seen against y, x to z runs clockwise about it, so the layer deeper in the wall is VTK's lower face.
    """
    n = len(quads.points)
    depth = np.linspace(0.0, facade.thickness, layers + 1)
    nodes = np.empty((layers + 1, n, 3))
    nodes[:, :, [0, 2]] = quads.points
    nodes[:, :, 1] = depth[:, None]
    offset = n * np.arange(layers)[:, None, None]
    elements = np.concatenate([quads.quads + offset + n, quads.quads + offset], axis=2)
    groups = {"front": quads.quads, "back": quads.quads[:, ::-1] + layers * n}
    for name, edges in _edge_groups(quads, facade).items():
        start, end = edges[:, 0], edges[:, 1]
        facets = np.stack([start, start + n, end + n, end], axis=1)
        groups[name] = (facets + offset).reshape(-1, 4)
    return VolumeMesh(
        nodes=nodes.reshape(-1, 3),
        elements=elements.reshape(-1, 8),
        kind=ElementKind.HEXAHEDRON,
        groups=groups,
    )


def _edge_groups(quads: QuadMesh, facade: Facade) -> Mapping[str, IntArray]:
    """Edges (k, 2) of the quadrilaterals, wall on their left, on each side of the facade's outline."""
    import shapely

    edges = _boundary_edges(quads)
    ends = quads.points[edges]
    centre = shapely.points(ends.mean(axis=1))
    to_outline = shapely.distance(centre, shapely.LinearRing(facade.outline))
    rims = shapely.union_all([shapely.LinearRing(opening.outline) for opening in facade.openings])
    outer = np.ones(len(edges), dtype=bool) if rims.is_empty else to_outline < shapely.distance(centre, rims)
    along = ends[:, 1] - ends[:, 0]
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    on_ground = ends[:, :, 1].max(axis=1) < quads.points[:, 1].min() + 1e-6
    sideways = outer & (np.abs(outward[:, 1]) <= FACING)
    return {
        "base": edges[outer & on_ground & (outward[:, 1] < -FACING)],
        "top": edges[outer & (outward[:, 1] > FACING)],
        "left": edges[sideways & (outward[:, 0] < 0.0)],
        "right": edges[sideways & (outward[:, 0] > 0.0)],
    }


def _boundary_edges(quads: QuadMesh) -> IntArray:
    """Edges of a single quadrilateral, in its sense."""
    edges = np.stack([quads.quads, np.roll(quads.quads, -1, axis=1)], axis=2).reshape(-1, 2)
    key = edges.min(axis=1) * len(quads.points) + edges.max(axis=1)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    single: IntArray = edges[np.sort(first[count == 1])]
    return single


def _check(mesh: VolumeMesh, facade: Facade, *, rectilinear: bool, options: MeshOptions) -> None:
    """Raise unless the elements are good and fill the wall, no more, no less."""
    shape, aspect = scaled_jacobians(mesh), element_aspects(mesh)
    if shape.min() < options.min_scaled_jacobian:
        msg = (
            f"The worst element, {_place(mesh, shape.argmin())}, has a scaled Jacobian of {shape.min():.3f}, "
            f"less than {options.min_scaled_jacobian:g}: try another size than {options.size:g} m, or "
            "simplify the outline."
        )
        raise MeshError(msg)
    if aspect.max() > MAX_ASPECT:
        msg = (
            f"An element, {_place(mesh, aspect.argmax())}, is {aspect.max():.0f} times longer than wide (at "
            f"most {MAX_ASPECT:.0f}): two edges of the facade all but coincide there; make them line up, or "
            "leave more wall between them."
        )
        raise MeshError(msg)
    volume = facade.wall_area * facade.thickness
    perimeter = sum(_perimeter(ring) for ring in (facade.outline, *(o.outline for o in facade.openings)))
    # A door's foot may move by two micrometres, nothing else.
    reach = 1e-5 if rectilinear else options.size / FLATTENING
    filled = float(element_volumes(mesh).sum())
    if abs(filled - volume) > reach * perimeter * facade.thickness:
        msg = f"The mesh holds {filled:.6g} m³ of a wall of {volume:.6g} m³: simplify the facade's outline."
        raise MeshError(msg)


def _place(mesh: VolumeMesh, element: np.intp) -> str:
    """Where an element is, for a message."""
    x, _, z = mesh.nodes[mesh.elements[element]].mean(axis=0)
    return f"at x = {x:.3f}, z = {z:.3f} m"


def _perimeter(ring: FloatArray) -> float:
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())
