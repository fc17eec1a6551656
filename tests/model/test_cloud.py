import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import PointCloud

POINTS = np.array([[715_830.1234, 734_120.5678, 12.5], [715_831.0, 734_121.0, 13.0]])


def test_survey_coordinates_keep_their_digits():
    cloud = PointCloud(POINTS.tolist(), "a survey")
    assert len(cloud) == 2
    assert cloud.points.dtype == np.float64
    assert cloud.points.tolist() == POINTS.tolist()


def test_what_the_file_does_not_say_is_empty():
    cloud = PointCloud(POINTS, "a survey")
    assert cloud.intensity.shape == (0,)
    assert cloud.scanners.shape == (0, 3)
    assert cloud.station.shape == (0,)
    assert cloud.no_returns == 0


def test_a_cloud_may_be_empty():
    assert len(PointCloud([], "nothing")) == 0


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"points": np.zeros((4, 2))}, r"Invalid 'points': expected shape \(n, 3\), got \(4, 2\)"),
        ({"points": [[0, 0, np.nan]]}, "Invalid 'points': 1 of 3 values are not finite"),
        ({"intensity": [0.5]}, "Invalid 'intensity': expected 2 values or none, got 1"),
        ({"intensity": [[0.5, 0.5]]}, r"Invalid 'intensity': expected shape \(n\)"),
        ({"station": [0, 0]}, "Invalid 'station': expected -1 to -1, as there are 0 scanners, got 0 to 0"),
        ({"station": [-2, -1]}, "Invalid 'station': expected -1 to -1, .*, got -2 to -1"),
        ({"station": [-1]}, "Invalid 'station': expected 2 values or none, got 1"),
        ({"station": [0.5, 0], "scanners": [[0, 0, 0]]}, "Invalid 'station': expected whole numbers"),
        (
            {"station": [0, 1], "scanners": [[0, 0, 0]]},
            "expected -1 to 0, as there are 1 scanners, got 0 to 1",
        ),
        ({"scanners": [1.0, 2.0, 3.0]}, r"Invalid 'scanners': expected shape \(n, 3\), got \(3,\)"),
    ],
)
def test_a_cloud_that_does_not_hold_together_is_refused(changed, message):
    with pytest.raises(InputError, match=message):
        PointCloud(**({"points": POINTS, "source": "a survey"} | changed))


def test_a_cloud_cannot_be_changed():
    own = POINTS.copy()
    cloud = PointCloud(own, "a survey", intensity=[0.1, 0.9], scanners=[[0, -10, 1.6]], station=[0, -1])
    own[:] = 0.0
    assert cloud.points[0, 2] == 12.5
    for name in ("points", "intensity", "scanners", "station"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(cloud, name)[0] = 0.0


def test_an_array_that_nobody_can_change_is_not_copied():
    fixed = POINTS.copy()
    fixed.setflags(write=False)
    assert PointCloud(fixed, "a survey").points is fixed
    window = POINTS.copy()[:]  # whoever holds the base of a view could change it
    window.setflags(write=False)
    assert PointCloud(window, "a survey").points is not window


@pytest.mark.parametrize("bad", [np.full((2, 3), np.nan), np.zeros((2, 2)), np.zeros(6)])
def test_an_array_that_nobody_can_change_is_checked(bad):
    bad.setflags(write=False)
    with pytest.raises(InputError, match="Invalid 'points'"):
        PointCloud(bad, "a survey")
