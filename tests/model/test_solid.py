import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import LoadCase, VoxelModel, WallCells

SQUARES = [[0, 0], [1, 0], [2, 0], [0, 2], [1, 2], [2, 2]]


def test_volume_of_cells_of_two_thicknesses():
    cells = WallCells(SQUARES, [[0, 1, 4, 3], [1, 2, 5, 4]], [0.3, 0.5])
    assert cells.volume == pytest.approx(2 * 0.3 + 2 * 0.5)


def test_one_thickness_serves_all():
    assert WallCells(SQUARES, [[0, 1, 4, 3], [1, 2, 5, 4]], 0.3).thickness.tolist() == [0.3, 0.3]
    voxels = VoxelModel([[0, 0], [1, 0]], [[1, 1], [2, 1]], [1, 0], 0.4)
    assert voxels.thickness.tolist() == [0.4, 0.4]
    assert voxels.volume == pytest.approx(0.4)


def test_a_slanted_cell():
    # A trapezoid with sides of 1 and 2 m, 1 m apart.
    cells = WallCells([[0, 0], [1, 0], [1, 2], [0, 1]], [[0, 1, 2, 3]], 0.2)
    assert cells.volume == pytest.approx(1.5 * 0.2)


@pytest.mark.parametrize(
    ("corners", "thickness", "message"),
    [
        ([[0, 1, 4, 6]], 0.3, "points that are not among the 6"),
        ([[0, 1, 4, 3]], 0.0, "'thickness': expected positive"),
        ([[0, 1, 4]], 0.3, "'corners': expected shape"),
    ],
)
def test_cells_that_make_no_sense(corners, thickness, message):
    with pytest.raises(InputError, match=message):
        WallCells(SQUARES, corners, thickness)


def test_a_load_case_needs_a_stiffness():
    with pytest.raises(InputError, match="'young'"):
        LoadCase(0.0, 0.2, 1900.0, 9.81, np.zeros_like)
