"""Many solids that share faces as one: what OpenCASCADE's Booleans take minutes for.

Faces that coincide are found by gluing; the others bound the whole.
"""

from pathlib import Path
from typing import Any

__all__ = ["glue"]

SAME_VOLUME = 1e-9
"""Relative difference of volume between the solids and the one made of them that passes."""


def glue(source: Path, target: Path) -> bool:
    """Write the solids of one BREP file as one to another, if they touch by whole faces only.

    Parameters
    ----------
    source, target : Path

    Returns
    -------
    bool
        Whether that was so; if not, there is no file.
    """
    from cadquery import Compound, Shape, Solid
    from OCP.BOPAlgo import BOPAlgo_Builder, BOPAlgo_GlueEnum
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    solids = Shape.importBrep(str(source)).Solids()
    builder = BOPAlgo_Builder()
    builder.SetGlue(BOPAlgo_GlueEnum.BOPAlgo_GlueFull)
    for solid in solids:
        builder.AddArgument(solid.wrapped)
    builder.Perform()
    if builder.HasErrors():
        return False
    shells = _free_shells(builder.Shape())
    whole = [Solid.makeSolid(shell).fix() for shell in shells]
    volume = sum(solid.Volume() for solid in solids)
    if not whole or abs(sum(solid.Volume() for solid in whole) - volume) > SAME_VOLUME * volume:
        return False
    unify = ShapeUpgrade_UnifySameDomain(Compound.makeCompound(whole).wrapped)
    unify.Build()
    joined = Shape.cast(unify.Shape())
    return bool(joined.isValid() and joined.exportBrep(str(target)))


def _free_shells(shape: Any) -> list[Any]:
    """Shells of the faces that belong to one solid of a shape only."""
    from cadquery import Shape
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
    from OCP.TopExp import TopExp
    from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

    owners = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_FACE, TopAbs_SOLID, owners)
    sewing = BRepBuilderAPI_Sewing(1e-7)
    for index in range(1, owners.Extent() + 1):
        if owners.FindFromIndex(index).Extent() == 1:
            sewing.Add(owners.FindKey(index))
    sewing.Perform()
    return list(Shape.cast(sewing.SewedShape()).Shells())
