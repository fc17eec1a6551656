import gmsh
import numpy as np
import pytest

from fd2fem.meshing import MeshOptions, mesh_facade, mesh_quality
from fd2fem.meshing.quality import element_aspects, element_volumes, scaled_jacobians
from fd2fem.meshing.session import gmsh_session
from fd2fem.meshing.topology import boundary_facets
from fd2fem.model import ElementKind, Facade, VolumeMesh, rectangle
from fd2fem.model.topology import EDGES, FACETS

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
)
REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
MIDDLES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def hexahedron(nodes):
    return VolumeMesh(nodes=nodes, elements=np.arange(8)[None], kind=ElementKind.HEXAHEDRON, groups={})


def tetrahedron(corners):
    middles = [(corners[i] + corners[j]) / 2 for i, j in MIDDLES]
    nodes = np.vstack([corners, middles])
    return VolumeMesh(nodes=nodes, elements=np.arange(10)[None], kind=ElementKind.TETRA10, groups={})


def test_a_sheared_brick_by_hand():
    shear = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 1.0]])  # z edges lean by 45°
    mesh = hexahedron(CUBE @ shear)
    assert scaled_jacobians(mesh) == pytest.approx([np.sqrt(0.5)], rel=1e-14)
    assert element_volumes(mesh) == pytest.approx([2.0], rel=1e-14)
    assert element_aspects(mesh) == pytest.approx([2.0], rel=1e-14)


def test_the_volume_of_a_frustum():
    # base 2 x 2, top 1 x 1, height 3: h / 3 (A1 + A2 + sqrt(A1 A2)) = 7
    nodes = (CUBE - [0.5, 0.5, 0.0]) * [2.0, 2.0, 3.0]
    nodes[4:, :2] /= 2.0
    assert element_volumes(hexahedron(nodes)) == pytest.approx([7.0], rel=1e-14)


def test_an_inverted_brick_is_negative():
    mesh = hexahedron(CUBE[[4, 5, 6, 7, 0, 1, 2, 3]])
    assert scaled_jacobians(mesh)[0] == pytest.approx(-1.0)
    assert element_volumes(mesh)[0] == pytest.approx(-1.0)


def test_a_regular_tetrahedron():
    mesh = tetrahedron(REGULAR[[0, 2, 1, 3]])  # edge 2 √2: volume edge³ / (6 √2)
    assert scaled_jacobians(mesh) == pytest.approx([1.0], rel=1e-14)
    assert element_volumes(mesh) == pytest.approx([8.0 / 3.0], rel=1e-14)
    assert element_aspects(mesh) == pytest.approx([1.0], rel=1e-14)


def hexahedron20(bend):
    """A unit cube with the middles of its edges, then moved by `bend`."""
    middles = CUBE[np.array(EDGES[ElementKind.HEXAHEDRON20])].mean(axis=1)
    nodes = bend(np.vstack([CUBE, middles]))
    return VolumeMesh(nodes=nodes, elements=np.arange(20)[None], kind=ElementKind.HEXAHEDRON20, groups={})


def test_the_volume_of_curved_bricks():
    def shear(p):  # volume 1
        return p + np.column_stack([0.3 * p[:, 1] * (1 - p[:, 1]), p[:, 0] * 0, p[:, 0] ** 2])

    def bulge(p):  # the height is 1 + x (1 - x): volume 1 + 1 / 6
        return p * np.column_stack([np.ones((len(p), 2)), 1 + p[:, 0] * (1 - p[:, 0])])

    assert element_volumes(hexahedron20(shear)) == pytest.approx([1.0], rel=1e-14)
    assert element_volumes(hexahedron20(bulge)) == pytest.approx([7.0 / 6.0], rel=1e-14)


def test_quadratic_bricks_are_judged_by_their_corners():
    shear = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 1.0]])
    mesh = hexahedron20(lambda p: p @ shear)
    assert scaled_jacobians(mesh) == pytest.approx([np.sqrt(0.5)], rel=1e-14)
    assert element_aspects(mesh) == pytest.approx([2.0], rel=1e-14)


def vtk_cell(kind):
    from vtkmodules.vtkCommonDataModel import vtkHexahedron, vtkQuadraticHexahedron, vtkQuadraticTetra

    cells = {
        "hexahedron": vtkHexahedron,
        "hexahedron20": vtkQuadraticHexahedron,
        "tetra10": vtkQuadraticTetra,
    }
    cell = cells[kind.value]()
    for k in range(kind.nodes):
        cell.GetPointIds().SetId(k, k)
    return cell


def ids(part):
    return [part.GetPointId(k) for k in range(part.GetNumberOfPoints())]


