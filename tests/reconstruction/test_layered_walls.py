"""A wall whose face has steps: what a wide band makes of it."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import PointCloud
from fd2fem.reconstruction import ReconstructionOptions, reconstruct


def scanned(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64], rng: np.random.Generator
) -> PointCloud:
    """Points of a wall with 3 mm of noise, a pavement before it, and the scanner."""
    points = np.column_stack([x, y + rng.normal(0.0, 0.003, len(x)), z])
    street = rng.uniform([-2.0, -6.0], [7.0, -0.15], (20_000, 2))
    pavement = np.column_stack([street, rng.normal(0.0, 0.005, len(street))])
    return PointCloud(np.concatenate([points, pavement]), "test", scanners=np.array([[2.5, -12.0, 1.7]]))


def tower(seed: int) -> PointCloud:
    """A base 4 m high with a door, 0.3 m before the shaft above it, which has a window of 1 x 1.5 m."""
    rng = np.random.default_rng(seed)
    x, z = rng.uniform([0.0, 0.0], [5.0, 12.0], (96_000, 2)).T
    base = z < 4.0
    y = np.where(base, -0.15, 0.15)
    y = np.where(base & (np.abs(x - 2.5) < 0.6) & (z < 2.2), 0.5, y)
    y = np.where((np.abs(x - 2.5) < 0.5) & (np.abs(z - 8.0) < 0.75), 0.8, y)
    return scanned(x, y, z, rng)


def panelled_wall(seed: int) -> PointCloud:
    """Two panels of 2 x 4 m, 0.12 m deep, each with a window of 1 x 1.5 m in it."""
    rng = np.random.default_rng(seed)
    x, z = rng.uniform([0.0, 0.0], [6.0, 5.0], (50_000, 2)).T
    aside = np.abs(np.abs(x - 3.0) - 1.5)
    y = np.where((aside < 1.0) & (np.abs(z - 2.5) < 2.0), 0.12, 0.0)
    y = np.where((aside < 0.5) & (np.abs(z - 2.5) < 0.75), 0.4, y)
    return scanned(x, y, z, rng)


def test_a_wide_band_takes_in_set_backs() -> None:
    facade = reconstruct(tower(0), options=ReconstructionOptions(wall_band=0.35)).facade
    assert np.allclose(np.ptp(facade.outline, axis=0), [5.0, 12.0], atol=0.06)
    found = sorted((each.z, each.x, each.width, each.height) for each in facade.openings)
    assert np.allclose(found, [(0.0, 1.9, 1.2, 2.2), (7.25, 2.0, 1.0, 1.5)], atol=0.06)


def test_a_wide_band_takes_in_panels() -> None:
    facade = reconstruct(panelled_wall(0), options=ReconstructionOptions(wall_band=0.2)).facade
    assert np.allclose(np.ptp(facade.outline, axis=0), [6.0, 5.0], atol=0.01)
    found = sorted((each.x, each.z, each.width, each.height) for each in facade.openings)
    assert np.allclose(found, [(1.0, 1.75, 1.0, 1.5), (4.0, 1.75, 1.0, 1.5)], atol=0.05)
