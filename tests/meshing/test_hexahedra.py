import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_oracles import assert_fills, vtk_quality

from fd2fem.drawings import stand_in
from fd2fem.errors import InputError, MeshError
from fd2fem.meshing import ElementShape, MeshOptions, mesh_facade, mesh_quality
from fd2fem.meshing.quality import element_volumes
from fd2fem.meshing.topology import boundary_facets
from fd2fem.model import GROUPS, ElementKind, Facade, Opening, OpeningKind, rectangle

OUTWARD = {
    "base": (0, 0, -1),
    "top": (0, 0, 1),
    "left": (-1, 0, 0),
    "right": (1, 0, 0),
    "front": (0, -1, 0),
    "back": (0, 1, 0),
}
L_SHAPE = np.array([[0, 0], [8, 0], [8, 3], [5, 3], [5, 6], [0, 6]], dtype=float)
GABLE = np.array([[0, 0], [6, 0], [6, 4], [3, 6], [0, 4]], dtype=float)


def opening(number, *box):
    return Opening(number, OpeningKind.DOOR if box[1] == 0 else OpeningKind.WINDOW, rectangle(*box))


def wall(*boxes, outline=None, thickness=0.4):
    outline = rectangle(0, 0, 8, 7) if outline is None else outline
    return Facade(outline, thickness, tuple(opening(number, *box) for number, box in enumerate(boxes, 1)))


def arch(x, z, width, height, *, chord=0.001):
    """A window with a half circle on top, in chords of about `chord`."""
    angle = np.linspace(0.0, np.pi, int(np.pi * width / 2 / chord))
    crown = np.column_stack([np.cos(angle), np.sin(angle)]) * width / 2 + [
        x + width / 2,
        z + height - width / 2,
    ]
    return np.vstack([[[x, z], [x + width, z]], crown])


def vector_areas(mesh, name):
    corner = mesh.nodes[mesh.groups[name]]
    return np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2


def group_area(mesh, name):
    """Area of a group along the outward normal."""
    return float(vector_areas(mesh, name).sum(axis=0) @ np.array(OUTWARD[name]))


def assert_tiles(mesh, facade):
    """Closed forms for a rectilinear facade without overhangs; every facet faces outward by itself."""
    doors = sum(o.width for o in facade.openings if o.kind is OpeningKind.DOOR)
    expected = {
        "front": facade.wall_area,
        "back": facade.wall_area,
        "base": (facade.length - doors) * facade.thickness,
        "top": facade.length * facade.thickness,
        "left": facade.height * facade.thickness,
        "right": facade.height * facade.thickness,
    }
    for name, area in expected.items():
        assert group_area(mesh, name) == pytest.approx(area, abs=1e-9)
        assert (vector_areas(mesh, name) @ np.array(OUTWARD[name]) > 0.0).all()
    assert mesh_quality(mesh).volume == pytest.approx(facade.wall_area * facade.thickness, abs=1e-9)


def assert_edges_are_exact(mesh, facade):
    """Each corner of the facade is a node, and along each edge the nodes lie on it without a gap."""
    front = mesh.nodes[np.unique(mesh.groups["front"])][:, [0, 2]]
    for ring in (facade.outline, *(o.outline for o in facade.openings)):
        for corner in ring:
            assert np.abs(front - corner).max(axis=1).min() < 1e-9
    surface = mesh.nodes[boundary_facets(mesh.elements, mesh.kind, nodes=len(mesh.nodes))]
    through = surface[np.ptp(surface[:, :, 1], axis=1) > 0.0].reshape(-1, 3)
    lines = [facade.outline, *(o.outline for o in facade.openings)]
    assert distance_to(lines, through[:, [0, 2]]).max() < 1e-9


def distance_to(rings, points):
    import shapely

    return shapely.distance(shapely.points(points), shapely.union_all([shapely.LinearRing(r) for r in rings]))


def test_a_plain_wall():
    mesh = mesh_facade(wall(), options=MeshOptions(size=0.5, layers=3))
    assert len(mesh.elements) == 16 * 14 * 3
    assert len(mesh.nodes) == 17 * 15 * 4
    assert mesh_quality(mesh).min_scaled_jacobian == pytest.approx(1.0)
    assert set(mesh.groups) == set(GROUPS)
    assert_tiles(mesh, wall())


