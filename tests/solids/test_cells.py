"""Walls of quadrilaterals: closed forms, the rules of a sound neutral file, and input that is none."""

import numpy as np
import pytest
import shapely
from anf_rules import check_anf
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import VoxelModel, WallCells
from fd2fem.solids import read_anf, solid_from_cells, solid_from_voxels, solid_volumes, write_anf


def ring_around_an_octagon(thickness=0.4):
    angle = np.arange(8) * np.pi / 4 + np.pi / 8
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    corners = [[i, i + 8, (i + 1) % 8 + 8, (i + 1) % 8] for i in range(8)]
    return WallCells(np.concatenate([circle, 2.2 * circle]) + 2.2, corners, thickness)


def grid(n, m):
    """Corners of a grid of n x m unit squares."""
    i, j = np.divmod(np.arange(n * m), m)
    return np.column_stack(
        [i * (m + 1) + j, (i + 1) * (m + 1) + j, (i + 1) * (m + 1) + j + 1, i * (m + 1) + j + 1]
    )


def lattice(n, m):
    i, j = np.divmod(np.arange((n + 1) * (m + 1)), m + 1)
    return np.column_stack([i, j]).astype(float)


def test_trapezoid():
    solid = solid_from_cells(WallCells([[0, 0], [4, 0], [3, 2], [1, 2]], [[0, 1, 2, 3]], 0.5))
    assert solid_volumes(solid) == pytest.approx([0.5 * (4 + 2) / 2 * 2], rel=1e-15)
    assert solid.keypoints[:4].tolist() == [[0, 0, 0], [4, 0, 0], [3, 0, 2], [1, 0, 2]]


@pytest.mark.parametrize("order", [2, 4])
def test_ring_around_an_octagon(tmp_path, order):
    solid = solid_from_cells(ring_around_an_octagon())
    assert (len(solid.keypoints), len(solid.lines)) == (2 * 16, 2 * 24 + 16)
    assert (len(solid.areas), len(solid.volumes)) == (2 * 8 + 24, 8)
    write_anf(solid, tmp_path / "ring.anf", order=order)
    sound = check_anf((tmp_path / "ring.anf").read_text())
    area = 2 * np.sqrt(2) * (2.2**2 - 1)  # an octagon of circumradius r has 2 √2 r²
    side = 16 * np.sin(np.pi / 8)
    assert sound.volumes == pytest.approx(np.full(8, 0.4 * area / 8), rel=1e-12)
    assert sound.outer_surface == pytest.approx(2 * area + 0.4 * side * 3.2, rel=1e-12)


def test_squares_are_the_voxels_that_they_look_like():
    i, j = np.divmod(np.arange(6), 2)
    low = np.column_stack([i, j])
    voxels = solid_from_voxels(VoxelModel(low, low + 1, np.ones(6), 0.5))
    cells = solid_from_cells(WallCells(lattice(3, 2), grid(3, 2), 0.5))
    assert [len(part) for part in (voxels.areas, voxels.lines)] == [
        len(part) for part in (cells.areas, cells.lines)
    ]
    assert sorted(voxels.keypoints.tolist()) == sorted(cells.keypoints.tolist())
    assert solid_volumes(voxels).tolist() == solid_volumes(cells).tolist()


def test_points_of_no_cell_are_left_out():
    solid = solid_from_cells(WallCells([[9, 9], [0, 0], [1, 0], [1, 1], [0, 1]], [[1, 2, 3, 4]], 0.5))
    assert len(solid.keypoints) == 8


@st.composite
def bent_grids(draw):
    """A grid of bent quadrilaterals, some of them missing, its rows of three thicknesses."""
    n, m = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    seed = draw(st.integers(0, 2**31))
    rng = np.random.default_rng(seed)
    points = lattice(n, m) + rng.uniform(-0.2, 0.2, size=((n + 1) * (m + 1), 2))
    scale = draw(st.sampled_from([1.0, 0.3]))
    kept = rng.random(n * m) < draw(st.sampled_from([0.7, 0.9, 1.0]))
    kept[0] = True
    corners = grid(n, m)[kept]
    # Turning a cell's list of corners changes nothing but where its rings begin.
    corners = np.array(
        [np.roll(row, turn) for row, turn in zip(corners, rng.integers(0, 4, len(corners)), strict=True)]
    )
    thickness = rng.choice([0.2, 0.3, 0.5], size=m)[np.arange(n * m) % m][kept]
    return points * scale, corners, thickness


def hangs_together(points, corners):
    """Whether the cells make one polygon whose rings do not meet, as shapely has it."""
    union = shapely.union_all(shapely.polygons(points[corners]))
    if union.geom_type != "Polygon":
        return False
    rings = [np.asarray(ring.coords)[:-1] for ring in (union.exterior, *union.interiors)]
    places = np.concatenate(rings).round(9)
    return len(np.unique(places, axis=0)) == len(places)


def solid_or_reason(cells):
    """The solid of cells, or why there is none."""
    try:
        return solid_from_cells(cells), ""
    except InputError as error:
        return None, str(error)


