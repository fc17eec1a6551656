"""The damage of a wall as the response keeps it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import VolumeMesh
from solvers.damage.bays import bay_strain
from solvers.damage.classes import assess_damage, assessment_to_dict, strain_damage_class, strain_label
from solvers.damage.cracks import crack_widths
from solvers.damage.equivalent_beam import beam_check_to_dict, equivalent_beam_check
from solvers.options import AnalysisOptions

__all__ = ["damage_record"]

FloatArray = NDArray[np.float64]


def damage_record(
    mesh: VolumeMesh, options: AnalysisOptions, displacement: FloatArray, opening: FloatArray | None = None
) -> dict[str, Any]:
    """Classes of damage by strain and by cracks, with the equivalent beam beside them, as JSON values.

    Parameters
    ----------
    mesh : VolumeMesh
    options : AnalysisOptions
    displacement : (n, 3) float array, m
    opening : (e,) float array, m, optional
        Of the cracks. A wall that the analysis takes to be elastic has none to class it by: what is read from
        cracks is left out.
    """
    strain = bay_strain(mesh, displacement)
    classes = {
        "tensile_strain": strain,
        "strain_class": int(strain_damage_class(strain)),
        "strain_label": strain_label(strain_damage_class(strain)),
    }
    if opening is not None:
        widths = crack_widths(mesh, opening)
        shown = widths if len(widths) else opening.max(keepdims=True)
        classes = assessment_to_dict(assess_damage(tensile_strain=strain, crack_widths=shown))
        classes["visible_cracks"] = len(widths)
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    beam = equivalent_beam_check(
        options.settlement,
        extent=(float(low[0]), float(high[0])),
        height=float(high[2] - low[2]),
        poisson=options.material.poisson,
        e_over_g=2.0 * (1.0 + options.material.poisson),
    )
    return classes | {"equivalent_beam": beam_check_to_dict(beam)}
