"""Cracks in a wall: how wide they are, which way they open, and which elements make up one crack."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fd2fem.model import VolumeMesh
from solvers.fem.connectivity import FACETS, parts

__all__ = ["Cracks", "crack_widths", "element_cracks", "principal_axes"]

FloatArray = NDArray[np.float64]

VISIBLE = 0.1e-3
"""Width, m, from which a crack can be seen (Burland's table begins there)."""


@dataclass(frozen=True, eq=False)
class Cracks:
    """Cracks, smeared over the elements that they run through.

    Attributes
    ----------
    opening : (e,) float array, m
        Width of the band times the element's mean strain across its crack; 0 where it is intact.
    normal : (e, 3) float array
        Unit vector across the crack; 0 where the element is intact.
    """

    opening: FloatArray
    normal: FloatArray


def principal_axes(tensor: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Principal values, descending, and their directions.

    Parameters
    ----------
    tensor : (..., 6) array-like
        xx, yy, zz, xy, yz, xz; of strains half the engineering shear strains.

    Returns
    -------
    values : (..., 3) float array
    axes : (..., 3, 3) float array
        axes[..., i, :] is the unit vector of the i-th value; its largest component is positive.

    Examples
    --------
    Pure shear pulls along the diagonal.

    >>> values, axes = principal_axes([0, 0, 0, 2, 0, 0])
    >>> values.tolist(), axes[0].round(4).tolist()
    ([2.0, 0.0, -2.0], [0.7071, 0.7071, 0.0])
    """
    components = np.asarray(tensor, dtype=np.float64)
    matrices = components[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*components.shape[:-1], 3, 3)
    values, vectors = np.linalg.eigh(matrices)
    axes = np.swapaxes(vectors, -1, -2)[..., ::-1, :]
    largest = np.take_along_axis(axes, np.abs(axes).argmax(axis=-1)[..., None], axis=-1)
    return values[..., ::-1], axes * np.where(largest < 0.0, -1.0, 1.0)


def element_cracks(strain: FloatArray, volumes: FloatArray, band: FloatArray) -> Cracks:
    """Cracks of elements from the strain that opens them.

    Parameters
    ----------
    strain : (e, q, 6) float array
        At the integration points; engineering shear strains.
    volumes : (e, q) float array, m³
    band : (e,) float array, m
        Width that a crack's opening is spread over.

    Returns
    -------
    cracks : Cracks
        Width and normal are those of the first principal value of the element's mean strain: the band is as
        wide as the element, and the law softens by the mean as well.
    """
    opening, normal = np.zeros(len(strain)), np.zeros((len(strain), 3))
    open_ = np.flatnonzero(strain.any(axis=(1, 2)))
    weights = volumes[open_] / volumes[open_].sum(axis=1, keepdims=True)
    mean = np.einsum("eqi,eq->ei", strain[open_], weights) * [1.0, 1.0, 1.0, 0.5, 0.5, 0.5]
    values, axes = principal_axes(mean)
    opening[open_], normal[open_] = band[open_] * values[:, 0], axes[:, 0]
    return Cracks(opening=opening, normal=normal)


def crack_widths(mesh: VolumeMesh, opening: FloatArray, *, visible: float = VISIBLE) -> FloatArray:
    """Width of each crack, the widest first.

    Elements that are open and share a facet belong to one crack, which is as wide as its widest element.

    Parameters
    ----------
    mesh : VolumeMesh
    opening : (e,) float array, m
    visible : float, m
        Narrower elements do not count.

    Returns
    -------
    widths : (c,) float array, m
    """
    open_ = np.flatnonzero(opening >= visible)
    if not len(open_):
        return np.zeros(0)
    corners = FACETS[mesh.kind]
    facets = np.sort(mesh.elements[open_][:, corners].reshape(-1, corners.shape[1]), axis=1)
    number = np.unique(facets, axis=0, return_inverse=True)[1].reshape(len(open_), -1)
    crack = parts(number)
    widths = np.zeros(int(crack.max()) + 1)
    np.maximum.at(widths, crack, opening[open_])
    return np.sort(widths)[::-1]
