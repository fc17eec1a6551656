"""Tetrahedra, in solids that CAD programs drew and in facades."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType, ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.cad_files import CAD_SETTINGS, load_solid
from fd2fem.meshing.hexahedra import mesh_facade
from fd2fem.meshing.options import (
    DEFAULT_OPTIONS,
    ElementShape,
    MeshOptions,
    check_fineness,
    divisions,
    slabs,
)
from fd2fem.meshing.quality import mesh_quality, tetrahedron_shapes
from fd2fem.meshing.relocation import relocate
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.solid_sides import group_facets, wall_frame
from fd2fem.meshing.solid_sizes import FLATTENING, Curve, default_solid_size, set_sizes, solid_curves
from fd2fem.meshing.splitting import quadratic_tetrahedra, split_hexahedra, tetrahedron_boundary, worst_split
from fd2fem.meshing.topology import boundary_facets
from fd2fem.model import ElementKind, Facade, VolumeMesh

__all__ = ["GMSH_TO_VTK", "mesh_facade_tetrahedra", "mesh_step"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

TETRA4 = 4
"""gmsh's number for a tetrahedron of 4 nodes."""
GMSH_TO_VTK = np.array([0, 1, 2, 3, 4, 5, 6, 7, 9, 8])
"""gmsh numbers the middles of a tetrahedron's last two edges the other way round; its own inverse."""
TETRA_SHARE = 0.5
"""Part of `MeshOptions.min_scaled_jacobian` asked of a tetrahedron: a well-shaped corner of a cube cut
into tetrahedra has 0.5 to 0.7, where the cube has 1."""
GOOD = 0.2
"""Scaled Jacobian of the worst tetrahedron from which on no other mesh is tried."""
TARGET = 0.25
"""Nodes are moved until tetrahedra have this scaled Jacobian, where they can."""
FEW = 100
"""With more poor tetrahedra than this, Netgen's optimization takes minutes and does not help."""
MANY = 80_000
"""From so many tetrahedra on, no smaller ones are tried: it would take minutes too."""
SMALLER = (1.0, 0.8, 0.64, 0.5)
"""Parts of the element size to try in turn."""
LONGEST = 3.0
"""Longest a tetrahedron may be through the wall, in edges of the smallest at a corner."""
HXT, DELAUNAY = 10.0, 1.0
"""gmsh's ways to fill a volume: the fast one and the other."""
SAME_VOLUME = 1e-6
"""Relative difference of volume between a solid of plane faces and its mesh that passes."""
_SETTINGS: Mapping[str, float | str] = MappingProxyType(
    {
        **CAD_SETTINGS,
        "Mesh.Algorithm": 6.0,  # frontal Delaunay
        "Mesh.Algorithm3D": HXT,
        "Mesh.MeshSizeMax": 1.0,
        "Mesh.MeshSizeFromCurvature": 12.0,  # of surfaces; curves have their own, finer rule
        "Mesh.MeshSizeFromParametricPoints": 1.0,
    }
)


@dataclass(frozen=True, eq=False)
class _Tetrahedra:
    """Nodes (n, 3), m, and corners (e, 4) of tetrahedra of 4 nodes.

    `worst` is their least scaled Jacobian, `poor` the number of those that are not `GOOD`.
    """

    nodes: FloatArray
    corners: IntArray
    worst: float
    poor: int


def mesh_step(path: Path, *, options: MeshOptions = DEFAULT_OPTIONS) -> VolumeMesh:
    """10-node tetrahedra, straight-edged, in the solid of a STEP, IGES or BREP file.

    The solid may have any number of faces and stand anywhere, upright; solids that touch are joined. Where
    it is curved, facets leave it by a fiftieth of the element size at most. The mesh stands in the facade
    frame of :func:`~fd2fem.meshing.solid_sides.wall_frame` and has the groups of a facade's.

    Of `options`, `size`, `pier_elements` and `min_scaled_jacobian` apply; a tetrahedron must reach half the
    latter. Without a size it is the solid's own, see
    :func:`~fd2fem.meshing.solid_sizes.default_solid_size`. Where the worst tetrahedron is poor, gmsh's
    second algorithm is tried, then smaller sizes, down to half.

    Parameters
    ----------
    path : Path
        Its suffix tells the format: .step, .stp, .igs, .iges, .brep.
    options : MeshOptions

    Raises
    ------
    InputError
        If the file is missing, of another format, truncated, or holds no solid that stands upright; if there
        would be too many elements.
    MeshError
        If gmsh fails, an element is too bad, or the volume of the mesh is not that of the solid.
    """
    with gmsh_session(_SETTINGS) as gmsh:
        volume = load_solid(gmsh, path)
        curves = solid_curves(gmsh)
        size = options.size or default_solid_size(gmsh, curves, volume=volume)
        check_fineness(volume, size=size)
        tetrahedra = _best(gmsh, curves, size=size, options=options)
        curved = sum(
            float(gmsh.model.occ.getMass(*face))
            for face in gmsh.model.getEntities(2)
            if gmsh.model.getType(*face) != "Plane"
        )
    tolerance = size / FLATTENING
    nodes, elements = quadratic_tetrahedra(tetrahedra.nodes, tetrahedra.corners)
    facets = boundary_facets(elements, ElementKind.TETRA10, nodes=len(nodes))
    nodes = wall_frame(nodes, facets).to_facade(nodes)
    mesh = VolumeMesh(
        nodes=nodes,
        elements=elements,
        kind=ElementKind.TETRA10,
        groups=group_facets(nodes, facets, tolerance=tolerance),
    )
    _check_shapes(mesh, options=options, size=size)
    _check_volume(mesh, volume=volume, off=SAME_VOLUME * volume + curved * tolerance)
    return mesh


