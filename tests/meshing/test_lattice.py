import numpy as np
import pytest

from fd2fem.meshing.lattice import build_lattice, count_divisions
from fd2fem.meshing.walls import is_rectilinear, wall_rings
from fd2fem.model import Facade, Opening, OpeningKind, rectangle


def facade(*windows, outline=None):
    outline = rectangle(0, 0, 6, 8) if outline is None else outline
    openings = [
        Opening(number, OpeningKind.DOOR if window[1] == 0 else OpeningKind.WINDOW, rectangle(*window))
        for number, window in enumerate(windows, 1)
    ]
    return Facade(outline=outline, thickness=0.4, openings=tuple(openings))


def test_rings_of_a_wall_with_a_door_and_a_window():
    rings = wall_rings(facade((1, 0, 1, 2), (3, 3, 1, 1)))
    corners = {(0, 0), (1, 0), (1, 2), (2, 2), (2, 0), (6, 0), (6, 8), (0, 8)}
    assert set(map(tuple, rings.outer.tolist())) == corners
    assert len(rings.outer) == len(corners)
    assert rings.holes[0].tolist() == rectangle(3, 3, 1, 1)[::-1].tolist()
    assert is_rectilinear(rings)


def test_idle_corners_and_rounding_go():
    outline = np.array([[0, 0], [1, 0], [6, 0], [6, 8], [3, 8], [1e-12, 8], [0, 4]])
    rings = wall_rings(facade(outline=outline))
    np.testing.assert_allclose(rings.outer, rectangle(0, 0, 6, 8), atol=1e-11)


def test_a_gable_is_not_rectilinear():
    assert not is_rectilinear(wall_rings(facade(outline=np.array([[0, 0], [6, 0], [6, 4], [3, 6], [0, 4]]))))


def test_jambs_that_almost_line_up_share_a_grid_line():
    lattice = build_lattice(wall_rings(facade((1, 1, 1, 1), (1.02, 4, 1, 1))), tolerance=0.1)
    assert lattice.wall.shape == (3, 5)
    np.testing.assert_allclose(lattice.columns, [0, 1.01, 2.01, 6])
    # by hand: exact on the jambs, constant beyond them, straight from z = 2 to z = 4 between them
    np.testing.assert_allclose(lattice.points[1, :, 0], [1, 1, 1, 1.02, 1.02, 1.02], atol=1e-15)
    assert lattice.wall.tolist()[1] == [True, False, True, False, True]


def test_the_plain_partition_at_tolerance_zero():
    lattice = build_lattice(wall_rings(facade((1, 1, 1, 1), (1.02, 4, 1, 1))), tolerance=0.0)
    assert lattice.wall.shape == (5, 5)
    assert lattice.min_scaled_jacobian() == pytest.approx(1.0)


def test_a_thin_pier_keeps_its_two_lines():
    # the pier between the windows of the lower row is 5 cm, less than the tolerance
    lattice = build_lattice(wall_rings(facade((1, 1, 1, 1), (2.05, 1, 1, 1), (2.04, 4, 1, 1))), tolerance=0.1)
    np.testing.assert_allclose(np.sort(lattice.points[:, 1, 0]), [0, 1, 2, 2.05, 3.05, 6])


def test_windows_that_almost_touch_at_a_corner_stay_apart():
    # merging both jambs and sills would put one point in two places
    wall = facade((1, 1, 1, 1), (2.005, 2.005, 1, 1))
    lattice = build_lattice(wall_rings(wall), tolerance=0.1)
    assert (len(lattice.columns), len(lattice.rows)) in {(5, 6), (6, 5)}
    assert lattice.points[..., 0].min() == 0.0


def test_a_spandrel_keeps_its_two_lines():
    lattice = build_lattice(wall_rings(facade((1, 1, 1, 1), (1, 2.03, 1, 1))), tolerance=0.1)
    assert len(lattice.rows) == 6


def test_a_skewed_cell_by_hand():
    # 0.5 m over a spandrel of 0.5 m: 45°
    lattice = build_lattice(wall_rings(facade((1, 1, 2, 1), (1.5, 2.5, 2, 1))), tolerance=0.6)
    assert lattice.min_scaled_jacobian() == pytest.approx(np.sqrt(0.5))


def test_divisions_across_piers_and_spandrels():
    # pier 0.3 m, spandrel 0.2 m: one element each by size, three asked for
    lattice = build_lattice(wall_rings(facade((1, 1, 1, 1), (2.3, 1, 1, 1), (1, 2.2, 1, 1))), tolerance=0.1)
    columns, rows = count_divisions(lattice, size=0.5, pier_elements=3)
    np.testing.assert_allclose(np.diff(lattice.columns), [1, 1, 0.3, 1, 2.7])
    assert columns.tolist() == [3, 2, 3, 2, 6]  # 2.7 / 0.5 = 5.4, past 0.37; the left pier is 2, too few
    np.testing.assert_allclose(np.diff(lattice.rows), [1, 1, 0.2, 1, 4.8])
    assert rows.tolist() == [3, 2, 3, 2, 10]


def test_a_pier_of_two_columns_counts_them_together():
    # the jamb at 1.5 of the upper row cuts the lower row's pier between 1.0 and 2.0
    lattice = build_lattice(wall_rings(facade((0.5, 1, 0.5, 1), (2, 1, 1, 1), (1.5, 4, 2, 1))), tolerance=0.1)
    columns, _ = count_divisions(lattice, size=1.0, pier_elements=2)
    pier = columns[np.searchsorted(lattice.columns, 1.0) : np.searchsorted(lattice.columns, 2.0)]
    assert pier.sum() == 2


def test_a_level_is_a_row_of_its_own_straight_all_along():
    # sills 3 cm above the level and 2 cm below it: less than the tolerance, yet neither moves it
    rings = wall_rings(facade((1, 3.03, 1, 1), (3, 2.98, 1, 1)))
    lattice = build_lattice(rings, tolerance=0.1, levels=[3.0])
    np.testing.assert_allclose(lattice.rows, [0, 2.98, 3.0, 3.03, 3.98 / 2 + 4.03 / 2, 8])
    assert (lattice.points[:, 2, 1] == 3.0).all()


def test_a_level_shares_the_row_of_edges_just_there():
    rings = wall_rings(facade((1, 3.0, 1, 1), (3, 3.0 + 1e-13, 1, 1)))
    lattice = build_lattice(rings, tolerance=0.1, levels=[3.0 + 1e-12])
    np.testing.assert_allclose(lattice.rows, [0, 3, 4, 8], atol=1e-11)
