import pytest

from fd2fem.errors import InputError
from fd2fem.meshing import MeshOptions
from fd2fem.meshing.options import divisions


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"size": 0.0}, "Invalid 'size': expected a positive number, got 0.0"),
        ({"size": float("nan")}, "Invalid 'size'"),
        ({"layers": -1}, "Invalid 'layers': expected a whole number of at least 0, got -1"),
        ({"layers": 1.5}, "Invalid 'layers': expected a whole number"),
        ({"pier_elements": 0}, "Invalid 'pier_elements': expected a whole number of at least 1, got 0"),
        ({"min_scaled_jacobian": 1.0}, "Invalid 'min_scaled_jacobian'"),
        ({"min_scaled_jacobian": -0.1}, "Invalid 'min_scaled_jacobian'"),
    ],
)
def test_options_out_of_range(values, message):
    with pytest.raises(InputError, match=message):
        MeshOptions(**values)


@pytest.mark.parametrize(
    ("layers", "thickness", "expected"), [(0, 0.35, 2), (0, 0.1, 1), (0, 1.0, 4), (3, 0.1, 3)]
)
def test_layers_through(layers, thickness, expected):
    assert MeshOptions(size=0.25, layers=layers).layers_through(thickness) == expected


def test_elements_stay_near_the_size():
    # by hand: n = floor(q + 0.63), so q / n lies between 0.63 (just above 0.37 + 0) and 1.37
    for tenths in range(4, 200):
        ratio = tenths / 10 / divisions(tenths / 10, 1.0)
        assert 0.37 <= ratio <= 1.37


@pytest.mark.parametrize("size", [0.1, 0.2, 0.25, 0.5])
def test_a_millimetre_does_not_decide_at_round_dimensions(size):
    for centimetres in range(5, 1000, 5):
        length = centimetres / 100
        assert divisions(length - 0.001, size) == divisions(length + 0.001, size)
