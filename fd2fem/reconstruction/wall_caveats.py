"""What the user should know of the choice of the wall."""

from collections.abc import Sequence

import numpy as np

from fd2fem.model import FacadePoints
from fd2fem.model.frame import OutOfPlane
from fd2fem.reconstruction.face import Face
from fd2fem.reconstruction.outside import NOTHING_TELLS
from fd2fem.reconstruction.thinning import thin_points
from fd2fem.reconstruction.wall_extent import Joint
from fd2fem.reconstruction.walls import Wall

__all__ = ["wall_warnings"]

RIVAL = 0.5
"""Another wall that spans a larger share of the chosen one's is worth a word."""
LAYER, LAYERED = 0.2, 1.2
"""Frames, glass and reveals up to so far from the face, m, return a smaller share of the face's points."""
STEP_BACK = 0.4
"""A wall may go on so far out of its plane, m."""
BULGE = 0.02
"""A face that leaves its plane by more is worth a word, m."""


def wall_warnings(
    points: FacadePoints, walls: Sequence[Wall], chosen: Wall, joints: Sequence[Joint], face: Face
) -> tuple[str, ...]:
    """What may be wrong with the wall that was taken."""
    warnings = []
    if points.outside_by == NOTHING_TELLS:
        warnings.append(
            "Nothing in the scan tells the outside of the wall: if the facade comes out mirrored, "
            "give the scanner's position."
        )
    rivals = [wall.value / max(chosen.value, 1e-300) for wall in walls if wall is not chosen]
    if chosen is walls[0] and max(rivals, default=0.0) > RIVAL:
        share = min(max(rivals), 1.0)
        number = 1 + walls.index(max(walls[1:], key=lambda wall: wall.value))
        warnings.append(
            f"Another wall spans {100 * share:.0f} % as much as the one that was taken; if it is the one you "
            f"want, set the option wall to {number}, or give the scanner's position before it."
        )
    warnings += [_joint_warning(points, joint) for joint in joints]
    bulge = _largest(points.relief)
    if abs(bulge) > BULGE:
        warnings.append(
            f"The wall's face bulges: it leaves its plane by up to {1000 * abs(bulge):.0f} mm "
            f"({'into the wall' if bulge > 0 else 'outwards'}); it was followed."
        )
    return (*warnings, *_layers(face), *_left_out(points))


def _largest(relief: OutOfPlane) -> float:
    """The value of the map farthest from zero, m."""
    low, high = float(np.nanmin(relief.values)), float(np.nanmax(relief.values))
    return low if -low > high else high


def _joint_warning(points: FacadePoints, joint: Joint) -> str:
    side = "left" if joint.high <= points.xz[0, 0] else "right"
    return (
        f"What lies in the wall's plane on the {side}, beyond a joint "
        f"{1000 * (joint.high - joint.low):.0f} mm wide, was cut off as a neighbour's; if you want that "
        "wall, cut the scan to it."
    )


def _layers(face: Face) -> list[str]:
    """That much of the wall lies a little before or behind its face."""
    (left, bottom), (right, top) = face.box
    x, _, z = face.local.T
    away = np.abs(face.depth[(x > left) & (x < right) & (z > bottom) & (z < top)])
    on_face = int(np.count_nonzero(away < face.band))
    beside = int(np.count_nonzero(away < LAYER)) - on_face
    if beside < LAYERED * on_face:
        return []
    share = 100 * beside / max(on_face, 1)
    return [
        f"Up to {LAYER} m before or behind the face lie {share:.0f} % as many points "
        "as on it, more than windows show: it has pilasters, panels or set-backs, and panels may come "
        f"out as openings. A wall_band of {LAYER} takes them in."
    ]


def _left_out(points: FacadePoints) -> list[str]:
    """What of the wall goes on in another plane above or below it."""
    warnings = []
    (left, bottom), (right, top) = points.xz.min(axis=0), points.xz.max(axis=0)
    for side in (points.front, points.behind):
        beyond = side[(np.abs(side[:, 1]) < STEP_BACK) & (side[:, 0] > left) & (side[:, 0] < right)]
        beyond = beyond[(beyond[:, 2] > top + 0.2) | (beyond[:, 2] < bottom - 0.2)]
        area = len(thin_points(beyond[:, [0, 2]], 0.2)) * 0.2**2 if len(beyond) else 0.0
        if area > 1.0:
            warnings.append(
                f"{area:.0f} m² of what may be the same wall go on above or below it, "
                f"{np.median(beyond[:, 1]):+.2f} m out of its plane; they were left out. "
                "A wall_band of more than that takes them in."
            )
    return warnings