@pytest.mark.parametrize(
    "facade",
    [
        wall((1, 1, 1, 1.5), (4, 1, 1, 1.5), (1, 4, 1, 1.5)),
        wall((1, 0, 1.2, 2.2), (4, 1, 1, 1.5)),
        wall((1, 0, 1, 2), (5.5, 1, 1, 1), (1.03, 3.5, 1, 1), (3.2, 3.4, 1, 1.3), outline=L_SHAPE),
    ],
    ids=["windows", "door", "stepped outline"],
)
def test_groups_tile_and_edges_are_exact(facade):
    mesh = mesh_facade(facade)
    assert_tiles(mesh, facade)
    assert_edges_are_exact(mesh, facade)


def test_a_door_half_a_micrometre_above_the_ground():
    door = Opening(1, OpeningKind.DOOR, rectangle(0.5, 5e-7, 1, 2))
    mesh = mesh_facade(Facade(rectangle(0, 0, 3, 3), 0.4, (door,)))
    assert mesh_quality(mesh).volume == pytest.approx((9 - 2) * 0.4, abs=1e-6)
    assert group_area(mesh, "base") == pytest.approx(2 * 0.4, abs=1e-9)


def area(mesh, name):
    """Area of a group, whichever way its facets look."""
    return float(np.linalg.norm(vector_areas(mesh, name), axis=1).sum())


def test_reveals_are_jambs_heads_and_sills():
    mesh = mesh_facade(wall((1, 0, 1, 2), (4, 1, 1, 1)))
    assert area(mesh, "reveals") == pytest.approx((5 + 4) * 0.4)  # door: two jambs, a head; window: all round
    assert len(mesh.groups["ledges"]) == 0
    # a closed surface: the areas of all groups add up to nothing
    total = sum(vector_areas(mesh, name).sum(axis=0) for name in mesh.groups)
    np.testing.assert_allclose(total, 0.0, atol=1e-9)


def test_the_underside_of_a_projection_is_no_base():
    outline = np.array([[0, 0], [3, 0], [3, 2], [5, 2], [5, 4], [0, 4]], dtype=float)
    mesh = mesh_facade(wall(outline=outline))
    assert group_area(mesh, "base") == pytest.approx(3 * 0.4)
    assert group_area(mesh, "top") == pytest.approx(5 * 0.4)
    assert group_area(mesh, "right") == pytest.approx(4 * 0.4)


@pytest.mark.parametrize("difference", [0.001, 0.003, 0.01, 0.03, 0.1])
def test_jambs_that_almost_line_up(difference):
    d = difference
    facade = wall(
        (1, 1, 1, 1.5), (1 + d, 4, 1 - d / 2, 1.5 + d), (4 - d, 1 + d, 1.2, 1.5), (4, 4 - d, 1.2, 1.5)
    )
    mesh = mesh_facade(facade)
    quality = mesh_quality(mesh)
    assert quality.min_scaled_jacobian > 0.95
    assert quality.max_aspect < 3.0
    assert_tiles(mesh, facade)
    assert_edges_are_exact(mesh, facade)


def grid(size, shifts, *, rows=2, columns=3):
    """A facade of windows whose edges are off by `shifts`, in fractions of `size`."""
    shifts = np.reshape(shifts, (rows * columns, 4)) * size
    boxes = [
        (1 + 2.25 * column + dx, 1 + 2.75 * row + dz, 1.25 + dw, 1.5 + dh)
        for (row, column), (dx, dz, dw, dh) in zip(np.ndindex(rows, columns), shifts, strict=True)
    ]
    return wall(*boxes)


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from([0.001, 0.003, 0.01, 0.03, 0.1]),
    st.lists(st.floats(-0.5, 0.5, allow_subnormal=False), min_size=24, max_size=24),
    st.sampled_from([0.2, 0.25, 0.4]),
)
def test_random_differences(amplitude, shifts, size):
    facade = grid(amplitude, shifts)
    mesh = mesh_facade(facade, options=MeshOptions(size=size, layers=1))
    assert_tiles(mesh, facade)
    assert mesh_quality(mesh).min_scaled_jacobian > 0.9
    assert mesh_quality(mesh).max_aspect < 3 * 0.4 / size + 6


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.floats(-1.0, 1.0, allow_subnormal=False), min_size=24, max_size=24),
    st.sampled_from([0.15, 0.2, 0.25, 0.4]),
)
def test_millimetres_do_not_change_the_numbers_of_elements(shifts, size):
    options = MeshOptions(size=size, layers=1)
    plain = mesh_facade(grid(0.0, np.zeros(24)), options=options)
    scanned = mesh_facade(grid(0.0005, shifts), options=options)
    assert len(scanned.elements) == len(plain.elements)
    assert np.abs(scanned.nodes - plain.nodes).max() < 0.002


