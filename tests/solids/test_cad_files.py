"""STEP, IGES and BREP files, held against closed forms and read by gmsh's own OpenCASCADE."""

import re
from collections import Counter
from getpass import getuser

import arched_walls as walls
import gmsh
import numpy as np
import pytest

from fd2fem.drawings import stand_in
from fd2fem.errors import InputError, NumericsError
from fd2fem.model import Facade, Opening, OpeningKind, Storey, rectangle
from fd2fem.solids import (
    cad_cells,
    cad_wall,
    check_step,
    face_groups,
    solid_from_voxels,
    wall_extent,
    write_brep,
    write_iges,
    write_step,
)

WRITERS = {"step": write_step, "stp": write_step, "iges": write_iges, "igs": write_iges, "brep": write_brep}
PLAIN = Facade(rectangle(0, 0, 2, 3), 0.5)


@pytest.fixture(scope="module")
def plain():
    return cad_wall(PLAIN)


@pytest.fixture(scope="module")
def gmsh_session():
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", "M")
    gmsh.option.setNumber("Geometry.OCCBoundsUseStl", 0)
    yield gmsh
    gmsh.finalize()


def read_by_gmsh(session, path):
    """Volume and extent in metres, and the numbers of volumes and surfaces."""
    session.clear()
    session.model.occ.importShapes(str(path))
    session.model.occ.synchronize()
    volumes = session.model.getEntities(3)
    box = np.array([session.model.occ.getBoundingBox(*volume) for volume in volumes])
    extent = box[:, 3:].max(axis=0) - box[:, :3].min(axis=0)
    volume = sum(session.model.occ.getMass(*volume) for volume in volumes)
    return volume, extent, len(volumes), len(session.model.getEntities(2))


FACADES = {
    "building1": lambda: stand_in("building1"),
    "building2": lambda: stand_in("building2"),
    "building3": lambda: stand_in("building3"),
    "arched": walls.arched,
    "storeys": lambda: walls.arched((Storey(2.1, 0.4), Storey(5.1, 0.3))),
    "gable": walls.curved_gable,
}


@pytest.mark.parametrize("suffix", ["step", "iges", "brep"])
@pytest.mark.parametrize("name", FACADES)
def test_walls_in_other_programs(tmp_path, gmsh_session, name, suffix):
    facade = FACADES[name]()
    solid, path = cad_wall(facade), tmp_path / f"wall.{suffix}"
    WRITERS[suffix](solid, path)
    # IGES has surfaces along whole ellipses as splines, which are exact to 1e-7 only.
    exact = 1e-7 if suffix == "iges" else 1e-9
    report = check_step(path, volume=facade.volume, extent=wall_extent(facade))
    assert (report.valid, report.solids, report.faces) == (True, 1, len(solid.Faces()))
    assert report.volume == pytest.approx(facade.volume, rel=exact)
    assert report.extent == pytest.approx(
        wall_extent(facade).tolist(), abs=1e-9 if suffix != "iges" else 1e-6
    )
    volume, extent, volumes, surfaces = read_by_gmsh(gmsh_session, path)
    assert volume == pytest.approx(facade.volume, rel=exact)
    # gmsh widens boxes by the tolerance.
    assert extent == pytest.approx(wall_extent(facade), abs=3e-7 if suffix != "iges" else 3e-6)
    assert (volumes, surfaces) == (1, len(solid.Faces()))


def test_cells_are_conformal_in_gmsh(tmp_path, gmsh_session, make_voxels):
    boxes = [(0, 0, 1, 1), (1, 0, 2, 1), (0, 1, 1, 2), (1, 1, 2, 2)]
    cells = cad_cells(solid_from_voxels(make_voxels(boxes, 0.3)))
    write_brep(cells, tmp_path / "cells.brep")
    volume, extent, volumes, surfaces = read_by_gmsh(gmsh_session, tmp_path / "cells.brep")
    assert (volumes, surfaces) == (4, 4 * 2 + 8 + 4)
    assert volume == pytest.approx(1.2, rel=1e-9)
    assert extent == pytest.approx([2, 0.3, 2], abs=3e-7)
    report = check_step(tmp_path / "cells.brep", volume=1.2, extent=(2, 0.3, 2), solids=4)
    assert report.faces == 20


