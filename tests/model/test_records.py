"""Records of the reconstruction, the solid and the response: read-only, and of the shapes they state."""

import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import (
    Boundary,
    BoundaryLine,
    CellState,
    ElementKind,
    Hole,
    HoleKind,
    QuadTree,
    Response,
    Side,
    SolidModel,
    VolumeMesh,
    VoxelModel,
    rectangle,
)

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
MESH = VolumeMesh(CUBE, [range(8)], ElementKind.HEXAHEDRON, {"base": [[0, 3, 2, 1]]})


def _boundary(**changed):
    fields = {"threshold": 0.1, "points": [0, 1, 2], "triangles": [[0, 1, 2]], "hole_of_triangle": [0]}
    return Boundary(**(fields | {"outer": [0], "edge_lengths": [0.01, 0.02]} | changed))


def _hole(**changed):
    fields = {"loop": rectangle(1, 1, 1, 1)[::-1], "points": [4, 5, 6, 7], "kind": HoleKind.OPENING}
    size = {"x": 1.0, "z": 1.0, "width": 1.0, "height": 1.0, "area": 1.0}
    return Hole(**(fields | size | {"reason": "a test", "confidence": 1.0} | changed))


def _quadtree(**changed):
    fields = {"lower": [[0, 0], [1, 0]], "upper": [[1, 1], [2, 1]], "state": [0, 1], "depth": 1}
    return QuadTree(**(fields | {"index": [[0, 0], [1, 0]]} | changed))


def _line(**changed):
    fields = {"start": [0, 0], "end": [0, 1], "points": [0, 1], "side": Side.LEFT, "hole": -1}
    return BoundaryLine(**(fields | {"position": 0.0, "sigma": 0.001} | changed))


def _voxels(**changed):
    fields = {
        "lower": [[0, 0], [2, 0]],
        "upper": [[2, 3], [3, 3]],
        "state": [CellState.FULL, CellState.EMPTY],
    }
    return VoxelModel(**(fields | {"thickness": 0.5} | changed))


def _solid(**changed):
    fields = {"keypoints": CUBE[:4], "lines": [[0, 1], [1, 2], [2, 3], [3, 0]], "areas": ((1, 2, 3, 4),)}
    return SolidModel(**(fields | {"patches": [[0, 1, 2, 3]], "volumes": ((1,),)} | changed))


def _response(**changed):
    arrays = {"displacement": (8, 3), "stress": (8, 6), "principal_stress": (8, 3), "reaction": (3,)}
    names = (
        "weight max_displacement max_principal_stress p95_principal_stress p99_principal_stress rms_stress "
        "strain_energy"
    )
    fields = {name: np.zeros(shape) for name, shape in arrays.items()} | dict.fromkeys(names.split(), 0.0)
    return Response(**({"mesh": MESH, "dofs": 24} | fields | changed))


@pytest.mark.parametrize(
    ("record", "names"),
    [
        (_boundary(), "points triangles hole_of_triangle outer edge_lengths"),
        (_hole(), "loop points"),
        (_quadtree(), "lower upper state index"),
        (_line(), "start end points"),
        (_voxels(), "lower upper state"),
        (_solid(), "keypoints lines patches"),
        (_response(), "displacement stress principal_stress reaction"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_arrays_cannot_be_written_to(record, names):
    for name in names.split():
        array = getattr(record, name)
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("make", "changed", "message"),
    [
        (
            _boundary,
            {"hole_of_triangle": [0, 1]},
            r"Invalid 'hole_of_triangle': expected shape \(1\), got \(2,\)",
        ),
        (_boundary, {"edge_lengths": [np.nan]}, "Invalid 'edge_lengths': 1 of 1 values are not finite"),
        (_hole, {"loop": [[0, 0], [1, 1]]}, "Invalid 'loop': a closed polygon needs at least 3 corners"),
        (_quadtree, {"state": [0]}, r"Invalid 'state': expected shape \(2\), got \(1,\)"),
        (_quadtree, {"index": [[0, 0]]}, "Invalid 'index'"),
        (_line, {"start": [0, 0, 0]}, r"Invalid 'start': expected shape \(2\), got \(3,\)"),
        (_voxels, {"state": [1, 1, 1]}, "Invalid 'state'"),
        (_solid, {"patches": [[0, 1, 2]]}, r"Invalid 'patches': expected shape \(1, 4\), got \(1, 3\)"),
        (_response, {"displacement": np.zeros((7, 3))}, r"Invalid 'displacement': expected shape \(8, 3\)"),
        (_response, {"stress": np.full((8, 6), np.nan)}, "Invalid 'stress': 48 of 48 values are not finite"),
    ],
)
def test_arrays_of_another_shape_are_refused(make, changed, message):
    with pytest.raises(InputError, match=message):
        make(**changed)


def test_volume_counts_full_voxels_alone():
    assert _voxels().volume == pytest.approx(2 * 3 * 0.5)
    assert _voxels(state=[CellState.FULL, CellState.FULL]).volume == pytest.approx(3 * 3 * 0.5)
    assert _voxels(state=[CellState.EMPTY, CellState.EMPTY]).volume == 0.0


def test_a_loop_is_turned_counter_clockwise():
    x, z = _hole().loop.T
    assert np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z) / 2 == pytest.approx(1.0)


def test_jambs_are_upright():
    assert [side for side in Side if side.vertical] == [Side.LEFT, Side.RIGHT]
