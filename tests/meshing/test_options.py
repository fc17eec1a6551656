import pytest

from fd2fem.config import options_from_dict
from fd2fem.errors import InputError
from fd2fem.meshing import ElementShape, MeshOptions
from fd2fem.meshing.options import divisions
from fd2fem.model import Facade, rectangle


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"size": 0.0}, "Invalid 'size': expected a positive number, got 0.0"),
        ({"size": float("nan")}, "Invalid 'size'"),
        ({"layers": -1}, "Invalid 'layers': expected a whole number from 0 to 100, got -1"),
        ({"layers": 1.5}, "Invalid 'layers': expected a whole number"),
        ({"pier_elements": 0}, "Invalid 'pier_elements': expected a whole number from 1 to 100, got 0"),
        ({"order": 3}, "Invalid 'order': expected 1, 2, or 0 .*, got 3"),
        ({"corner_size": 0.0}, "Invalid 'corner_size': expected a positive number"),
        ({"size": 0.2, "corner_size": 0.3}, "'corner_size': 0.3 m is more than the size of 0.2 m"),
        ({"min_scaled_jacobian": 1.0}, "Invalid 'min_scaled_jacobian'"),
        ({"min_scaled_jacobian": -0.1}, "Invalid 'min_scaled_jacobian'"),
    ],
)
def test_options_out_of_range(values, message):
    with pytest.raises(InputError, match=message):
        MeshOptions(**values)


def test_a_size_from_the_wall_or_as_asked():
    facade = Facade(rectangle(0, 0, 6, 4), 0.1)
    assert MeshOptions().for_wall(facade).size == MeshOptions().size_for(facade) == pytest.approx(0.072)
    assert MeshOptions(size=0.3).for_wall(facade) == MeshOptions(size=0.3)


def test_options_from_a_configuration():
    section = {"order": 2, "elements": "tetrahedra", "corner_size": 0.05}
    options = options_from_dict({"mesh": section}, source="test").mesh
    assert options == MeshOptions(order=2, elements=ElementShape.TETRAHEDRA, corner_size=0.05)
    with pytest.raises(InputError, match="elements: Input should be 'hexahedra' or 'tetrahedra'"):
        options_from_dict({"mesh": {"elements": "prisms"}}, source="test")


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (MeshOptions(size=1e-6), r"Elements of 1e-06 m would be .* take larger ones"),
        (MeshOptions(size=0.2, corner_size=1e-4), "less than a hundredth of the size of 0.2 m"),
    ],
)
def test_elements_that_no_machine_would_hold_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        options.for_wall(Facade(rectangle(0, 0, 5, 6), 0.35))


@pytest.mark.parametrize("name", ["layers", "pier_elements"])
def test_more_than_a_hundred_elements_across_are_refused(name):
    with pytest.raises(InputError, match=f"'{name}': expected a whole number from . to 100, got 101"):
        MeshOptions(**{name: 101})
