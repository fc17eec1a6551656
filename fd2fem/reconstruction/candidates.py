"""The walls of a scan to choose from."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.model.frame import WallCandidate
from fd2fem.reconstruction.outside import inward_sign
from fd2fem.reconstruction.thinning import Sample
from fd2fem.reconstruction.walls import Wall

__all__ = ["choose_wall", "list_walls"]

TELLING = 40_000
"""Points of the sample that tell the outside of a wall that was not chosen."""


def choose_wall(walls: Sequence[Wall], number: int) -> Wall:
    """The wall with a number from 1.

    Raises
    ------
    ReconstructionError
        If there are fewer.
    """
    if number > len(walls):
        sizes = [wall.high - wall.low for wall in walls]
        listed = ", ".join(f"{k}: {size[0]:.1f} x {size[1]:.1f} m" for k, size in enumerate(sizes, start=1))
        msg = (
            f"The scan shows {len(walls)} wall{'s' * (len(walls) != 1)} ({listed}), but option 'wall' asks "
            f"for number {number}: choose from these."
        )
        raise ReconstructionError(msg)
    return walls[number - 1]


def list_walls(
    walls: Sequence[Wall], chosen: Wall, sample: Sample, scanners: NDArray[np.float64]
) -> tuple[WallCandidate, ...]:
    """All walls, the best one first, as the user gets to see them.

    Parameters
    ----------
    walls : sequence of Wall
    chosen : Wall
        One of them.
    sample : Sample
    scanners : (s, 3) float array, m
        Relative to the sample's centre.
    """
    listed = []
    for number, wall in enumerate(walls, start=1):
        if len(scanners):
            sign = -float(np.sign(np.median((scanners - wall.on_plane) @ wall.normal))) or 1.0
        else:
            sign, _ = inward_sign(sample.points[:TELLING], wall, sample.centre)
        outward = -sign * wall.normal
        length, height = wall.high - wall.low
        listed.append(
            WallCandidate(
                number=number,
                length=float(length),
                height=float(height),
                centre=sample.centre + wall.centre,
                facing=float(np.degrees(np.arctan2(outward[0], outward[1])) % 360.0),
                points=round(wall.points / sample.share),
                chosen=wall is chosen,
            )
        )
    return tuple(listed)
