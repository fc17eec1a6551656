"""The answer of a facade to a load."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model.checks import as_array
from fd2fem.model.mesh import VolumeMesh

__all__ = ["Response"]


@dataclass(frozen=True, eq=False)
class Response:
    """Displacements, stresses and reactions of a converged analysis.

    Attributes
    ----------
    mesh : VolumeMesh
    displacement : (n, 3) float array, m
        At the nodes, facade frame.
    stress : (n, 6) float array, Pa
        At the nodes: xx, yy, zz, xy, yz, xz; tension positive.
    principal_stress : (n, 3) float array, Pa
        Of `stress`: σ1 ≥ σ2 ≥ σ3.
    reaction : (3,) float array, N
        Sum over the base; balances the load.
    weight : float, N
        Self-weight of the wall.
    max_displacement : float, m
    max_principal_stress : float, Pa
        Largest σ1 at a node.
    p95_principal_stress, p99_principal_stress, rms_stress : float, Pa
        Percentiles of σ1 and root mean square of σ1 by volume, over the wall higher above the base
        than it is thick: unlike the maximum, these converge with the mesh.
    strain_energy : float, J
    dissipated_energy : float, J
    max_crack_opening : float, m
    damage_class : int
        After Burland; -1 where the analysis does not say.
    dofs : int
    solver : mapping
        Name, element, relative residual and imbalance; JSON values.
    timings : mapping of str to float, s
    """

    mesh: VolumeMesh
    displacement: NDArray[np.float64]
    stress: NDArray[np.float64]
    principal_stress: NDArray[np.float64]
    reaction: NDArray[np.float64]
    weight: float
    max_displacement: float
    max_principal_stress: float
    p95_principal_stress: float
    p99_principal_stress: float
    rms_stress: float
    strain_energy: float
    dofs: int
    dissipated_energy: float = 0.0
    max_crack_opening: float = 0.0
    damage_class: int = -1
    solver: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = len(self.mesh.nodes)
        for name, shape in (
            ("displacement", (n, 3)),
            ("stress", (n, 6)),
            ("principal_stress", (n, 3)),
            ("reaction", (3,)),
        ):
            object.__setattr__(self, name, as_array(name, getattr(self, name), shape))
        object.__setattr__(self, "solver", MappingProxyType(dict(self.solver)))
        object.__setattr__(self, "timings", MappingProxyType(dict(self.timings)))
