"""Cells as CAD solids: volumes, sharing of faces and edges, and validity."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.model import Facade, Group, WallCells
from fd2fem.solids import cad_cells, face_groups, solid_from_cells, solid_from_voxels


def test_a_wall_with_windows_in_unequal_cells(make_wall, measured):
    voxels = make_wall(5.0, 4.0, [(1.03, 0.8, 2.11, 2.2), (3.0, 1.5, 4.0, 3.1)])
    solid = solid_from_voxels(voxels)
    cells = cad_cells(solid)
    assert cells.isValid()
    assert [part.Volume() for part in cells.Solids()] == pytest.approx(measured(solid).volumes, rel=1e-9)
    assert (len(cells.Vertices()), len(cells.Edges()), len(cells.Faces()), len(cells.Solids())) == (
        len(solid.keypoints),
        len(solid.lines),
        len(solid.areas),
        len(solid.volumes),
    )
    assert cells.Volume() == pytest.approx(0.35 * (20 - 1.08 * 1.4 - 1.6), rel=1e-12)


def test_slanted_cells_of_two_thicknesses():
    """Two cells of 0.5 m below a gable of two, 0.3 m thick, of 2.4 m² each."""
    points = [(0, 0), (2, 0), (4, 0), (0, 3), (2, 3), (4, 3), (0.8, 4.2), (2, 5), (3.2, 4.2)]
    corners = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
    wall = WallCells(np.array(points, float), np.array(corners), np.array([0.5, 0.5, 0.3, 0.3]))
    cells = cad_cells(solid_from_cells(wall))
    assert cells.isValid()
    assert len(cells.Solids()) == 2 * 2 + 2  # the thick ones in two layers, so that neighbours match
    assert cells.Volume() == pytest.approx(0.5 * 12 + 0.3 * 4.8, rel=1e-12)
    ring = np.array([(0, 0), (4, 0), (4, 3), (3.2, 4.2), (2, 5), (0.8, 4.2), (0, 3)], float)
    groups = Counter(face_groups(cells, Facade(ring, 0.5)))
    # Between layers, between the thick cells twice, between thick and thin ones, between the thin ones.
    assert groups[None] == 2 + 2 + 2 + 1
    assert (groups[Group.FRONT], groups[Group.BACK], groups[Group.LEDGES]) == (4, 4, 2)
    assert (groups[Group.BASE], groups[Group.TOP], groups[Group.LEFT], groups[Group.RIGHT]) == (4, 4, 2, 2)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(*[st.integers(0, 4)] * 2), min_size=1, max_size=12, unique=True))
def test_any_set_of_unit_cells(make_voxels, places):
    cells = cad_cells(solid_from_voxels(make_voxels([(x, z, x + 1, z + 1) for x, z in places], 0.3)))
    assert cells.isValid()
    assert cells.Volume() == pytest.approx(0.3 * len(places), rel=1e-12)
    upright = {(x + dx, z) for x, z in places for dx in (0, 1)}
    level = {(x, z + dz) for x, z in places for dz in (0, 1)}
    assert len(cells.Faces()) == 2 * len(places) + len(upright) + len(level)
