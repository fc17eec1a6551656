"""Voxel models to test with, and a measure of solids that shares no code with the package."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from fd2fem.model import CellState, Facade, SolidModel, VoxelModel

Box = tuple[float, float, float, float]


def voxels_of(boxes: Sequence[Box], thickness: float = 0.5, empty: Sequence[Box] = ()) -> VoxelModel:
    """Voxels from (x0, z0, x1, z1): the given ones full, `empty` ones empty."""
    table = np.array([*boxes, *empty], dtype=float).reshape(-1, 4)
    state = [CellState.FULL] * len(boxes) + [CellState.EMPTY] * len(empty)
    return VoxelModel(table[:, :2], table[:, 2:], np.array(state), thickness)


def cut_wall(length: float, height: float, windows: Sequence[Box], step: float) -> list[tuple[Box, bool]]:
    """A grid of squares, each cut by the window edges inside it alone, which makes T-junctions."""
    pieces = []
    for x0 in np.arange(0.0, length - 1e-9, step):
        for z0 in np.arange(0.0, height - 1e-9, step):
            x1, z1 = min(x0 + step, length), min(z0 + step, height)
            xs, zs = {x0, x1}, {z0, z1}
            for a, b, c, d in windows:
                if a < x1 and c > x0 and b < z1 and d > z0:
                    xs |= {x for x in (a, c) if x0 < x < x1}
                    zs |= {z for z in (b, d) if z0 < z < z1}
            for p, q in zip(sorted(xs)[:-1], sorted(xs)[1:], strict=True):
                for r, s in zip(sorted(zs)[:-1], sorted(zs)[1:], strict=True):
                    x, z = (p + q) / 2, (r + s) / 2
                    inside = any(a < x < c and b < z < d for a, b, c, d in windows)
                    pieces.append(((float(p), float(r), float(q), float(s)), not inside))
    return pieces


def wall_voxels(
    length: float, height: float, windows: Sequence[Box], step: float = 0.7, thickness: float = 0.35
) -> VoxelModel:
    """A rectangular wall with rectangular openings, by `cut_wall`."""
    pieces = cut_wall(length, height, windows, step)
    return voxels_of(
        [box for box, full in pieces if full], thickness, [box for box, full in pieces if not full]
    )


def facade_voxels(facade: Facade) -> VoxelModel:
    """Voxels of a facade with rectangular openings in a rectangular wall."""
    windows = [(o.x, o.z, o.x + o.width, o.z + o.height) for o in facade.openings]
    return wall_voxels(facade.length, facade.height, windows, thickness=facade.thickness)


@dataclass
class Measure:
    """Volume and Euler number of each volume, the signs that each area is listed with, and the extent."""

    volumes: list[float]
    euler: list[int]
    signs: dict[int, list[int]]
    extent: list[float]


def measure(solid: SolidModel) -> Measure:
    """Walk the loops of a solid in plain Python; asserts that loops and volumes are closed."""
    points = solid.keypoints.tolist()
    lines = solid.lines.tolist()
    volumes, euler, signs = [], [], {}
    for areas in solid.volumes:
        edges: Counter[tuple[int, int]] = Counter()
        six = 0.0
        for area in areas:
            signs.setdefault(abs(area), []).append(1 if area > 0 else -1)
            loop = solid.areas[abs(area) - 1]
            walk = [lines[i - 1] if i > 0 else lines[-i - 1][::-1] for i in loop]
            assert all(a[1] == b[0] for a, b in zip(walk, walk[1:] + walk[:1], strict=True))
            ring = [a for a, _ in walk] if area > 0 else [a for a, _ in walk][::-1]
            edges.update(zip(ring, ring[1:] + ring[:1], strict=True))
            for b, c in pairwise(ring[1:]):
                six += np.linalg.det([points[ring[0]], points[b], points[c]])
        assert set(edges.values()) == {1}, "an edge is walked twice in one sense"
        assert all((b, a) in edges for a, b in edges), "a volume is open"
        volumes.append(six / 6.0)
        euler.append(len({a for a, _ in edges}) - len(edges) // 2 + len(areas))
    return Measure(volumes, euler, signs, np.ptp(solid.keypoints, axis=0).tolist())


@pytest.fixture(scope="session")
def make_voxels() -> Callable[..., VoxelModel]:
    return voxels_of


@pytest.fixture(scope="session")
def make_wall() -> Callable[..., VoxelModel]:
    return wall_voxels


@pytest.fixture(scope="session")
def make_facade_voxels() -> Callable[[Facade], VoxelModel]:
    return facade_voxels


@pytest.fixture(scope="session")
def measured() -> Callable[[SolidModel], Measure]:
    return measure
