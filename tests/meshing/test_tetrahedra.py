import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError, MeshError
from fd2fem.meshing import MeshOptions, mesh_facade, mesh_quality, mesh_step
from fd2fem.meshing.quality import element_volumes
from fd2fem.meshing.tetrahedra import mesh_facade_tetrahedra
from fd2fem.meshing.topology import boundary_facets
from fd2fem.model import Arc, ElementKind, Facade, Opening, OpeningKind, Storey, facet_arc, rectangle

GABLE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 4.5], [0.0, 3.0]])


def gable(storeys=()):
    door = Opening(1, OpeningKind.DOOR, rectangle(0.6, 0.0, 0.9, 2.0))
    window = Opening(2, OpeningKind.WINDOW, rectangle(2.3, 0.8, 1.0, 1.4))
    return Facade(GABLE, 0.4, (door, window), storeys=storeys)


def arched():
    """A window with a semicircular head."""
    arc = Arc(2, 10, 1.5, 1.5, 0.5, 0.5)
    head = facet_arc(arc, 0.0, np.pi, count=8)
    ring = np.vstack([[[1.0, 0.5], [2.0, 0.5]], head])
    return Facade(rectangle(0, 0, 3, 3), 0.4, (Opening(1, OpeningKind.WINDOW, ring, arcs=(arc,)),))


def box(x, y, z, width, depth, height):
    import cadquery

    return cadquery.Solid.makeBox(width, depth, height, cadquery.Vector(x, y, z))


def prism(ring, thickness):
    import cadquery

    corners = [cadquery.Vector(x, 0, z) for x, z in np.asarray(ring).tolist()]
    wire = cadquery.Wire.makePolygon(corners, close=True)
    return cadquery.Solid.extrudeLinear(wire, [], cadquery.Vector(0, thickness, 0))


def cad(facade):
    """The solid of a facade without curves, by cadquery."""
    import cadquery

    solid = cadquery.Workplane(prism(facade.outline, facade.thickness))
    for opening in facade.openings:
        solid = solid.cut(cadquery.Workplane(prism(opening.outline, facade.thickness)))
    for storey in facade.storeys:
        solid = solid.cut(cadquery.Workplane(box(-1, storey.thickness, storey.z, 99, 9, 99)))
    return solid.val()


