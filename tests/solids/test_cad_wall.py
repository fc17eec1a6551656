"""The merged wall, held against closed forms, shapely and OpenCASCADE's own checker."""

import arched_walls as walls
import numpy as np
import pytest
import shapely
from arched_walls import DOOR, WINDOW, headed, oval
from hypothesis import assume, given, settings

from fd2fem.drawings import stand_in
from fd2fem.errors import InputError, NumericsError
from fd2fem.model import Facade, Opening, Storey, rectangle
from fd2fem.solids.cad import cad_wall, wall_extent
from fd2fem.solids.rims import wall_rims


def region(facade):
    """The front as a polygon."""
    openings = shapely.union_all([shapely.Polygon(o.outline) for o in facade.openings])
    return shapely.Polygon(facade.outline).difference(openings)


def expected_faces(facade, edges):
    """Front, one face for each edge, back pieces of each band, ledges: from polygons alone."""
    front, right = region(facade), facade.length + 1.0
    backs = ledges = 0
    for band in facade.bands:
        parts = shapely.get_parts(front.intersection(shapely.box(-1.0, band.low, right, band.high)))
        backs += sum(part.area > 1e-9 for part in parts)
    for storey in facade.storeys:
        beside = []
        for z in (storey.z - 1e-5, storey.z + 1e-5):
            line = front.intersection(shapely.LineString([(-1.0, z), (right, z)]))
            spans = [shapely.get_coordinates(part)[:, 0] for part in shapely.get_parts(line)]
            beside.append(
                shapely.union_all([shapely.LineString([(x.min(), 0), (x.max(), 0)]) for x in spans])
            )
        both = shapely.get_parts(beside[0].intersection(beside[1]))
        ledges += sum(part.length > 1e-3 for part in both)
    return 1 + edges + backs + ledges


def check(facade, edges):
    solid = cad_wall(facade)
    assert solid.isValid()
    assert len(solid.Solids()) == 1
    assert solid.Volume() == pytest.approx(facade.volume, rel=1e-12)
    assert len(solid.Faces()) == expected_faces(facade, edges)
    box = solid.BoundingBox()
    assert (box.xmin, box.ymin, box.zmin) == pytest.approx((0, 0, 0), abs=1e-9)
    assert wall_extent(facade) == pytest.approx([box.xlen, box.ylen, box.zlen], abs=1e-9)
    return solid


@pytest.mark.parametrize(
    ("name", "doors", "windows"), [("building1", 1, 3), ("building2", 1, 7), ("building3", 2, 26)]
)
def test_stand_ins(name, doors, windows):
    facade = stand_in(name)
    kinds = [o.kind for o in facade.openings]
    assert (kinds.count(DOOR), kinds.count(WINDOW)) == (doors, windows)
    # A door's notch has three sides and parts the ground in two.
    solid = check(facade, edges=4 + 4 * doors + 4 * windows)
    assert len(solid.Faces()) == 2 + 4 + 4 * doors + 4 * windows


def test_arched_facade_has_true_curves():
    """Closed forms: the segment of radius r and half angle t has the area r² (t - sin t cos t)."""
    segments = 0.0
    for half, rise in ((0.5, 0.2), (0.5, 0.5), (0.5, 0.5)):
        radius = (half**2 + rise**2) / (2 * rise)
        t = np.arccos((radius - rise) / radius)
        segments += radius**2 * (t - np.sin(t) * np.cos(t))
    for half, rise in ((0.5, 1.0), (0.3, 0.9)):
        # Pointed: each side is the segment between a centre on the springing and the axis.
        radius = (half**2 + rise**2) / (2 * half)
        t = np.arctan2(rise, radius - half)
        segments += radius**2 * t - (radius - half) * rise
    curved = segments + np.pi * 0.7 * 0.3 / 2 + np.pi * (0.6 * 0.6 + 0.4 * 0.6 + 0.6 * 0.4)
    straight = 3 * 1.0 + 1.4 * 1.0 + 1.0 * 2.0 + 0.6 * 2.0 + 0.8 * 1.25
    area = 11 * 7 - curved - straight
    # Windows: 4, 4, 5, 4, 5 edges and three ovals of one; doors: 2 jambs, head of 1 or 2, ground in two.
    edges = 4 + (4 + 4 + 5 + 4 + 5) + 3 + (3 + 1) + (4 + 1)
    for tolerance in (1e-3, 0.02):
        facade = walls.arched(tolerance=tolerance)
        solid = check(facade, edges)
        assert solid.Volume() == pytest.approx(0.5 * area, rel=1e-12)
        kinds = [face.geomType() for face in solid.Faces()]
        assert kinds.count("CYLINDER") == 3 + 4 + 1
        assert kinds.count("EXTRUSION") == 3
        assert {edge.geomType() for edge in solid.Edges()} == {"LINE", "CIRCLE", "ELLIPSE"}


