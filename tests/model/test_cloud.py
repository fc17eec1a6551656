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


def test_a_cloud_may_be_empty():
    assert len(PointCloud([], "nothing")) == 0


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"points": np.zeros((4, 2))}, r"Invalid 'points': expected shape \(n, 3\), got \(4, 2\)"),
        ({"points": [[0, 0, np.nan]]}, "Invalid 'points': 1 of 3 values are not finite"),
        ({"intensity": [0.5]}, "Invalid 'intensity': expected 2 values or none, got 1"),
        ({"intensity": [[0.5, 0.5]]}, r"Invalid 'intensity': expected shape \(n\)"),
        ({"scanners": [1.0, 2.0, 3.0]}, r"Invalid 'scanners': expected shape \(n, 3\), got \(3,\)"),
    ],
)
def test_a_cloud_that_does_not_hold_together_is_refused(changed, message):
    with pytest.raises(InputError, match=message):
        PointCloud(**({"points": POINTS, "source": "a survey"} | changed))


def test_a_cloud_cannot_be_changed():
    own = POINTS.copy()
    cloud = PointCloud(own, "a survey", intensity=[0.1, 0.9], scanners=[[0, -10, 1.6]])
    own[:] = 0.0
    assert cloud.points[0, 2] == 12.5
    for name in ("points", "intensity", "scanners"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(cloud, name)[0] = 0.0