def mesh_facade_tetrahedra(facade: Facade, *, options: MeshOptions = DEFAULT_OPTIONS) -> VolumeMesh:
    """10-node tetrahedra, straight-edged, in a facade: its hexahedra, each cut into six.

    So they are as many across piers and through the thickness, as fine at corners, and have the same groups
    and exactly the wall's volume; and no sliver can come about as in a volume that is filled freely. Where
    elements are small at corners or curves, there are more layers than hexahedra need, unless `layers` says
    how many.

    Parameters
    ----------
    facade : Facade
    options : MeshOptions
        A tetrahedron must reach half of `min_scaled_jacobian`.

    Raises
    ------
    MeshError
        If there are no hexahedra as good as `options.min_scaled_jacobian`, or a tetrahedron is too bad.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> mesh = mesh_facade_tetrahedra(Facade(rectangle(0, 0, 4, 3), 0.5), options=MeshOptions(size=0.5))
    >>> mesh.elements.shape, round(mesh_quality(mesh).volume, 9)
    ((288, 10), 6.0)
    """
    size, layers = options.size_for(facade), options.layers
    check_fineness(facade.volume, size=size, corner_size=options.corner_size)
    if options.corner_size is not None and not layers:
        thickest = max(band.thickness for band in facade.bands)
        layers = divisions(thickest, min(size, LONGEST * options.corner_size))
    wanted = replace(options, size=size, layers=layers, elements=ElementShape.HEXAHEDRA, order=1)
    hexahedra = mesh_facade(facade, options=wanted)
    if not options.layers and worst_split(hexahedra) < GOOD:
        # At curves, elements can be far smaller in the wall's plane than through it.
        layers = 2 * (layers or sum(count for _, count in slabs(facade, size=size)))
        thinner = mesh_facade(facade, options=replace(wanted, layers=layers))
        hexahedra = max(hexahedra, thinner, key=worst_split)
    mesh = split_hexahedra(hexahedra, target=GOOD)
    _check_shapes(mesh, options=options, size=size)
    return mesh


def _check_shapes(mesh: VolumeMesh, *, options: MeshOptions, size: float) -> None:
    """Raise MeshError if a tetrahedron has less than its share of `options.min_scaled_jacobian`."""
    worst, least = mesh_quality(mesh).min_scaled_jacobian, TETRA_SHARE * options.min_scaled_jacobian
    if worst < least:
        msg = (
            f"The worst tetrahedron has a scaled Jacobian of {worst:.3f}, less than {least:g}: try another "
            f"size than {size:g} m."
        )
        raise MeshError(msg)


def _best(gmsh: ModuleType, curves: tuple[Curve, ...], *, size: float, options: MeshOptions) -> _Tetrahedra:
    """The first mesh that is good, or else the best one of the largest size that gives one that passes."""
    best: _Tetrahedra | None = None
    refused = MeshError("gmsh made no tetrahedra: try another element size.")
    for part in SMALLER:
        gmsh.option.setNumber("Mesh.MeshSizeMax", part * size)
        set_sizes(gmsh, curves, size=part * size, pier_elements=options.pier_elements)
        for algorithm in (HXT, DELAUNAY):
            try:
                mesh = _fill(gmsh, algorithm=algorithm)
            except MeshError as error:
                refused = error
                continue
            if best is None or mesh.worst > best.worst:
                best = mesh
            if best.worst >= GOOD:
                return best
        if best is None:
            continue
        if best.worst >= TETRA_SHARE * options.min_scaled_jacobian or len(best.corners) > MANY:
            return best
    if best is None:
        raise refused
    return best


def _fill(gmsh: ModuleType, *, algorithm: float) -> _Tetrahedra:
    """Mesh the model at the sizes set; where that is poor, Netgen's optimization may do better."""
    gmsh.option.setNumber("Mesh.Algorithm3D", algorithm)
    try:
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(3)
        mesh = _tetrahedra(gmsh)
        if 0 < mesh.poor <= FEW:
            gmsh.model.mesh.optimize("Netgen")
            mesh = max(mesh, _tetrahedra(gmsh), key=lambda tried: tried.worst)
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"gmsh could not mesh the solid: {error}. Try another element size, or heal the solid."
        raise MeshError(msg) from error
    return mesh


def _tetrahedra(gmsh: ModuleType) -> _Tetrahedra:
    """The tetrahedra of the model, their nodes numbered densely."""
    _, corners = gmsh.model.mesh.getElementsByType(TETRA4)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    place = np.empty(int(tags.max()) + 1, dtype=np.intp)
    place[tags.astype(np.intp)] = np.arange(len(tags))
    used, elements = np.unique(place[corners.astype(np.intp)], return_inverse=True)
    nodes, elements = coordinates.reshape(-1, 3)[used], elements.reshape(-1, 4)
    nodes = relocate(nodes, elements, tetrahedron_boundary(elements, nodes=len(nodes)), target=TARGET)
    shapes = tetrahedron_shapes(nodes[elements])
    return _Tetrahedra(nodes, elements, float(shapes.min()), int((shapes < GOOD).sum()))


def _check_volume(mesh: VolumeMesh, *, volume: float, off: float) -> None:
    """Raise unless the mesh has the solid's volume but for what its curved faces allow."""
    have = mesh_quality(mesh).volume
    if abs(have - volume) > off:
        msg = (
            f"The mesh has {have:.6g} m³, the solid {volume:.6g} m³, more than {off:.2g} m³ apart: try a "
            "smaller element size, or heal the solid."
        )
        raise MeshError(msg)
