"""The outline of the wall, from its points and from what is known of the gaps between them."""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.model import Boundary, FacadePoints
from fd2fem.reconstruction.gaps import polygons_of
from fd2fem.reconstruction.rays import Shadows, is_hidden
from fd2fem.reconstruction.sampling import Sampling
from fd2fem.reconstruction.skyline import fit_outline

__all__ = ["WallOutline", "wall_outline"]


SMALLEST = 0.5
"""Gaps of a smaller share of the smallest opening's area are no holes in the wall."""


@dataclass(frozen=True, eq=False)
class WallOutline:
    """The outer edge of the wall.

    Attributes
    ----------
    ring : (k, 2) float array, m
        Counter-clockwise, not closed.
    sigma : tuple of float, m
        Standard error of the edge that starts at each corner.
    warnings : tuple of str
        What the user should know of it.
    """

    ring: NDArray[np.float64]
    sigma: tuple[float, ...]
    warnings: tuple[str, ...] = ()


def wall_outline(
    points: FacadePoints, boundary: Boundary, shadows: Shadows, sampling: Sampling
) -> WallOutline:
    """Fit the outer edge of the wall: a rectangle unless the points contradict that.

    Parameters
    ----------
    points : FacadePoints
    boundary : Boundary
    shadows : Shadows
        Places in shadow say nothing of where the wall ends.
    sampling : Sampling

    Raises
    ------
    ReconstructionError
        If the wall is no larger than an opening.
    """
    fit = fit_outline(
        points.xz,
        sampling=sampling,
        gaps=_inner_gaps(points, boundary),
        ground=points.ground,
        hidden=(lambda places: is_hidden(shadows, places)) if shadows.rays.stations else None,
        min_feature=boundary.min_opening,
        grid=boundary.spacing,
    )
    length, height = np.ptp(fit.ring, axis=0)
    if min(length, height) <= boundary.min_opening:
        msg = f"The wall is {length:.2f} x {height:.2f} m, no larger than the smallest opening."
        raise ReconstructionError(msg)
    warnings: tuple[str, ...] = ()
    if not fit.rectangular:
        warnings = (
            f"The wall's outline is no rectangle with upright ends: see its {len(fit.ring)} corners.",
        )
    # The pavement's level is known better than the points' spacing, but it need not be flat.
    sigma = np.where(np.isfinite(fit.sigma), fit.sigma, points.spacing / 2.0)
    return WallOutline(fit.ring, tuple(sigma.tolist()), warnings)


def _inner_gaps(points: FacadePoints, boundary: Boundary) -> list[NDArray[np.float64]]:
    """Outlines of the gaps that are closed all round by wall."""
    outlines = []
    # Between single points of a sparse scan there are gaps all over the wall; they part nothing.
    least = SMALLEST * boundary.min_opening**2
    for cluster in np.setdiff1d(np.unique(boundary.hole_of_triangle), [-1, *boundary.open_clusters]):
        triangles = boundary.triangles[boundary.hole_of_triangle == cluster]
        region = shapely.coverage_union_all(shapely.polygons(points.xz[triangles]))
        pieces = [piece for piece in polygons_of(region) if piece.area > least]
        outlines += [np.array(piece.exterior.coords)[:-1] for piece in pieces]
    return outlines
