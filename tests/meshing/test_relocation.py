import numpy as np
import pytest

from fd2fem.meshing.quality import tetrahedron_shapes
from fd2fem.meshing.relocation import relocate
from fd2fem.meshing.splitting import tetrahedron_boundary

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


def star(apex):
    """A unit cube of tetrahedra from its surface, two triangles a side, to a point within."""
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    corners = np.array([(*triangle, 8) for triangle in triangles])
    nodes = np.vstack([CUBE, apex])
    inverted = tetrahedron_shapes(nodes[corners]) < 0.0
    corners[inverted] = corners[inverted][:, [1, 0, 2, 3]]
    return nodes, corners


def test_an_inner_node_moves_to_where_the_worst_tetrahedron_is_best():
    nodes, corners = star([0.5, 0.5, 0.93])
    boundary = tetrahedron_boundary(corners, nodes=9)
    moved = relocate(nodes, corners, boundary, target=1.0)
    before, after = (tetrahedron_shapes(p[corners]).min() for p in (nodes, moved))
    centred, _ = star([0.5, 0.5, 0.5])
    assert after > 4.0 * before
    assert after == pytest.approx(tetrahedron_shapes(centred[corners]).min(), rel=0.05)
    np.testing.assert_array_equal(moved[:8], CUBE)  # the corners of a solid stay


def test_good_tetrahedra_are_let_alone():
    nodes, corners = star([0.5, 0.5, 0.5])
    moved = relocate(nodes, corners, tetrahedron_boundary(corners, nodes=9), target=0.1)
    np.testing.assert_array_equal(moved, nodes)