def test_cells_in_one_step_product(tmp_path, gmsh_session, make_voxels):
    cells = cad_cells(solid_from_voxels(make_voxels([(0, 0, 1, 1), (1, 0, 2, 1)], 0.3)))
    path = tmp_path / "cells.step"
    write_step(cells, path, name="wall", faces=face_groups(cells, Facade(rectangle(0, 0, 2, 1), 0.3)))
    text = path.read_text()
    assert re.findall(r" PRODUCT\('([^']*)'", text) == ["wall"]
    assert re.findall(r"MANIFOLD_SOLID_BREP\('([^']*)'", text) == ["wall 1", "wall 2"]
    names = Counter(re.findall(r"ADVANCED_FACE\('([^']*)'", text))
    # In STEP every solid has faces of its own, so that the one between them, unnamed, is there twice.
    assert names == {"front": 2, "back": 2, "base": 2, "top": 2, "left": 1, "right": 1, "": 2}
    assert read_by_gmsh(gmsh_session, path)[2:] == (2, 12)
    check_step(path, volume=0.6, extent=(2, 0.3, 1), solids=2)
    with pytest.raises(NumericsError, match="reads back with 2 solids in it, expected 1"):
        check_step(path, volume=0.6, extent=(2, 0.3, 1))


def test_step_declares_metres_and_its_name(tmp_path, plain):
    write_step(plain, tmp_path / "a.step", name="north wall")
    text = (tmp_path / "a.step").read_text()
    assert re.findall(r"LENGTH_UNIT\(\) NAMED_UNIT\(\*\) (SI_UNIT\([^)]*\))", text) == ["SI_UNIT($,.METRE.)"]
    assert ".MILLI." not in text
    assert "AUTOMOTIVE_DESIGN { 1 0 10303 214" in text
    assert re.findall(r" PRODUCT\('([^']*)','([^']*)'", text) == [("north wall", "north wall")]
    assert re.findall(r"MANIFOLD_SOLID_BREP\('([^']*)'", text) == ["north wall"]
    corners = re.findall(r"CARTESIAN_POINT\('',\(([^)]*)\)\)", text)
    assert max(float(v) for corner in corners for v in corner.split(",")) == 3.0


def test_iges_declares_metres(tmp_path, plain):
    write_iges(plain, tmp_path / "a.iges")
    lines = (tmp_path / "a.iges").read_text().splitlines()
    section = "".join(line[:72].strip() for line in lines if line[72] == "G")
    # Parameters 14 and 15 of the global section (IGES 5.3, 2.2.4.3): unit flag 6 and its name, metres.
    assert ",6,1HM," in section
    kinds = Counter(line[:8].strip() for line in lines if line[72] == "D")
    assert kinds["186"] == 2  # one manifold solid, two lines for each entity
    assert kinds["510"] == 2 * 6
    assert f"{len(getuser())}H{getuser()}" not in section


def test_step_faces_are_named_by_group(tmp_path):
    facade = walls.arched((Storey(5.0, 0.4),))
    solid = cad_wall(facade)
    groups = face_groups(solid, facade)
    write_step(solid, tmp_path / "a.step", faces=groups)
    names = Counter(re.findall(r"ADVANCED_FACE\('([^']*)'", (tmp_path / "a.step").read_text()))
    assert names == Counter(str(group) for group in groups)
    assert set(names) == {"base", "front", "back", "left", "right", "top", "reveals", "ledges"}


