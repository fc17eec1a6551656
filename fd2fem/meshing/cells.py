"""A wall that is not rectilinear as convex cells, exactly, for solids that are made of such."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import MeshError
from fd2fem.meshing.chains import wall_chains
from fd2fem.meshing.free_quads import best_quads
from fd2fem.meshing.sizes import size_field
from fd2fem.meshing.smoothing import corner_quality
from fd2fem.meshing.sweep import band_thickness
from fd2fem.meshing.walls import wall_rings
from fd2fem.model import Facade, WallCells
from fd2fem.model.checks import check_positive

__all__ = ["front_cells"]

FloatArray = NDArray[np.float64]

CONVEX = 0.02
"""Sine of the worst corner of a cell that passes: about 1°, where an edge of the wall meets a level."""
ENOUGH = 0.15
"""Sine of the worst corner from which on smaller cells are not tried."""
SMALLER = (1.0, 0.7, 0.5)
"""Parts of the cell size to try in turn."""


def front_cells(facade: Facade, *, size: float) -> WallCells:
    """Divide a wall, seen from outside, into convex quadrilaterals.

    Every corner of the wall's outline and of its openings is a corner of cells, and no other ones lie on
    their edges but in line: the cells are exactly the wall, and end at the levels of its storeys.

    Parameters
    ----------
    facade : Facade
    size : float, m
        Edge of a cell at most, about.

    Raises
    ------
    MeshError
        If no division has convex cells only.

    Examples
    --------
    >>> gable = Facade(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 5.0], [0.0, 3.0]]), 0.5)
    >>> cells = front_cells(gable, size=0.5)
    >>> bool(abs(cells.volume - gable.volume) < 1e-12)
    True
    """
    check_positive("size", size)
    chains = wall_chains(wall_rings(facade), [storey.z for storey in facade.storeys])
    quads = best_quads(
        ((chains, size_field(chains, size=part * size, pier_elements=1)) for part in SMALLER), enough=ENOUGH
    )
    quality = corner_quality(quads.points, quads.quads)
    if quality.min() < CONVEX:
        x, z = quads.points[quads.quads[quality.argmin()]].mean(axis=0)
        msg = (
            f"The wall cannot be divided into convex cells at x = {x:.3f}, z = {z:.3f} m: two edges meet at "
            "too sharp an angle there; simplify the outline, or move the storey's level."
        )
        raise MeshError(msg)
    return WallCells(quads.points, quads.quads, band_thickness(facade, quads))
