import numpy as np
import pytest

from fd2fem.reconstruction.histogram import histogram_peaks


def test_peaks_ignore_a_bulge():
    rng = np.random.default_rng(0)
    jambs = np.concatenate([rng.normal(1.0, 0.01, 80), rng.normal(2.2, 0.01, 80)])
    bulge = rng.uniform(0.4, 1.0, 15)
    values = np.concatenate([jambs, bulge])
    low, high = histogram_peaks(values, np.ones(len(values)), centre=1.6, width=0.04)
    assert (low, high) == pytest.approx((1.0, 2.2), abs=0.01)


def test_extremes_stand_in_where_a_side_has_no_peak():
    values, weights = np.array([0.3, 1.0, 1.0, 2.0]), np.array([0.0, 1.0, 1.0, 0.0])
    assert histogram_peaks(values, weights, centre=1.2, width=0.05, least=0.5) == pytest.approx((1.0, 2.0))
