"""Walls whose thickness varies: counts by hand, closed forms, and the rules of a sound neutral file."""

import numpy as np
import pytest
from anf_rules import check_anf
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import CellState, VoxelModel
from fd2fem.solids import check_joined, read_anf, solid_from_voxels, solid_volumes, write_anf

STEPPED = [(0, 0, 2, 3), (0, 3, 2, 5)]


def voxels_of(boxes, thickness, state=1):
    table = np.array(boxes, dtype=float)
    return VoxelModel(table[:, :2], table[:, 2:], np.broadcast_to(state, len(table)), thickness)


def counts(solid):
    return len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes)


def written(solid, folder, order=2):
    write_anf(solid, folder / "wall.anf", order=order)
    return (folder / "wall.anf").read_text()


def test_the_thicker_storey_is_cut_where_the_thinner_one_ends(tmp_path):
    solid = solid_from_voxels(voxels_of(STEPPED, [0.5, 0.3]))
    # Levels 0 and 0.3 have 6 corners and 7 sides each, level 0.5 has 4 of both.
    assert counts(solid) == (6 + 6 + 4, 7 + 7 + 4 + 6 + 4, 2 + 2 + 1 + 7 + 4, 3)
    assert sorted(solid_volumes(solid)) == pytest.approx([2 * 3 * 0.2, 2 * 2 * 0.3, 2 * 3 * 0.3])
    assert np.unique(solid.keypoints[:, 1]).tolist() == [0.0, 0.3, 0.5]
    sound = check_anf(written(solid, tmp_path))
    rims = 0.5 * (2 * 3) + 0.3 * (2 * 2)  # both ends of each storey
    levels = 0.5 * 2 + 0.2 * 2 + 0.3 * 2  # ground, ledge, top
    assert sound.outer_surface == pytest.approx(2 * (2 * 5) + rims + levels, rel=1e-12)


def test_overhanging_storeys_are_no_different(tmp_path):
    below, above = (solid_from_voxels(voxels_of(STEPPED, t)) for t in ([0.5, 0.3], [0.3, 0.5]))
    assert counts(below) == counts(above)
    assert check_anf(written(above, tmp_path)).outer_surface == pytest.approx(
        2 * (2 * 5) + 0.3 * 6 + 0.5 * 4 + 0.3 * 2 + 0.2 * 2 + 0.5 * 2, rel=1e-12
    )


def test_every_thickness_makes_one_slab():
    boxes = [(i, 0, i + 1, 1) for i in range(4)]
    solid = solid_from_voxels(voxels_of(boxes, [0.4, 0.1, 0.3, 0.2]))
    assert len(solid.volumes) == 4 + 1 + 3 + 2
    assert solid_volumes(solid) == pytest.approx(np.full(10, 0.1))


def test_one_thickness_for_all_is_the_plain_wall():
    one, each = (solid_from_voxels(voxels_of(STEPPED, t)) for t in (0.4, [0.4, 0.4]))
    assert one.areas == each.areas
    assert one.volumes == each.volumes
    assert one.keypoints.tolist() == each.keypoints.tolist()


def test_nearly_equal_thicknesses_are_one():
    assert counts(solid_from_voxels(voxels_of(STEPPED, [0.4, 0.4 + 1e-9]))) == (12, 20, 11, 2)


def test_empty_voxels_may_have_any_thickness():
    solid = solid_from_voxels(voxels_of([*STEPPED, (0, 5, 2, 6)], [0.5, 0.3, 0.0], [1, 1, 0]))
    assert len(solid.volumes) == 3


@pytest.mark.parametrize("flat", [0.0, -0.3, 5e-8])
def test_voxels_without_thickness_are_refused(flat):
    with pytest.raises(InputError, match=r"1 full voxels have no thickness, the first, at x = 0\.0+, z = 3"):
        solid_from_voxels(voxels_of(STEPPED, [0.5, flat]))


@st.composite
def divisions(draw):
    """A rectangle cut again and again at random; each piece full or empty and of one of three thicknesses."""
    pieces = [(0, 0, 24, 24)]
    for _ in range(draw(st.integers(0, 14))):
        x0, z0, x1, z1 = pieces.pop(draw(st.integers(0, len(pieces) - 1)))
        along, most = draw(st.sampled_from([(0, x1 - x0), (1, z1 - z0)]))
        if most == 1:
            pieces.append((x0, z0, x1, z1))
            continue
        cut = draw(st.integers(1, most - 1))
        if along == 0:
            pieces += [(x0, z0, x0 + cut, z1), (x0 + cut, z0, x1, z1)]
        else:
            pieces += [(x0, z0, x1, z0 + cut), (x0, z0 + cut, x1, z1)]
    n = len(pieces)
    full = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    full[0] = True
    thickness = draw(st.lists(st.sampled_from([0.2, 0.35, 0.5]), min_size=n, max_size=n))
    scale = draw(st.sampled_from([1.0, 0.1, 1 / 3]))
    return np.array(pieces) * scale, np.array(thickness), np.array(full)


@settings(max_examples=50, deadline=None)
@given(division=divisions(), order=st.sampled_from([2, 4]))
def test_any_division_makes_a_sound_file(tmp_path_factory, division, order):
    boxes, thickness, full = division
    state = np.where(full, CellState.FULL, CellState.EMPTY)
    voxels = voxels_of(boxes, thickness, state)
    solid = solid_from_voxels(voxels)
    folder = tmp_path_factory.mktemp("division")
    sound = check_anf(written(solid, folder, order))
    boxes, thickness = boxes[full], thickness[full]
    area = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
    assert sum(sound.volumes) == pytest.approx(float(area @ thickness), rel=1e-12)
    levels = np.unique(thickness)
    assert len(sound.volumes) == (thickness[:, None] >= levels).sum()
    back = read_anf(folder / "wall.anf")
    assert (back.areas, back.volumes) == (solid.areas, solid.volumes)
    assert back.patches.tolist() == solid.patches.tolist()


def test_quarters_of_unlike_thickness_meet_only_at_their_edge():
    """Behind the thinner two, the thicker two have but a line in common."""
    boxes = [(0, 0, 1, 1), (1, 1, 2, 2), (1, 0, 2, 1), (0, 1, 1, 2)]
    with pytest.raises(InputError, match=r"meet only at their edge at x = 1\.000, z = 1\.000"):
        check_joined(solid_from_voxels(voxels_of(boxes, [0.5, 0.5, 0.3, 0.3])))
    check_joined(solid_from_voxels(voxels_of(boxes, [0.5, 0.5, 0.3, 0.5])))


@pytest.mark.parametrize(
    ("boxes", "match"),
    [
        (
            [(0, 0, 1, 1), (3, 0, 4, 2)],
            r"falls into 2 pieces, the smallest of 0\.5000 m³ at x = 0\.000, z = 0",
        ),
        ([(0, 0, 1, 1), (1, 1, 2, 2)], "falls into 2 pieces"),
        (
            # A ring of voxels around two empty ones that meet in the point (2, 2).
            [(0, 0, 4, 1), (0, 3, 4, 4), (0, 1, 1, 3), (3, 1, 4, 3), (1, 2, 2, 3), (2, 1, 3, 2)],
            r"meet only at their edge at x = 2\.000, z = 2\.000",
        ),
    ],
)
def test_walls_that_do_not_hang_together(boxes, match):
    with pytest.raises(InputError, match=match) as caught:
        check_joined(solid_from_voxels(voxels_of(boxes, 0.5)))
    assert "\n" not in str(caught.value)
