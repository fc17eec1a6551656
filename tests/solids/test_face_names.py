"""Names of a wall's faces, held against areas in closed form."""

import arched_walls as walls
import numpy as np
import pytest

from fd2fem.drawings import stand_in
from fd2fem.model import GROUPS, Facade, Group, Opening, OpeningKind, Storey, rectangle
from fd2fem.solids import cad_wall, face_groups


def group_areas(facade):
    """Area of each group, m²."""
    solid = cad_wall(facade)
    areas = {}
    for face, group in zip(solid.Faces(), face_groups(solid, facade), strict=True):
        areas[group] = areas.get(group, 0.0) + face.Area()
    return areas


def test_plain_wall_with_door_and_window():
    facade = Facade(
        rectangle(0, 0, 5, 4),
        0.5,
        (
            Opening(1, OpeningKind.DOOR, rectangle(1, 0, 1, 2)),
            Opening(2, OpeningKind.WINDOW, rectangle(3, 1, 1, 1.5)),
        ),
    )
    assert group_areas(facade) == pytest.approx(
        {
            Group.FRONT: 16.5,
            Group.BACK: 16.5,
            Group.BASE: 0.5 * 4,
            Group.TOP: 0.5 * 5,
            Group.LEFT: 2.0,
            Group.RIGHT: 2.0,
            Group.REVEALS: 0.5 * (2 + 1 + 2 + 2 * 2.5),
        }
    )


def test_storeys_have_ledges_beside_their_sills():
    sill = Opening(1, OpeningKind.WINDOW, rectangle(1, 3, 1, 1.5))
    facade = Facade(rectangle(0, 0, 4, 6), 0.5, (sill,), storeys=(Storey(3.0, 0.3), Storey(5.0, 0.4)))
    areas = group_areas(facade)
    # 3 m of wall on the lower level, 4 m on the upper one; the sill, 0.5 m deep, is a reveal as a whole.
    assert areas[Group.LEDGES] == pytest.approx(3 * 0.2 + 4 * 0.1)
    assert areas[Group.REVEALS] == pytest.approx(1 * 0.5 + 0.3 * (1 + 1.5 + 1.5))
    assert areas[Group.BACK] == pytest.approx(areas[Group.FRONT])
    assert areas[Group.LEFT] == pytest.approx(3 * 0.5 + 2 * 0.3 + 1 * 0.4)
    assert None not in areas


def test_projections_and_shoulders():
    ring = np.array([(1, 0), (3, 0), (3, 2), (4, 2), (4, 3), (2, 5), (0, 3), (0, 1), (1, 1)], float)
    areas = group_areas(Facade(ring, 0.5))
    assert areas[Group.BASE] == pytest.approx(0.5 * 2)
    assert areas[None] == pytest.approx(0.5 * 2)  # two undersides
    assert areas[Group.TOP] == pytest.approx(0.5 * 2 * np.sqrt(8))
    assert areas[Group.RIGHT] == pytest.approx(0.5 * 3)
    assert areas[Group.LEFT] == pytest.approx(0.5 * 3)


def test_curves_bear_the_name_of_their_middle():
    areas = group_areas(walls.curved_gable())
    assert areas[Group.TOP] == pytest.approx(0.4 * (1.0 + np.pi * 1.5))
    assert areas[Group.REVEALS] == pytest.approx(0.4 * (4.0 + np.pi * 0.5))
    ovals = group_areas(Facade(rectangle(0, 0, 4, 4), 0.3, (walls.oval(2, 2, 1, 1),)))
    assert ovals[Group.REVEALS] == pytest.approx(0.3 * 2 * np.pi)


@pytest.mark.parametrize("name", ["building1", "building2", "building3"])
def test_stand_ins_have_all_groups_but_ledges(name):
    facade = stand_in(name)
    areas = group_areas(facade)
    assert set(areas) == {Group(group) for group in GROUPS} - {Group.LEDGES}
    assert areas[Group.FRONT] == pytest.approx(facade.wall_area, rel=1e-9)
    windows = [o for o in facade.openings if o.kind is OpeningKind.WINDOW]
    doors = [o for o in facade.openings if o.kind is OpeningKind.DOOR]
    rims = sum(2 * (o.width + o.height) for o in windows) + sum(o.width + 2 * o.height for o in doors)
    assert areas[Group.REVEALS] == pytest.approx(rims * facade.thickness, rel=1e-9)
