"""Meshes in gmsh's own files, written and read by gmsh: meshio can lose the names of the groups."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing.quality import element_volumes
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.tetrahedra import GMSH_TO_VTK
from fd2fem.meshing.topology import facet_keys
from fd2fem.model import GROUPS, ElementKind, VolumeMesh
from fd2fem.model.topology import FACETS

__all__ = ["read_msh", "write_by_gmsh"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

WALL = "wall"
"""Physical group of the elements."""
TYPES: Mapping[ElementKind, tuple[int, int]] = {
    ElementKind.HEXAHEDRON: (5, 3),
    ElementKind.HEXAHEDRON20: (17, 16),
    ElementKind.TETRA10: (11, 9),
}
"""gmsh's numbers of the element and its facet."""
ORDER: Mapping[ElementKind, IntArray] = {
    ElementKind.HEXAHEDRON: np.arange(8),
    # gmsh sorts the edges by their ends: 01 03 04 12 15 23 26 37 45 47 56 67
    ElementKind.HEXAHEDRON20: np.array([*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]),
    ElementKind.TETRA10: GMSH_TO_VTK,
}
"""Where gmsh keeps each of VTK's nodes; their places in a facet are the same."""
MIRROR: Mapping[ElementKind, list[int]] = {
    ElementKind.HEXAHEDRON: [4, 5, 6, 7, 0, 1, 2, 3],
    ElementKind.HEXAHEDRON20: [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19],
    ElementKind.TETRA10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
}
"""Order of the nodes that turns an element inside out."""


def write_by_gmsh(mesh: VolumeMesh, path: Path) -> None:
    """Write MSH 4.1 (.msh) or MED (.med), the groups as physical groups of facets, the elements as "wall".

    Raises
    ------
    MeshError
        If gmsh cannot write the file.
    """
    with gmsh_session({"Mesh.MshFileVersion": 4.1, "Mesh.Binary": 0.0, "Mesh.SaveAll": 0.0}) as gmsh:
        model = gmsh.model
        solid, facet = TYPES[mesh.kind]
        wall = model.addDiscreteEntity(3)
        model.mesh.addNodes(3, wall, np.arange(1, len(mesh.nodes) + 1), mesh.nodes.ravel())
        elements = mesh.elements[:, np.argsort(ORDER[mesh.kind])] + 1
        model.mesh.addElementsByType(wall, solid, [], elements.ravel())
        model.addPhysicalGroup(3, [wall], name=WALL)
        for name, facets in mesh.groups.items():
            if len(facets):
                side = model.addDiscreteEntity(2)
                model.mesh.addElementsByType(side, facet, [], (facets + 1).ravel())
                model.addPhysicalGroup(2, [side], name=name)
        # gmsh chooses the format by the suffix, and knows none in capitals.
        with TemporaryDirectory(dir=path.parent, prefix=".fd2fem-") as folder:
            written = Path(folder) / f"mesh{path.suffix.lower()}"
            try:
                gmsh.write(str(written))
            except Exception as error:  # gmsh raises nothing more specific
                msg = f"gmsh could not write {path}: {error}."
                raise MeshError(msg) from error
            written.replace(path)


def read_msh(path: Path) -> VolumeMesh:
    """Read hexahedra of 8 or 20 nodes, or 10-node tetrahedra, and the named groups of a .msh file.

    Elements come out with positive volume and facets right-handed about the outward normal, however
    they were written. Nodes of no element are left out; groups other than
    :data:`~fd2fem.model.GROUPS` are ignored.

    Raises
    ------
    InputError
        If the file is missing or damaged, holds other elements, or lacks the group "base".
    """
    _check_header(path)
    with gmsh_session() as gmsh:
        try:
            gmsh.merge(str(path))
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
        except Exception as error:  # gmsh raises nothing more specific
            msg = f"{path.name} is not a .msh file that gmsh can read: {error}. Write it again as MSH 4.1."
            raise InputError(msg) from error
        kind = _kind(gmsh, path)
        _, connectivity = gmsh.model.mesh.getElementsByType(TYPES[kind][0])
        facets = _named_facets(gmsh, kind)
    if not len(facets.get("base", ())):
        msg = (
            f"{path.name} has no facets in the physical group 'base' (it has: {', '.join(facets) or 'none'})"
            ": name the surface on the ground 'base' and write the file again."
        )
        raise InputError(msg)
    place = np.full(int(tags.max()) + 1, -1, dtype=np.intp)
    place[tags.astype(np.intp)] = np.arange(len(tags))
    used, elements = np.unique(place[connectivity.astype(np.intp)], return_inverse=True)
    nodes = coordinates.reshape(-1, 3)[used]
    elements = _upright(nodes, elements.reshape(-1, kind.nodes)[:, ORDER[kind]], kind, path)
    dense = np.full(len(tags), -1, dtype=np.intp)
    dense[used] = np.arange(len(used))
    named = {name: dense[place[table]] for name, table in facets.items()}
    return VolumeMesh(nodes=nodes, elements=elements, kind=kind, groups=_outward(named, elements, kind, path))


