"""Hexahedra on walls with slanted and curved edges."""

import numpy as np
import pytest
import shapely
from curved_walls import CURVED_WALLS, arcade, church, gabled
from mesh_oracles import assert_conformal, assert_fills, group_area, ledge_area, vtk_quality

from fd2fem.errors import MeshError
from fd2fem.meshing import MeshOptions, mesh_facade, mesh_quality
from fd2fem.meshing.chains import wall_chains
from fd2fem.meshing.free_quads import ALGORITHMS, best_quads, halve, quads_between
from fd2fem.meshing.sizes import SizeField
from fd2fem.meshing.smoothing import corner_quality
from fd2fem.meshing.walls import wall_rings
from fd2fem.model import Facade, Opening, OpeningKind


@pytest.mark.parametrize("name", CURVED_WALLS)
def test_curved_walls_at_the_default_size(name):
    facade = CURVED_WALLS[name]
    mesh = mesh_facade(facade)
    assert vtk_quality(mesh).min() > 0.45  # the corners of curves at levels allow no more
    assert mesh_quality(mesh).max_aspect < 25.0  # layers of 0.2 m beside a strip of 30 mm
    assert_conformal(mesh)
    assert_fills(mesh, facade)
    assert group_area(mesh, "ledges") == pytest.approx(ledge_area(facade), rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("size", [0.1, 0.4])
def test_other_sizes(size):
    facade = CURVED_WALLS["elliptic"]
    mesh = mesh_facade(facade, options=MeshOptions(size=size, layers=1))
    assert vtk_quality(mesh).min() > 0.45
    assert_fills(mesh, facade)
    edges = np.linalg.norm(np.diff(mesh.nodes[mesh.elements[:, 4:]], axis=1), axis=2)
    assert 0.3 * size < np.median(edges) < 1.2 * size
    assert edges.max() < 2.2 * size


def test_nodes_follow_the_curves():
    facade = CURVED_WALLS["pointed"]
    mesh = mesh_facade(facade, options=MeshOptions(size=0.2, layers=1))
    nodes = mesh.nodes[np.unique(mesh.groups["reveals"])][:, [0, 2]]
    rims = shapely.union_all([shapely.LinearRing(opening.outline) for opening in facade.openings])
    # facets of the mesh and of the outline, each within its own distance of the true curve
    assert shapely.distance(shapely.points(nodes), rims).max() < 0.2 / 50 + 0.002
    for opening in facade.openings:
        for corner in opening.outline[[0, 1, opening.arcs[0].first, opening.arcs[0].last]]:
            assert np.abs(nodes - corner).max(axis=1).min() < 1e-9  # springings and the point stay


def test_an_arcade_of_28_arches():
    facade = arcade()
    mesh = mesh_facade(facade, options=MeshOptions(size=0.5))
    assert vtk_quality(mesh).min() > 0.45
    assert_fills(mesh, facade)
    assert len(mesh.elements) < 15_000


def test_storeys_of_a_church():
    facade = church()
    mesh = mesh_facade(facade)
    heights = mesh.nodes[np.unique(mesh.groups["ledges"]), 2]
    assert set(heights.round(9).tolist()) == {2.9, 6.2}
    depths = mesh.nodes[np.unique(mesh.groups["ledges"]), 1]
    assert set(depths.round(9).tolist()) >= {0.3, 0.4, 0.5}


def test_polygons_without_arcs_are_thinned_but_keep_their_area():
    # chords of 2 mm, as from a scan: no arc says that they are one
    angle = np.linspace(0.0, np.pi, 800)
    head = np.column_stack([3 + 0.6 * np.cos(angle), 2.4 + 0.6 * np.sin(angle)])
    ring = np.vstack([[[2.4, 1.0], [3.6, 1.0]], head])
    gable = gabled()
    facade = Facade(gable.outline, 0.4, (Opening(1, OpeningKind.WINDOW, ring),), storeys=gable.storeys)
    mesh = mesh_facade(facade)
    assert vtk_quality(mesh).min() > 0.45
    assert_fills(mesh, facade)
    assert len(mesh.elements) < 5_000


@pytest.mark.parametrize("count", [1, 2, 4])
def test_elements_across_a_slanted_pier(count):
    slanted = [
        np.array([[1, 1], [2, 1], [2.1, 2.5], [1, 2.5]]),
        np.array([[2.3, 1], [3.4, 1], [3.4, 2.5], [2.4, 2.5]]),
    ]
    openings = tuple(Opening(k, OpeningKind.WINDOW, ring) for k, ring in enumerate(slanted, start=1))
    facade = Facade(np.array([[0, 0], [5, 0], [5, 4], [0, 4]], dtype=float), 0.4, openings)
    mesh = mesh_facade(facade, options=MeshOptions(size=0.5, pier_elements=count, min_scaled_jacobian=0.2))
    line = shapely.LineString([(2.05 + 1e-6, 1.7513), (2.35 - 1e-6, 1.7513)])
    front = shapely.polygons(mesh.nodes[mesh.groups["front"]][:, :, [0, 2]])
    assert shapely.intersects(front, line).sum() >= count


def test_refinement_at_the_corners_of_openings():
    facade = CURVED_WALLS["leaning"]
    mesh = mesh_facade(facade, options=MeshOptions(size=0.25, corner_size=0.05, layers=1))
    assert vtk_quality(mesh).min() > 0.45
    assert_fills(mesh, facade)
    corners = np.vstack([opening.outline for opening in facade.openings])
    assert edges_at(mesh, corners).max() < 2.5 * 0.05
    assert edges_at(mesh, facade.outline).min() > 0.1


def edges_at(mesh, points):
    """Mean edge on the front at each of the points."""
    quads = mesh.groups["front"]
    corner = mesh.nodes[quads][:, :, [0, 2]]
    length = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).mean(axis=1)
    return np.array([length[(np.abs(corner - p).max(axis=2) < 1e-9).any(axis=1)].mean() for p in points])


