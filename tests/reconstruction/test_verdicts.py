from dataclasses import replace

import pytest

from fd2fem.model import HoleKind
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.verdicts import Evidence, equation_1, weigh

OPTIONS = ReconstructionOptions()
WINDOW = Evidence(length=1.0, height=1.5, rectangularity=0.95)


@pytest.mark.parametrize(
    ("height", "length", "reason"),
    [
        (0.4, 0.4, ""),
        (5.0, 1.0, ""),
        (0.5, 2.0, ""),
        (0.39, 1.0, "height 0.39 m is under"),
        (1.0, 0.39, "length 0.39 m is under"),
        (0.49, 2.0, "is under 0.25"),
        (5.1, 1.0, "is over 5.00"),
    ],
)
def test_equation_1_at_its_limits(height, length, reason):
    verdict = equation_1(height, length, options=OPTIONS)
    assert verdict == reason if not reason else reason in verdict


def kind_of(evidence, options=OPTIONS):
    return weigh(evidence, options=options)[0]


def test_a_cleaned_cloud_leaves_the_rule_of_the_paper():
    assert kind_of(WINDOW) is HoleKind.OPENING
    assert kind_of(replace(WINDOW, rectangularity=0.7)) is HoleKind.OCCLUSION
    assert kind_of(replace(WINDOW, length=0.2)) is HoleKind.OCCLUSION


def test_limits_of_equation_1_are_options():
    slit = replace(WINDOW, length=0.25)
    assert kind_of(slit) is HoleKind.OCCLUSION
    assert kind_of(slit, ReconstructionOptions(min_opening=0.2, max_aspect=7.0)) is HoleKind.OPENING


def test_shadow_decides_unless_something_was_seen_through_it():
    hidden = replace(WINDOW, in_shadow=0.95, stations=1)
    kind, reason, confidence = weigh(hidden, options=OPTIONS)
    assert kind is HoleKind.OCCLUSION
    assert "95 % of it lies in the shadow" in reason
    assert confidence > 0.9
    assert kind_of(replace(hidden, in_shadow=0.3, seen_through=0.6)) is HoleKind.OPENING


def test_a_scan_that_shows_rooms_makes_a_blind_gap_suspect_without_a_station():
    blind = replace(WINDOW, others_show=True)
    assert kind_of(blind) is HoleKind.OCCLUSION
    # ... unless it repeats, as a window does whose blinds are down.
    assert kind_of(replace(blind, alike=4)) is HoleKind.OPENING
    # With a station, the rays themselves say that nothing was in the way.
    assert kind_of(replace(blind, stations=1, missing=1.0)) is HoleKind.OPENING


@pytest.mark.parametrize("more", [{"alike": 3}, {"seen_through": 0.5}, {"missing": 0.9, "stations": 1}])
def test_each_further_witness_raises_the_confidence(more):
    before, after = (weigh(said, options=OPTIONS)[2] for said in (WINDOW, replace(WINDOW, **more)))
    assert after > before
