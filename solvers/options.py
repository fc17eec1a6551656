"""Options of an analysis."""

from dataclasses import dataclass, field

import numpy as np

from fd2fem.errors import InputError
from fd2fem.model import ElementKind
from solvers.fem.elements import ElementType
from solvers.fem.linear_solvers import SolverName
from solvers.ground.settlement import LinearSettlement, Settlement
from solvers.masonry import MasonryLaw
from solvers.materials import Material
from solvers.steps.stepping import SteppingOptions
from solvers.steps.supports import BaseKind, BaseOptions

__all__ = ["AnalysisOptions", "element_of"]


@dataclass(frozen=True)
class AnalysisOptions:
    """What the wall is made of, what it stands on, and what happens to it.

    Attributes
    ----------
    material : Material
    settlement : Settlement
        Displacement of the ground under the base.
    gravity : float, m/s²
        Along -z; 0 leaves the self-weight out.
    element : ElementType, optional
        What a mesh of 8-node hexahedra is analysed with; by default HEXAHEDRON20 where the wall is elastic
        and tied to the ground, INCOMPATIBLE else. Other meshes are taken as they are.
    solver : SolverName
        Of the linear equations.
    masonry : MasonryLaw, optional
        Strengths of masonry that cracks; without them the wall is elastic.
    base : BaseOptions
        The joint between ground and wall; by default tied.
    stepping : SteppingOptions
        Steps of the settlement, for a wall that cracks or a base that is not tied.

    Raises
    ------
    InputError
        If gravity is negative or not finite, or the element is no hexahedron.
    """

    material: Material = field(default_factory=Material)
    settlement: Settlement = field(default_factory=LinearSettlement)
    gravity: float = 9.81
    element: ElementType | None = None
    solver: SolverName = SolverName.AUTO
    masonry: MasonryLaw | None = None
    base: BaseOptions = field(default_factory=BaseOptions)
    stepping: SteppingOptions = field(default_factory=SteppingOptions)

    def __post_init__(self) -> None:
        if not 0.0 <= self.gravity < np.inf:
            msg = f"Invalid 'gravity': expected 0 or a positive number, got {self.gravity}."
            raise InputError(msg)
        if self.element is ElementType.TETRA10:
            msg = "Invalid 'element': hexahedra cannot be analysed as tetrahedra; mesh the wall with those."
            raise InputError(msg)

    @property
    def linear(self) -> bool:
        """Whether one solve gives the answer: an elastic wall, tied to the ground."""
        return self.masonry is None and self.base.kind is BaseKind.TIED


def element_of(kind: ElementKind, options: AnalysisOptions) -> ElementType:
    """What the elements of a mesh are analysed with.

    Examples
    --------
    >>> element_of(ElementKind.HEXAHEDRON, AnalysisOptions(masonry=MasonryLaw())).value
    'incompatible'
    """
    if kind is not ElementKind.HEXAHEDRON:
        return ElementType(kind.value)
    if options.element is not None:
        return options.element
    return ElementType.HEXAHEDRON20 if options.linear else ElementType.INCOMPATIBLE