def write_iges(shape, path, *, unit, solids):
    """As solids (entity 186), or as faces only (entity 144)."""
    from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer

    IGESControl_Controller.Init_s()
    writer = IGESControl_Writer(unit, 1 if solids else 0)
    writer.AddShape(shape.wrapped)
    writer.ComputeModel()
    writer.Write(str(path))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A wall 3 x 0.4 x 2 m with a window of 1 x 1 m in all formats and several units, and faulty files."""
    import cadquery

    folder = tmp_path_factory.mktemp("step")
    wall = (
        cadquery.Workplane(box(0, 0, 0, 3, 0.4, 2)).cut(cadquery.Workplane(box(1, 0, 0.5, 1, 0.4, 1))).val()
    )
    wall.exportStep(str(folder / "metres.step"), unit="M", outputUnit="M")
    large = wall.scale(1000.0)  # OpenCASCADE works in millimetres
    large.exportStep(str(folder / "millimetres.stp"), unit="MM", outputUnit="MM")
    large.exportStep(str(folder / "inches.step"), unit="MM", outputUnit="IN")
    write_iges(large, folder / "solid.igs", unit="MM", solids=True)
    write_iges(large, folder / "faces.iges", unit="M", solids=False)
    wall.exportBrep(str(folder / "metres.brep"))
    large.exportBrep(str(folder / "millimetres.brep"))
    both = cadquery.Compound.makeCompound([wall, box(3, 0, 0, 1, 0.4, 2)])
    both.exportStep(str(folder / "two.step"), unit="M", outputUnit="M")
    voxels = [box(x, 0, z, 1, 0.4, 1) for x in range(4) for z in range(3) if (x, z) != (1, 1)]
    cadquery.Compound.makeCompound(voxels).exportBrep(str(folder / "voxels.brep"))
    uneven = [*voxels[:-2], box(3, 0, 1, 2, 0.4, 2)]  # touches two voxels, and by a part of its side
    cadquery.Compound.makeCompound(uneven).exportBrep(str(folder / "uneven.brep"))
    sheet = cadquery.Face.makePlane(1, 1)
    sheet.exportStep(str(folder / "sheet.step"), unit="M", outputUnit="M")
    sheet.exportBrep(str(folder / "sheet.brep"))
    write_iges(sheet, folder / "sheet.igs", unit="M", solids=False)
    cadquery.Edge.makeLine(cadquery.Vector(0, 0, 0), cadquery.Vector(1, 0, 0)).exportBrep(
        str(folder / "line.brep")
    )
    for name, whole in (("step", "metres.step"), ("igs", "solid.igs"), ("brep", "metres.brep")):
        (folder / f"nonsense.{name}").write_text("this is no solid\nat all\n")
        (folder / f"empty.{name}").write_text("")
        text = (folder / whole).read_bytes()
        (folder / f"half.{name}").write_bytes(text[: len(text) // 2])
    (folder / "wall.obj").write_text("v 0 0 0\n")
    return folder


def facet_areas(mesh, name):
    """Area vectors of the corner triangles."""
    p = mesh.nodes[mesh.groups[name][:, :3]]
    return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2


def group_areas(mesh):
    """Area of each group that has any, by corner triangles or quadrilaterals."""
    areas = {}
    for name, facets in mesh.groups.items():
        p = mesh.nodes[facets]
        triangle = mesh.kind is ElementKind.TETRA10
        sides = (p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) if triangle else (p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
        areas[name] = np.linalg.norm(np.cross(*sides) / 2, axis=1).sum()
    return {name: area for name, area in areas.items() if area > 0.0}


@pytest.mark.parametrize(
    "name",
    ["metres.step", "millimetres.stp", "inches.step", "solid.igs", "faces.iges", "metres.brep"],
)
def test_a_wall_in_every_format_and_unit(folder, name):
    mesh = mesh_step(folder / name, options=MeshOptions(size=0.5))
    assert mesh.kind is ElementKind.TETRA10
    reach = 1e-7 if name == "inches.step" else 1e-9  # its file has few digits
    np.testing.assert_allclose(mesh.nodes.min(axis=0), [0, 0, 0], atol=reach)
    np.testing.assert_allclose(mesh.nodes.max(axis=0), [3, 0.4, 2], atol=reach)
    assert mesh_quality(mesh).volume == pytest.approx(5 * 0.4, rel=1e-6 if reach > 1e-8 else 1e-9)
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
        assert vectors[:, axis].sum() == pytest.approx(area, rel=1e-6)
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


@pytest.mark.parametrize(
    ("name", "area"), [("two.step", 4 * 2 - 1), ("voxels.brep", 11), ("uneven.brep", 13)]
)
def test_solids_that_touch_are_joined(folder, name, area):
    mesh = mesh_step(folder / name, options=MeshOptions(size=0.4))
    assert mesh_quality(mesh).volume == pytest.approx(area * 0.4, rel=1e-9)
    assert len(np.unique(mesh.nodes.round(9), axis=0)) == len(mesh.nodes)
    assert facet_areas(mesh, "front")[:, 1].sum() == pytest.approx(-area, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing.step", "There is no file .*missing.step"),
        ("wall.obj", "wall.obj is no CAD file that can be read: expected one of .step, .stp"),
        ("nonsense.step", "nonsense.step is not a STEP file"),
        ("nonsense.igs", "nonsense.igs is not an IGES file"),
        ("nonsense.brep", "nonsense.brep is not a BREP file"),
        ("empty.step", "empty.step is empty"),
        ("empty.igs", "empty.igs is empty"),
        ("empty.brep", "empty.brep is empty"),
        ("half.step", "half.step is cut short"),
        ("half.igs", "half.igs is cut short"),
        ("half.brep", "half.brep is cut short"),
        ("sheet.step", "sheet.step holds no solid but faces that do not close"),
        ("sheet.igs", "sheet.igs holds no solid but faces that do not close"),
        ("sheet.brep", "sheet.brep holds no solid but faces that do not close"),
        ("line.brep", "line.brep holds no solid but curves or points only"),
        ("millimetres.brep", "millimetres.brep is 3000 m long: .* export it in metres"),
    ],
)
def test_files_at_fault(folder, name, message, capfd):
    with pytest.raises(InputError, match=message) as raised:
        mesh_step(folder / name)
    assert "\n" not in str(raised.value)
    assert capfd.readouterr().out == ""


def test_bad_tetrahedra_are_refused(folder):
    with pytest.raises(
        MeshError, match=r"worst tetrahedron has a scaled Jacobian of 0\.\d+, less than 0\.495"
    ):
        mesh_step(folder / "metres.step", options=MeshOptions(size=0.9, min_scaled_jacobian=0.99))


@pytest.mark.parametrize("storeys", [(), (Storey(2.6, 0.25),)])
@pytest.mark.parametrize("turn", [0.0, 37.0])
def test_groups_of_an_imported_wall_are_the_facades(tmp_path, storeys, turn):
    import cadquery

    facade = gable(storeys)
    solid = cad(facade).rotate(cadquery.Vector(0, 0, 0), cadquery.Vector(0, 0, 1), turn)
    if turn:
        solid = solid.translate(cadquery.Vector(100.0, -50.0, 12.0))
    solid.scale(1000.0).exportStep(str(tmp_path / "wall.step"), unit="MM", outputUnit="MM")
    mesh = mesh_step(tmp_path / "wall.step", options=MeshOptions(size=0.4))
    hexahedra = mesh_facade(facade, options=MeshOptions(size=0.4))
    np.testing.assert_allclose(mesh.nodes.min(axis=0), 0.0, atol=1e-6)
    np.testing.assert_allclose(mesh.nodes.max(axis=0), [4.0, 0.4, 4.5], atol=1e-6)
    assert group_areas(mesh) == pytest.approx(group_areas(hexahedra), rel=1e-6)
    assert ("ledges" in group_areas(mesh)) == bool(storeys)


def test_a_curved_solid(tmp_path):
    import cadquery

    head = cadquery.Solid.makeCylinder(0.5, 0.4, cadquery.Vector(1.5, 0, 1.5), cadquery.Vector(0, 1, 0))
    wall = cadquery.Workplane(box(0, 0, 0, 3, 0.4, 3)).cut(cadquery.Workplane(box(1, 0, 0.5, 1, 0.4, 1)))
    solid = wall.cut(cadquery.Workplane(head)).val()
    solid.exportBrep(str(tmp_path / "arch.brep"))
    mesh, size = mesh_step(tmp_path / "arch.brep", options=MeshOptions(size=0.3)), 0.3
    quality = mesh_quality(mesh)
    assert quality.min_scaled_jacobian > 0.15
    exact = 0.4 * (9.0 - 1.0 - np.pi / 8.0)
    curved = 0.4 * np.pi * 0.5
    assert exact < quality.volume < exact + curved * size / 50.0  # chords cut into the opening
    head_nodes = mesh.nodes[mesh.group_nodes("reveals")]
    away = np.hypot(head_nodes[:, 0] - 1.5, head_nodes[:, 2] - 1.5)[head_nodes[:, 2] > 1.5 + 1e-9]
    assert away.max() < 0.5 + 1e-9
    assert away.min() > 0.5 - size / 50.0


def closed(mesh):
    """Whether each edge of the surface belongs to two facets that run along it both ways."""
    facets = boundary_facets(mesh.elements, mesh.kind, nodes=len(mesh.nodes))[:, :3]
    edges = np.vstack([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]])
    return set(map(tuple, edges.tolist())) == set(map(tuple, edges[:, ::-1].tolist()))


@pytest.mark.parametrize(
    "facade",
    [gable(), gable((Storey(2.6, 0.25),)), arched(), Facade(rectangle(0, 0, 3, 2), 0.3)],
    ids=["gable", "storeys", "arched", "box"],
)
def test_tetrahedra_of_a_facade_fill_it_and_have_its_groups(facade):
    options = MeshOptions(size=0.3)
    mesh = mesh_facade_tetrahedra(facade, options=options)
    quality = mesh_quality(mesh)
    assert mesh.kind is ElementKind.TETRA10
    assert quality.volume == pytest.approx(facade.volume, rel=1e-6)
    assert quality.min_scaled_jacobian > 0.15
    assert closed(mesh)
    hexahedra = mesh_facade(facade, options=options)
    assert group_areas(mesh) == pytest.approx(group_areas(hexahedra), rel=1e-9)
    for name, facets in mesh.groups.items():
        boundary = boundary_facets(mesh.elements, mesh.kind, nodes=len(mesh.nodes))
        assert set(map(tuple, facets.tolist())) <= set(map(tuple, boundary.tolist())), name


def test_two_tetrahedra_lie_across_a_narrow_pier():
    boxes = [rectangle(0.8, 0.8, 1.0, 1.2), rectangle(2.1, 0.8, 1.0, 1.2)]
    windows = tuple(Opening(k, OpeningKind.WINDOW, box) for k, box in enumerate(boxes, start=1))
    mesh = mesh_facade_tetrahedra(Facade(rectangle(0, 0, 4, 3), 0.3, windows), options=MeshOptions(size=0.4))
    x = mesh.nodes[mesh.elements[:, :4], 0]
    within = (mesh.nodes[mesh.elements[:, :4], 2] > 0.8 - 1e-9).all(axis=1)
    within &= (mesh.nodes[mesh.elements[:, :4], 2] < 2.0 + 1e-9).all(axis=1)
    assert not (within & (x.min(axis=1) < 1.8 + 1e-9) & (x.max(axis=1) > 2.1 - 1e-9)).any()


def test_elements_are_small_at_corners_on_request():
    window = Opening(1, OpeningKind.WINDOW, rectangle(1.5, 1.0, 1.0, 1.0))
    facade = Facade(rectangle(0, 0, 4, 3), 0.3, (window,))
    mesh = mesh_facade_tetrahedra(facade, options=MeshOptions(size=0.3, corner_size=0.08))
    corners = mesh.nodes[mesh.elements[:, :4]]
    at = (np.abs(corners[..., [0, 2]] - [1.5, 2.0]).max(axis=2) < 1e-9).any(axis=1)
    assert at.any()
    size = np.ptp(corners[at][..., [0, 2]], axis=1)
    assert size.max() < 0.15
    assert mesh_quality(mesh).min_scaled_jacobian > 0.15


@settings(max_examples=5, deadline=None)
@given(
    width=st.floats(0.4, 1.6),
    height=st.floats(0.4, 1.6),
    left=st.floats(0.3, 1.2),
    low=st.floats(0.3, 1.0),
    thickness=st.floats(0.2, 0.6),
)
def test_any_window(width, height, left, low, thickness):
    window = Opening(1, OpeningKind.WINDOW, rectangle(left, low, width, height))
    facade = Facade(rectangle(0, 0, 3.2, 3.0), thickness, (window,))
    mesh = mesh_facade_tetrahedra(facade, options=MeshOptions(size=0.4))
    assert mesh_quality(mesh).volume == pytest.approx(facade.volume, rel=1e-6)
    assert group_areas(mesh)["reveals"] == pytest.approx(2 * (width + height) * thickness, rel=1e-5)


def test_iges_is_read_by_a_process_that_has_seen_no_step(tmp_path):
    path = tmp_path / "wall.igs"
    # OpenCASCADE works in millimetres.
    write_iges(box(0, 0, 0, 4000, 500, 3000), path, unit="M", solids=True)
    code = (
        "from pathlib import Path; from fd2fem.meshing import MeshOptions, mesh_quality, mesh_step; "
        f"print(mesh_quality(mesh_step(Path({str(path)!r}), options=MeshOptions(size=0.5))).volume)"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(answer.stdout) == pytest.approx(6.0, rel=1e-9)


def test_solids_that_do_not_touch_are_refused(tmp_path):
    import cadquery

    pair = cadquery.Compound.makeCompound([box(0, 0, 0, 2, 0.4, 3), box(3, 0, 0, 2, 0.4, 3)])
    pair.exportStep(str(tmp_path / "pair.step"), unit="M", outputUnit="M")
    with pytest.raises(InputError, match=r"pair\.step holds 2 solids that do not touch"):
        mesh_step(tmp_path / "pair.step", options=MeshOptions(size=0.5))
