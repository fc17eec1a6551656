"""Facade to hexahedra: quadrilaterals on its front, swept through its thickness."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.chains import Chain, thin, wall_chains
from fd2fem.meshing.curves import refacet
from fd2fem.meshing.free_quads import best_quads
from fd2fem.meshing.grading import grade_lattice
from fd2fem.meshing.lattice import Lattice, build_lattice, count_divisions
from fd2fem.meshing.options import DEFAULT_OPTIONS, ElementShape, MeshOptions, slabs
from fd2fem.meshing.order import quadratic_mesh
from fd2fem.meshing.quads import QuadMesh, lattice_quads
from fd2fem.meshing.quality import element_aspects, element_volumes, scaled_jacobians
from fd2fem.meshing.sizes import SizeField, opening_corners, size_field
from fd2fem.meshing.sweep import sweep
from fd2fem.meshing.walls import WallRings, is_rectilinear, wall_rings
from fd2fem.model import Facade, VolumeMesh

__all__ = ["mesh_facade"]

FloatArray = NDArray[np.float64]

SHARED_LINE = 0.43
"""Edges closer than this part of the element size share a grid line. A little under one half, which is
where the differences between dimensions on drawings tend to lie: a millimetre must not decide."""
FINER = (1.0, 0.5, 0.25, 0.125, 0.0)
"""Parts of that tolerance to try in turn, until the elements are good enough; 0 skews none."""
SMALLER = (1.0, 0.8, 0.64, 0.5)
"""Parts of the element size to try in turn where edges are slanted or curved."""
FLATTENING = 50.0
"""A curved edge is followed to within the element size over this."""
MAX_ASPECT = 1000.0
"""Longest over shortest edge of an element beyond which the stiffness matrix is not worth solving."""
DEPTH = 1
"""Axis through the wall."""
QUADRATIC = 2
"""`MeshOptions.order` of elements with nodes in the middle of their edges."""


def mesh_facade(facade: Facade, *, options: MeshOptions = DEFAULT_OPTIONS) -> VolumeMesh:
    """Mesh of a facade, with the groups of :data:`~fd2fem.model.GROUPS`: hexahedra, if nothing else is asked.

    Where all edges are horizontal or vertical the hexahedra are block-structured and exact: edges of
    openings that almost line up share a grid line that passes through each of them, so that two facades
    which differ by millimetres have the same numbers of elements wherever possible. Otherwise they are
    unstructured, and follow curved edges to within a fiftieth of the element size, without a change of
    volume; where that makes too bad an element, smaller sizes are tried, down to half. Either is swept
    through the thickness in equal layers; where that changes with the storeys, in layers from one depth of
    the back to the next, and elements end at the storeys' levels.

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
    if options.elements is ElementShape.TETRAHEDRA:
        from fd2fem.meshing.tetrahedra import mesh_facade_tetrahedra

        return mesh_facade_tetrahedra(facade, options=options)
    size, options = options.size_for(facade), options.for_wall(facade)
    rings = wall_rings(facade)
    if is_rectilinear(rings):
        quads = _structured(rings, facade, size=size, options=options)
    else:
        quads = best_quads(_attempts(facade, size=size, options=options), enough=options.min_scaled_jacobian)
    mesh = sweep(quads, facade, slabs=slabs(facade, size=size, layers=options.layers))
    _check(mesh, facade, size=size, least=options.min_scaled_jacobian)
    return quadratic_mesh(mesh) if options.order == QUADRATIC else mesh


def _structured(rings: WallRings, facade: Facade, *, size: float, options: MeshOptions) -> QuadMesh:
    """Quadrilaterals on the first lattice that is good enough; the last one has right angles only."""
    levels = [storey.z for storey in facade.storeys]
    lattice: Lattice
    for part in FINER:
        lattice = build_lattice(rings, tolerance=part * SHARED_LINE * size, levels=levels)
        if lattice.min_scaled_jacobian() >= options.min_scaled_jacobian:
            break
    if options.corner_size is None:
        return lattice_quads(
            lattice, *count_divisions(lattice, size=size, pier_elements=options.pier_elements)
        )
    graded = grade_lattice(
        lattice,
        opening_corners(facade),
        size=size,
        corner_size=options.corner_size,
        pier_elements=options.pier_elements,
    )
    across, up = graded.wall.shape
    return lattice_quads(graded, np.ones(across, dtype=np.intp), np.ones(up, dtype=np.intp))


def _attempts(
    facade: Facade, *, size: float, options: MeshOptions
) -> Iterator[tuple[Sequence[Chain], SizeField]]:
    """Lines and sizes of unstructured quadrilaterals to try in turn."""
    levels = [storey.z for storey in facade.storeys]
    for part in SMALLER:
        smaller = part * size
        tolerance = smaller / FLATTENING
        rings = wall_rings(refacet(facade, size=smaller, tolerance=tolerance))
        chains = [thin(chain, tolerance=tolerance) for chain in wall_chains(rings, levels)]
        yield (
            chains,
            size_field(
                chains,
                size=smaller,
                pier_elements=options.pier_elements,
                corners=opening_corners(facade),
                corner_size=options.corner_size,
            ),
        )


def _check(mesh: VolumeMesh, facade: Facade, *, size: float, least: float) -> None:
    """Raise unless the elements are good and fill the wall, no more, no less."""
    shape, aspect = scaled_jacobians(mesh), element_aspects(mesh)
    if shape.min() < least:
        msg = (
            f"The worst element, {_place(mesh, shape.argmin())}, has a scaled Jacobian of {shape.min():.3f}, "
            f"less than {least:g}: try another size than {size:g} m, simplify the outline"
            f"{', move the level of a storey' if facade.storeys else ''}, or lower 'min_scaled_jacobian'."
        )
        raise MeshError(msg)
    if aspect.max() > MAX_ASPECT:
        worst = aspect.argmax()
        thin = int(np.ptp(mesh.nodes[mesh.elements[worst]], axis=0).argmin()) == DEPTH
        cause = "two thicknesses of its storeys" if thin else "two edges of the facade"
        msg = (
            f"An element, {_place(mesh, worst)}, is {aspect.max():.0f} times longer than wide (at most "
            f"{MAX_ASPECT:.0f}): {cause} all but coincide there; make them line up, or leave more wall "
            "between them."
        )
        raise MeshError(msg)
    perimeter = sum(_perimeter(ring) for ring in (facade.outline, *(o.outline for o in facade.openings)))
    # A door's foot may move by two micrometres, an arc's end by one, nothing else.
    reach = 1e-5 * perimeter * max(band.thickness for band in facade.bands)
    filled = float(element_volumes(mesh).sum())
    if abs(filled - facade.volume) > reach:
        msg = (
            f"The mesh holds {filled:.6g} m³ of a wall of {facade.volume:.6g} m³: simplify the facade's "
            "outline."
        )
        raise MeshError(msg)


def _place(mesh: VolumeMesh, element: np.intp) -> str:
    """Where an element is, for a message."""
    x, _, z = mesh.nodes[mesh.elements[element]].mean(axis=0)
    return f"at x = {x:.3f}, z = {z:.3f} m"


def _perimeter(ring: FloatArray) -> float:
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())
