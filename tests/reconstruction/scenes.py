"""Walls with something before them, made ray by ray: where each ray would meet the wall is known."""

import numpy as np

from fd2fem.model import PointCloud

__all__ = ["STATION", "scene"]

STATION = np.array([3.0, -10.0, 1.6])


def scene(facade, spacing, *, panels=(), stations=STATION[None], room=0.15, seed=0, told=True):
    """Scan a wall with panels before it.

    Every ray aims at a random place of the wall's rectangle. The first panel (y, x, z, width, height; y < 0)
    in its way returns it, else the wall, else (in an opening) what stands `room` m behind the face.
    """
    rng = np.random.default_rng(seed)
    count = int(facade.length * facade.height / spacing**2)
    points, origin = [], []
    for number, station in enumerate(stations):
        places = np.insert(rng.uniform(0.0, [facade.length, facade.height], (count, 2)), 1, 0.0, axis=1)
        solid = np.ones(count, dtype=bool)
        for opening in facade.openings:
            low, high = opening.outline.min(axis=0), opening.outline.max(axis=0)
            solid &= ~((places[:, [0, 2]] > low) & (places[:, [0, 2]] < high)).all(axis=1)
        share = np.where(solid, 1.0, 1.0 + room / -station[1])
        for y, x, z, width, height in panels:
            at = 1.0 - y / station[1]
            hit = station + at * (places - station)
            inside = (np.abs(hit[:, 0] - x - width / 2) < width / 2) & (
                np.abs(hit[:, 2] - z - height / 2) < height / 2
            )
            share = np.where(inside & (at < share), at, share)
        points.append(
            station + share[:, None] * (places - station) + rng.normal(0, 0.001, (count, 1)) * [0, 1, 0]
        )
        origin.append(np.full(count, number))
    return PointCloud(
        np.concatenate(points),
        "rays",
        scanners=np.asarray(stations) if told else np.empty((0, 3)),
        station=np.concatenate(origin) if told else np.empty(0),
    )
