"""Facades to make solids of: arched ones, and any that hypothesis thinks of."""

import numpy as np
from hypothesis import strategies as st

from fd2fem.model import Facade, Opening, OpeningKind, Storey, number_by_rows, rectangle
from fd2fem.model.heads import Head, HeadKind, head_outline
from fd2fem.model.outlines import Outline, Oval, curved_outline, oval_outline

DOOR, WINDOW = OpeningKind.DOOR, OpeningKind.WINDOW
FLAT, ARC, OVAL, POINTED, GABLED = (
    HeadKind.FLAT,
    HeadKind.ARC,
    HeadKind.ELLIPTICAL,
    HeadKind.POINTED,
    HeadKind.GABLED,
)


def opening(kind: OpeningKind, outline: Outline) -> Opening:
    return Opening(0, kind, outline.ring, arcs=outline.arcs)


def headed(kind, head, sides, heights, tolerance=1e-3):
    """An opening from its left and right side, and the heights of its sill, springing and crown."""
    bottom, springing, crown = heights
    return opening(kind, head_outline(Head(head, springing, crown), *sides, bottom, tolerance))


def oval(x, z, a, b, tolerance=1e-3):
    """A round or oval window."""
    return opening(WINDOW, oval_outline(Oval(x, z, a, b, 0.0, 0.0), tolerance=tolerance))


def arched(storeys=(), tolerance=1e-3):
    """All heads, two doors, a round and two oval windows; 11 x 7 m, 0.5 m thick at the ground."""
    openings = (
        headed(WINDOW, ARC, (1, 2), (1, 2, 2.2), tolerance),
        headed(WINDOW, ARC, (3, 4), (1, 2, 2.5), tolerance),
        headed(WINDOW, POINTED, (5, 6), (1, 2, 3), tolerance),
        headed(WINDOW, OVAL, (7, 8.4), (1, 2, 2.3), tolerance),
        headed(DOOR, ARC, (9, 10), (0, 2, 2.5), tolerance),
        headed(DOOR, POINTED, (10.2, 10.8), (0, 2, 2.9), tolerance),
        headed(WINDOW, GABLED, (1.1, 1.9), (4, 5, 5.5), tolerance),
        oval(4.5, 5, 0.6, 0.6, tolerance),
        oval(7.5, 5, 0.4, 0.6, tolerance),
        oval(9.5, 5, 0.6, 0.4, tolerance),
    )
    return Facade(rectangle(0, 0, 11, 7), 0.5, number_by_rows(openings), storeys=tuple(storeys))


def curved_gable():
    """A semicircular top on shoulders, with a stepped left side; 4 m wide, 4.5 m high."""
    corners = [(0, 0), (4, 0), (4, 3), (3.5, 3), (0.5, 3), (0, 3)]
    outline = curved_outline(corners, {3: Oval(2.0, 3.0, 1.5, 1.5, 0.0, np.pi)}, tolerance=1e-3)
    return Facade(outline.ring, 0.4, (headed(DOOR, ARC, (1.5, 2.5), (0, 2, 2.5)),), arcs=outline.arcs)


@st.composite
def facades(draw):
    """Walls of up to three by three openings of any shape, and of up to three storeys."""
    columns, rows = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    number = st.integers(1, 9)
    openings = []
    for column in range(columns):
        for row in range(rows):
            x, z = 2.0 * column + 0.05 * draw(number), 3.0 * row + 0.05 * draw(number)
            width, height = 0.7 + 0.08 * draw(number), 0.9 + 0.05 * draw(number)
            shape = draw(st.sampled_from([None, FLAT, ARC, OVAL, POINTED, GABLED, "oval"]))
            if shape == "oval":
                openings.append(oval(x + width / 2, z + height / 2, width / 2, height / 2))
            elif shape is not None:
                rise = width / 2 * (draw(number) / 10 if shape is not POINTED else 1 + draw(number) / 20)
                kind = draw(st.sampled_from([WINDOW, DOOR])) if row == 0 else WINDOW
                bottom = 0.0 if kind is DOOR else z
                crown = z + height + (0.0 if shape is FLAT else rise)
                openings.append(headed(kind, shape, (x, x + width), (bottom, z + height, crown)))
    length, top = 2.0 * columns + 0.1, 3.0 * rows + 0.1
    outline = draw(st.sampled_from(["rectangle", "gable", "steps"]))
    ring = rectangle(0, 0, length, top)
    if outline == "gable":
        ring = np.vstack([ring[:3], [[length / 2, top + 1.0]], ring[3:]])
    elif outline == "steps":
        ring = np.vstack(
            [ring[:2], [[length, top - 0.02], [length - 0.03, top - 0.02], [length - 0.03, top]], ring[3:]]
        )
    # Levels in steps of 5 cm meet many sills, heads and springings.
    count = draw(st.integers(0, 2))
    heights = draw(st.lists(st.integers(5, int(20 * top) - 5), unique=True, min_size=count, max_size=count))
    storeys = [Storey(0.05 * z, draw(st.sampled_from([0.25, 0.3, 0.4, 0.5, 0.6]))) for z in sorted(heights)]
    return Facade(ring, 0.5, number_by_rows(openings), storeys=tuple(storeys))
