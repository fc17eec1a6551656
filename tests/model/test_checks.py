import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import rectangle
from fd2fem.model.checks import as_array, as_points, as_ring, check_positive, signed_area


def test_array_is_a_read_only_copy():
    given_values = np.array([1.0, 2.0, 3.0])
    array = as_array("origin", given_values, (3,))
    given_values[0] = 99.0
    assert array.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0.0


@pytest.mark.parametrize(
    ("values", "shape", "message"),
    [
        ([1, 2], (3,), r"Invalid 'origin': expected shape \(3\), got \(2,\)"),
        ([[1, 2]], (None,), r"expected shape \(n\), got \(1, 2\)"),
        ([[1, 2]], (None, 3), r"expected shape \(n, 3\), got \(1, 2\)"),
        ([1, np.nan, np.inf], (3,), "Invalid 'origin': 2 of 3 values are not finite"),
    ],
)
def test_array_says_what_is_wrong(values, shape, message):
    with pytest.raises(InputError, match=message):
        as_array("origin", values, shape)


def test_integer_array_keeps_its_type():
    assert as_array("points", [3, 1], (None,), dtype=np.intp).dtype == np.intp


@pytest.mark.parametrize("empty", [[], np.empty(0), np.empty((0, 2)), np.empty((0, 7))])
def test_no_points_are_points(empty):
    assert as_points("xz", empty, dim=2).shape == (0, 2)


def test_points_of_another_dimension_are_refused():
    with pytest.raises(InputError, match=r"Invalid 'xz': expected shape \(n, 2\), got \(4, 3\)"):
        as_points("xz", np.zeros((4, 3)), dim=2)


# Shoelace formula by hand: a right triangle with legs 3 and 4, the same turned round, an L of five squares.
@pytest.mark.parametrize(
    ("ring", "area"),
    [
        ([[0, 0], [3, 0], [0, 4]], 6.0),
        ([[0, 0], [0, 4], [3, 0]], -6.0),
        ([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], 5.0),
    ],
)
def test_signed_area_by_hand(ring, area):
    assert signed_area(ring) == pytest.approx(area, rel=1e-15)


@given(
    size=st.tuples(st.floats(0.1, 50.0), st.floats(0.1, 50.0)),
    corner=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    turned=st.booleans(),
    closed=st.booleans(),
)
@settings(max_examples=40, deadline=None)
def test_ring_runs_counter_clockwise_and_keeps_its_area(size, corner, turned, closed):
    ring = rectangle(*corner, *size)
    ring = ring[::-1] if turned else ring
    checked = as_ring("outline", np.vstack([ring, ring[:1]]) if closed else ring)
    assert len(checked) == 4
    assert signed_area(checked) == pytest.approx(size[0] * size[1], rel=1e-9)


@pytest.mark.parametrize(
    ("ring", "message"),
    [
        ([[0, 0], [1, 0]], "Invalid 'outline': a closed polygon needs at least 3 corners, got 2"),
        ([[0, 0], [1, 0], [0, 0]], "at least 3 corners, got 2"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "Self-intersection.*does not cross itself"),
        ([[0, 0], [1, 0], [2, 0]], "Invalid 'outline'.*expected a polygon with area"),
        ([], "at least 3 corners, got 0"),
    ],
)
def test_ring_says_what_is_wrong(ring, message):
    with pytest.raises(InputError, match=message):
        as_ring("outline", ring)


@pytest.mark.parametrize("value", [0, -0.35, np.nan, np.inf, -np.inf])
def test_only_positive_finite_numbers_are_positive(value):
    with pytest.raises(InputError, match=f"Invalid 'thickness': expected a positive number, got {value}"):
        check_positive("thickness", value)


def test_input_errors_are_value_errors():
    with pytest.raises(ValueError, match="positive"):
        check_positive("thickness", -1)
