"""Mesh files read back: by our own reader, by gmsh, meshio and VTK."""

import gmsh
import meshio
import numpy as np
import pytest
from exported_meshes import VOLUME, all_kinds, hexahedra, hexahedra20, load_case, options_for
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.meshing import MESH_SUFFIXES, mesh_quality, read_mesh, write_mesh
from fd2fem.meshing.session import gmsh_session
from fd2fem.model import ElementKind, VolumeMesh

KINDS = ["hexahedron", "hexahedron20", "tetra10"]
FACETS = {"hexahedron": "quad", "hexahedron20": "quad8", "tetra10": "triangle6"}


@pytest.fixture(scope="module")
def wall():
    return hexahedra()


@pytest.fixture(params=KINDS)
def mesh(request):
    return all_kinds()[request.param]


def filled(mesh):
    """Groups that have facets: files keep no others."""
    return {name: facets for name, facets in mesh.groups.items() if len(facets)}


def facet_sets(mesh):
    return {
        name: {tuple(sorted(facet)) for facet in facets.tolist()} for name, facets in filled(mesh).items()
    }


def test_msh_comes_back(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.msh")
    back = read_mesh(tmp_path / "wall.msh")
    assert back.kind is mesh.kind
    np.testing.assert_allclose(back.nodes, mesh.nodes, atol=1e-15)
    assert np.array_equal(back.elements, mesh.elements)
    assert facet_sets(back) == facet_sets(mesh)
    for name in filled(mesh):
        np.testing.assert_allclose(area(back, name), area(mesh, name), atol=1e-14)
        if mesh.kind is not ElementKind.HEXAHEDRON:
            check_middles(back, name)


def check_middles(mesh, name):
    """The middles of a facet's edges follow its corners in order."""
    corners = mesh.nodes[mesh.groups[name][:, : mesh.kind.facet_nodes // 2]]
    middles = mesh.nodes[mesh.groups[name][:, mesh.kind.facet_nodes // 2 :]]
    np.testing.assert_allclose(middles, (corners + np.roll(corners, -1, axis=1)) / 2, atol=1e-14)


def area(mesh, name):
    """Area vector of a group, from the corners."""
    p = mesh.nodes[mesh.groups[name]]
    if mesh.kind is ElementKind.TETRA10:
        return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]).sum(axis=0) / 2
    return np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]).sum(axis=0) / 2


@pytest.mark.parametrize("suffix", [".msh", ".med", ".MSH"])
def test_gmsh_reads_the_groups(mesh, tmp_path, suffix):
    write_mesh(mesh, tmp_path / f"wall{suffix}")
    with gmsh_session():
        gmsh.merge(str(tmp_path / f"wall{suffix}"))
        # MED pads names with blanks
        named = {
            gmsh.model.getPhysicalName(d, tag).strip(): (d, tag) for d, tag in gmsh.model.getPhysicalGroups()
        }
        assert set(named) == {*filled(mesh), "wall"}
        for name, facets in filled(mesh).items():
            tags, _ = gmsh.model.mesh.getNodesForPhysicalGroup(*named[name])
            assert len(tags) == len(np.unique(facets))
        entity = gmsh.model.getEntitiesForPhysicalGroup(*named["wall"])[0]
        types, elements, _ = gmsh.model.mesh.getElements(3, entity)
        volumes = gmsh.model.mesh.getElementQualities(elements[0], "volume")
        shape = gmsh.model.mesh.getElementQualities(elements[0], "minSJ")
        # At every integration point of gmsh's own rule: false orders of the mid-edge nodes fold the element.
        points, weights = gmsh.model.mesh.getIntegrationPoints(types[0], "Gauss4")
        _, determinants, _ = gmsh.model.mesh.getJacobians(types[0], points)
    # positive in gmsh's eyes, in the order of nodes that each format asks for
    assert volumes.sum() == pytest.approx(VOLUME, rel=1e-12)
    assert shape.min() > 0.0
    by_point = determinants.reshape(-1, len(weights))
    np.testing.assert_allclose(by_point, np.tile(by_point[:, :1], len(weights)), rtol=1e-9)
    assert (by_point @ weights).sum() == pytest.approx(VOLUME, rel=1e-10)


def test_meshio_reads_the_groups_of_msh(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.msh")
    back = meshio.read(tmp_path / "wall.msh")
    assert set(back.field_data) == {*filled(mesh), "wall"}
    for name, facets in filled(mesh).items():
        blocks = [back.cells[k].data[rows] for k, rows in enumerate(back.cell_sets[name]) if len(rows)]
        assert {tuple(sorted(f)) for f in np.vstack(blocks).tolist()} == facet_sets(mesh)[name]
        assert len(np.vstack(blocks)) == len(facets)
    solids = next(block.data for block in back.cells if block.type == mesh.kind.value)
    np.testing.assert_allclose(back.points[solids], mesh.nodes[mesh.elements], atol=1e-15)


def test_vtu_as_meshio_reads_it(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.vtu")
    back = meshio.read(tmp_path / "wall.vtu")
    np.testing.assert_array_equal(back.points, mesh.nodes)
    assert [block.type for block in back.cells] == [mesh.kind.value, FACETS[mesh.kind.value]]
    np.testing.assert_array_equal(back.cells[0].data, mesh.elements)
    for name, facets in mesh.groups.items():
        assert np.flatnonzero(back.point_data[name]).tolist() == np.unique(facets).tolist()
        on_elements, on_facets = back.cell_data[name]
        assert not on_elements.any()
        np.testing.assert_array_equal(back.cells[1].data[on_facets == 1], facets)


def test_vtu_as_vtk_reads_it(mesh, tmp_path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkThreshold
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    write_mesh(mesh, tmp_path / "wall.vtu")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "wall.vtu"))
    size = vtkCellSizeFilter()
    size.SetInputConnection(reader.GetOutputPort())
    size.Update()
    cells = size.GetOutput().GetCellData()
    volume = vtk_to_numpy(cells.GetArray("Volume"))
    if mesh.kind is not ElementKind.HEXAHEDRON20:  # of which VTK 9.6 finds a twelfth, its own included
        assert volume.sum() == pytest.approx(VOLUME)
        assert volume[: len(mesh.elements)].min() > 0.0
    check_maps(reader.GetOutput(), mesh)
    facet_area = vtk_to_numpy(cells.GetArray("Area"))
    for name in filled(mesh):
        # As a user of ParaView would: the group's cells by a threshold.
        threshold = vtkThreshold()
        threshold.SetInputConnection(size.GetOutputPort())
        threshold.SetInputArrayToProcess(0, 0, 0, 1, name)
        threshold.SetLowerThreshold(1)
        threshold.SetUpperThreshold(1)
        threshold.Update()
        assert threshold.GetOutput().GetNumberOfCells() == len(mesh.groups[name])
        found = facet_area[vtk_to_numpy(cells.GetArray(name)) == 1].sum()
        expected = facet_areas(mesh, name)
        assert found == pytest.approx(expected)


def check_maps(grid, mesh):
    """VTK's quadratic map of each cell is that of its corners alone, so the middles are in their places."""
    from vtkmodules.vtkCommonCore import reference

    assert grid.GetNumberOfCells() == len(mesh.elements) + sum(map(len, mesh.groups.values()))
    a, b, c = place = (0.2, 0.3, 0.4)
    if mesh.kind is ElementKind.TETRA10:
        shares = np.array([1 - a - b - c, a, b, c])
    else:
        level = np.array([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b])
        shares = np.concatenate([(1 - c) * level, c * level])
    for number, element in enumerate(mesh.elements):
        found = [0.0] * 3
        grid.GetCell(number).EvaluateLocation(reference(0), place, found, [0.0] * mesh.kind.nodes)
        assert found == pytest.approx(shares @ mesh.nodes[element[: len(shares)]], abs=1e-12)


def facet_areas(mesh, name):
    corners = mesh.nodes[mesh.groups[name]]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    share = 0.5 if mesh.kind is ElementKind.TETRA10 else 1.0
    return share * np.linalg.norm(cross, axis=1).sum()


def test_inp_as_meshio_reads_it(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.inp", case=load_case(mesh, options_for("linear")))
    back = meshio.read(tmp_path / "wall.inp")
    np.testing.assert_allclose(back.points, mesh.nodes, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(back.cells_dict[mesh.kind.value], mesh.elements)
    for name in filled(mesh):
        assert sorted(back.point_sets[name.upper()]) == mesh.group_nodes(name).tolist()
    assert len(back.cell_sets["WALL"][0]) == len(mesh.elements)


@pytest.mark.parametrize("name", ["wall.stl", "wall", "wall.msh.gz", "wall.MSHX"])
def test_unknown_suffixes(wall, tmp_path, name):
    with pytest.raises(InputError, match=r"the suffix must be one of \.msh, \.vtu, \.inp, \.cdb, \.med"):
        write_mesh(wall, tmp_path / name)


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_a_missing_folder(wall, tmp_path, suffix):
    with pytest.raises(InputError, match=r"There is no folder .*nowhere"):
        write_mesh(wall, tmp_path / "nowhere" / f"wall{suffix}")


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_capitals_in_the_suffix(wall, tmp_path, suffix):
    write_mesh(wall, tmp_path / f"low{suffix}")
    write_mesh(wall, tmp_path / f"HIGH{suffix.upper()}")
    low, high = (tmp_path / f"low{suffix}").read_bytes(), (tmp_path / f"HIGH{suffix.upper()}").read_bytes()
    assert len(low) == len(high)
    if suffix != ".med":  # gmsh's library writes the time into it
        assert low == high


@pytest.mark.parametrize("name", ["", "Wall", "all", "two words", "2nd", "naïve", "a,b", "a" * 25, "BASE"])
def test_names_that_not_all_programs_take(wall, tmp_path, name):
    odd = VolumeMesh(
        wall.nodes, wall.elements, wall.kind, {"base": wall.groups["base"], name: wall.groups["top"]}
    )
    with pytest.raises(InputError, match=f"Cannot write the group '{name}'"):
        write_mesh(odd, tmp_path / "wall.inp")


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
@pytest.mark.parametrize("empty", [True, False])
def test_no_groups_at_all(wall, tmp_path, suffix, empty):
    groups = {name: facets[:0] for name, facets in wall.groups.items()} if empty else {}
    write_mesh(VolumeMesh(wall.nodes, wall.elements, wall.kind, groups), tmp_path / f"wall{suffix}")
    if suffix in (".msh", ".vtu", ".inp"):
        back = meshio.read(tmp_path / f"wall{suffix}")
        assert sum(len(block) for block in back.cells) == len(wall.elements)


def foreign(path, *, name="base", order=1, hexahedra=True, inverted=False, incomplete=False):
    """A unit cube by gmsh itself, as another program might have written it."""
    version = 2.2 if inverted else 4.1
    with gmsh_session({"Mesh.MshFileVersion": version, "Mesh.SecondOrderIncomplete": float(incomplete)}):
        geo = gmsh.model.geo
        corners = [geo.addPoint(x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        sides = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        base = geo.addPlaneSurface([geo.addCurveLoop(sides)])
        for side in sides:
            geo.mesh.setTransfiniteCurve(side, 3)
        geo.mesh.setTransfiniteSurface(base)
        if hexahedra:
            geo.mesh.setRecombine(2, base)
        swept = geo.extrude([(2, base)], 0, 0, 1, numElements=[2], recombine=hexahedra)
        geo.synchronize()
        gmsh.model.addPhysicalGroup(3, [swept[1][1]], name="solid")
        gmsh.model.addPhysicalGroup(2, [base], name=name)
        gmsh.model.addPhysicalGroup(2, [swept[0][1]], name="top")
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        if inverted:
            gmsh.model.mesh.reverse([(3, swept[1][1]), (2, base)])
        gmsh.write(str(path))
    return path


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_mesh_from_elsewhere(tmp_path, inverted, kind):
    options = {
        "hexahedron": {"order": 1},
        "hexahedron20": {"order": 2, "incomplete": True},
        "tetra10": {"order": 2, "hexahedra": False},
    }[kind]
    mesh = read_mesh(foreign(tmp_path / "cube.msh", inverted=inverted, **options))
    assert mesh.kind.value == kind
    assert mesh_quality(mesh).volume == pytest.approx(1.0)
    assert mesh_quality(mesh).min_scaled_jacobian > 0.3
    assert set(mesh.groups) == {"base", "top"}
    np.testing.assert_allclose(area(mesh, "base"), [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(area(mesh, "top"), [0, 0, 1], atol=1e-12)
    if kind == "hexahedron20":
        ends = np.array([0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7])
        middle = mesh.nodes[mesh.elements[:, ends.reshape(-1, 2)]].mean(axis=2)
        np.testing.assert_allclose(mesh.nodes[mesh.elements[:, 8:]], middle, atol=1e-12)
        check_middles(mesh, "base")


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from([".msh", ".MSH"]))
def test_any_numbering_and_place_comes_back(tmp_path_factory, seed, suffix):
    rng = np.random.default_rng(seed)
    mesh = hexahedra20(hexahedra(layers=1))
    number = rng.permutation(len(mesh.nodes))
    nodes = np.empty_like(mesh.nodes)
    nodes[number] = mesh.nodes * rng.uniform(0.1, 30) + rng.uniform(-1e3, 1e3, 3)
    elements = number[mesh.elements[rng.permutation(len(mesh.elements))]]
    groups = {name: number[facets] for name, facets in mesh.groups.items()}
    mixed = VolumeMesh(nodes, elements, mesh.kind, groups)
    path = tmp_path_factory.mktemp("mixed") / f"wall{suffix}"
    write_mesh(mixed, path)
    back = read_mesh(path)
    np.testing.assert_allclose(back.nodes[back.elements], nodes[elements], rtol=1e-15, atol=1e-12)
    assert {n: len(f) for n, f in back.groups.items()} == {n: len(f) for n, f in filled(mixed).items()}
    for name in back.groups:
        np.testing.assert_allclose(area(back, name), area(mixed, name), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"name": "bottom"}, r"no facets in the physical group 'base' \(it has: top\)"),
        ({"hexahedra": False}, "holds Tetrahedron 4: mesh with 8-node hexahedra alone"),
        ({"order": 2}, "holds Hexahedron 27.*SecondOrderIncomplete = 1"),
    ],
)
def test_meshes_that_do_not_fit(tmp_path, options, message):
    path = foreign(tmp_path / "cube.msh", **options)
    with pytest.raises(InputError, match=message):
        read_mesh(path)


def test_facets_inside_the_wall(tmp_path, wall):
    inside = wall.elements[:1, [3, 2, 6, 7]]  # between two layers
    mesh = VolumeMesh(wall.nodes, wall.elements, wall.kind, {"base": inside})
    write_mesh(mesh, tmp_path / "wall.msh")
    with pytest.raises(InputError, match="the group 'base' has facets that are not on the surface"):
        read_mesh(tmp_path / "wall.msh")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("wall.vtu", "", r"the suffix must be \.msh"),
        ("wall.msh", None, "There is no file"),
        ("wall.msh", "", "does not start with"),
        ("wall.msh", 'SystemCall "touch ran";', "does not start with"),
        ("wall.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "holds no volume element"),
        ("wall.msh", "$MeshFormat\nnonsense\n$EndMeshFormat\n", "not a .msh file that gmsh can read"),
    ],
)
def test_files_at_fault(tmp_path, name, text, message):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("kept", [0.1, 0.4, 0.7, 0.95])
def test_a_torn_file(wall, tmp_path, kept):
    path = tmp_path / "wall.msh"
    write_mesh(wall, path)
    text = path.read_text()
    path.write_text(text[: int(kept * len(text))])
    with pytest.raises(InputError, match=r"wall\.msh"):
        read_mesh(path)
