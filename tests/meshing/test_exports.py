import shutil
import subprocess

import gmsh
import meshio
import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.meshing import MESH_SUFFIXES, mesh_facade, mesh_quality, read_mesh, write_mesh
from fd2fem.meshing.session import gmsh_session
from fd2fem.model import GROUPS, ElementKind, Facade, Opening, OpeningKind, VolumeMesh, rectangle

WINDOW = Opening(1, OpeningKind.WINDOW, rectangle(1.0, 1.0 / 3.0, 1.0, 1.1))
WALL = Facade(rectangle(0, 0, np.pi, 2.2), 0.4, (WINDOW,))


@pytest.fixture(scope="module")
def hexahedra():
    return mesh_facade(WALL)


@pytest.fixture(scope="module")
def tetrahedra():
    """Two tetrahedra over a square base."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.3, 0.4, 1 / 3]])
    edges = [(0, 1), (1, 2), (2, 0), (0, 4), (1, 4), (2, 4), (2, 3), (3, 0), (3, 4)]
    number = {frozenset(edge): 5 + k for k, edge in enumerate(edges)}
    nodes = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in edges]])

    def element(a, b, c, d):
        return [a, b, c, d, *(number[frozenset(e)] for e in ((a, b), (b, c), (c, a), (a, d), (b, d), (c, d)))]

    def facet(a, b, c):
        return [a, b, c, number[frozenset((a, b))], number[frozenset((b, c))], number[frozenset((c, a))]]

    return VolumeMesh(
        nodes=nodes,
        elements=np.array([element(0, 1, 2, 4), element(0, 2, 3, 4)]),
        kind=ElementKind.TETRA10,
        groups={"base": np.array([facet(0, 2, 1), facet(0, 3, 2)]), "front": np.array([facet(0, 1, 4)])},
    )


@pytest.fixture(params=["hexahedra", "tetrahedra"])
def mesh(request):
    return request.getfixturevalue(request.param)


def facet_sets(mesh):
    return {name: {tuple(sorted(facet)) for facet in facets.tolist()} for name, facets in mesh.groups.items()}


def test_msh_comes_back(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.msh")
    back = read_mesh(tmp_path / "wall.msh")
    assert back.kind is mesh.kind
    np.testing.assert_allclose(back.nodes, mesh.nodes, atol=1e-15)
    assert np.array_equal(back.elements, mesh.elements)
    assert facet_sets(back) == facet_sets(mesh)
    for name in mesh.groups:
        np.testing.assert_allclose(area(back, name), area(mesh, name), atol=1e-14)


def area(mesh, name):
    """Area vector of a group, from the corners."""
    p = mesh.nodes[mesh.groups[name]]
    if mesh.kind is ElementKind.HEXAHEDRON:
        return np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]).sum(axis=0) / 2
    return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]).sum(axis=0) / 2


@pytest.mark.parametrize("suffix", [".msh", ".med"])
def test_gmsh_reads_the_groups(mesh, tmp_path, suffix):
    write_mesh(mesh, tmp_path / f"wall{suffix}")
    with gmsh_session():
        gmsh.merge(str(tmp_path / f"wall{suffix}"))
        # MED pads names with blanks
        named = {
            gmsh.model.getPhysicalName(d, tag).strip(): (d, tag) for d, tag in gmsh.model.getPhysicalGroups()
        }
        assert set(named) == {*mesh.groups, "wall"}
        for name, facets in mesh.groups.items():
            tags, _ = gmsh.model.mesh.getNodesForPhysicalGroup(*named[name])
            assert len(tags) == len(np.unique(facets))
        entity = gmsh.model.getEntitiesForPhysicalGroup(*named["wall"])[0]
        _, elements, _ = gmsh.model.mesh.getElements(3, entity)
        volumes = gmsh.model.mesh.getElementQualities(elements[0], "volume")
        shape = gmsh.model.mesh.getElementQualities(elements[0], "minSJ")
    # positive in gmsh's eyes, in the order of nodes that each format asks for
    assert volumes.sum() == pytest.approx(mesh_quality(mesh).volume, rel=1e-12)
    assert shape.min() > 0.0


def test_meshio_reads_the_groups_of_msh(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.msh")
    back = meshio.read(tmp_path / "wall.msh")
    assert set(back.field_data) == {*mesh.groups, "wall"}
    for name, facets in mesh.groups.items():
        blocks = [back.cells[k].data[rows] for k, rows in enumerate(back.cell_sets[name]) if len(rows)]
        assert {tuple(sorted(f)) for f in np.vstack(blocks).tolist()} == facet_sets(mesh)[name]
        assert len(np.vstack(blocks)) == len(facets)
    solids = next(block.data for block in back.cells if block.type == mesh.kind.value)
    np.testing.assert_allclose(back.points[solids], mesh.nodes[mesh.elements], atol=1e-15)


def test_vtu_holds_the_groups_as_fields(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.vtu")
    back = meshio.read(tmp_path / "wall.vtu")
    np.testing.assert_array_equal(back.points, mesh.nodes)
    np.testing.assert_array_equal(back.cells_dict[mesh.kind.value], mesh.elements)
    for name in mesh.groups:
        assert np.flatnonzero(back.point_data[name]).tolist() == mesh.group_nodes(name).tolist()


def test_inp_as_meshio_reads_it(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.inp")
    back = meshio.read(tmp_path / "wall.inp")
    np.testing.assert_allclose(back.points, mesh.nodes, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(back.cells_dict[mesh.kind.value], mesh.elements)
    for name in mesh.groups:
        assert sorted(back.point_sets[name.upper()]) == mesh.group_nodes(name).tolist()
    assert len(back.cell_sets["WALL"][0]) == len(mesh.elements)


def test_inp_keeps_to_what_calculix_reads(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.inp")
    for line in (tmp_path / "wall.inp").read_text().splitlines():
        if not line.startswith("*"):
            assert len(line.split(",")) <= 16
            assert all(len(field.strip()) <= 20 for field in line.split(","))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX (Debian: calculix-ccx)")
def test_calculix_carries_the_weight(hexahedra, tmp_path):
    write_mesh(hexahedra, tmp_path / "wall.inp")
    deck = """*INCLUDE, INPUT=wall.inp