def test_names_stay_with_their_faces_in_another_reader(tmp_path):
    """OpenCASCADE's document reader, which knows names of faces, against where they lie."""
    from cadquery import Face
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_LabelSequence
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    facade = Facade(rectangle(0, 0, 4, 6), 0.5, storeys=(Storey(3.0, 0.3),))
    solid = cad_wall(facade)
    write_step(solid, tmp_path / "a.step", faces=face_groups(solid, facade))
    document, reader = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF")), STEPCAFControl_Reader()
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    before = Interface_Static.IVal_s("read.stepcaf.subshapes.name")
    Interface_Static.SetIVal_s("read.stepcaf.subshapes.name", 1)
    try:
        reader.SetNameMode(True)
        reader.ReadFile(str(tmp_path / "a.step"))
        reader.Transfer(document)
    finally:
        Interface_Static.SetIVal_s("read.stepcaf.subshapes.name", before)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots, parts = TDF_LabelSequence(), TDF_LabelSequence()
    tool.GetFreeShapes(roots)
    tool.GetSubShapes_s(roots.Value(1), parts)
    found = []
    for number in range(1, parts.Length() + 1):
        shape, name = tool.GetShape_s(parts.Value(number)), TDataStd_Name()
        if parts.Value(number).FindAttribute(TDataStd_Name.GetID_s(), name):
            normal = Face(shape).normalAt()
            axis = max(range(3), key=lambda k, n=normal: abs(n.toTuple()[k]))
            found.append((name.Get().ToExtString(), axis, round(normal.toTuple()[axis])))
    assert sorted(found) == sorted(
        [
            ("front", 1, -1),
            ("back", 1, 1),
            ("back", 1, 1),
            ("left", 0, -1),
            ("right", 0, 1),
            ("base", 2, -1),
            ("top", 2, 1),
            ("ledges", 2, 1),
        ]
    )


def test_names_for_other_faces_are_refused(tmp_path, plain):
    with pytest.raises(InputError, match="2 names for 6 faces"):
        write_step(plain, tmp_path / "a.step", faces=["front", "back"])


def test_second_file_is_named_like_the_first(tmp_path, plain):
    for name in ("a", "b"):
        write_step(plain, tmp_path / f"{name}.step")
        assert "PRODUCT('facade','facade'" in (tmp_path / f"{name}.step").read_text()


def test_opencascade_prints_nothing_and_keeps_its_settings(tmp_path, plain, capfd):
    from OCP.Interface import Interface_Static
    from OCP.Message import Message

    texts = {"xstep.cascade.unit": "MM", "write.iges.unit": "MM", "write.step.unit": "MM"}
    for name, value in texts.items():
        Interface_Static.SetCVal_s(name, value)
    assembly = Interface_Static.IVal_s("write.step.assembly")
    for suffix, write in WRITERS.items():
        write(plain, tmp_path / f"a.{suffix}")
        check_step(tmp_path / f"a.{suffix}", volume=3.0, extent=(2, 0.5, 3))
        (tmp_path / f"bad.{suffix}").write_text("hello\n")
        with pytest.raises(InputError, match=rf"bad\.{suffix} "):
            check_step(tmp_path / f"bad.{suffix}", volume=3.0, extent=(2, 0.5, 3))
    assert capfd.readouterr() == ("", "")
    assert {name: Interface_Static.CVal_s(name) for name in texts} == texts
    assert Interface_Static.IVal_s("write.step.assembly") == assembly
    assert len(list(Message.DefaultMessenger_s().Printers())) > 0


@pytest.mark.parametrize("suffix", ["step", "iges", "brep"])
def test_unwritable_path(tmp_path, plain, suffix):
    with pytest.raises(NumericsError, match="could not be written"):
        WRITERS[suffix](plain, tmp_path / "none" / f"a.{suffix}")


def test_openings_of_voxels_and_walls_agree(make_facade_voxels):
    """The two forms have one volume."""
    window = Opening(1, OpeningKind.WINDOW, rectangle(1.1, 0.9, 1.2, 1.3))
    facade = Facade(rectangle(0, 0, 3, 4), 0.35, (window,))
    cells = cad_cells(solid_from_voxels(make_facade_voxels(facade)))
    assert cells.isValid()
    assert cells.Volume() == pytest.approx(cad_wall(facade).Volume(), rel=1e-12)


def test_cadquery_imports_millimetres(tmp_path, plain):
    """Its importer works in millimetres, and so finds 1e9 times the number of cubic metres."""
    from cadquery import importers

    write_step(plain, tmp_path / "a.step")
    imported = importers.importStep(str(tmp_path / "a.step")).val()
    assert imported.Volume() == pytest.approx(3.0e9, rel=1e-9)
    assert imported.isValid()
