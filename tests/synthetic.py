"""Point clouds of facades whose truth is known, made without the package's own scanner."""

import numpy as np

from fd2fem.model import (
    Facade,
    FacadeFrame,
    Hole,
    HoleKind,
    Opening,
    OpeningKind,
    PointCloud,
    rectangle,
)

__all__ = ["cleaned_cloud", "facade_of", "sketch", "survey_frame", "wall_points"]


def facade_of(length, height, rectangles, *, thickness=0.35):
    """A facade from (x, z, width, height) rectangles; those that start at z = 0 are doors."""
    openings = [
        Opening(number, OpeningKind.DOOR if box[1] == 0 else OpeningKind.WINDOW, rectangle(*box))
        for number, box in enumerate(rectangles, start=1)
    ]
    return Facade(rectangle(0, 0, length, height), thickness, tuple(openings))


def wall_points(facade, spacing, *, pattern="random", seed=0):
    """Points (n, 2) on the wall: evenly random, a grid, or scan lines twice as far apart as their points."""
    rng = np.random.default_rng(seed)
    length, height = facade.length, facade.height
    if pattern == "random":
        xz = rng.uniform(0.0, 1.0, (int(length * height / spacing**2), 2)) * [length, height]
    else:
        pitch = {"grid": (spacing, spacing), "lines": (1.4 * spacing, spacing / 1.4)}[pattern]
        start = rng.uniform(0.0, pitch)
        columns, rows = (np.arange(start[i], (length, height)[i], pitch[i]) for i in range(2))
        xz = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    for opening in facade.openings:
        low, high = opening.outline.min(axis=0), opening.outline.max(axis=0)
        inside = (xz > low) & (xz < high)
        xz = xz[~inside.all(axis=1)]
    return xz


def survey_frame(degrees=37.0, origin=(715_830.0, 734_120.0, 12.5)):
    """A frame far from the origin, turned about the vertical."""
    angle = np.radians(degrees)
    right, inward = [np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0]
    return FacadeFrame(np.array(origin), np.array([right, inward, [0.0, 0.0, 1.0]]))


def cleaned_cloud(facade, spacing, *, pattern="random", seed=0, frame=None, noise=0.002):
    """A cleaned scan with a scanner 10 m before the wall."""
    frame = frame or FacadeFrame.identity()
    xz = wall_points(facade, spacing, pattern=pattern, seed=seed)
    depth = np.random.default_rng(seed + 1).normal(0.0, noise, len(xz))
    scanner = frame.to_world([[facade.length / 2, -10.0, 1.6]])
    return PointCloud(frame.to_world(np.insert(xz, 1, depth, axis=1)), f"synthetic {seed}", scanners=scanner)


def sketch(x, z, width, height, *, kind=HoleKind.OPENING, unseen=None):
    """A hole with nothing but its rectangle."""
    return Hole(
        loop=rectangle(x, z, width, height),
        points=np.arange(3),
        kind=kind,
        reason="drawn",
        x=x,
        z=z,
        width=width,
        height=height,
        area=width * height,
        confidence=1.0,
        unseen=unseen or {},
    )