@settings(max_examples=25, deadline=None)
@given(st.randoms(use_true_random=False))
def test_random_windows(random):
    boxes = []
    for _ in range(12):
        box = [
            random.uniform(0.2, 6),
            random.uniform(0.2, 5),
            random.uniform(0.3, 1.6),
            random.uniform(0.3, 1.6),
        ]
        if random.random() < 0.15:
            box[1] = 0
        # apart by at least 20 mm; an opening may pass the edge: such a box is left out
        fits = box[0] + box[2] < 7.9 and box[1] + box[3] < 6.9
        if fits and all(gap(box, other) > 0.02 for other in boxes):
            boxes.append(box)
    facade = wall(*boxes)
    mesh = mesh_facade(facade, options=MeshOptions(size=0.3, layers=1))
    assert mesh_quality(mesh).min_scaled_jacobian >= 0.3
    assert_tiles(mesh, facade)
    assert_edges_are_exact(mesh, facade)


def gap(one, other):
    """Distance between two boxes along the axis that separates them best."""
    return max(max(one[k] - other[k] - other[k + 2], other[k] - one[k] - one[k + 2]) for k in (0, 1))


def test_a_cell_that_clustering_would_fold_is_meshed_finer():
    # a spandrel of 20 mm between windows 100 mm out of line: its shared grid line would lean by 79°
    facade = wall((1, 1, 2, 1), (1.1, 2.02, 2, 1))
    assert mesh_quality(mesh_facade(facade)).min_scaled_jacobian >= 0.3
    relaxed = mesh_facade(facade, options=MeshOptions(min_scaled_jacobian=0.1))
    assert 0.1 < mesh_quality(relaxed).min_scaled_jacobian < 0.3


@pytest.mark.parametrize("count", [1, 2, 4])
def test_elements_across_a_pier(count):
    # 0.3 m of wall between the windows
    mesh = mesh_facade(wall((1, 1, 1, 1), (2.3, 1, 1, 1)), options=MeshOptions(size=0.5, pier_elements=count))
    front = mesh.nodes[np.unique(mesh.groups["front"])]
    row = front[np.abs(front[:, 2] - 1.0) < 1e-9, 0]
    assert ((row > 2.0 + 1e-9) & (row < 2.3 - 1e-9)).sum() == count - 1


def test_a_gable_with_arches():
    openings = (
        Opening(1, OpeningKind.WINDOW, arch(0.8, 1.2, 1.0, 2.0)),
        Opening(2, OpeningKind.DOOR, arch(2.5, 0.0, 1.0, 2.4)),
        opening(3, 4.2, 1.2, 1.0, 1.5),
    )
    facade = Facade(GABLE, 0.4, openings)
    mesh = mesh_facade(facade, options=MeshOptions(size=0.2))
    quality = mesh_quality(mesh)
    assert quality.min_scaled_jacobian > 0.3
    # chords of an arc lie inside it, by at most 0.2 / 50 along two arcs of 1.57 m
    assert 0.0 <= quality.volume - facade.wall_area * 0.4 < 0.2 / 50 * 2 * 1.58 * 0.4
    assert quality.elements < 6000  # chords of 1 mm would make many more
    slopes = 2 * np.hypot(3, 2) * 0.4
    assert np.linalg.norm(vector_areas(mesh, "top"), axis=1).sum() == pytest.approx(slopes, abs=1e-9)
    assert group_area(mesh, "base") == pytest.approx(5 * 0.4, abs=1e-9)
    assert group_area(mesh, "left") == pytest.approx(4 * 0.4, abs=1e-9)
    assert group_area(mesh, "right") == pytest.approx(4 * 0.4, abs=1e-9)
    assert group_area(mesh, "front") == pytest.approx(group_area(mesh, "back"), rel=1e-12)


