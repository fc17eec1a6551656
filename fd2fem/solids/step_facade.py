"""A facade from a CAD solid: its front face says where the wall ends and where its openings are."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Band, Facade, FacadeFrame, Opening, OpeningKind, Storey, number_by_rows
from fd2fem.solids.back_bands import back_bands, face_normal, face_point, is_plane
from fd2fem.solids.occ import read_shape
from fd2fem.solids.rim_edges import Edge
from fd2fem.solids.rims import rim_points
from fd2fem.solids.step_rings import moved_rim, outline_of, rim_of, split_doors

if TYPE_CHECKING:
    from cadquery import Face, Solid

__all__ = ["facade_from_step"]

FloatArray = NDArray[np.float64]

PARALLEL = 1e-6
"""Directions whose unit vectors differ by less than this are one."""
PRISM = 0.05
"""A wall's volume may differ from front face x thickness by this, relative: sills, cornices, reveals."""


def facade_from_step(path: Path, *, thickness: float | None = None) -> Facade:
    """Read the solid of a facade, drawn in any program and unit of length.

    The largest vertical plane face and its largest counterpart on the other side are the wall's front
    and back; of the two, the one that looks towards -y is the front (towards -x where the wall runs
    along y). The front's outer wire is the wall's outline, its inner wires are windows, and notches
    of the outline that stand on the ground are doors. Arcs of circles and of level ellipses stay arcs;
    other curved edges are flattened to 1 mm. Where the faces at the back lie one above the other at
    several depths, they are storeys.

    Parameters
    ----------
    path : Path
        A STEP, IGES or BREP file with one solid, z up; BREP in metres.
    thickness : float, m, optional
        Overrules the distance from front to back, of all storeys.

    Returns
    -------
    facade : Facade
        Its frame says where it stands in the file's coordinates.

    Raises
    ------
    InputError
        If the file cannot be read, or its solid is not a facade: no or several solids, no vertical plane
        faces opposite each other, thicker than high, or far from a wall of one thickness or of storeys.

    References
    ----------
    ISO 10303-21 and 10303-214, as OpenCASCADE reads them; lengths are converted from the unit that
    the file declares.
    """
    solid = _only_solid(path)
    front, back = _front_and_back(path, solid)
    normal = face_normal(front)
    axes = np.array([np.cross(-normal, [0.0, 0.0, 1.0]), -normal, [0.0, 0.0, 1.0]])
    frame = FacadeFrame(face_point(front), axes)
    rims = [rim_of(wire, frame) for wire in (front.outerWire(), *front.innerWires())]
    low = rim_points(rims[0]).min(axis=0)
    rims = [moved_rim(rim, -low[0], -low[1]) for rim in rims]
    height = float(rim_points(rims[0])[:, 1].max())
    depth = float(np.dot(normal, face_point(front) - face_point(back)))
    bands = back_bands(_planes(solid), front, height) or (Band(0.0, height, depth),)
    _check_height(path, bands[0].thickness, height)
    facade = _facade(rims, bands, frame.moved(low[0], low[1]))
    ratio = float(solid.Volume()) / facade.volume
    _check_volume(path, ratio)
    record = {"source": path.name, "volume_over_front_times_thickness": ratio}
    if thickness is not None:
        facade = replace(facade, thickness=thickness, storeys=())
    return replace(facade, record=record)


def _facade(rims: Sequence[Sequence[Edge]], bands: Sequence[Band], frame: FacadeFrame) -> Facade:
    """The facade of a wall's rims, the outer one first."""
    outer, doors = split_doors(rims[0])
    outline = outline_of(outer)
    kinds = [OpeningKind.DOOR] * len(doors) + [OpeningKind.WINDOW] * (len(rims) - 1)
    shapes = [outline_of(rim) for rim in (*doors, *rims[1:])]
    openings = [Opening(0, k, shape.ring, arcs=shape.arcs) for k, shape in zip(kinds, shapes, strict=True)]
    return Facade(
        outline=outline.ring,
        thickness=bands[0].thickness,
        openings=number_by_rows(openings),
        frame=frame,
        arcs=outline.arcs,
        storeys=tuple(Storey(band.low, band.thickness) for band in bands[1:]),
    )


def _not_a_facade(path: Path, reason: str) -> InputError:
    return InputError(f"{path.name} is not a facade: {reason}.")


def _only_solid(path: Path) -> "Solid":
    """The one solid of the file, with faces that continue each other joined."""
    solids = read_shape(path).Solids()
    if len(solids) != 1:
        raise _not_a_facade(path, f"it holds {len(solids)} solids, expected one; join or export it alone")
    joined: Solid = solids[0].clean()
    return joined


def _front_and_back(path: Path, solid: "Solid") -> tuple["Face", "Face"]:
    """The two largest vertical plane faces that look away from each other."""
    faces = sorted(_planes(solid), key=lambda face: float(face.Area()), reverse=True)
    if not faces:
        raise _not_a_facade(path, "it has no vertical plane face; z must point up")
    first = faces[0]
    others = [face for face in faces if np.abs(face_normal(face) + face_normal(first)).max() < PARALLEL]
    if not others:
        raise _not_a_facade(path, "no plane face lies opposite its largest vertical one")
    pair = sorted((first, others[0]), key=lambda face: _outwardness(face_normal(face)))
    return pair[0], pair[1]


def _planes(solid: "Solid") -> list["Face"]:
    """Vertical plane faces."""
    return [face for face in solid.Faces() if is_plane(face) and abs(face_normal(face)[2]) < PARALLEL]


def _outwardness(normal: FloatArray) -> tuple[float, float]:
    """Smallest for the face that looks outwards: towards -y, or else towards -x."""
    return (float(normal[1]) if abs(normal[1]) > PARALLEL else 0.0, float(normal[0]))


def _check_height(path: Path, depth: float, height: float) -> None:
    if depth >= height:
        reason = f"it is {depth:.3f} m thick and {height:.3f} m high; turn it so that z points up"
        raise _not_a_facade(path, reason)


def _check_volume(path: Path, ratio: float) -> None:
    if abs(ratio - 1.0) > PRISM:
        reason = (
            f"its volume is {ratio:.3f} times front face x thickness, expected 1 +- {PRISM}; "
            "draw it as a plane wall of one thickness, or of one for each storey with the steps at the back"
        )
        raise _not_a_facade(path, reason)
