"""How the volumes of a solid hang together."""

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import SolidModel
from fd2fem.solids.loops import flat, solid_volumes

__all__ = ["check_joined"]

IntArray = NDArray[np.intp]


def check_joined(solid: SolidModel) -> None:
    """Raise unless the volumes make one piece that nowhere hangs together by an edge.

    Raises
    ------
    InputError
        If the volumes, joined by the areas that they share, fall into pieces; if more than two outer
        areas meet in a line.
    """
    listed, volume = flat(solid.volumes)
    area = np.abs(listed) - 1
    _check_one_piece(solid, area, volume)
    _check_pinches(solid, np.bincount(area, minlength=len(solid.areas)) == 1)


def _check_one_piece(solid: SolidModel, area: IntArray, volume: IntArray) -> None:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    v = len(solid.volumes)
    links = coo_array((np.ones(len(area)), (volume, v + area)), shape=(v + len(solid.areas),) * 2)
    _, label = connected_components(links, directed=False)
    names, piece = np.unique(label[:v], return_inverse=True)
    if len(names) == 1:
        return
    sizes = np.bincount(piece, weights=solid_volumes(solid))
    some = area[np.isin(volume, np.flatnonzero(piece == sizes.argmin()))]
    x, _, z = solid.keypoints[solid.patches[some].ravel()].min(axis=0)
    msg = (
        f"The wall falls into {len(names)} pieces, the smallest of {sizes.min():.4f} m³ at "
        f"x = {x:.3f}, z = {z:.3f}: join them, or remove the loose ones."
    )
    raise InputError(msg)


def _check_pinches(solid: SolidModel, outer: NDArray[np.bool_]) -> None:
    """Raise if a line bounds more than two of the `outer` areas."""
    signed, area = flat(solid.areas)
    count = np.bincount(np.abs(signed[outer[area]]) - 1, minlength=len(solid.lines))
    pinched = np.flatnonzero(count > 2)
    if len(pinched):
        x, _, z = solid.keypoints[solid.lines[pinched[0]]].mean(axis=0)
        msg = (
            f"Parts of the wall meet only at their edge at x = {x:.3f}, z = {z:.3f}: fill or empty a "
            "neighbour there, a solid cannot hang together by an edge."
        )
        raise InputError(msg)