*MATERIAL, NAME=MASONRY
*ELASTIC
3e9, 0.2
*DENSITY
1800
*SOLID SECTION, ELSET=WALL, MATERIAL=MASONRY
*BOUNDARY
BASE, 1, 3
*STEP
*STATIC
*DLOAD
WALL, GRAV, 9.81, 0, 0, -1
*NODE PRINT, NSET=BASE, TOTALS=ONLY
RF
*END STEP
"""
    (tmp_path / "run.inp").write_text(deck)
    subprocess.run(["ccx", "run"], cwd=tmp_path, check=True, capture_output=True, timeout=120)
    total = (tmp_path / "run.dat").read_text().split()[-3:]
    # CalculiX takes the load on the fixed nodes off: half the lowest elements, two to the sill at 1/3 m.
    weight = 9.81 * 1800 * (np.pi * 2.2 - 1.1 - np.pi / 6 / 2) * 0.4
    assert float(total[2]) == pytest.approx(weight, rel=1e-5)
    assert max(abs(float(total[0])), abs(float(total[1]))) < 1e-5 * weight


def test_cdb_field_by_field(mesh, tmp_path):
    write_mesh(mesh, tmp_path / "wall.cdb")
    lines = (tmp_path / "wall.cdb").read_text().splitlines()
    assert f"ET,1,{ {'hexahedron': 185, 'tetra10': 187}[mesh.kind.value] }" in lines
    start = lines.index("(3i9,6e20.13)") + 1
    for k, node in enumerate(mesh.nodes):
        line = lines[start + k]
        assert int(line[:9]) == k + 1
        np.testing.assert_allclose(
            [float(line[27 + 20 * c : 47 + 20 * c]) for c in range(3)], node, atol=1e-12
        )
    assert lines[start + len(mesh.nodes)] == "N,R5.3,LOC,       -1,"
    start = lines.index("(19i9)") + 1
    per_element = 2 if mesh.kind is ElementKind.TETRA10 else 1
    for k, element in enumerate(mesh.elements):
        record = "".join(lines[start + per_element * k : start + per_element * (k + 1)])
        fields = [int(record[9 * c : 9 * c + 9]) for c in range(len(record) // 9)]
        assert fields[:11] == [1, 1, 1, 1, 0, 0, 0, 0, mesh.kind.nodes, 0, k + 1]
        assert fields[11:] == (element + 1).tolist()
    assert lines[start + per_element * len(mesh.elements)].strip() == "-1"
    for name in mesh.groups:
        members = mesh.group_nodes(name) + 1
        start = lines.index(f"CMBLOCK,{name.upper()},NODE,{len(members):8d}")
        text = "".join(lines[start + 2 : start + 2 + -(-len(members) // 8)])
        assert [int(text[10 * c : 10 * c + 10]) for c in range(len(members))] == members.tolist()


@pytest.mark.parametrize("name", ["wall.stl", "wall", "wall.msh.gz", "wall.MSH"])
def test_unknown_suffixes(hexahedra, tmp_path, name):
    with pytest.raises(InputError, match=r"the suffix must be one of \.msh, \.vtu, \.inp, \.cdb, \.med"):
        write_mesh(hexahedra, tmp_path / name)


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_a_missing_folder(hexahedra, tmp_path, suffix):
    with pytest.raises(InputError, match=r"There is no folder .*nowhere"):
        write_mesh(hexahedra, tmp_path / "nowhere" / f"wall{suffix}")


def foreign(path, *, name="base", order=1, hexahedra=True, inverted=False):
    """A unit cube by gmsh itself, as another program might have written it."""
    with gmsh_session({"Mesh.MshFileVersion": 2.2 if inverted else 4.1}):
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
@pytest.mark.parametrize("hexahedra", [False, True])
def test_a_mesh_from_elsewhere(tmp_path, inverted, hexahedra):
    order = 1 if hexahedra else 2
    mesh = read_mesh(foreign(tmp_path / "cube.msh", hexahedra=hexahedra, order=order, inverted=inverted))
    assert mesh_quality(mesh).volume == pytest.approx(1.0)
    assert mesh_quality(mesh).min_scaled_jacobian > 0.3
    assert set(mesh.groups) == {"base", "top"}
    np.testing.assert_allclose(area(mesh, "base"), [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(area(mesh, "top"), [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"name": "bottom"}, r"no facets in the physical group 'base' \(it has: top\)"),
        ({"hexahedra": False}, "holds Tetrahedron 4: mesh with 8-node hexahedra alone"),
        ({"order": 2}, "holds Hexahedron 27"),
    ],
)
def test_meshes_that_do_not_fit(tmp_path, options, message):
    path = foreign(tmp_path / "cube.msh", **options)
    with pytest.raises(InputError, match=message):
        read_mesh(path)


def test_facets_inside_the_wall(tmp_path, hexahedra):
    inside = hexahedra.elements[:1, :4]  # between two layers
    mesh = VolumeMesh(
        nodes=hexahedra.nodes, elements=hexahedra.elements, kind=hexahedra.kind, groups={"base": inside}
    )
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
def test_a_torn_file(hexahedra, tmp_path, kept):
    path = tmp_path / "wall.msh"
    write_mesh(hexahedra, path)
    text = path.read_text()
    path.write_text(text[: int(kept * len(text))])
    with pytest.raises(InputError, match=r"wall\.msh"):
        read_mesh(path)


def test_all_groups_of_a_facade_are_written(hexahedra):
    assert set(hexahedra.groups) == set(GROUPS)