@pytest.mark.parametrize("kind", ElementKind)
def test_facets_and_edges_are_those_of_vtk(kind):
    cell = vtk_cell(kind)
    theirs = {frozenset(ids(cell.GetFace(k))) for k in range(cell.GetNumberOfFaces())}
    assert {frozenset(facet) for facet in FACETS[kind]} == theirs
    theirs = {frozenset(ids(cell.GetEdge(k))) for k in range(cell.GetNumberOfEdges())}
    quadratic = kind is not ElementKind.HEXAHEDRON
    corners = 4 if kind is ElementKind.TETRA10 else 8
    ours = [(*edge, corners + k) if quadratic else edge for k, edge in enumerate(EDGES[kind])]
    assert {frozenset(edge) for edge in ours} == theirs


def test_facets_of_a_quadratic_brick_look_outwards_and_have_their_middles_in_order():
    mesh = hexahedron20(lambda p: p)
    facets = boundary_facets(mesh.elements, mesh.kind, nodes=20)
    assert facets.shape == (6, 8)
    p = mesh.nodes[facets]
    np.testing.assert_array_equal(p[:, 4:], (p[:, :4] + np.roll(p[:, :4], -1, axis=1)) / 2)
    area = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) / 2
    outward = p[:, :4].mean(axis=1) - 0.5
    np.testing.assert_allclose(area, 2 * outward, atol=1e-15)


def vtk_scaled_jacobians(mesh):
    """The same by VTK's Verdict."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, VTK_TETRA, vtkUnstructuredGrid
    from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.array(mesh.nodes), deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    hexahedra = mesh.kind is not ElementKind.TETRA10
    for element in mesh.elements[:, : 8 if hexahedra else 4]:
        grid.InsertNextCell(VTK_HEXAHEDRON if hexahedra else VTK_TETRA, len(element), element.tolist())
    quality = vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetHexQualityMeasureToScaledJacobian()
    quality.SetTetQualityMeasureToScaledJacobian()
    quality.Update()
    return vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))


@pytest.mark.parametrize("seed", range(3))
def test_hexahedra_as_verdict_and_gmsh_have_them(seed):
    rng = np.random.default_rng(seed)
    nodes = np.vstack([CUBE + rng.uniform(-0.2, 0.2, CUBE.shape) + [2 * k, 0, 0] for k in range(50)])
    elements = np.arange(400).reshape(50, 8)
    mesh = VolumeMesh(nodes=nodes, elements=elements, kind=ElementKind.HEXAHEDRON, groups={})
    # Verdict also looks at the centre, which never is the worst place here.
    np.testing.assert_allclose(scaled_jacobians(mesh), vtk_scaled_jacobians(mesh), atol=1e-12)
    with gmsh_session():
        gmsh.model.addDiscreteEntity(3, 1)
        gmsh.model.mesh.addNodes(3, 1, np.arange(1, 401), nodes.ravel())
        gmsh.model.mesh.addElementsByType(1, 5, np.arange(1, 51), elements.ravel() + 1)
        volume = gmsh.model.mesh.getElementQualities(np.arange(1, 51), "volume")
    np.testing.assert_allclose(element_volumes(mesh), volume, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_tetrahedra_as_verdict_has_them(seed):
    rng = np.random.default_rng(seed)
    meshes = [tetrahedron(REGULAR[[0, 2, 1, 3]] + rng.uniform(-0.5, 0.5, (4, 3))) for _ in range(20)]
    for mesh in meshes:
        np.testing.assert_allclose(scaled_jacobians(mesh), vtk_scaled_jacobians(mesh), atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_quadratic_hexahedra_as_verdict_has_them(seed):
    rng = np.random.default_rng(seed)
    for _ in range(10):
        matrix = np.eye(3) + rng.uniform(-0.4, 0.4, (3, 3))
        mesh = hexahedron20(lambda p, m=matrix: p @ m)
        np.testing.assert_allclose(scaled_jacobians(mesh), vtk_scaled_jacobians(mesh), atol=1e-12)
        assert element_volumes(mesh) == pytest.approx([np.linalg.det(matrix)], rel=1e-12)


def test_summary_of_a_facade():
    quality = mesh_quality(
        mesh_facade(Facade(outline=rectangle(0, 0, 3, 2), thickness=0.25), options=MeshOptions(size=0.25))
    )
    assert (quality.elements, quality.nodes) == (12 * 8, 13 * 9 * 2)
    assert quality.min_scaled_jacobian == pytest.approx(1.0)
    assert quality.mean_scaled_jacobian == pytest.approx(1.0)
    assert quality.max_aspect == pytest.approx(1.0)
    assert quality.volume == pytest.approx(1.5)
