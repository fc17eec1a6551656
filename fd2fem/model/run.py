"""What one run of the whole chain makes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fd2fem.model.cloud import PointCloud
from fd2fem.model.comparison import Comparison
from fd2fem.model.facade import Facade
from fd2fem.model.mesh import MeshQuality, VolumeMesh
from fd2fem.model.reconstruction import Reconstruction
from fd2fem.model.response import Response

__all__ = ["Model", "RunResult"]


@dataclass(frozen=True, eq=False)
class Model:
    """A facade and how it answers: what a comparison takes. Either may be missing, not both."""

    facade: Facade | None
    response: Response | None


@dataclass(frozen=True, eq=False)
class RunResult:
    """Everything that one run made; reference and comparison are ``None`` where no drawing was given.

    `solid` holds the volumes and counts of the files written, `timings` the seconds of each step.
    """

    cloud: PointCloud
    reconstruction: Reconstruction
    solid: Mapping[str, Any]
    mesh: VolumeMesh
    quality: MeshQuality
    response: Response
    reference: Model | None
    comparison: Comparison | None
    timings: Mapping[str, float]
