import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import LoadCase


def test_a_case_of_a_wall():
    case = LoadCase(3e9, 0.0, 1900.0, 0.0, base=lambda points: 0.001 * points)
    np.testing.assert_allclose(case.base(np.ones((2, 3))), np.full((2, 3), 0.001))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("young", 0.0), ("young", np.nan), ("density", -1.0), ("poisson", 0.5), ("poisson", -0.1),
        ("poisson", np.nan), ("gravity", -9.81), ("gravity", np.inf), ("gravity", np.nan),
    ],
)  # fmt: skip
def test_values_out_of_range(name, value):
    values = {"young": 3e9, "poisson": 0.2, "density": 1900.0, "gravity": 9.81} | {name: value}
    with pytest.raises(InputError, match=f"'{name}'"):
        LoadCase(**values, base=np.zeros_like)
