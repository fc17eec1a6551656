"""The answer of a facade to a load."""

import math
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
        Largest σ1 that the wall has carried. After a single solve, at a node. After steps, over all of them,
        at an integration point: cracks set a wall free, so that its last step may show less than what every
        crack had to pass on the way. In masonry at most the tensile strength.
    final_principal_stress : float, Pa
        The same in the last step; after a single solve `max_principal_stress`, which is its default.
    p95_principal_stress, p99_principal_stress, rms_stress : float, Pa
        Percentiles of σ1 and root mean square of σ1 by volume, over the wall higher above the base
        than it is thick: unlike the maximum, these converge with the mesh.
    strain_energy : float, J
    dissipated_energy : float, J
    max_crack_opening : float, m
        Of the elements' `crack_opening`.
    damage_class : int
        After Burland, by the width of the cracks; -1 where the analysis knows no cracks.
    dofs : int
    solver : mapping
        Name, element, relative residual and imbalance; JSON values. Of the steps' stresses at the points,
        ``max_principal_stress_at_points_pa`` is that of the last one.
    timings : mapping of str to float, s
    crack_opening : (e,) float array, m
        Width of the crack through each element: its band times the mean over its points of the strain that
        opens cracks, in the first principal direction of that mean. 0 where it is intact.
    crack_normal : (e, 3) float array
        Unit vector across it; 0 where the element is intact.
    dissipation : (e,) float array, J
        Energy that each element has taken.
    largest_stress : (e,) float array, Pa
        Largest σ1 in each element over all steps, at its integration points; after a single solve, at its
        nodes.
    feet : tuple of mappings
        What the ground does to each connected part of the base, from left to right: ``x_m``, its ends;
        ``middle_m``; ``reaction_n``; ``moment_nm`` about the middle, r × F, of which the second, about y,
        acts in the wall's plane; ``share_of_weight``. JSON values.
    history : tuple of mappings
        What each step of the load found, the self-weight first; JSON values. Empty after a single solve.
    damage : mapping
        Classes of damage by strain and, where the analysis knows any, by cracks, and what an equivalent beam
        says; JSON values.
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
    final_principal_stress: float = math.nan
    dissipated_energy: float = 0.0
    max_crack_opening: float = 0.0
    damage_class: int = -1
    solver: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    crack_opening: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    crack_normal: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    dissipation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    largest_stress: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    feet: tuple[Mapping[str, Any], ...] = ()
    history: tuple[Mapping[str, Any], ...] = ()
    damage: Mapping[str, Any] = field(default_factory=dict)

    @property
    def knows_cracks(self) -> bool:
        """Whether the wall could have cracked."""
        return self.damage_class >= 0

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
        at_nodes = self.principal_stress[self.mesh.elements, 0].max(axis=1)
        for name, shape, default in (
            ("crack_opening", (elements,), np.zeros(elements)),
            ("crack_normal", (elements, 3), np.zeros((elements, 3))),
            ("dissipation", (elements,), np.zeros(elements)),
            ("largest_stress", (elements,), at_nodes),
        ):
            given = getattr(self, name)
            object.__setattr__(self, name, as_array(name, given if len(given) else default, shape))
        if math.isnan(self.final_principal_stress):
            object.__setattr__(self, "final_principal_stress", self.max_principal_stress)
        for name in ("history", "feet"):
            object.__setattr__(self, name, tuple(MappingProxyType(dict(one)) for one in getattr(self, name)))
        for name in ("damage", "solver", "timings"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
