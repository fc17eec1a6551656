"""Walls whose thickness changes with the storeys."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_oracles import assert_conformal, assert_fills, facet_areas, group_area, ledge_area, vtk_quality

from fd2fem.errors import MeshError
from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.meshing.options import slabs
from fd2fem.model import Facade, Opening, OpeningKind, Storey, rectangle

STOREYS = (Storey(3.0, 0.38), Storey(6.0, 0.25))


def opening(number, *box):
    return Opening(number, OpeningKind.DOOR if box[1] == 0 else OpeningKind.WINDOW, rectangle(*box))


def wall(*boxes, storeys=STOREYS, thickness=0.5):
    openings = tuple(opening(number, *box) for number, box in enumerate(boxes, 1))
    return Facade(rectangle(0, 0, 8, 9), thickness, openings, storeys=storeys)


def test_a_plain_wall_by_hand():
    facade = wall()
    mesh = mesh_facade(facade, options=MeshOptions(size=0.5))
    # 16 x 6 quadrilaterals a storey; slabs of 0.25, 0.13 and 0.12 m, a layer each
    assert len(mesh.elements) == 16 * 6 * (3 + 2 + 1)
    assert len(mesh.nodes) == 17 * (2 * 19 + 13 + 7)  # layers at y = 0 and 0.25; 0.38; 0.5
    assert np.unique(mesh.nodes[:, 1].round(12)).tolist() == [0.0, 0.25, 0.38, 0.5]
    assert group_area(mesh, "ledges") == pytest.approx(8 * (0.12 + 0.13))
    assert (facet_areas(mesh, "ledges")[:, 2] > 0).all()  # the wall gets thinner: they face up
    assert group_area(mesh, "left") == pytest.approx(3 * (0.5 + 0.38 + 0.25))
    assert group_area(mesh, "top") == pytest.approx(8 * 0.25)
    assert_conformal(mesh)
    assert_fills(mesh, facade)


def test_ledges_face_down_where_the_wall_gets_thicker():
    facade = wall(storeys=(Storey(4.0, 0.6),))
    mesh = mesh_facade(facade)
    assert (facet_areas(mesh, "ledges")[:, 2] < 0).all()
    assert group_area(mesh, "ledges") == pytest.approx(8 * 0.1)
    assert_conformal(mesh)
    assert_fills(mesh, facade)


@pytest.mark.parametrize("gap", [-0.5, -0.03, -0.001, 0.0, 0.001, 0.03, 0.1, 0.2])
def test_a_sill_close_to_a_level(gap):
    facade = wall((1, 3.0 + gap, 1, 1.5), (4, 3.05 + gap, 1, 1.5), (6, 0, 1, 2.1))
    mesh = mesh_facade(facade)
    assert vtk_quality(mesh).min() > 0.9
    assert_conformal(mesh)
    assert_fills(mesh, facade)
    assert group_area(mesh, "ledges") == pytest.approx(ledge_area(facade), rel=1e-9)


def test_a_level_through_openings():
    facade = wall((1, 2, 1, 2), (4, 0, 1.5, 7), (6.5, 4.5, 1, 3))
    mesh = mesh_facade(facade)
    assert_conformal(mesh)
    assert_fills(mesh, facade)
    assert group_area(mesh, "ledges") == pytest.approx(5.5 * 0.12 + 5.5 * 0.13)  # by hand
    rims = [(1, 2, 0.5), (1, 2, 0.38)]  # first window: bottom and jambs below 3 m, jambs and top above
    first = sum((1 + 2 * 1) * thickness for _, _, thickness in rims)
    door = 2 * (3 * 0.5 + 3 * 0.38 + 1 * 0.25) + 1.5 * 0.25
    upper = (1 + 2 * 1.5) * 0.38 + (1 + 2 * 1.5) * 0.25
    assert group_area(mesh, "reveals") == pytest.approx(first + door + upper)


def test_thicknesses_that_all_but_coincide_are_refused():
    with pytest.raises(MeshError, match="two thicknesses of its storeys all but coincide"):
        mesh_facade(wall(storeys=(Storey(3.0, 0.4999),)))


@pytest.mark.parametrize(
    ("size", "layers", "expected"),
    [(0.1, 0, (3, 1, 1)), (0.5, 0, (1, 1, 1)), (0.5, 5, (3, 1, 1)), (0.5, 10, (5, 3, 3))],
)
def test_layers_of_the_slabs(size, layers, expected):
    # by hand: slabs of 0.25, 0.13 and 0.12 m; 5 or 10 layers are 0.1 or 0.05 m each, rounded up from 0.37
    found = slabs(wall(), size=size, layers=layers)
    assert [depth for depth, _ in found] == [0.25, 0.38, 0.5]
    assert tuple(count for _, count in found) == expected


@settings(max_examples=15, deadline=None)
@given(st.randoms(use_true_random=False))
def test_random_rectilinear_walls(random):
    boxes = []
    for _ in range(9):
        box = [
            random.uniform(0.2, 6.5),
            0.0 if random.random() < 0.15 else random.uniform(0.2, 7),
            random.uniform(0.3, 1.6),
            random.uniform(0.3, 1.6),
        ]
        inside = box[0] + box[2] < 7.9 and box[1] + box[3] < 8.9
        if inside and all(gap(box, other) > 0.02 for other in boxes):
            boxes.append(box)
    levels = sorted({round(random.uniform(0.5, 8.5), 2) for _ in range(random.randint(1, 3))})
    storeys = tuple(Storey(level, round(random.uniform(0.2, 0.6), 2)) for level in levels)
    facade = wall(*boxes, storeys=storeys)
    mesh = mesh_facade(facade, options=MeshOptions(size=0.3))
    assert vtk_quality(mesh).min() >= 0.3
    assert_conformal(mesh)
    assert_fills(mesh, facade)
    assert group_area(mesh, "ledges") == pytest.approx(ledge_area(facade), rel=1e-9)


def gap(one, other):
    """Distance between two boxes along the axis that separates them best."""
    return max(max(one[k] - other[k] - other[k + 2], other[k] - one[k] - one[k + 2]) for k in (0, 1))
