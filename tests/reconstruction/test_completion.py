import numpy as np
import pytest
from synthetic import sketch

from fd2fem.model import Side
from fd2fem.reconstruction.completion import Draft, complete_edges


def draft(x, z, width, height, *, unseen=(), door=False):
    """A draft of an opening; `unseen` maps sides to the interval they lie in."""
    hole = sketch(x, z, width, height, unseen=dict(unseen))
    position = {Side.LEFT: x, Side.RIGHT: x + width, Side.BOTTOM: z, Side.TOP: z + height}
    return Draft(0, hole, position, dict.fromkeys(Side, 0.003), door)


ROW = [draft(3.0 + 2 * k, 1.0, 1.2, 1.6) for k in range(3)]


def test_sill_comes_from_the_row():
    hidden = draft(1.0, 0.0, 1.2, 2.6, unseen={Side.BOTTOM: (0.0, 1.5)}, door=True)
    done = complete_edges([hidden, *ROW])[0]
    assert done.position[Side.BOTTOM] == pytest.approx(1.0)
    assert not done.door
    assert done.sigma[Side.BOTTOM] > done.sigma[Side.TOP]
    assert "3 openings" in done.notes[Side.BOTTOM]


def test_jamb_comes_from_the_column():
    above = draft(1.0, 4.0, 1.3, 1.6)
    hidden = draft(1.0, 1.0, 0.9, 1.6, unseen={Side.RIGHT: (1.9, 2.5)})
    done = complete_edges([hidden, above, *ROW])[0]
    assert done.position[Side.RIGHT] == pytest.approx(2.3)


def test_jamb_is_as_far_away_as_the_row_says_where_no_column_tells():
    hidden = draft(1.0, 1.0, 0.9, 1.6, unseen={Side.RIGHT: (1.9, 2.5)})
    assert complete_edges([hidden, *ROW])[0].position[Side.RIGHT] == pytest.approx(2.2)


def test_what_lies_outside_of_the_shadow_is_no_witness():
    hidden = draft(1.0, 1.3, 1.2, 1.3, unseen={Side.BOTTOM: (1.2, 1.6)})
    done = complete_edges([hidden, draft(3.0, 0.4, 1.2, 2.2)])[0]
    # Half-way, with the standard deviation of an even distribution.
    assert done.position[Side.BOTTOM] == pytest.approx(1.4)
    assert done.sigma[Side.BOTTOM] == pytest.approx(0.4 / np.sqrt(12))


def test_door_with_a_hidden_foot_and_no_like_stays_a_door():
    hidden = draft(1.0, 0.0, 1.2, 2.6, unseen={Side.BOTTOM: (0.0, 1.5)}, door=True)
    done = complete_edges([hidden])[0]
    assert done.door
    assert done.position[Side.BOTTOM] == 0.0
    assert "may be a window" in done.notes[Side.BOTTOM]


def test_edges_that_were_seen_stay():
    hidden = draft(1.0, 0.0, 1.2, 2.6, unseen={Side.BOTTOM: (0.0, 1.5)}, door=True)
    for before, after in zip(ROW, complete_edges([hidden, *ROW])[1:], strict=True):
        assert after is before


def test_jamb_comes_from_another_storey_where_nothing_else_tells():
    above = [draft(2.0, 4.0, 1.4, 1.6), draft(2.05, 7.0, 1.35, 1.6)]
    hidden = draft(1.0, 1.0, 2.2, 1.6, unseen={Side.RIGHT: (3.2, 3.45)})
    done = complete_edges([hidden, *above])[0]
    assert done.position[Side.RIGHT] == pytest.approx(3.4)
