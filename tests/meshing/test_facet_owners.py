import numpy as np
import pytest
from exported_meshes import HEX_FACETS, TETRA_FACETS, all_kinds

from fd2fem.errors import InputError
from fd2fem.meshing.facet_owners import facet_owners
from fd2fem.model import VolumeMesh

KINDS = ["hexahedron", "hexahedron20", "tetra10"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_facet_is_the_face_of_its_owner(kind):
    mesh = all_kinds()[kind]
    faces = TETRA_FACETS if kind == "tetra10" else HEX_FACETS
    owners = facet_owners(mesh)
    assert set(owners) == {name for name, facets in mesh.groups.items() if len(facets)}
    for name, table in owners.items():
        for facet, (element, face) in zip(mesh.groups[name], table, strict=True):
            corners = mesh.elements[element][list(faces[face])]
            assert set(corners) == set(facet[: len(corners)])


def test_a_facet_of_no_element():
    mesh = all_kinds()["hexahedron"]
    odd = VolumeMesh(mesh.nodes, mesh.elements, mesh.kind, {"base": np.array([[0, 1, 2, 60]])})
    with pytest.raises(InputError, match="Invalid group 'base': 1 of its 1 facets belong to no element"):
        facet_owners(odd)
