import numpy as np
import pytest

from fd2fem.reconstruction.rounds import fit_round
from fd2fem.reconstruction.sampling import Sampling

CENTRE = np.array([1.5, 1.5])


def found(half, spacing, rng, *, hole=None):
    xz = rng.uniform(0.0, 3.0, (rng.poisson(9.0 / spacing**2), 2))
    off = (xz - CENTRE) / half
    inside = np.hypot(*off.T) < 1.0 if hole is None else hole(off)
    error = rng.normal(0.0, spacing / 4.0, (2, 2))
    low, high = CENTRE - half + error[0], CENTRE + half + error[1]
    near = ((xz[~inside] > low - 0.4) & (xz[~inside] < high + 0.4)).all(axis=1)
    sampling = Sampling(spacing=spacing, noise=0.0, exclusion=0.0)
    return fit_round(xz[~inside][near], low=low, high=high, sampling=sampling)


@pytest.mark.parametrize("half", [(0.5, 0.5), (0.4, 0.6), (0.7, 0.4)])
def test_round_windows_at_20_mm(half):
    rng = np.random.default_rng(3)
    windows = [found(np.array(half), 0.02, rng) for _ in range(8)]
    assert all(window is not None for window in windows)
    areas = np.array([w.half_width * w.half_height for w in windows]) / np.prod(half) - 1.0
    assert np.abs(areas).max() < 0.01
    assert abs(areas.mean()) < 0.003
    assert all(abs(w.x - 1.5) < 0.006 and abs(w.z - 1.5) < 0.006 for w in windows)
    circle = half[0] == half[1]
    assert sum((w.half_width == w.half_height) is circle for w in windows) >= 7


@pytest.mark.parametrize(
    "hole",
    [
        lambda off: (np.abs(off) < 1.0).all(axis=1),
        # A round head on straight jambs, and the same upside down.
        lambda off: (np.abs(off) < 1.0).all(axis=1) & ((off[:, 1] < 0.0) | (np.hypot(*off.T) < 1.0)),
        lambda off: (np.abs(off) < 1.0).all(axis=1) & ((off[:, 1] > 0.0) | (np.hypot(*off.T) < 1.0)),
    ],
)
def test_what_is_not_round_is_refused(hole):
    rng = np.random.default_rng(4)
    for spacing in (0.02, 0.05):
        assert found(np.array([0.5, 0.5]), spacing, rng, hole=hole) is None
