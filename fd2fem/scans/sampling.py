"""Random re-sampling of a point cloud to the densities of the paper."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import PointCloud
from fd2fem.model.checks import check_positive

__all__ = ["Density", "resample", "resample_to"]

FloatArray = NDArray[np.float64]


class Density(StrEnum):
    """The paper's data sets (Table 1): the original scan, and no two points closer than 20, 50, 75 mm."""

    NS00 = "NS00"
    S20 = "S20"
    S50 = "S50"
    S75 = "S75"

    @property
    def spacing(self) -> float:
        """Smallest distance between neighbours, m; 0 for the original scan.

        Examples
        --------
        >>> Density("S20").spacing
        0.02
        """
        return int(self.value[-2:]) / 1000.0


def resample_to(cloud: PointCloud, density: Density, *, seed: int = 0) -> PointCloud:
    """Thin a scan to one of the paper's densities; NS00 returns it as it is."""
    if density is Density.NS00:
        return cloud
    return resample(cloud, density.spacing, seed=seed)


def resample(cloud: PointCloud, spacing: float, *, seed: int = 0) -> PointCloud:
    """Keep points at random such that no two are closer than `spacing` and none could be added.

    Parameters
    ----------
    cloud : PointCloud
    spacing : float, m
        Smallest distance between two points that stay.
    seed : int

    Returns
    -------
    PointCloud
        The points that stay, in their order, with their intensities and stations, and the cloud's scanners.

    Raises
    ------
    InputError
        If the spacing is not positive.

    Notes
    -----
    On a dense wall this is random sequential adsorption of discs of diameter `spacing`, which jams when
    they cover 0.547 of it: 0.70/spacing² points per unit of area. The paper's S20 of Building 1
    has 51,171 points on 29.5 m², 0.69/spacing²; where the scan has only a few points per disc, fewer
    can stay.

    Examples
    --------
    >>> cloud = PointCloud([[0, 0, 0], [0.01, 0, 0], [1, 0, 0]], source="three points")
    >>> len(resample(cloud, 0.02))
    2
    """
    check_positive("spacing", spacing)
    order = np.random.default_rng(seed).permutation(len(cloud))
    # An origin of its own keeps the digits of survey coordinates.
    points = cloud.points[order]
    kept = np.sort(order[_select(points - points.min(axis=0), spacing)]) if len(points) else order
    intensity = cloud.intensity[kept] if len(cloud.intensity) else cloud.intensity
    station = cloud.station[kept] if len(cloud.station) else cloud.station
    source = f"{cloud.source}, re-sampled at {1000 * spacing:g} mm, seed {seed}"
    return PointCloud(
        cloud.points[kept],
        source=source,
        intensity=intensity,
        scanners=cloud.scanners,
        station=station,
        no_returns=cloud.no_returns,
    )


def _select(points: FloatArray, spacing: float) -> NDArray[np.intp]:
    """Indices of a maximal set of points at least `spacing` apart; earlier points come first.

    In each round the first undecided point of every cell is a candidate, and the candidates with
    no earlier one within the spacing stay. A cell is so small that it can hold one kept point only; that
    bounds the pairs, and so the memory, however dense the scan is.
    """
    from scipy.spatial import cKDTree

    cell = _cell_of(points, spacing / np.sqrt(3.0))
    undecided = np.arange(len(points))
    chosen = []
    while len(undecided):
        candidates = undecided[np.sort(np.unique(cell[undecided], return_index=True)[1])]
        pairs = cKDTree(points[candidates]).query_pairs(spacing, output_type="ndarray")
        later = np.zeros(len(candidates), dtype=np.bool_)
        later[pairs[:, 1]] = True  # query_pairs sorts each pair, candidates run from early to late
        kept = candidates[~later]
        chosen.append(kept)
        # The bound is exclusive: a point at just the spacing stays undecided.
        near, _ = cKDTree(points[kept]).query(points[undecided], distance_upper_bound=spacing)
        undecided = undecided[np.isinf(near)]
    return np.concatenate(chosen)


def _cell_of(points: FloatArray, side: float) -> NDArray[np.intp]:
    """Number of the cubic cell that each point lies in, from 0."""
    number = np.zeros(len(points), dtype=np.intp)
    for coordinate in points.T:
        # Renumbering after each axis keeps the numbers small however far the points reach.
        layer = np.unique(np.floor(coordinate / side), return_inverse=True)[1]
        number = np.unique(number * (layer.max() + 1) + layer, return_inverse=True)[1]
    return number
