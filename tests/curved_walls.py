"""Facades with slanted and curved edges, for the tests of solids and meshes."""

import numpy as np

from fd2fem.model import Arc, Facade, Opening, OpeningKind, Storey, facet_arc, rectangle

GABLE = np.array([[0, 0], [6, 0], [6, 4], [3, 6], [0, 4]], dtype=float)
LEANING = np.array([[0.004, 0], [9.5, 0], [9.494, 8.003], [0, 7.997]])
_RIGHT_HALF = np.array([[8, 0], [8, 5], [6.8, 5], [6.8, 6], [5.5, 6], [5.5, 7], [4.9, 7.5]])
STEPPED_GABLE = np.vstack([[[0, 0]], _RIGHT_HALF, ([8, 0] + [-1, 1] * _RIGHT_HALF)[:0:-1]])


def _chords(turn, radius, sagitta):
    return max(2, int(np.ceil(turn / (2.0 * np.arccos(1.0 - sagitta / radius)))))


def _opening(number, z, ring, arcs):
    kind = OpeningKind.DOOR if z == 0.0 else OpeningKind.WINDOW
    return Opening(number, kind, ring, arcs=arcs)


def plain(number, x, z, width, height):
    return _opening(number, z, rectangle(x, z, width, height), ())


def elliptic(number, x, z, width, height, rise, *, sagitta=0.002):
    """A rectangle with half an ellipse on top; half a circle if the rise is half the width."""
    count = _chords(np.pi, max(width / 2, rise), sagitta)
    arc = Arc(2, 2 + count, x + width / 2, z + height, width / 2, rise)
    ring = np.vstack([[[x, z], [x + width, z]], facet_arc(arc, 0.0, np.pi, count=count)])
    return _opening(number, z, ring, (arc,))


def round_headed(number, x, z, width, height, **more):
    return elliptic(number, x, z, width, height, width / 2, **more)


def segmental(number, x, z, width, height, rise, *, sagitta=0.002):
    """A rectangle with less than half a circle on top."""
    radius = (width**2 / 4 + rise**2) / (2 * rise)
    half = np.arcsin(width / 2 / radius)
    count = _chords(2 * half, radius, sagitta)
    arc = Arc(2, 2 + count, x + width / 2, z + height + rise - radius, radius, radius)
    ring = facet_arc(arc, np.pi / 2 - half, np.pi / 2 + half, count=count)
    return _opening(number, z, np.vstack([[[x, z], [x + width, z]], ring]), (arc,))


def pointed(number, x, z, width, height, *, sagitta=0.002):
    """A rectangle with two arcs about the opposite springings on top."""
    count = _chords(np.pi / 3, width, sagitta)
    right = Arc(2, 2 + count, x, z + height, width, width)
    left = Arc(2 + count, 2 + 2 * count, x + width, z + height, width, width)
    up = facet_arc(right, 0.0, np.pi / 3, count=count)
    down = facet_arc(left, 2 * np.pi / 3, np.pi, count=count)
    return _opening(number, z, np.vstack([[[x, z], [x + width, z]], up, down[1:]]), (right, left))


def oculus(number, x, z, a, b, *, sagitta=0.002):
    """A whole ellipse about (x, z)."""
    count = _chords(2 * np.pi, max(a, b), sagitta)
    step = 2 * np.pi / count
    out = np.sqrt(step / np.sin(step))  # the polygon's area is that of the ellipse
    angle = step * np.arange(count)
    ring = np.column_stack([x + a * out * np.cos(angle), z + b * out * np.sin(angle)])
    return Opening(number, OpeningKind.WINDOW, ring, arcs=(Arc(0, 0, x, z, a, b),))


def arcade():
    """28 round-headed openings in four rows."""
    boxes = [(0.9 + 2.6 * column, 1.0 + 4 * row) for row in range(4) for column in range(7)]
    boxes[3] = (boxes[3][0], 0.0)
    return Facade(
        rectangle(0, 0, 19.36, 17),
        0.35,
        tuple(round_headed(number, x, z, 1.2, 1.6) for number, (x, z) in enumerate(boxes, start=1)),
    )


def curved_top():
    arc = Arc(2, 22, 5.0, 6.0, 5.0, 1.5)
    outline = np.vstack([[[0, 0], [10, 0]], facet_arc(arc, 0.0, np.pi, count=20)])
    openings = (round_headed(1, 1.5, 1, 1.4, 2), round_headed(2, 4.2, 0, 1.6, 2.4), plain(3, 7, 1, 1.4, 2))
    return Facade(outline, 0.4, openings, arcs=(arc,))


def church():
    outline = np.array([[0, 0], [8, 0], [8, 6], [4, 9.5], [0, 6]], dtype=float)
    sides = (round_headed(3, 0.9, 1.5, 0.7, 2), round_headed(4, 6.4, 1.5, 0.7, 2))
    openings = (oculus(1, 4, 6.2, 1.1, 1.1), round_headed(2, 3.2, 0, 1.6, 2.2), *sides)
    return Facade(outline, 0.5, openings, storeys=(Storey(2.9, 0.4), Storey(6.2, 0.3)))


def gabled():
    openings = (
        elliptic(1, 0.8, 1.2, 1, 1.5, 0.5),
        round_headed(2, 2.5, 0, 1, 1.9),
        plain(3, 4.2, 1.2, 1, 1.5),
    )
    return Facade(GABLE, 0.4, openings, storeys=(Storey(1.17, 0.35), Storey(4.0, 0.3)))


CURVED_WALLS = {
    "elliptic": Facade(
        rectangle(0, 0, 7.2, 4.6),
        0.35,
        tuple(elliptic(k, 2 * k - 1, 1, 1.2, 1.4, rise) for k, rise in enumerate((0.3, 0.45, 0.9), start=1)),
    ),
    "pointed": Facade(
        rectangle(0, 0, 7.2, 5.6),
        0.35,
        (pointed(1, 1, 1, 1.2, 1.6), pointed(2, 3, 0, 1.4, 2.2), pointed(3, 5.2, 1, 0.8, 1.6)),
    ),
    "segmental": Facade(
        rectangle(0, 0, 7.2, 4.6),
        0.4,
        tuple(
            segmental(k, 2.1 * k - 1.3, 0.9, 1.2, 1.5, rise)
            for k, rise in enumerate((0.12, 0.15, 0.25), start=1)
        ),
    ),
    "oculi": Facade(
        rectangle(0, 0, 9, 7),
        0.3,
        (
            *(oculus(k, 1.6 * k - 0.4, 5.5, 0.2 + 0.05 * k, 0.2 + 0.05 * k) for k in range(1, 6)),
            oculus(6, 4.5, 3, 1.2, 0.8),
        ),
    ),
    "leaning": Facade(
        LEANING, 0.35, tuple(plain(k + 1, 0.8 + 2.2 * k, 0.9 + 1.3 * (k % 2), 1.1, 1.6) for k in range(4))
    ),
    "stepped": Facade(
        STEPPED_GABLE,
        0.4,
        (pointed(1, 3.4, 4.2, 1.2, 1.2), round_headed(2, 1, 1, 1, 1.5), round_headed(3, 3.5, 0, 1, 2)),
    ),
    "curved top": curved_top(),
    "church": church(),
    "gabled": gabled(),
}
