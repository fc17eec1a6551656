"""The model of a wall from its mesh."""

from fd2fem.model import VolumeMesh
from solvers.compiled.cracking import Body
from solvers.compiled.pattern import build_pattern
from solvers.fem.assembly import body_force, point_volumes
from solvers.fem.connectivity import check_held
from solvers.fem.elements import ElementType, Space, displacement_space
from solvers.fem.rules import space_rule, stiffness_order
from solvers.masonry import MasonryLaw, point_law
from solvers.materials import Material
from solvers.steps.supports import BaseOptions, support_of
from solvers.steps.wall_model import WallModel

__all__ = ["wall_model"]


def wall_model(
    mesh: VolumeMesh,
    *,
    material: Material,
    law: MasonryLaw,
    gravity: float,
    base: BaseOptions,
    element: ElementType = ElementType.INCOMPATIBLE,
) -> tuple[WallModel, Space]:
    """Model of a wall, and the points that carry its displacements.

    Parameters
    ----------
    mesh : VolumeMesh
        With a group "base".
    material : Material
    law : MasonryLaw
    gravity : float, m/s²
    base : BaseOptions
    element : ElementType
        What a mesh of 8-node hexahedra is analysed with.

    Raises
    ------
    InputError
        If an element is folded or has no volume, or a part of the wall is not held.
    """
    space = displacement_space(mesh, element)
    rule = space_rule(space, stiffness_order(space))
    volumes = point_volumes(space, rule)
    support = support_of(mesh, space.points, space.base, options=base)
    check_held(mesh, space.points, (support.prescribed | (support.springs > 0.0)).reshape(-1, 3))
    model = WallModel(
        body=Body(space.points, space.connectivity, rule, point_law(material, law)),
        pattern=build_pattern(
            space.connectivity, points=len(space.points), prescribed=support.prescribed, upper=True
        ),
        support=support,
        weight=body_force(space, [0.0, 0.0, -material.density * gravity]),
        volumes=volumes,
    )
    return model, space