def test_arches_of_storeys_are_exact():
    """A round window of radius 1 whose lower half lies in the thicker storey."""
    for lower, upper in ((0.5, 0.3), (0.3, 0.5)):
        facade = Facade(
            rectangle(0, 0, 4, 6), lower, (oval(2, 3, 1, 1, 0.05),), storeys=(Storey(3.0, upper),)
        )
        solid = check(facade, edges=5)
        assert solid.Volume() == pytest.approx((12 - np.pi / 2) * (lower + upper), rel=1e-12)
        assert solid.isInside((0.5, 0.4, 1.0)) is (lower > 0.4)
        assert solid.isInside((0.5, 0.4, 5.0)) is (upper > 0.4)
        assert not solid.isInside((2.0, 0.1, 3.0))


def test_a_level_through_a_circle_at_any_height():
    """The part of a unit disc above the height h is arccos h - h sqrt(1 - h²)."""
    for h in (-0.99, -0.3, 0.123456, 0.9999):
        above = np.arccos(h) - h * np.sqrt(1 - h * h)
        facade = Facade(
            rectangle(0, 0, 4, 6), 0.5, (oval(2, 3, 1, 1, 0.01),), storeys=(Storey(3.0 + h, 0.3),)
        )
        volume = 0.5 * (4 * (3 + h) - (np.pi - above)) + 0.3 * (4 * (3 - h) - above)
        assert check(facade, edges=5).Volume() == pytest.approx(volume, rel=1e-12)


def test_storeys_step_the_back_and_leave_the_front_flush():
    facade = Facade(rectangle(0, 0, 4, 9), 0.5, storeys=(Storey(3.0, 0.4), Storey(6.0, 0.45)))
    solid = check(facade, edges=4)
    assert len(solid.Faces()) == 1 + 4 + 3 + 2
    assert solid.Volume() == pytest.approx(4 * 3 * (0.5 + 0.4 + 0.45), rel=1e-12)
    areas = sorted(face.Area() for face in solid.Faces() if abs(face.normalAt().y) > 0.9)
    assert areas == pytest.approx([12, 12, 12, 36])


def test_sills_and_heads_at_the_level_of_a_storey():
    sill = Opening(1, WINDOW, rectangle(1, 3, 1, 1.5))
    head = Opening(2, WINDOW, rectangle(3, 1.5, 1, 1.5))
    facade = Facade(rectangle(0, 0, 5, 6), 0.5, (sill, head), storeys=(Storey(3.0, 0.3),))
    solid = check(facade, edges=12)
    # The sill is as deep as the wall below it, the head as deep as the wall above it.
    level = {
        round(f.Area(), 9)
        for f in solid.Faces()
        if abs(f.normalAt().z) > 0.9 and abs(f.Center().z - 3.0) < 1e-9
    }
    assert level == {0.5, 0.3, 0.2}


def test_storeys_of_one_thickness_are_none():
    facade = Facade(rectangle(0, 0, 4, 9), 0.5, storeys=(Storey(3.0, 0.5), Storey(6.0, 0.4)))
    assert len(check(facade, edges=4).Faces()) == 1 + 4 + 2 + 1


def test_curved_gable():
    facade = walls.curved_gable()
    # Base twice, door 3, right, shoulder, arc, shoulder, left.
    solid = check(facade, edges=2 + 3 + 5)
    area = 12 + np.pi * 1.5**2 / 2 - 2.0 - np.pi * 0.25 / 2
    assert solid.Volume() == pytest.approx(0.4 * area, rel=1e-12)
    assert solid.BoundingBox().zlen == pytest.approx(4.5, abs=1e-9)


