"""The records that flow between the stages: frozen dataclasses of read-only arrays, no algorithms."""

from fd2fem.model.arcs import Arc, arc_angles, arc_corners, facet_arc
from fd2fem.model.cloud import PointCloud
from fd2fem.model.comparison import Comparison, QuantityComparison
from fd2fem.model.facade import Band, Facade, Storey
from fd2fem.model.frame import Attachment, FacadeFrame, FacadePoints, OutOfPlane, WallCandidate
from fd2fem.model.load_case import LoadCase
from fd2fem.model.mesh import ElementKind, MeshQuality, VolumeMesh
from fd2fem.model.opening import EdgeSigma, FilledHole, Opening, OpeningKind, number_by_rows, rectangle
from fd2fem.model.rays import RayMap
from fd2fem.model.reconstruction import (
    Boundary,
    BoundaryLine,
    CellState,
    Hole,
    HoleKind,
    QuadTree,
    Reconstruction,
    Side,
    VoxelModel,
)
from fd2fem.model.response import Response
from fd2fem.model.run import Model, RunResult
from fd2fem.model.sides import GROUPS, Group, edge_groups
from fd2fem.model.solid import SolidModel, WallCells
from fd2fem.model.spacing import SpacingGrid

__all__ = [
    "GROUPS",
    "Arc",
    "Attachment",
    "Band",
    "Boundary",
    "BoundaryLine",
    "CellState",
    "Comparison",
    "EdgeSigma",
    "ElementKind",
    "Facade",
    "FacadeFrame",
    "FacadePoints",
    "FilledHole",
    "Group",
    "Hole",
    "HoleKind",
    "LoadCase",
    "MeshQuality",
    "Model",
    "Opening",
    "OpeningKind",
    "OutOfPlane",
    "PointCloud",
    "QuadTree",
    "QuantityComparison",
    "RayMap",
    "Reconstruction",
    "Response",
    "RunResult",
    "Side",
    "SolidModel",
    "SpacingGrid",
    "Storey",
    "VolumeMesh",
    "VoxelModel",
    "WallCandidate",
    "WallCells",
    "arc_angles",
    "arc_corners",
    "edge_groups",
    "facet_arc",
    "number_by_rows",
    "rectangle",
]
