"""The records that flow between the stages: frozen dataclasses of read-only arrays, no algorithms."""

from fd2fem.model.cloud import PointCloud
from fd2fem.model.comparison import Comparison, QuantityComparison
from fd2fem.model.facade import EdgeSigma, Facade, FilledHole, Opening, OpeningKind, number_by_rows, rectangle
from fd2fem.model.frame import Attachment, FacadeFrame, FacadePoints, OutOfPlane, WallCandidate
from fd2fem.model.mesh import GROUPS, ElementKind, MeshQuality, VolumeMesh
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
from fd2fem.model.solid import SolidModel
from fd2fem.model.spacing import SpacingGrid

__all__ = [
    "GROUPS",
    "Attachment",
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
    "Hole",
    "HoleKind",
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
    "VolumeMesh",
    "VoxelModel",
    "WallCandidate",
    "number_by_rows",
    "rectangle",
]
