"""A window and the shadow of a panel that stands before the wall: which is which.

A panel 1 m before the wall, a tenth of the way to the scanner, throws a shadow as rectangular as a window
and of much the same size. By its shape alone it passes as an opening (equation 1 of the paper). Where the
scanner's position is known the panel's points say more: thrown along their rays onto the wall::

    p_wall = s + (p - s) s_y / (s_y - p_y)

they cover the hole, and through it nothing was seen; so the wall goes on behind, and the hole is filled.
"""

from dataclasses import replace

import numpy as np

from fd2fem.model import PointCloud
from fd2fem.reconstruction import reconstruct

rng = np.random.default_rng(3)
scanner = np.array([3.5, -10.0, 1.6])

wall = rng.uniform([0.0, -0.002, 0.0], [7.0, 0.002, 4.0], (60_000, 3))
x, z = wall[:, 0], wall[:, 2]
in_window = (x > 1.0) & (x < 2.2) & (z > 1.2) & (z < 2.8)
seen = wall[~in_window]  # nothing returns from the window

at_panel = seen + 0.1 * (scanner - seen)  # where each ray passes y = -1 m
hit = (np.abs(at_panel[:, 0] - 5.0) < 0.5) & (np.abs(at_panel[:, 2] - 2.0) < 0.7)
points = np.where(hit[:, None], at_panel, seen)

cloud = PointCloud(points, source="a wall behind a panel", scanners=scanner[None])
known = reconstruct(cloud).facade
unknown = reconstruct(replace(cloud, scanners=np.empty((0, 3)))).facade

openings_known, openings_unknown = len(known.openings), len(unknown.openings)
shadow_area = sum(hole.area for hole in known.filled_holes)  # the panel's 1.0 x 1.4 m, thrown from 9 to 10 m

if __name__ == "__main__":
    for title, facade in (("scanner known", known), ("scanner unknown", unknown)):
        print(f"{title}: {len(facade.openings)} openings, {len(facade.filled_holes)} filled holes")
        for opening in facade.openings:
            print(f"  opening at x = {opening.x:.2f}: {opening.width:.2f} x {opening.height:.2f} m")
        for hole in facade.filled_holes:
            print(f"  filled {hole.area:.2f} m²: {hole.reason}")