def test_a_thin_pier_of_a_gable_gets_its_elements():
    facade = wall((1, 1, 1.5, 1), (2.8, 1, 1.5, 1), outline=GABLE)
    mesh = mesh_facade(facade, options=MeshOptions(size=0.5, pier_elements=4, min_scaled_jacobian=0.2))
    front = mesh.nodes[np.unique(mesh.groups["front"])]
    corner = (np.abs(front[:, 2] - 2.0) < 0.5) & (front[:, 0] > 2.5 + 1e-9) & (front[:, 0] < 2.8 - 1e-9)
    assert len(np.unique(front[corner, 0].round(2))) >= 3


def test_slivers_are_refused():
    # a pier of 0.1 mm: two elements of 0.05 mm beside 0.25 m
    with pytest.raises(
        MeshError, match=r"at x = 2\.000, z = .* times longer than wide .* edges of the facade"
    ):
        mesh_facade(wall((1, 1, 1, 1), (2.0001, 1, 1, 1)))


def test_bad_free_elements_are_refused():
    needle = np.array([[0, 0], [6, 0], [6, 4], [0.0, 0.1]], dtype=float)
    with pytest.raises(MeshError, match=r"worst element, at x = .* scaled Jacobian of .* less than 0\.9"):
        mesh_facade(wall(outline=needle), options=MeshOptions(min_scaled_jacobian=0.9))


def test_openings_that_cut_the_wall_in_two():
    outline = np.array([[0, 0], [2, 0], [2, 1], [4, 1], [4, 0], [6, 0], [6, 3], [0, 3]], dtype=float)
    with pytest.raises(InputError):  # the record already refuses what would leave two pieces
        wall((1.5, 0, 3, 2.0), outline=outline)


def test_numbering_is_dense_and_conformal():
    mesh = mesh_facade(wall((1, 1, 1, 1)))
    assert set(np.unique(mesh.elements)) == set(range(len(mesh.nodes)))
    assert len(np.unique(mesh.nodes.round(9), axis=0)) == len(mesh.nodes)
    # Euler: a wall with one window through it is a solid torus, whose surface has V - E + F = 0
    surface = boundary_facets(mesh.elements, mesh.kind, nodes=len(mesh.nodes))
    edges = np.sort(np.stack([surface, np.roll(surface, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert len(np.unique(surface)) - len(np.unique(edges, axis=0)) + len(surface) == 0


@pytest.mark.parametrize("rise", [0.3, 0.6, 0.9])
def test_arched_windows_mesh_at_the_default_size(rise):
    # A round head of 24 chords was refused at 0.25 m; a little finer, it meshes.
    angle = np.linspace(0.0, np.pi, 25)
    openings = []
    for number, x in enumerate((1.0, 3.0, 5.0), start=1):
        head = np.column_stack([x + 0.6 + 0.6 * np.cos(angle), 2.4 + rise * np.sin(angle)])
        ring = np.vstack([[[x, 1.0], [x + 1.2, 1.0]], head])
        openings.append(Opening(number, OpeningKind.WINDOW, ring))
    facade = Facade(rectangle(0, 0, 7.2, 4.6), 0.35, tuple(openings))
    mesh = mesh_facade(facade)
    assert mesh_quality(mesh).min_scaled_jacobian >= 0.3
    assert element_volumes(mesh).sum() == pytest.approx(facade.wall_area * 0.35, rel=2e-3)


def test_the_largest_stand_in_at_a_tenth_of_a_metre():
    facade = stand_in("building3")
    mesh = mesh_facade(facade, options=MeshOptions(size=0.1))
    assert mesh.kind is ElementKind.HEXAHEDRON
    assert vtk_quality(mesh).min() >= 0.9
    assert vtk_quality(mesh, volume=True).sum() == pytest.approx(facade.volume, rel=1e-12)
    assert_fills(mesh, facade)


def test_quadratic_elements_on_request():
    facade = wall((1, 1, 1, 1.5))
    linear, quadratic = (mesh_facade(facade, options=MeshOptions(size=0.4, order=n)) for n in (0, 2))
    assert quadratic.kind is ElementKind.HEXAHEDRON20
    np.testing.assert_array_equal(quadratic.elements[:, :8], linear.elements)
    assert set(quadratic.groups) == set(GROUPS)


def test_tetrahedra_on_request():
    facade = wall((1, 1, 1, 1.5))
    mesh = mesh_facade(facade, options=MeshOptions(size=0.5, elements=ElementShape.TETRAHEDRA))
    assert mesh.kind is ElementKind.TETRA10
    assert element_volumes(mesh).sum() == pytest.approx(facade.volume, rel=1e-9)