def test_too_sharp_a_corner_is_refused_with_its_place():
    facade = Facade(np.array([[0, 0], [6, 0], [6, 0.8]], dtype=float), 0.4)
    sine = 0.8 / np.hypot(6, 0.8)  # 0.13: of the one element in the sharp corner, at best
    with pytest.raises(MeshError, match=r"worst element, at x = 0\.\d+, z = 0\.\d+ m, has a scaled Jacobian"):
        mesh_facade(facade, options=MeshOptions(size=0.4))
    mesh = mesh_facade(facade, options=MeshOptions(size=0.4, min_scaled_jacobian=0.1))
    assert 0.1 < vtk_quality(mesh).min() <= sine + 1e-9


def test_halving_a_square_and_a_triangle_by_hand():
    points = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [4, 0], [1.1, -0.1]], dtype=float)
    polygons = [np.array([[1, 4, 2]]), np.array([[0, 1, 2, 3]])]
    halved, quads = halve(points, polygons, middles=np.array([[0, 5, 1]]))
    assert len(quads) == 3 + 4
    assert len(halved) == 6 + 6 + 2  # points; edges, one of which has its middle but one unused; middles
    assert (corner_quality(halved, quads) > 0).all()
    corner = halved[quads]
    diagonals = corner[:, 2:] - corner[:, :2]
    area = np.sum(diagonals[:, 0, 0] * diagonals[:, 1, 1] - diagonals[:, 0, 1] * diagonals[:, 1, 0]) / 2
    assert area == pytest.approx(4 + 2 + 0.1)  # the square's lower edge bends out to (1.1, -0.1)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_each_algorithm_fills_the_wall(algorithm):
    facade = CURVED_WALLS["oculi"]
    chains = wall_chains(wall_rings(facade), [])
    field = SizeField(np.empty((0, 2)), np.empty(0), 0.3)
    mesh = quads_between(chains, field, algorithm=algorithm)
    assert mesh.areas.sum() == pytest.approx(facade.wall_area, rel=1e-12)
    assert (mesh.areas > 0).all()


def test_no_attempt_fills_the_wall():
    with pytest.raises(MeshError, match="no lines"):
        best_quads([], enough=0.3)
