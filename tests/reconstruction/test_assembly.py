import pytest

from fd2fem.model import Opening, OpeningKind, rectangle
from fd2fem.reconstruction.assembly import complete_sills
from fd2fem.reconstruction.options import ReconstructionOptions

OPTIONS = ReconstructionOptions()


def window(x, z=0.7, width=1.6, head=3.1):
    return Opening(0, OpeningKind.WINDOW, rectangle(x, z, width, head - z), evidence={"foot_in_shadow": 0.0})


def door(x, *, shadow, width=1.6, head=3.1):
    return Opening(0, OpeningKind.DOOR, rectangle(x, 0.0, width, head), evidence={"foot_in_shadow": shadow})


def test_hidden_sill_is_that_of_like_windows():
    found = complete_sills([window(0.5), window(3.0, z=0.72), door(6.0, shadow=0.9)], options=OPTIONS)[2]
    assert found.kind is OpeningKind.WINDOW
    assert (found.z, found.z + found.height) == pytest.approx((0.71, 3.1))
    assert found.sigma.bottom >= 0.05
    assert found.evidence["sill"] == "hidden; taken from 2 openings like it"


@pytest.mark.parametrize(
    "openings",
    [
        [window(0.5), window(3.0), door(6.0, shadow=0.2)],
        [window(0.5), window(3.0), door(6.0, shadow=0.9, width=1.0)],
        [window(0.5), window(3.0), door(6.0, shadow=0.9, head=2.5)],
        [window(0.5), door(6.0, shadow=0.9)],
    ],
    ids=["foot seen", "other width", "other head", "one window only"],
)
def test_door_stays_a_door(openings):
    assert complete_sills(openings, options=OPTIONS)[-1].kind is OpeningKind.DOOR
