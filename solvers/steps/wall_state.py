"""A state of a wall as people look at it: fields at the nodes and in the elements."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.damage.cracks import Cracks, element_cracks
from solvers.fem.elements import Space, tabulate
from solvers.fem.nodal_stress import element_stress, mean_at_nodes
from solvers.fem.rules import stiffness_order
from solvers.masonry import MasonryLaw
from solvers.steps.stepping import LoadStep, Snapshot
from solvers.steps.wall_model import WallModel

__all__ = ["WallState", "wall_state"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WallState:
    """A wall after a step; the fields that take time are computed when they are first asked for.

    Attributes
    ----------
    index : int
        Number of the step; 0: the self-weight.
    record : LoadStep
    displacement : (n, 3) float array, m
        At the mesh's nodes.
    stress : (n, 6) float array, Pa
        Mean over the elements at each node.
    cracks : Cracks
    dissipation : (e,) float array, J
        Energy that each element has taken.
    """

    index: int
    record: LoadStep
    displacement: FloatArray
    dissipation: FloatArray
    _stress: Callable[[], FloatArray]
    _cracks: Callable[[], Cracks]

    @cached_property
    def stress(self) -> FloatArray:
        """See the class."""
        return self._stress()

    @cached_property
    def cracks(self) -> Cracks:
        """See the class."""
        return self._cracks()


def wall_state(
    mesh: VolumeMesh, space: Space, model: WallModel, law: MasonryLaw, snapshot: Snapshot
) -> WallState:
    """Fields of a snapshot."""
    fields = snapshot.fields

    def stress() -> FloatArray:
        at_nodes = element_stress(
            mesh.kind,
            tabulate(mesh.kind, stiffness_order(space)).extrapolation,
            fields.stress,
            cracked=np.asarray(fields.kappa.max(axis=1) > 0.0),
            strength=law.tensile_strength,
        )
        return mean_at_nodes(mesh, at_nodes)

    return WallState(
        index=len(snapshot.history) - 1,
        record=snapshot.history[-1],
        displacement=snapshot.motion.displacement[: len(mesh.nodes)],
        dissipation=snapshot.dissipated,
        _stress=stress,
        _cracks=lambda: element_cracks(fields.crack, model.volumes, model.band),
    )
