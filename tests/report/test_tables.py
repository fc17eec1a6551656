import json

import pytest
from synthetic import facade_of

from fd2fem.model import Facade, FilledHole, rectangle
from fd2fem.report import facade_summary


def test_summary_by_hand():
    summary = facade_summary(facade_of(4.0, 3.0, [(0.6, 0.0, 0.9, 2.0), (2.2, 1.0, 1.2, 1.3)]))
    assert (summary["length"], summary["height"], summary["thickness"]) == (4.0, 3.0, 0.35)
    assert summary["opening_area"] == pytest.approx(0.9 * 2.0 + 1.2 * 1.3)
    door, window = summary["openings"]
    assert (door["id"], door["kind"], door["z"], door["confidence"]) == (1, "door", 0.0, 1.0)
    assert [window[name] for name in ("x", "z", "width", "height")] == pytest.approx([2.2, 1.0, 1.2, 1.3])


def test_summary_of_a_drawing_has_no_points_and_no_warnings():
    summary = facade_summary(Facade(rectangle(0, 0, 4, 3), 0.35))
    assert [summary[name] for name in ("openings", "filled_holes", "warnings")] == [[], [], []]
    assert summary["points"] == {}


def test_summary_is_json():
    hole = FilledHole(rectangle(1, 1, 0.5, 2), "in the shadow of a post")
    record = {"points": {"read": 10, "on_facade": 8}, "warnings": ["look"]}
    facade = Facade(rectangle(0, 0, 4, 3), 0.35, filled_holes=(hole,), record=record)
    summary = json.loads(json.dumps(facade_summary(facade)))
    assert summary["filled_holes"] == [{"area": 1.0, "reason": "in the shadow of a post"}]
    assert (summary["points"], summary["warnings"]) == ({"read": 10, "on_facade": 8}, ["look"])