def _check_header(path: Path) -> None:
    """Let gmsh see nothing but its own mesh files: it runs anything else as a script."""
    if not path.is_file():
        msg = f"There is no file {path}: give a .msh file."
        raise InputError(msg)
    with path.open("rb") as stream:
        if stream.read(11) != b"$MeshFormat":
            msg = f"{path.name} does not start with $MeshFormat: it is not a .msh file of gmsh."
            raise InputError(msg)


def _kind(gmsh: ModuleType, path: Path) -> ElementKind:
    """The one kind of element in the model."""
    found = list(gmsh.model.mesh.getElementTypes(3))
    for kind, (solid, _) in TYPES.items():
        if found == [solid]:
            return kind
    names = (
        ", ".join(gmsh.model.mesh.getElementProperties(number)[0] for number in found) or "no volume element"
    )
    msg = (
        f"{path.name} holds {names}: mesh with 8-node hexahedra alone, 20-node hexahedra alone "
        "(Mesh.SecondOrderIncomplete = 1) or 10-node tetrahedra alone."
    )
    raise InputError(msg)


def _named_facets(gmsh: ModuleType, kind: ElementKind) -> dict[str, IntArray]:
    """Node tags (f, 4, 8 or 6) of the facets in each of our groups."""
    facets: dict[str, IntArray] = {}
    for dim, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(dim, group)
        if name in GROUPS:
            tables = [
                gmsh.model.mesh.getElementsByType(TYPES[kind][1], entity)[1]
                for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group)
            ]
            facets[name] = np.concatenate(tables).astype(np.intp).reshape(-1, kind.facet_nodes)
    return facets


def _upright(nodes: FloatArray, elements: IntArray, kind: ElementKind, path: Path) -> IntArray:
    """Turn elements that are inside out."""
    mesh = VolumeMesh(nodes=nodes, elements=elements, kind=kind, groups={})
    volume = element_volumes(mesh)
    if (volume == 0.0).any():
        msg = f"{path.name}: {int((volume == 0.0).sum())} elements have no volume; mesh again."
        raise InputError(msg)
    upright = elements.copy()
    upright[volume < 0.0] = elements[volume < 0.0][:, MIRROR[kind]]
    return upright


def _outward(
    named: Mapping[str, IntArray], elements: IntArray, kind: ElementKind, path: Path
) -> dict[str, IntArray]:
    """Replace each facet by the same one as its element has it, which faces outward."""
    own = elements[:, np.array(FACETS[kind])].reshape(-1, kind.facet_nodes)
    # A node of -1 belongs to no element; shifted by one, it can be part of a key.
    keys = facet_keys(np.concatenate([own, *named.values()]) + 1, nodes=int(own.max()) + 2)
    own_keys, first, count = np.unique(keys[: len(own)], return_index=True, return_counts=True)
    groups, start = {}, len(own)
    for name, table in named.items():
        wanted = keys[start : start + len(table)]
        start += len(table)
        at = np.minimum(np.searchsorted(own_keys, wanted), len(own_keys) - 1)
        if (own_keys[at] != wanted).any() or (count[at] != 1).any():
            msg = f"{path.name}: the group '{name}' has facets that are not on the surface of the wall."
            raise InputError(msg)
        groups[name] = own[first[at]]
    return groups