def test_idle_corners_make_no_faces():
    ring = [(0, 0), (1, 0), (4, 0), (4, 1.5), (4, 3), (2, 3), (0, 3), (0, 2), (0, 1)]
    assert len(check(Facade(np.array(ring, float), 0.3), edges=4).Faces()) == 6


def test_doors_within_the_grounds_tolerance():
    door = Opening(1, DOOR, rectangle(1, 9e-7, 1, 2))
    solid = cad_wall(Facade(rectangle(0, 0, 4, 3), 0.3, (door,)))
    assert len(solid.Faces()) == 2 + 8
    assert solid.Volume() == pytest.approx(0.3 * (12 - 2), rel=1e-6)


@pytest.mark.parametrize("digits", [7, 8])
def test_rounded_corners_of_arcs(digits):
    """As they come from files: the ends lie on their curves to some digits only."""
    facade = walls.arched()
    rounded = [
        Opening(o.id, o.kind, o.outline.round(digits), arcs=o.arcs) if o.arcs else o for o in facade.openings
    ]
    solid = cad_wall(Facade(facade.outline, 0.5, tuple(rounded)))
    assert solid.Volume() == pytest.approx(facade.volume, rel=10.0**-digits)
    assert solid.isValid()
    assert len(solid.Faces()) == len(cad_wall(facade).Faces())


def test_arcs_about_a_round_foot():
    """A door whose arc springs from the ground."""
    door = headed(DOOR, walls.ARC, (1, 3), (0, 0, 1))
    solid = check(Facade(rectangle(0, 0, 5, 3), 0.3, (door,)), edges=4 + 1 + 1)
    assert solid.Volume() == pytest.approx(0.3 * (15 - np.pi / 2), rel=1e-12)


@pytest.mark.parametrize(
    ("window", "level"),
    [
        (headed(WINDOW, walls.GABLED, (1, 2), (1, 2, 2.5)), 2.5),
        (headed(WINDOW, walls.ARC, (1, 2), (1, 2, 2.5)), 2.5),
        (oval(1.5, 2.0, 0.5, 0.5), 1.5),
    ],
)
def test_levels_that_touch_an_opening(window, level):
    storeys = (Storey(level, 0.3),)
    with pytest.raises(InputError, match=r"touches its level in the point x = 1\.500"):
        cad_wall(Facade(rectangle(0, 0, 4, 5), 0.5, (window,), storeys=storeys))
    shifted = Facade(rectangle(0, 0, 4, 5), 0.5, (window,), storeys=(Storey(level + 0.002, 0.3),))
    assert cad_wall(shifted).isValid()


def test_doors_that_part_the_wall():
    ring = np.array([(1, 0), (1.5, 0), (1.5, 1), (2.5, 1), (2.5, 0), (3, 0), (3, 2), (1, 2)], float)
    with pytest.raises(InputError, match=r"opening 1 \(door, at x = 1\.000\) stands on the ground in 4"):
        cad_wall(Facade(rectangle(0, 0, 4, 3), 0.3, (Opening(1, DOOR, ring),)))
    point = np.array([(1, 1), (2, 0), (3, 1), (3, 2), (1, 2)], float)
    with pytest.raises(InputError, match="in 1 corners"):
        cad_wall(Facade(rectangle(0, 0, 4, 3), 0.3, (Opening(1, DOOR, point),)))


def test_unsound_solids_are_noticed(monkeypatch):
    """OpenCASCADE's verdict counts."""
    import cadquery

    monkeypatch.setattr(cadquery.Solid, "isValid", lambda _: False)
    with pytest.raises(NumericsError, match="no sound solid"):
        cad_wall(Facade(rectangle(0, 0, 4, 3), 0.3))


@settings(max_examples=40, deadline=None)
@given(walls.facades())
def test_any_wall(facade):
    try:
        solid = cad_wall(facade)
    except InputError as error:
        assume("touches its level" not in str(error))
        raise
    assert solid.Volume() == pytest.approx(facade.volume, rel=1e-11)
    edges = sum(len(rim) for rim in wall_rims(facade).all)
    assert len(solid.Faces()) == expected_faces(facade, edges)
