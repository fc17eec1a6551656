import numpy as np
import pytest

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing import MeshOptions, mesh_quality, mesh_step
from fd2fem.meshing.quality import element_volumes
from fd2fem.model import ElementKind


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """STEP files by cadquery: a wall 3 x 0.4 x 2 m with a window of 1 x 1 m, in metres and millimetres."""
    import cadquery

    folder = tmp_path_factory.mktemp("step")
    box = {"centered": (False, False, False)}
    window = cadquery.Workplane("XY").box(1, 0.4, 1, **box).translate((1, 0, 0.5))
    wall = cadquery.Workplane("XY").box(3, 0.4, 2, **box).cut(window)
    wall.val().exportStep(str(folder / "metres.step"), unit="M", outputUnit="M")
    scaled = wall.val().scale(1000.0)
    scaled.exportStep(str(folder / "millimetres.step"), unit="MM", outputUnit="MM")
    right = cadquery.Workplane("XY").box(1, 0.4, 2, **box).translate((3, 0, 0))
    both = cadquery.Compound.makeCompound([wall.val(), right.val()])
    both.exportStep(str(folder / "two.step"), unit="M", outputUnit="M")
    sheet = cadquery.Face.makePlane(1, 1)
    sheet.exportStep(str(folder / "sheet.step"), unit="M", outputUnit="M")
    (folder / "nonsense.step").write_text("this is no STEP file\n")
    return folder


def facet_areas(mesh, name):
    """Area vectors of the corner triangles."""
    p = mesh.nodes[mesh.groups[name][:, :3]]
    return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2


@pytest.mark.parametrize("name", ["metres.step", "millimetres.step"])
def test_a_wall_in_either_unit(folder, name):
    mesh = mesh_step(folder / name, options=MeshOptions(size=0.3))
    assert mesh.kind is ElementKind.TETRA10
    np.testing.assert_allclose(mesh.nodes.min(axis=0), [0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(mesh.nodes.max(axis=0), [3, 0.4, 2], atol=1e-9)
    assert mesh_quality(mesh).volume == pytest.approx(5 * 0.4, rel=1e-9)
    assert (element_volumes(mesh) > 0.0).all()
    areas = {
        "base": (2, -1.2),
        "top": (2, 1.2),
        "left": (0, -0.8),
        "right": (0, 0.8),
        "front": (1, -5),
        "back": (1, 5),
    }
    for group, (axis, area) in areas.items():
        vectors = facet_areas(mesh, group)
        assert vectors[:, axis].sum() == pytest.approx(area, rel=1e-9)
        assert (vectors[:, axis] * area > 0.0).all()


def test_middle_nodes_lie_midway(folder):
    mesh = mesh_step(folder / "metres.step", options=MeshOptions(size=0.5))
    for middle, (start, end) in enumerate([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)], start=4):
        element = mesh.nodes[mesh.elements]
        np.testing.assert_allclose(element[:, middle], (element[:, start] + element[:, end]) / 2, atol=1e-12)
    for facets in mesh.groups.values():
        facet = mesh.nodes[facets]
        for middle, (start, end) in enumerate([(0, 1), (1, 2), (2, 0)], start=3):
            np.testing.assert_allclose(facet[:, middle], (facet[:, start] + facet[:, end]) / 2, atol=1e-12)


def test_solids_that_touch_are_joined(folder):
    mesh = mesh_step(folder / "two.step", options=MeshOptions(size=0.4))
    assert mesh_quality(mesh).volume == pytest.approx((4 * 2 - 1) * 0.4, rel=1e-9)
    assert len(np.unique(mesh.nodes.round(9), axis=0)) == len(mesh.nodes)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing.step", "There is no file .*missing.step"),
        ("nonsense.step", "nonsense.step is not a STEP file that can be read"),
        ("sheet.step", "sheet.step holds no solid"),
    ],
)
def test_files_at_fault(folder, name, message):
    with pytest.raises(InputError, match=message):
        mesh_step(folder / name)


def test_bad_tetrahedra_are_refused(folder):
    with pytest.raises(
        MeshError, match=r"worst tetrahedron has a scaled Jacobian of 0\.\d+, less than 0\.495"
    ):
        mesh_step(folder / "metres.step", options=MeshOptions(size=0.5, min_scaled_jacobian=0.99))
