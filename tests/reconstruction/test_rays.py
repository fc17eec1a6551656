import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import STATION, scene
from synthetic import facade_of

from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.plane import find_facade
from fd2fem.reconstruction.rays import cast_shadows, is_hidden, ray_map, rows_in_the_light, throw

WALL = facade_of(7.0, 5.0, [(1.0, 1.0, 1.2, 1.6)])
PANEL = (-2.0, 3.6, 2.0, 0.8, 1.2)


def shadow_of(panel, station=STATION):
    """Corners of a panel's shadow on the wall, by similar triangles."""
    y, x, z, width, height = panel
    corners = np.array([[x, z], [x + width, z + height]])
    return station[[0, 2]] + (corners - station[[0, 2]]) * station[1] / (station[1] - y)


def shadows_in(cloud):
    points = find_facade(cloud, options=ReconstructionOptions())
    return cast_shadows(ray_map(cloud, points)), points.frame.origin[[0, 2]]


@given(
    st.tuples(st.floats(-20, 20), st.floats(-15, -0.5), st.floats(0, 20)),
    st.floats(0.05, 3.0),
    st.tuples(st.floats(-10, 10), st.floats(-5, 15)),
)
def test_a_point_is_thrown_to_where_its_ray_meets_the_wall(station, share, place):
    station, place = np.array(station), np.insert(np.array(place), 1, 0.0)
    point = station + share * (place - station)
    assert throw(point[None], station)[0] == pytest.approx(place[[0, 2]], abs=1e-6)


def test_points_behind_the_scanner_throw_no_shadow():
    assert np.isnan(throw(np.array([[0.0, -12.0, 1.0]]), STATION)).all()


def test_shadow_lies_where_similar_triangles_say():
    shadows, origin = shadows_in(scene(WALL, 0.025, panels=[PANEL]))
    low, high = shadow_of(PANEL) - origin
    x, z = np.nonzero(shadows.hidden)
    cells = shadows.rays.low + shadows.rays.cell * (np.column_stack([x, z]) + 0.5)
    assert cells.min(axis=0) == pytest.approx(low, abs=shadows.rays.cell)
    assert cells.max(axis=0) == pytest.approx(high, abs=shadows.rays.cell)
    assert is_hidden(shadows, ((low + high) / 2)[None]).all()
    assert not is_hidden(shadows, np.array([low - 0.2, [99.0, 99.0]])).any()


def test_window_is_seen_through_and_the_panel_is_not():
    shadows, origin = shadows_in(scene(WALL, 0.025, panels=[PANEL]))
    x, z = np.nonzero(shadows.passed)
    cells = shadows.rays.low + shadows.rays.cell * (np.column_stack([x, z]) + 0.5) + origin
    assert cells.min(axis=0) == pytest.approx([1.0, 1.0], abs=shadows.rays.cell)
    assert cells.max(axis=0) == pytest.approx([2.2, 2.6], abs=shadows.rays.cell)


def test_only_what_every_station_misses_is_hidden():
    stations = np.array([[1.0, -8.0, 1.6], [6.0, -8.0, 1.6]])
    shadows, origin = shadows_in(scene(WALL, 0.025, panels=[PANEL], stations=stations))
    each = [shadow_of(PANEL, station) - origin for station in stations]
    low, high = np.max([corners[0] for corners in each], axis=0), np.min([c[1] for c in each], axis=0)
    both = np.prod(np.maximum(high - low, 0.0))
    assert shadows.hidden.sum() * shadows.rays.cell**2 == pytest.approx(both, abs=0.15)


def test_a_ray_is_not_ascribed_to_a_station_that_could_not_see_it():
    # What is seen through the window from one station lies, from the other, behind the panel's shadow.
    stations = np.array([[1.0, -8.0, 1.6], [6.0, -8.0, 1.6]])
    panel = (-0.4, 3.2, 1.0, 1.6, 1.8)
    cloud = scene(WALL, 0.025, panels=[panel], stations=stations, room=3.0)
    known, _ = shadows_in(cloud)
    unknown, _ = shadows_in(type(cloud)(cloud.points, "no stations", scanners=stations))
    assert not (unknown.passed & known.hidden).any()


def test_rows_beside_a_shadow_are_told_apart():
    shadows, origin = shadows_in(scene(WALL, 0.025, panels=[PANEL]))
    low, high = shadow_of(PANEL) - origin
    box = np.array([[low[0] - 0.1, low[1] - 1.0], [low[0] + 0.1, high[1] + 1.0]])
    along = np.array([low[1] - 0.5, (low[1] + high[1]) / 2, high[1] + 0.5])
    assert rows_in_the_light(shadows, box, along, 1).tolist() == [True, False, True]
