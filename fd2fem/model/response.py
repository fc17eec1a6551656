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
        Largest σ1 at a node; in masonry that cracks, at a node of an element, before the mean over elements.
    p95_principal_stress, p99_principal_stress, rms_stress : float, Pa
        Percentiles of σ1 and root mean square of σ1 by volume, over the wall higher above the base
        than it is thick: unlike the maximum, these converge with the mesh.
    strain_energy : float, J
    dissipated_energy : float, J
    max_crack_opening : float, m
    damage_class : int
        After Burland, by the width of the cracks; -1 where the analysis knows no cracks.
    dofs : int
    solver : mapping
        Name, element, relative residual and imbalance; JSON values.
    timings : mapping of str to float, s
    crack_opening : (e,) float array, m
        Width of the crack through each element; 0 where it is intact.
    crack_normal : (e, 3) float array
        Unit vector across it; 0 where the element is intact.
    dissipation : (e,) float array, J
        Energy that each element has taken.
    history : tuple of mappings
        What each step of the load found, the self-weight first; JSON values. Empty after a single solve.
    damage : mapping
        Classes of damage by strain and by cracks, and what an equivalent beam says; JSON values.
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
    crack_opening: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    crack_normal: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    dissipation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    history: tuple[Mapping[str, Any], ...] = ()
    damage: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = len(self.mesh.nodes)
        for name, shape in (
            ("displacement", (n, 3)),
            ("stress", (n, 6)),
            ("principal_stress", (n, 3)),
            ("reaction", (3,)),
        ):
            object.__setattr__(self, name, as_array(name, getattr(self, name), shape))
        elements = len(self.mesh.elements)
        for name, shape in (
            ("crack_opening", (elements,)),
            ("crack_normal", (elements, 3)),
            ("dissipation", (elements,)),
        ):
            given = getattr(self, name)
            object.__setattr__(self, name, as_array(name, given if len(given) else np.zeros(shape), shape))
        object.__setattr__(self, "history", tuple(MappingProxyType(dict(step)) for step in self.history))
        object.__setattr__(self, "damage", MappingProxyType(dict(self.damage)))
        object.__setattr__(self, "solver", MappingProxyType(dict(self.solver)))
        object.__setattr__(self, "timings", MappingProxyType(dict(self.timings)))