@settings(max_examples=60, deadline=None)
@given(cells=bent_grids(), order=st.sampled_from([2, 4]))
def test_any_bent_grid_makes_a_sound_file_or_an_error(tmp_path_factory, cells, order):
    points, corners, thickness = cells
    if not hangs_together(points, corners):
        with pytest.raises(InputError, match=r"falls into|meet only at their edge"):
            solid_from_cells(WallCells(points, corners, 0.4))
        return
    solid = solid_from_cells(WallCells(points, corners, 0.4))
    folder = tmp_path_factory.mktemp("grid")
    write_anf(solid, folder / "wall.anf", order=order)
    sound = check_anf((folder / "wall.anf").read_text())
    areas = shapely.area(shapely.polygons(points[corners]))
    assert sound.volumes == pytest.approx(0.4 * areas, rel=1e-9)
    back = read_anf(folder / "wall.anf")
    assert (back.areas, back.volumes) == (solid.areas, solid.volumes)
    stepped, reason = solid_or_reason(WallCells(points, corners, thickness))
    if stepped is None:
        assert "meet only at their edge" in reason  # behind the thinner rows
        return
    write_anf(stepped, folder / "stepped.anf", order=order)
    assert sum(check_anf((folder / "stepped.anf").read_text()).volumes) == pytest.approx(
        areas @ thickness, rel=1e-9
    )


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.parametrize(
    ("points", "corners", "match"),
    [
        (SQUARE, np.empty((0, 4), dtype=int), "There are no cells"),
        (SQUARE, [[0, 3, 2, 1]], r"1 cells are not convex quadrilaterals, .* at x = 0\.5"),
        (SQUARE, [[0, 2, 1, 3]], "not convex"),
        ([[0, 0], [1, 0], [0.2, 0.2], [0, 1]], [[0, 1, 2, 3]], "not convex"),
        ([[0, 0], [1, 0], [0.5, 0.5], [0, 1]], [[0, 1, 2, 3]], "not convex"),  # a straight corner
        (SQUARE, [[0, 1, 2, 2]], "not convex"),
        (SQUARE, [[0, 1, 2, 3], [0, 1, 2, 3]], r"Cells overlap: two lie on the same side of the edge"),
        ([*SQUARE, [2, 0.1], [2, 0.9]], [[0, 1, 2, 3], [1, 4, 5, 2], [1, 4, 5, 2]], "Cells overlap"),
        # A T-junction: the right cell is half as high.
        (
            [*SQUARE, [2, 0], [2, 0.5], [1, 0.5]],
            [[0, 1, 2, 3], [1, 4, 5, 6]],
            r"1 corners lie on .* z = 0\.5",
        ),
        # The same corner twice.
        (
            [*SQUARE, [1, 0], [2, 0], [2, 1], [1, 1]],
            [[0, 1, 2, 3], [4, 5, 6, 7]],
            "do not meet along whole edges",
        ),
        # Two pieces, one on top of the other.
        (
            [*SQUARE, [0.3, 0.3], [1.3, 0.4], [1.4, 1.3], [0.4, 1.4]],
            [[0, 1, 2, 3], [4, 5, 6, 7]],
            "pairs of cells overlap",
        ),
        ([*SQUARE, [3, 0], [4, 0], [4, 1], [3, 1]], [[0, 1, 2, 3], [4, 5, 6, 7]], "falls into 2 pieces"),
        ([*SQUARE, [2, 1], [2, 2], [1, 2]], [[0, 1, 2, 3], [2, 4, 5, 6]], "falls into 2 pieces"),
    ],
)
def test_cells_that_make_no_solid(points, corners, match):
    with pytest.raises(InputError, match=match) as caught:
        solid_from_cells(WallCells(points, corners, 0.5))
    assert "\n" not in str(caught.value)


def test_cells_around_two_holes_that_meet_in_a_point():
    corners = [cell for k, cell in enumerate(grid(4, 4).tolist()) if k not in (1 * 4 + 1, 2 * 4 + 2)]
    with pytest.raises(InputError, match=r"meet only at their edge at x = 2\.000, z = 2\.000"):
        solid_from_cells(WallCells(lattice(4, 4), corners, 0.5))


@pytest.mark.parametrize(
    ("corners", "thickness", "match"),
    [
        ([[0, 1, 2, 4]], 0.5, "they name points that are not among the 4"),
        ([[0, 1, 2, -1]], 0.5, "they name points"),
        ([[0, 1, 2, 3]], 0.0, "Invalid 'thickness'"),
        ([[0, 1, 2, 3]], [-0.1], "Invalid 'thickness'"),
        ([[0, 1, 2, 3]], [np.nan], "thickness"),
    ],
)
def test_records_that_are_none(corners, thickness, match):
    with pytest.raises(InputError, match=match):
        WallCells(SQUARE, corners, thickness)


def test_volume_of_the_record():
    assert ring_around_an_octagon().volume == pytest.approx(0.4 * 2 * np.sqrt(2) * (2.2**2 - 1), rel=1e-14)
