"""The boundary representation against closed forms and a plain walk along its loops."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import CellState
from fd2fem.solids import solid_from_voxels, solid_volumes

BOX = [(0, 0, 2, 3)]
TWO = [(0, 0, 2, 3), (2, 0, 4, 3)]
TEE = [(0, 0, 2, 2), (2, 0, 3, 1), (2, 1, 3, 2)]
CORNER = [(0, 0, 1, 1), (1, 1, 2, 2)]


def counts(solid):
    return len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes)


@pytest.mark.parametrize(
    ("boxes", "expected"),
    [
        (BOX, (8, 12, 6, 1)),
        (TWO, (12, 20, 11, 2)),
        (TEE, (16, 28, 16, 3)),
        # Two boxes that share one line only: 8 + 8 - 2 keypoints, 12 + 12 - 1 lines.
        (CORNER, (14, 23, 12, 2)),
    ],
)
def test_neighbours_share_their_parts(boxes, expected, make_voxels, measured):
    solid = solid_from_voxels(make_voxels(boxes))
    assert counts(solid) == expected
    found = measured(solid)
    areas = [(c - a) * (d - b) for a, b, c, d in boxes]
    assert found.volumes == pytest.approx([0.5 * area for area in areas], rel=1e-14)
    assert found.euler == [2] * len(boxes)


def test_grid_has_the_counts_of_a_grid(make_voxels):
    n, m = 7, 4
    solid = solid_from_voxels(make_voxels([(i, j, i + 1, j + 1) for i in range(n) for j in range(m)]))
    corners = (n + 1) * (m + 1)
    sides = n * (m + 1) + m * (n + 1)
    assert counts(solid) == (2 * corners, 2 * sides + corners, 2 * n * m + sides, n * m)


def test_loops_beside_smaller_neighbours_are_longer(make_voxels):
    solid = solid_from_voxels(make_voxels(TEE))
    assert sorted(len(loop) for loop in solid.areas) == [4] * 14 + [5] * 2


def test_front_looks_outwards_and_wall_runs_inwards(make_voxels):
    solid = solid_from_voxels(make_voxels(BOX))
    assert solid.keypoints.min(axis=0).tolist() == [0, 0, 0]
    assert solid.keypoints.max(axis=0).tolist() == [2, 0.5, 3]
    q = solid.keypoints[solid.patches]
    normals = np.cross(q[:, 1] - q[:, 0], q[:, 3] - q[:, 0])
    centre = [1, 0.25, 1.5]
    assert (np.einsum("ij,ij->i", normals, q.mean(axis=1) - centre) > 0).all()
    assert normals[0].tolist() == [0, -6, 0]
    assert normals[1].tolist() == [0, 6, 0]


def test_patch_goes_round_its_loop(make_wall):
    solid = solid_from_voxels(make_wall(4.0, 3.0, [(1.1, 0.9, 2.3, 2.2)]))
    for loop, patch in zip(solid.areas, solid.patches, strict=True):
        ring = [solid.lines[i - 1][0] if i > 0 else solid.lines[-i - 1][1] for i in loop]
        places = [ring.index(k) for k in patch]
        turned = places[places.index(min(places)) :] + places[: places.index(min(places))]
        assert turned == sorted(places)


def test_empty_voxels_leave_no_trace(make_voxels):
    full = solid_from_voxels(make_voxels(TEE))
    with_empty = solid_from_voxels(make_voxels(TEE, empty=[(0, 2, 1.5, 4), (1.5, 2, 3, 4)]))
    assert counts(full) == counts(with_empty)


def test_nearly_equal_coordinates_are_one(make_voxels, measured):
    boxes = [(0, 0, 2 + 4e-9, 2 - 3e-9), (2 - 5e-9, 0, 3, 1 + 1e-9), (2, 1 - 1e-9, 3, 2)]
    solid = solid_from_voxels(make_voxels(boxes))
    assert counts(solid) == (16, 28, 16, 3)
    assert measured(solid).volumes == pytest.approx([2, 0.5, 0.5], rel=1e-7)


def test_coordinates_either_side_of_a_rounding_step_are_one(make_voxels):
    half = 2.00000005
    solid = solid_from_voxels(make_voxels([(0, 0, half - 1e-10, 1), (half + 1e-10, 0, 3, 1)]))
    assert counts(solid) == (12, 20, 11, 2)


def test_slivers_of_rounding_vanish(make_voxels, measured):
    third = 3 * 0.7  # 2.0999999999999996
    solid = solid_from_voxels(make_voxels([(0, 0, third, 1), (third, 0, 2.1, 1), (2.1, 0, 3, 1)]))
    assert counts(solid) == (12, 20, 11, 2)
    assert sum(measured(solid).volumes) == pytest.approx(1.5, rel=1e-12)


@st.composite
def partitions(draw):
    """A rectangle cut again and again at random, each piece full or empty, at least one full."""
    pieces = [(0, 0, 24, 24)]
    for _ in range(draw(st.integers(0, 25))):
        x0, z0, x1, z1 = pieces.pop(draw(st.integers(0, len(pieces) - 1)))
        if draw(st.booleans()) and x1 - x0 > 1:
            cut = draw(st.integers(x0 + 1, x1 - 1))
            pieces += [(x0, z0, cut, z1), (cut, z0, x1, z1)]
        elif z1 - z0 > 1:
            cut = draw(st.integers(z0 + 1, z1 - 1))
            pieces += [(x0, z0, x1, cut), (x0, cut, x1, z1)]
        else:
            pieces.append((x0, z0, x1, z1))
    full = draw(st.lists(st.booleans(), min_size=len(pieces), max_size=len(pieces)))
    full[0] = True
    scale = draw(st.sampled_from([1.0, 0.1, 1 / 3]))
    scaled = [tuple(scale * value for value in piece) for piece in pieces]
    chosen = [piece for piece, keep in zip(scaled, full, strict=True) if keep]
    return chosen, [piece for piece, keep in zip(scaled, full, strict=True) if not keep]


@settings(max_examples=120, deadline=None)
@given(partitions())
def test_any_partition_is_conformal(make_voxels, measured, partition):
    boxes, empty = partition
    solid = solid_from_voxels(make_voxels(boxes, empty=empty))
    found = measured(solid)
    volumes = [0.5 * (c - a) * (d - b) for a, b, c, d in boxes]
    assert found.volumes == pytest.approx(volumes, rel=1e-9)
    assert solid_volumes(solid) == pytest.approx(volumes, rel=1e-9)
    assert set(found.euler) == {2}
    assert sorted(found.signs) == list(range(1, len(solid.areas) + 1))
    assert all(signs in ([1], [1, -1]) for signs in found.signs.values())
    check_conformity(solid)


def check_conformity(solid):
    """No keypoint twice, no line twice, no keypoint inside a line; every line and keypoint is used."""
    points = solid.keypoints.round(7)
    assert len(np.unique(points, axis=0)) == len(points)
    ends = np.sort(solid.lines, axis=1)
    assert len(np.unique(ends, axis=0)) == len(ends)
    a, b = solid.keypoints[solid.lines[:, 0]], solid.keypoints[solid.lines[:, 1]]
    length = np.linalg.norm(b - a, axis=1)
    to_a = np.linalg.norm(solid.keypoints[:, None] - a, axis=2)
    to_b = np.linalg.norm(solid.keypoints[:, None] - b, axis=2)
    inside = (to_a + to_b < length + 1e-9) & (to_a > 1e-7) & (to_b > 1e-7)
    assert not inside.any()
    assert {abs(i) for loop in solid.areas for i in loop} == set(range(1, len(solid.lines) + 1))
    assert set(solid.lines.ravel().tolist()) == set(range(len(points)))


def test_shared_areas_are_where_full_voxels_touch(make_wall, measured):
    windows = [(1.1, 0.9, 2.3, 2.2)]
    voxels = make_wall(4.0, 3.0, windows, thickness=0.4)
    solid = solid_from_voxels(voxels)
    signs = measured(solid).signs
    q = solid.keypoints[solid.patches]
    size = np.linalg.norm(np.cross(q[:, 1] - q[:, 0], q[:, 3] - q[:, 0]), axis=1)
    outer = sum(size[area - 1] for area, listed in signs.items() if listed == [1])
    # Front and back without the window, the wall's rim and the window's reveal.
    assert outer == pytest.approx(2 * (12 - 1.2 * 1.3) + 0.4 * (14 + 2 * (1.2 + 1.3)), rel=1e-12)
    assert solid_volumes(solid).sum() == pytest.approx(0.4 * (12 - 1.2 * 1.3), rel=1e-12)


def test_volumes_far_from_the_origin_keep_their_digits(make_voxels):
    solid = solid_from_voxels(make_voxels([(1e6, 0, 1e6 + 1, 1)]))
    assert solid_volumes(solid) == pytest.approx([0.5], rel=1e-9)


@pytest.mark.parametrize(
    ("boxes", "empty", "match"),
    [
        ([], [(0, 0, 1, 1)], "None of the 1 voxels is full"),
        ([], [], "None of the 0 voxels is full"),
        ([(1, 0, 1 + 5e-8, 1)], [], "None of the 1 voxels is full"),
        ([(0, 0, 1, 1), (3, 2, 2, 3)], [], "1 full voxels end before they begin, the first at x = 3.0"),
        ([(0, 0, 2, 2), (1, 1, 3, 3)], [], "1 pairs of full voxels overlap.* 0.000000 and 1.0"),
        ([(0, 0, 2, 2), (0, 0, 2, 2)], [], "overlap"),
        ([(0, 1, 3, 2), (1, 0, 2, 3)], [], "overlap"),
    ],
)
def test_voxels_that_make_no_solid(boxes, empty, match, make_voxels):
    with pytest.raises(InputError, match=match):
        solid_from_voxels(make_voxels(boxes, empty=empty))


def test_partial_voxels_are_not_full(make_voxels):
    voxels = make_voxels(TEE)
    object.__setattr__(voxels, "state", np.array([1, 1, CellState.PARTIAL]))
    assert len(solid_from_voxels(voxels).volumes) == 2


def test_thickness_must_be_positive(make_voxels):
    with pytest.raises(InputError, match="thickness"):
        solid_from_voxels(make_voxels(BOX, 0.0))
