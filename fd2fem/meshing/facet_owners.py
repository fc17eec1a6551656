"""Which element, and which of its faces, each facet of a group is: other programs ask for that."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.meshing.topology import facet_keys
from fd2fem.model import ElementKind, VolumeMesh
from fd2fem.model.topology import FACETS

__all__ = ["facet_owners"]

IntArray = NDArray[np.intp]


def facet_owners(mesh: VolumeMesh) -> dict[str, IntArray]:
    """Element and face, both from 0, of the facets in each group that has any.

    Faces are counted as in :data:`~fd2fem.model.topology.FACETS`, which is the order of S1, S2, … in
    Abaqus and CalculiX.

    Returns
    -------
    owners : dict of str to (f, 2) int arrays
        Columns element, face.

    Raises
    ------
    InputError
        If a facet is none of any element.

    Examples
    --------
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    >>> groups = {"base": np.array([[0, 3, 2, 1]]), "top": np.array([[4, 5, 6, 7]])}
    >>> cube = VolumeMesh(np.array(corners), np.arange(8)[None], ElementKind.HEXAHEDRON, groups)
    >>> {name: table.tolist() for name, table in facet_owners(cube).items()}
    {'base': [[0, 0]], 'top': [[0, 1]]}
    """
    faces = FACETS[mesh.kind]
    own = mesh.elements[:, np.array(faces)].reshape(-1, mesh.kind.facet_nodes)
    filled = {name: facets for name, facets in mesh.groups.items() if len(facets)}
    table = np.concatenate([own, *filled.values()])
    # Corners have the lower numbers as a rule, and the lower they are the faster are the keys.
    corners = table[:, : 3 if mesh.kind is ElementKind.TETRA10 else 4]
    keys = facet_keys(table, nodes=int(corners.max()) + 1)
    own_keys, first = np.unique(keys[: len(own)], return_index=True)
    owners, start = {}, len(own)
    for name, facets in filled.items():
        wanted = keys[start : start + len(facets)]
        start += len(facets)
        at = np.minimum(np.searchsorted(own_keys, wanted), len(own_keys) - 1)
        strays = int((own_keys[at] != wanted).sum())
        if strays:
            msg = f"Invalid group '{name}': {strays} of its {len(facets)} facets belong to no element."
            raise InputError(msg)
        owners[name] = np.column_stack(np.divmod(first[at], len(faces)))
    return owners
