"""A facade from a STEP solid: its front face says where the wall ends and where its openings are."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import Facade, FacadeFrame, Opening, OpeningKind, number_by_rows
from fd2fem.model.checks import signed_area
from fd2fem.solids.occ import read_shape

if TYPE_CHECKING:
    from cadquery import Face, Solid, Wire

__all__ = ["facade_from_step"]

FloatArray = NDArray[np.float64]

PARALLEL = 1e-6
"""Directions whose unit vectors differ by less than this are one."""
FLATTEN = 1e-3
"""Curved edges become chords that leave them by no more than this, m."""
TOUCH = 1e-6
"""Points closer to the ground than this, m, stand on it."""
STRAIGHT = 1e-9
"""A corner closer than this to the chord of its neighbours, m, is none."""
PRISM = 0.05
"""A wall's volume may differ from front face x thickness by this, relative: sills, cornices, reveals."""


def facade_from_step(path: Path, *, thickness: float | None = None) -> Facade:
    """Read the solid of a facade, drawn in any program and unit of length.

    The largest vertical plane face and its largest counterpart on the other side are the wall's front
    and back; of the two, the one that looks towards -y is the front (towards -x where the wall runs
    along y). The front's outer wire is the wall's outline, its inner wires are windows, and notches
    of the outline that stand on the ground are doors. Curved edges are flattened to 1 mm.

    Parameters
    ----------
    path : Path
        A STEP file with one solid, z up.
    thickness : float, m, optional
        Overrules the distance from front to back.

    Returns
    -------
    facade : Facade
        Its frame says where it stands in the file's coordinates.

    Raises
    ------
    InputError
        If the file is not STEP, or its solid is not a facade: no or several solids, no vertical plane
        faces opposite each other, thicker than high, or far from a wall of one thickness.

    References
    ----------
    ISO 10303-21 and 10303-214, as OpenCASCADE reads them; lengths are converted from the unit that
    the file declares.
    """
    import shapely

    solid = _only_solid(path)
    front, back = _front_and_back(path, solid)
    normal = _normal(front)
    depth = float(np.dot(normal, _point(front) - _point(back)))
    axes = np.array([np.cross(-normal, [0.0, 0.0, 1.0]), -normal, [0.0, 0.0, 1.0]])
    frame = FacadeFrame(_point(front), axes)
    rings = [_ring(wire, frame) for wire in (front.outerWire(), *front.innerWires())]
    low = rings[0].min(axis=0)
    outline, doors = _fill_doors(rings[0] - low)
    ratio = float(solid.Volume()) / (float(front.Area()) * depth)
    _check_wall(path, depth, float(np.ptp(outline[:, 1])), ratio)
    openings = [Opening(0, OpeningKind.DOOR, door) for door in doors]
    openings += [Opening(0, OpeningKind.WINDOW, _corners(shapely.Polygon(ring - low))) for ring in rings[1:]]
    return Facade(
        outline=outline,
        thickness=depth if thickness is None else thickness,
        openings=number_by_rows(openings),
        frame=frame.moved(low[0], low[1]),
        record={"source": path.name, "volume_over_front_times_thickness": ratio},
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
    faces = [
        face for face in solid.Faces() if face.geomType() == "PLANE" and abs(_normal(face)[2]) < PARALLEL
    ]
    faces.sort(key=lambda face: float(face.Area()), reverse=True)
    if not faces:
        raise _not_a_facade(path, "it has no vertical plane face; z must point up")
    first = faces[0]
    others = [face for face in faces if np.abs(_normal(face) + _normal(first)).max() < PARALLEL]
    if not others:
        raise _not_a_facade(path, "no plane face lies opposite its largest vertical one")
    pair = sorted((first, others[0]), key=lambda face: _outwardness(_normal(face)))
    return pair[0], pair[1]


def _outwardness(normal: FloatArray) -> tuple[float, float]:
    """Smallest for the face that looks outwards: towards -y, or else towards -x."""
    return (float(normal[1]) if abs(normal[1]) > PARALLEL else 0.0, float(normal[0]))


def _normal(face: "Face") -> FloatArray:
    """Outward unit normal of a plane face, exactly horizontal where it nearly is."""
    normal = np.array(face.normalAt().toTuple())
    if abs(normal[2]) < PARALLEL:
        normal[2] = 0.0
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit


def _point(face: "Face") -> FloatArray:
    return np.array(face.Center().toTuple())


def _ring(wire: "Wire", frame: FacadeFrame) -> FloatArray:
    """Corners (k, 2), m, of a wire, in turn, in x and z of a frame."""
    from OCP.BRepTools import BRepTools_WireExplorer

    points: list[tuple[float, float, float]] = []
    explorer = BRepTools_WireExplorer(wire.wrapped)
    while explorer.More():
        points += _edge_points(explorer.Current())[:-1]
        explorer.Next()
    return frame.to_facade(points)[:, [0, 2]].round(9)


def _edge_points(edge: Any) -> list[tuple[float, float, float]]:
    """Points along an edge in the sense of its wire, ends included."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_QuasiUniformDeflection
    from OCP.GeomAbs import GeomAbs_Line
    from OCP.TopAbs import TopAbs_REVERSED

    curve = BRepAdaptor_Curve(edge)
    if curve.GetType() == GeomAbs_Line:
        ends = (curve.Value(curve.FirstParameter()), curve.Value(curve.LastParameter()))
        points = [(p.X(), p.Y(), p.Z()) for p in ends]
    else:
        division = GCPnts_QuasiUniformDeflection(curve, FLATTEN)
        points = [(p.X(), p.Y(), p.Z()) for p in (division.Value(i + 1) for i in range(division.NbPoints()))]
    return points[::-1] if edge.Orientation() == TopAbs_REVERSED else points


def _fill_doors(ring: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """Outline with its notches on the ground filled, and the notches."""
    import shapely

    ring = np.where(np.abs(ring) < TOUCH, 0.0, ring)
    standing = ring[ring[:, 1] == 0.0, 0]
    wall = shapely.Polygon(ring)
    ground = shapely.LineString([(standing.min(), 0.0), (standing.max(), 0.0)])
    edges = shapely.union_all([wall.exterior, ground] if ground.length else [wall.exterior])
    cells = shapely.get_parts(shapely.polygonize([edges]))
    doors = [cell for cell in cells if not wall.contains(cell.representative_point())]
    outline = shapely.union_all([wall, *doors])
    return _corners(outline), [_corners(door) for door in doors]


def _corners(polygon: Any) -> FloatArray:
    """Corners of a polygon's outer ring, counter-clockwise from the lower left one."""
    points = np.asarray(polygon.exterior.coords)[:-1]
    points = points if signed_area(points) > 0.0 else points[::-1]
    while True:  # Points on a straight edge go, one by one: the next may become straight or not.
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        chord, arm = after - before, points - before
        height = np.abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.hypot(*chord.T)
        straight = np.flatnonzero(height < STRAIGHT)
        if not len(straight):
            break
        points = np.delete(points, straight[0], axis=0)
    return np.roll(points, -int(np.lexsort((points[:, 0], points[:, 1]))[0]), axis=0)


def _check_wall(path: Path, depth: float, height: float, ratio: float) -> None:
    if depth >= height:
        reason = f"it is {depth:.3f} m thick and {height:.3f} m high; turn it so that z points up"
        raise _not_a_facade(path, reason)
    if abs(ratio - 1.0) > PRISM:
        reason = (
            f"its volume is {ratio:.3f} times front face x thickness, expected 1 +- {PRISM}; "
            "draw it as a plane wall of one thickness"
        )
        raise _not_a_facade(path, reason)
