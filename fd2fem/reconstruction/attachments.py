"""What is fixed to the wall and stands out from it: downpipes, cornices, balconies, bay windows."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fd2fem.model.frame import Attachment
from fd2fem.reconstruction.face import Face
from fd2fem.reconstruction.wall_extent import WallCut

__all__ = ["find_attachments"]

FloatArray = NDArray[np.float64]

NEAREST, FARTHEST = 0.06, 2.5
"""Attachments lie so far before the face, m: closer is relief, farther is street."""
TOUCH = 0.15
"""What comes so close to the face is fixed to it, m."""
ABOVE_GROUND = 0.5
"""Things lower than this are steps, cars and plants, m."""
RIM = 0.10
"""Closer to the wall's ends begin its neighbours, m."""
VOXEL = 0.15
"""Points in neighbouring voxels of this size belong together, m; more where points are few."""
SPARSE = 0.05
"""Voxels with a smaller share of the points on an equal piece of wall are mixed pixels."""
LOOSE = 0.5
"""A thing that fills a smaller share of its box, as seen square to the wall, is taken apart."""
FULL = 0.6
"""A row or column of it that is filled for a larger share is one of its parts."""
FEWEST = 20
"""Points of the smallest attachment."""
SMALLEST = 0.3
"""Length of the smallest attachment, m."""


def find_attachments(face: Face, cut: WallCut) -> tuple[Attachment, ...]:
    """Find the connected things before a wall that touch its face.

    Parameters
    ----------
    face : Face
    cut : WallCut
        The wall, whose extent bounds what is fixed to it.
    """
    (left, foot), (right, top) = cut.box
    size = max(VOXEL, 2.5 * face.spacing)
    local, depth = face.local, face.depth
    above = local[:, 2] - foot if face.pavement is None else face.pavement.above(local)
    near = (depth < -NEAREST) & (depth > -FARTHEST) & (above > ABOVE_GROUND)
    near &= (local[:, 0] > left + RIM) & (local[:, 0] < right - RIM) & (local[:, 2] < top + ABOVE_GROUND)
    places = np.column_stack([local[near, 0], -depth[near], local[near, 2]])
    least = max(SPARSE * (size / face.spacing) ** 2, 1.0)
    found: list[Attachment] = []
    for thing in _things(places, size, least):
        for part in _parts(thing, size, least):
            found += _attachment(part, right - left)
    return tuple(sorted(found, key=lambda each: (each.x, each.z)))


def _things(places: FloatArray, size: float, least: float) -> list[FloatArray]:
    """The connected groups of points; voxels with fewer than `least` points are mixed pixels."""
    if len(places) < FEWEST:
        return []
    voxel = np.floor((places - places.min(axis=0)) / size).astype(np.intp)
    shape = tuple(int(most) + 1 for most in voxel.max(axis=0))
    number = np.ravel_multi_index(tuple(voxel.T), shape)
    held = np.bincount(number, minlength=int(np.prod(shape))) >= least
    label, count = ndimage.label(held.reshape(shape), structure=np.ones((3, 3, 3)))
    group = label.ravel()[number]
    order = np.argsort(group, kind="stable")
    ends = np.searchsorted(group[order], np.arange(1, count + 1), side="right")
    starts = np.searchsorted(group[order], np.arange(1, count + 1))
    things = [places[order[start:end]] for start, end in zip(starts, ends, strict=True)]
    return [thing for thing in things if len(thing) >= FEWEST and thing[:, 1].min() <= TOUCH]


def _parts(thing: FloatArray, size: float, least: float) -> list[FloatArray]:
    """A thing taken apart, if it is several that touch: a cornice, say, that crosses a downpipe."""
    if not _is_compound(thing, size):
        return [thing]
    parts, rest = [], thing
    # What runs along the wall is taken off first, then what runs up it.
    for axis in (2, 0):
        course = _in_full_rows(rest, size, axis)
        parts += _things(rest[course], size, least)
        rest = rest[~course]
        if len(rest) == 0:
            return parts
    return parts + _things(rest, size, least)


def _filled(thing: FloatArray, size: float) -> NDArray[np.bool_]:
    """The thing as seen square to the wall: which squares of the wall it covers."""
    cell = np.floor((thing[:, [0, 2]] - thing[:, [0, 2]].min(axis=0)) / size).astype(np.intp)
    image = np.zeros(cell.max(axis=0) + 1, dtype=bool)
    image[cell[:, 0], cell[:, 1]] = True
    return image


def _is_compound(thing: FloatArray, size: float) -> bool:
    """Whether a thing fills so little of its box that it rather is several that touch."""
    image = _filled(thing, size)
    return bool(min(image.shape) * size > 1.0 and image.mean() < LOOSE)


def _in_full_rows(thing: FloatArray, size: float, axis: int) -> NDArray[np.bool_]:
    """Which points lie in rows (axis 2) or columns (axis 0) that the thing fills for the most part."""
    image = _filled(thing, size)
    full = image.mean(axis=0 if axis == 2 else 1) > FULL
    number = np.floor((thing[:, axis] - thing[:, axis].min()) / size).astype(np.intp)
    inside: NDArray[np.bool_] = full[number]
    return inside


def _attachment(thing: FloatArray, length: float) -> list[Attachment]:
    """The record of a thing on a wall of some length, m, or none where it is too small."""
    low, high = np.percentile(thing, [0.5, 99.5], axis=0)
    (width, _, height), out = high - low, float(high[1])
    if max(width, height) < SMALLEST:
        return []
    kind = _kind(float(width), float(height), out, share=float(width / length))
    return [Attachment(kind, float(low[0]), float(low[2]), float(width), float(height), out)]


def _kind(width: float, height: float, out: float, *, share: float) -> str:
    """What a thing is by its box, m, and the share of the wall's length that it spans.

    Examples
    --------
    >>> _kind(0.12, 6.0, 0.2, share=0.02), _kind(6.0, 0.3, 0.4, share=1.0)
    ('downpipe', 'cornice')
    >>> _kind(2.0, 1.1, 1.0, share=0.3), _kind(2.0, 3.0, 0.8, share=0.3)
    ('balcony', 'bay')
    """
    if width <= 0.35 and height >= max(1.5, 3.0 * width) and out <= 0.5:
        return "downpipe"
    if (share >= 0.5 or width >= 5.0 * height) and width >= 1.5 and height <= 0.8 and out <= 1.2:
        return "cornice"
    if width >= 0.8 and out >= 0.3:
        return "bay" if height > 1.6 else "balcony"
    return "other"
