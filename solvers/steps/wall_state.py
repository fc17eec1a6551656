"""A state of a wall as people look at it: fields at the nodes and in the elements."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.damage.cracks import Cracks, element_cracks
from solvers.fem.elements import Space, tabulate
from solvers.fem.nodal_stress import element_stress, mean_at_nodes
from solvers.fem.rules import stiffness_order
from solvers.fem.stress import principal_stress
from solvers.masonry import MasonryLaw
from solvers.steps.stepping import LoadStep, Snapshot
from solvers.steps.wall_model import WallModel

__all__ = ["WallState", "wall_state"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WallState:
    """A wall after a step.

    Attributes
    ----------
    index : int
        Number of the step; 0: the self-weight.
    record : LoadStep
    displacement : (n, 3) float array, m
        At the mesh's nodes.
    stress : (n, 6) float array, Pa
        Mean over the elements at each node.
    largest_stress : float, Pa
        Largest σ1 at a node of an element.
    cracks : Cracks
    dissipation : (e,) float array, J
        Energy that each element has taken.
    """

    index: int
    record: LoadStep
    displacement: FloatArray
    stress: FloatArray
    largest_stress: float
    cracks: Cracks
    dissipation: FloatArray


def wall_state(
    mesh: VolumeMesh, space: Space, model: WallModel, law: MasonryLaw, snapshot: Snapshot
) -> WallState:
    """Fields of a snapshot."""
    fields = snapshot.fields
    table = tabulate(mesh.kind, stiffness_order(space))
    at_nodes = element_stress(
        mesh.kind,
        table.extrapolation,
        fields.stress,
        cracked=np.asarray(fields.kappa.max(axis=1) > 0.0),
        strength=law.tensile_strength,
    )
    return WallState(
        index=len(snapshot.history) - 1,
        record=snapshot.history[-1],
        displacement=snapshot.motion.displacement[: len(mesh.nodes)],
        stress=mean_at_nodes(mesh, at_nodes),
        largest_stress=float(principal_stress(at_nodes)[..., 0].max()),
        cracks=element_cracks(fields.crack, model.volumes, model.band),
        dissipation=snapshot.dissipated,
    )
