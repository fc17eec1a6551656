"""The paper's solid in CAD: every volume a solid of its own, which shares its faces with its neighbours."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import SolidModel
from fd2fem.solids.occ_shapes import backwards, line_edge, make_solid, plane_face, vertex

if TYPE_CHECKING:
    from cadquery import Compound

__all__ = ["cad_cells"]

FloatArray = NDArray[np.float64]


def cad_cells(solid: SolidModel) -> "Compound":
    """One CAD solid for each volume; each keypoint, line and area is made once and shared.

    Programs that keep shared faces (gmsh, from a BREP file) mesh it without gluing.

    Parameters
    ----------
    solid : SolidModel

    Returns
    -------
    compound : cadquery.Compound
        The solids in the order of the volumes, m.

    Examples
    --------
    >>> from fd2fem.model import VoxelModel
    >>> from fd2fem.solids.brep import solid_from_voxels
    >>> two = VoxelModel([[0, 0], [2, 0]], [[2, 3], [4, 3]], [1, 1], 0.5)
    >>> cells = cad_cells(solid_from_voxels(two))
    >>> len(cells.Solids()), len(cells.Faces()), round(cells.Volume(), 9)
    (2, 11, 6.0)
    """
    from cadquery import Compound
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    vertices = [vertex(*point) for point in solid.keypoints.tolist()]
    edges = [line_edge(vertices[start], vertices[end]) for start, end in solid.lines.tolist()]
    faces = [_face(solid, edges, loop) for loop in solid.areas]
    compound, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(compound)
    for areas in solid.volumes:
        bounds = [faces[area - 1] if area > 0 else faces[-area - 1].Reversed() for area in areas]
        builder.Add(compound, make_solid(bounds))
    return Compound(compound)


def _face(solid: SolidModel, edges: list[Any], loop: tuple[int, ...]) -> Any:
    """The plane face of an area; its normal is that of the loop."""
    starts = [solid.lines[line - 1, 0] if line > 0 else solid.lines[-line - 1, 1] for line in loop]
    points = solid.keypoints[starts]
    chain = [edges[line - 1] if line > 0 else backwards(edges[-line - 1]) for line in loop]
    return plane_face(points[0], _normal(points), [chain])


def _normal(ring: FloatArray) -> FloatArray:
    """Twice the vector area of a closed chain of points (k, 3)."""
    arms = ring - ring[0]
    normal: FloatArray = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    return normal
