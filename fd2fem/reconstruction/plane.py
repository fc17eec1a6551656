"""The wall of a raw scan that is to be reconstructed: its frame, and which points lie on it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import ReconstructionError
from fd2fem.model import FacadeFrame, FacadePoints, PointCloud
from fd2fem.reconstruction.attachments import find_attachments
from fd2fem.reconstruction.candidates import choose_wall, list_walls
from fd2fem.reconstruction.face import Face, change_frame, find_face, frame_of, frame_through, turn_relief
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.outside import NOTHING_TELLS, away_from_scanners, inward_sign
from fd2fem.reconstruction.relief import facade_depth
from fd2fem.reconstruction.roundness import check_not_round
from fd2fem.reconstruction.thinning import Sample, pick, take_sample
from fd2fem.reconstruction.wall_caveats import wall_warnings
from fd2fem.reconstruction.wall_extent import WallCut, cut_wall
from fd2fem.reconstruction.wall_points import point_spacing, points_beside, sort_points
from fd2fem.reconstruction.wall_search import refine_plane, search_walls
from fd2fem.reconstruction.walls import MIN_POINTS, Cells, Wall, face_before, thin_cells

__all__ = ["NOTHING_TELLS", "facade_depth", "find_facade", "point_spacing"]

FloatArray = NDArray[np.float64]

DENSE = 40_000.0
"""More points per m² than this, a spacing of 5 mm, tell nothing more."""
SHOWN = 200_000
"""Most points before and behind the wall that are kept for figures."""


def find_facade(cloud: PointCloud, *, options: ReconstructionOptions) -> FacadePoints:
    """Find the wall of a scan to reconstruct, and sort the points by it.

    A sample of the scan shows which wall it is, and its face; the points of the wall are then taken from the
    whole scan, and the plane is that of least squares through all of them.

    Parameters
    ----------
    cloud : PointCloud
        May hold ground, rooms, neighbours and street objects.
    options : ReconstructionOptions

    Returns
    -------
    FacadePoints
        In a frame whose origin lies on the wall's plane; the boundary lines move it to the corner.

    Raises
    ------
    ReconstructionError
        If no vertical plane of at least 1 x 1 m stands out, if the best one is a strip of a round surface,
        or if the scan shows fewer walls than `options.wall` asks for.
    InputError
        If a scanner cannot stand where it is said to.
    """
    if len(cloud) < MIN_POINTS:
        msg = f"No wall found: the scan has {len(cloud)} points, expected at least {MIN_POINTS}."
        raise ReconstructionError(msg)
    sample = take_sample(cloud.points)
    scanners = cloud.scanners - sample.centre
    cells = thin_cells(sample)
    walls = search_walls(cells, scanners, options.seed)
    wall = choose_wall(walls, options.wall)
    frame, outside_by = _orient(wall, sample, cells, scanners)
    face = find_face(
        sample,
        frame,
        _box_in(wall, sample, frame),
        scanners=cloud.scanners,
        band=options.wall_band,
    )
    check_not_round(face)
    # The sample's density on the wall tells which share of the scan's points is enough there.
    share = min(1.0, DENSE * face.spacing**2 * sample.share)
    near = points_beside(cloud.points, face, share=share)
    cut = cut_wall(
        near,
        face,
        spacing=face.spacing * float(np.sqrt(sample.share / share)),
        scanners=face.frame.to_facade(cloud.scanners),
    )
    points = _facade_points(cloud, face, cut, outside_by)
    return replace(
        points,
        walls=list_walls(walls, wall, sample, scanners),
        warnings=wall_warnings(points, walls, wall, cut.joints, face),
    )


def _orient(wall: Wall, sample: Sample, cells: Cells, scanners: FloatArray) -> tuple[FacadeFrame, str]:
    """The frame of the plane that is the wall's face, and what told its outside."""
    if len(scanners):
        sign, outside_by = away_from_scanners(scanners, wall), "the scanner's position"
    else:
        sign, outside_by = inward_sign(cells.points, wall, sample.centre)
    on_plane, normal = wall.on_plane, sign * wall.normal
    shift = face_before(cells, (cells.points - on_plane) @ normal, wall)
    if shift:
        on_plane, normal = refine_plane(cells.points, cells.weight, on_plane + shift * normal, normal)
    return frame_of(sample.centre + on_plane, normal), outside_by


def _box_in(wall: Wall, sample: Sample, frame: FacadeFrame) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner (x, z) of a wall in the facade frame."""
    half = 0.5 * (wall.high - wall.low)
    middle = frame.to_facade([sample.centre + wall.centre])[0, [0, 2]]
    return middle - half, middle + half


def _facade_points(cloud: PointCloud, face: Face, cut: WallCut, outside_by: str) -> FacadePoints:
    """The record of the wall's points, in the frame of the plane through all of them."""
    found = frame_through(cut.local, face.frame)

    def moved(local: FloatArray) -> FloatArray:
        return change_frame(local, face.frame, found)

    xz = moved(cut.local)[:, ::2]
    order = sort_points(xz)
    xz, depth = pick(xz, order), cut.depth[order]
    return FacadePoints(
        xz=xz,
        depth=depth,
        front=moved(pick(face.local, np.flatnonzero(face.depth < -face.band)[:SHOWN])),
        behind=moved(pick(face.local, np.flatnonzero(face.depth > face.band)[:SHOWN])),
        scanners=found.to_facade(cloud.scanners),
        frame=found,
        rms=float(np.sqrt(np.mean(depth**2))),
        spacing=point_spacing(xz),
        ground=None if face.pavement is None else face.pavement.level_at(float(0.5 * (xz[0, 0] + xz[-1, 0]))),
        outside_by=outside_by,
        relief=turn_relief(face.relief, face.frame, found),
        band=face.band,
        ground_slope=0.0 if face.pavement is None else face.pavement.slope,
        attachments=find_attachments(face, cut),
    )
