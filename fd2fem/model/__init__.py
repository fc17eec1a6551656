"""The records that flow between the stages: frozen dataclasses of read-only arrays, no algorithms."""

from fd2fem.model.cloud import PointCloud
from fd2fem.model.comparison import Comparison, QuantityComparison
from fd2fem.model.facade import EdgeSigma, Facade, FilledHole, Opening, OpeningKind, number_by_rows, rectangle
from fd2fem.model.frame import FacadeFrame, FacadePoints
from fd2fem.model.mesh import GROUPS, ElementKind, MeshQuality, VolumeMesh
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

__all__ = [
    "GROUPS",
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
    "PointCloud",
    "QuadTree",
    "QuantityComparison",
    "Reconstruction",
    "Response",
    "RunResult",
    "Side",
    "SolidModel",
    "VolumeMesh",
    "VoxelModel",
    "number_by_rows",
    "rectangle",
]
