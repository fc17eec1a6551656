import numpy as np
import pytest

from fd2fem.model import GROUPS, Facade, Group, Opening, OpeningKind, edge_groups, rectangle


def edges(ring):
    points = np.asarray(ring, dtype=float)
    return points, np.roll(points, -1, axis=0)


def test_names_are_those_of_the_groups():
    assert set(GROUPS) == {"base", "front", "back", "left", "right", "top", "reveals", "ledges"}


def test_a_gable():
    gable = [[0, 0], [4, 0], [4, 3], [2, 5], [0, 3]]
    assert edge_groups(Facade(gable, 0.3), *edges(gable)) == (
        Group.BASE,
        Group.RIGHT,
        Group.TOP,
        Group.TOP,
        Group.LEFT,
    )


def test_the_underside_of_a_projection_has_no_group():
    # The wall is wider above z = 1.
    outline = [[0, 0], [3, 0], [3, 1], [4, 1], [4, 3], [0, 3]]
    groups = edge_groups(Facade(outline, 0.3), *edges(outline))
    assert groups == (Group.BASE, Group.RIGHT, None, Group.RIGHT, Group.TOP, Group.LEFT)


@pytest.mark.parametrize(("lean", "group"), [(0.2, Group.RIGHT), (-0.2, Group.RIGHT), (-2.0, Group.TOP)])
def test_a_leaning_end_is_a_side_up_to_15_degrees(lean, group):
    outline = [[0, 0], [5, 0], [5 + lean, 3], [0, 3]]
    assert edge_groups(Facade(outline, 0.3), *edges(outline))[1] is group


def test_rims_of_openings_are_reveals_and_the_ground_at_a_door_is_none():
    door = Opening(1, OpeningKind.DOOR, rectangle(1, 0, 1, 2))
    window = Opening(2, OpeningKind.WINDOW, rectangle(3, 1, 1, 1))
    facade = Facade(rectangle(0, 0, 5, 4), 0.3, (door, window))
    # The wall on the left: clockwise round the window, up the door's left jamb seen from the wall.
    start, end = edges(window.outline[::-1])
    assert set(edge_groups(facade, start, end)) == {Group.REVEALS}
    jamb = edge_groups(facade, [[1.0, 0.0], [1.0, 2.0]], [[1.0, 2.0], [2.0, 2.0]])
    assert jamb == (Group.REVEALS, Group.REVEALS)
    foot = edge_groups(facade, [[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.0], [5.0, 0.0]])
    assert foot == (Group.BASE, Group.BASE)
