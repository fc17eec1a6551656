"""STEP solid to tetrahedra, by gmsh and its OpenCASCADE kernel."""

from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing.options import DEFAULT_OPTIONS, MeshOptions
from fd2fem.meshing.quality import mesh_quality
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.topology import boundary_facets
from fd2fem.model import ElementKind, VolumeMesh

__all__ = ["GMSH_TO_VTK", "mesh_step"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

TETRA10 = 11
"""gmsh's number for a tetrahedron of 10 nodes."""
GMSH_TO_VTK = np.array([0, 1, 2, 3, 4, 5, 6, 7, 9, 8])
"""gmsh numbers the middles of a tetrahedron's last two edges the other way round; its own inverse."""
SIDES: Mapping[str, tuple[int, int]] = {
    "base": (2, -1), "top": (2, 1), "left": (0, -1), "right": (0, 1), "front": (1, -1), "back": (1, 1),
}  # fmt: skip
"""Axis and sense of each group's outward normal."""
TETRA_SHARE = 0.5
"""Part of `MeshOptions.min_scaled_jacobian` asked of a tetrahedron: a well-shaped corner of a cube cut
into tetrahedra has 0.5 to 0.7, where the cube has 1."""


def mesh_step(path: Path, *, options: MeshOptions = DEFAULT_OPTIONS) -> VolumeMesh:
    """10-node tetrahedra, straight-edged, in the solid of a STEP file.

    The solid stands in the facade frame, in whatever unit the file declares. Its groups are the facets
    on the sides of its bounding box: base z min, top z max, left x min, right x max, front y min, back
    y max. Solids that touch are joined. Of `options`, `size` and `min_scaled_jacobian` apply; a
    tetrahedron must reach half the latter.

    Raises
    ------
    InputError
        If the file is missing or holds no solid.
    MeshError
        If gmsh fails, or an element is too bad.
    """
    if not path.is_file():
        msg = f"There is no file {path}: give a STEP file with a solid."
        raise InputError(msg)
    settings: dict[str, float | str] = {
        "Geometry.OCCTargetUnit": "M",
        "Mesh.MeshSizeMax": options.size,
        "Mesh.Optimize": 1.0,
        "Mesh.OptimizeNetgen": 1.0,
        "Mesh.SecondOrderLinear": 1.0,  # curving could fold elements; the corners stay where they are
    }
    with gmsh_session(settings) as gmsh:
        _import_solid(gmsh, path)
        nodes, elements = _generate(gmsh)
    mesh = VolumeMesh(
        nodes=nodes, elements=elements, kind=ElementKind.TETRA10, groups=_box_groups(nodes, elements)
    )
    worst = mesh_quality(mesh).min_scaled_jacobian
    if worst < TETRA_SHARE * options.min_scaled_jacobian:
        msg = (
            f"The worst tetrahedron has a scaled Jacobian of {worst:.3f}, less than "
            f"{TETRA_SHARE * options.min_scaled_jacobian:g}: try another size than {options.size:g} m."
        )
        raise MeshError(msg)
    return mesh


def _import_solid(gmsh: ModuleType, path: Path) -> None:
    """Load the solids of a STEP file and let those that touch share their faces."""
    # OpenCASCADE writes to stdout about anything but a whole file.
    text = path.read_bytes()
    if b"ISO-10303-21" not in text[:4096] or b"END-ISO-10303-21" not in text[-4096:]:
        msg = f"{path.name} is not a STEP file that can be read: export the solid again."
        raise InputError(msg)
    try:
        gmsh.model.occ.importShapes(str(path), format="step")
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"{path.name} is not a STEP file that can be read: {error}. Export it again."
        raise InputError(msg) from error
    gmsh.model.occ.synchronize()
    volumes = gmsh.model.getEntities(3)
    if not volumes:
        msg = f"{path.name} holds no solid: export a closed solid, not surfaces or curves."
        raise InputError(msg)
    if len(volumes) > 1:
        gmsh.model.occ.fragment(volumes[:1], volumes[1:])
        gmsh.model.occ.synchronize()


def _generate(gmsh: ModuleType) -> tuple[FloatArray, IntArray]:
    """Mesh the model; used nodes, numbered densely, and elements in VTK's order."""
    try:
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
    except Exception as error:  # gmsh raises nothing more specific
        msg = f"gmsh could not mesh the solid: {error}. Try another element size, or heal the solid."
        raise MeshError(msg) from error
    _, corners = gmsh.model.mesh.getElementsByType(TETRA10)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    place = np.empty(int(tags.max()) + 1, dtype=np.intp)
    place[tags.astype(np.intp)] = np.arange(len(tags))
    used, elements = np.unique(place[corners.astype(np.intp)], return_inverse=True)
    return coordinates.reshape(-1, 3)[used], elements.reshape(-1, 10)[:, GMSH_TO_VTK]


def _box_groups(nodes: FloatArray, elements: IntArray) -> dict[str, IntArray]:
    """Boundary facets on each side of the bounding box."""
    facets = boundary_facets(elements, ElementKind.TETRA10, nodes=len(nodes))
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    reach = 1e-6 * float((high - low).max())
    groups = {}
    for name, (axis, sense) in SIDES.items():
        plane = high[axis] if sense > 0 else low[axis]
        on_side = (np.abs(nodes[facets[:, :3], axis] - plane) < reach).all(axis=1)
        groups[name] = facets[on_side]
    return groups
