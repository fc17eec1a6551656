import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
)
BASE = np.array([[0, 3, 2, 1]])


def _cube(*, nodes=CUBE, elements=((0, 1, 2, 3, 4, 5, 6, 7),), groups=None):
    groups = {"base": BASE} if groups is None else groups
    return VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.HEXAHEDRON, groups=groups)


# VTK's numbers of nodes per cell and per face.
@pytest.mark.parametrize(("kind", "nodes", "facet"), [("hexahedron", 8, 4), ("tetra10", 10, 6)])
def test_nodes_of_an_element(kind, nodes, facet):
    assert (ElementKind(kind).nodes, ElementKind(kind).facet_nodes) == (nodes, facet)


def test_nodes_of_a_group_are_sorted_and_listed_once():
    mesh = _cube(groups={"sides": np.array([[0, 1, 5, 4], [1, 2, 6, 5]])})
    assert mesh.group_nodes("sides").tolist() == [0, 1, 2, 4, 5, 6]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"elements": [[0, 1, 2, 3, 4, 5, 6, 8]]}, "Invalid 'elements': node 8 of a mesh with 8 nodes"),
        ({"elements": [[0, 1, 2, 3, 4, 5, 6, -1]]}, "Invalid 'elements': node"),
        ({"elements": [[0, 1, 2, 3]]}, r"Invalid 'elements': expected shape \(n, 8\), got \(1, 4\)"),
        ({"groups": {"top": [[4, 5, 6, 9]]}}, "Invalid 'top': node 9"),
        ({"groups": {"top": [[4, 5, 6]]}}, r"Invalid 'group top': expected shape \(n, 4\), got \(1, 3\)"),
        ({"nodes": np.vstack([CUBE, [[5, 5, 5]]])}, "Invalid 'nodes': 1 of 9 nodes belong to no element"),
        ({"nodes": np.where(CUBE == 1, np.nan, CUBE)}, "Invalid 'nodes': 12 of 24 values are not finite"),
    ],
)
def test_a_mesh_that_does_not_hold_together_is_refused(changed, message):
    with pytest.raises(InputError, match=message):
        _cube(**changed)


@pytest.mark.parametrize(
    ("groups", "name", "message"),
    [
        ({"base": BASE}, "top", "The mesh has no group 'top'; it has: base"),
        ({}, "base", "no group 'base'; it has: none"),
        ({"base": np.empty((0, 4), dtype=int)}, "base", "no group 'base'"),
    ],
)
def test_a_missing_or_empty_group_is_named(groups, name, message):
    with pytest.raises(InputError, match=message):
        _cube(groups=groups).group_nodes(name)


def test_a_mesh_cannot_be_changed():
    mesh = _cube()
    for array in (mesh.nodes, mesh.elements, mesh.groups["base"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
    with pytest.raises(TypeError, match="assignment"):
        mesh.groups["top"] = BASE
