import numpy as np
import pytest

from fd2fem.model import Side, rectangle
from fd2fem.reconstruction.profiles import outermost, piecewise_lines, profile, rim, wall_cells


def wall(spacing=0.05, seed=2):
    xz = np.random.default_rng(seed).uniform([0.0, 0.0], [8.0, 6.0], (int(48.0 / spacing**2), 2))
    return xz[np.argsort(xz[:, 0])]


def test_reach_on_all_sides():
    xz = wall()
    cells = wall_cells(xz, 0.05, [])
    for side, edge in ((Side.LEFT, 0.0), (Side.RIGHT, 8.0), (Side.BOTTOM, 0.0), (Side.TOP, 6.0)):
        seen = profile(xz, cells, side, 0.05, None)
        reach = seen.reach[seen.known] if edge else -seen.reach[seen.known]
        inside = np.abs(edge - reach) if edge else reach
        # Of n points per metre of depth in a column of three spacings the third lies 3/n inside: a spacing.
        assert np.median(inside) == pytest.approx(0.05, rel=0.25)
        assert len(inside) == pytest.approx((6.0 if side.vertical else 8.0) / cells.size, abs=2)


def test_gap_at_the_edge_and_hidden_columns_are_unknown():
    xz = wall()
    gap = rectangle(3.0, 5.0, 1.0, 1.0)
    xz = xz[~((xz > gap.min(axis=0)) & (xz < gap.max(axis=0))).all(axis=1)]
    cells = wall_cells(xz, 0.05, [gap])
    seen = profile(xz, cells, Side.TOP, 0.05, lambda places: places[:, 0] > 7.0)
    assert not seen.known[(seen.along > 3.2) & (seen.along < 3.8)].any()
    assert not seen.known[seen.along > 7.0].any()
    assert seen.known[(seen.along > 4.2) & (seen.along < 6.9)].all()


def test_rim_holds_the_edge_and_little_else():
    xz = wall()
    near = rim(wall_cells(xz, 0.05, []), 0.4)
    depth = np.min([xz[:, 0], 8.0 - xz[:, 0], xz[:, 1], 6.0 - xz[:, 1]], axis=0)
    assert near[depth < 0.4].all()
    assert not near[depth > 0.8].any()


def test_outermost_against_sorting():
    rng = np.random.default_rng(3)
    column, value = rng.integers(0, 20, 500), rng.normal(size=500)
    kept, first, third = outermost(column, value, 20, 3)
    for number in range(20):
        ordered = np.sort(value[column == number])[::-1]
        assert first[number] == ordered[0]
        assert third[number] == ordered[2]
    assert len(kept) == 60


def test_pieces_of_a_known_profile():
    x = np.arange(0.0, 12.0, 0.1)
    z = np.where(x < 3.0, 8.0, np.where(x < 7.0, 8.0 + 0.5 * (x - 3.0), 9.0))
    z = z + np.random.default_rng(4).normal(0.0, 0.01, len(x))
    pieces = piecewise_lines(x, z, np.ones(len(x)), sigma=0.03, least=4, price=50.0)
    assert [start for start, _ in pieces] == pytest.approx([0, 30, 70], abs=1)
