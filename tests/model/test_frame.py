import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import FacadeFrame, FacadePoints
from fd2fem.model.frame import Attachment, OutOfPlane, WallCandidate

coordinates = st.floats(-1e6, 1e6)
local = st.floats(-100.0, 100.0)


def _axes(turn, lean):
    """Rows X, Y, Z: leant about x, then turned about the vertical, rad."""
    about_x = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    about_z = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return (about_z @ about_x).T


@given(
    origin=st.tuples(coordinates, coordinates, coordinates),
    turn=st.floats(0.0, 7.0),
    lean=st.floats(-0.2, 0.2),
    point=st.tuples(local, local, local),
)
@settings(max_examples=100, deadline=None)
def test_there_and_back_again(origin, turn, lean, point):
    frame = FacadeFrame(np.array(origin), _axes(turn, lean))
    world = frame.to_world([point])
    # float64 at 1e6 m resolves 1.2e-10 m; the sums of three terms stay well under 1e-8.
    assert frame.to_facade(world) == pytest.approx(np.array([point]), abs=1e-8)


@given(turn=st.floats(0.0, 7.0), lean=st.floats(-0.2, 0.2), a=st.tuples(local, local, local))
@settings(max_examples=50, deadline=None)
def test_lengths_and_handedness_stay(turn, lean, a):
    frame = FacadeFrame(np.array([7e5, 7e5, 10.0]), _axes(turn, lean))
    X, Y, Z = frame.to_world(np.eye(3)) - frame.origin
    assert np.cross(X, Y) == pytest.approx(Z, abs=1e-9)
    moved = frame.to_world([a, [0, 0, 0]])
    assert np.linalg.norm(moved[0] - moved[1]) == pytest.approx(np.linalg.norm(a), abs=1e-8)


def test_a_wall_that_faces_north():
    # Seen from the north, the right hand is west: X = -x, into the wall is south: Y = -y.
    frame = FacadeFrame(np.array([10.0, 20.0, 1.0]), np.diag([-1.0, -1.0, 1.0]))
    assert frame.to_world([[2, 3, 4]]).tolist() == [[8, 17, 5]]
    assert frame.to_facade([[8, 17, 5]]).tolist() == [[2, 3, 4]]


def test_moving_the_origin_along_the_wall():
    frame = FacadeFrame(np.array([10.0, 20.0, 1.0]), np.diag([-1.0, -1.0, 1.0])).moved(2.0, 0.5)
    assert frame.origin.tolist() == [8.0, 20.0, 1.5]
    assert frame.to_facade([[8.0, 20.0, 1.5]]).tolist() == [[0.0, 0.0, 0.0]]


def test_the_frame_of_a_drawing_is_the_world():
    points = np.arange(6.0).reshape(2, 3)
    assert FacadeFrame.identity().to_world(points).tolist() == points.tolist()


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        (np.diag([-1.0, 1.0, 1.0]), "Invalid 'axes': expected three orthonormal rows, right-handed"),
        (2.0 * np.eye(3), "orthonormal"),
        (np.array([[1, 0, 0], [1, 0, 0], [0, 0, 1]]), "orthonormal"),
        (np.array([[1, 1e-4, 0], [0, 1, 0], [0, 0, 1]]), "orthonormal"),
        (np.eye(2), r"Invalid 'axes': expected shape \(3, 3\), got \(2, 2\)"),
    ],
)
def test_axes_that_are_no_right_handed_frame_are_refused(axes, message):
    with pytest.raises(InputError, match=message):
        FacadeFrame(np.zeros(3), axes)


def test_points_of_a_frame_must_be_three_dimensional():
    with pytest.raises(InputError, match=r"Invalid 'world': expected shape \(n, 3\), got \(1, 2\)"):
        FacadeFrame.identity().to_facade([[1, 2]])


def _points(**changed):
    fields = {
        "xz": [[0, 0], [1, 0]],
        "depth": [0.0, 0.001],
        "front": [[0, -1, 0]],
        "behind": [],
        "scanners": [],
        "frame": FacadeFrame.identity(),
        "rms": 0.001,
        "spacing": 1.0,
        "ground": None,
        "outside_by": "a test",
    }
    return FacadePoints(**(fields | changed))


def test_facade_points_are_read_only():
    points = _points()
    assert points.behind.shape == points.scanners.shape == (0, 3)
    for name in ("xz", "depth", "front", "behind", "scanners"):
        assert not getattr(points, name).flags.writeable


def test_every_point_on_the_wall_has_a_depth():
    with pytest.raises(InputError, match=r"Invalid 'depth': expected shape \(2\), got \(1,\)"):
        _points(depth=[0.0])


def test_points_move_with_all_that_belongs_to_them():
    points = _points(
        ground=-0.5,
        scanners=[[1, -9, 1]],
        relief=OutOfPlane([0.0, 0.0], 0.5, [[0.01, 0.02]]),
        attachments=(Attachment("bay", 3.0, 2.0, 1.0, 2.0, 0.5),),
    )
    moved = points.moved(0.25, -0.5)
    assert moved.xz.tolist() == [[-0.25, 0.5], [0.75, 0.5]]
    assert moved.scanners.tolist() == [[0.75, -9.0, 1.5]]
    assert moved.front.tolist() == [[-0.25, -1.0, 0.5]]
    assert moved.ground == 0.0
    assert moved.relief.low.tolist() == [-0.25, 0.5]
    assert (moved.attachments[0].x, moved.attachments[0].z) == (2.75, 2.5)
    # The world does not move.
    world = points.frame.to_world(np.insert(points.xz, 1, 0.0, axis=1))
    assert moved.frame.to_world(np.insert(moved.xz, 1, 0.0, axis=1)) == pytest.approx(world)


def test_map_of_the_face_holds_numbers_somewhere():
    assert not OutOfPlane([0, 0], 0.5, [[0.0, np.nan]]).values.flags.writeable
    for values in ([[np.nan]], [[np.inf]], [0.0, 1.0]):
        with pytest.raises(InputError, match="Invalid 'values'"):
            OutOfPlane([0, 0], 0.5, values)


def test_centre_of_a_wall_is_a_place():
    with pytest.raises(InputError, match="Invalid 'centre'"):
        WallCandidate(1, 6.0, 5.0, [1.0, 2.0], 180.0, 1000, chosen=True)
