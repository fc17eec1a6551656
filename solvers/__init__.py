"""How a facade answers its own weight and the settlement of the ground under it.

>>> from solvers import AnalysisOptions, PeckTrough
>>> options = AnalysisOptions(settlement=PeckTrough(volume_loss=0.01, diameter=6.0, depth=15.0))
>>> options.gravity
9.81

Then ``analyse(mesh, options=options)`` gives a :class:`~fd2fem.model.Response`.
"""

from solvers.elasticity import AnalysisOptions, analyse
from solvers.materials import LameParameters, Material, elasticity_matrix, lame_parameters
from solvers.results import SCHEMA, read_response, response_to_dict, write_response
from solvers.settlement import (
    LinearSettlement,
    PeckTrough,
    Settlement,
    base_displacement,
    horizontal_movement,
    horizontal_strain,
    max_settlement,
    settlement_slope,
    trough_settlement,
    trough_volume,
    trough_width,
)
from solvers.stress import principal_stress

__all__ = [
    "SCHEMA",
    "AnalysisOptions",
    "LameParameters",
    "LinearSettlement",
    "Material",
    "PeckTrough",
    "Settlement",
    "analyse",
    "base_displacement",
    "elasticity_matrix",
    "horizontal_movement",
    "horizontal_strain",
    "lame_parameters",
    "max_settlement",
    "principal_stress",
    "read_response",
    "response_to_dict",
    "settlement_slope",
    "trough_settlement",
    "trough_volume",
    "trough_width",
    "write_response",
]
