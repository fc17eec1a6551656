"""How a facade answers its own weight and the settlement of the ground under it.

>>> from solvers import AnalysisOptions, PeckTrough
>>> options = AnalysisOptions(settlement=PeckTrough(volume_loss=0.01, diameter=6.0, depth=15.0))
>>> options.gravity
9.81

Then ``analyse(mesh, options=options)`` gives a :class:`~fd2fem.model.Response`.
"""

from solvers.analysis import analyse
from solvers.damage.classes import (
    DamageClass,
    assess_damage,
    assessment_to_dict,
    crack_damage_class,
    strain_damage_class,
)
from solvers.damage.equivalent_beam import beam_check_to_dict, equivalent_beam_check
from solvers.fem.stress import principal_stress
from solvers.ground.settlement import (
    FunctionSettlement,
    LengthUnit,
    LinearSettlement,
    PeckTrough,
    Settlement,
    SettlementTable,
    SettlementTrough,
    Soil,
    base_displacement,
    horizontal_movement,
    horizontal_strain,
    max_settlement,
    read_settlement_table,
    settlement_record,
    settlement_slope,
    settlement_trough,
    soil_trough_width,
    swap_horizontal,
    trough_settlement,
    trough_volume,
    trough_width,
)
from solvers.masonry import MasonryLaw
from solvers.materials import LameParameters, Material, elasticity_matrix, lame_parameters
from solvers.options import AnalysisOptions
from solvers.results import SCHEMA, read_response, response_to_dict, write_response
from solvers.steps.stepping import StepMode, SteppingOptions
from solvers.steps.supports import BaseKind, BaseOptions
from solvers.steps.wall_state import WallState
from solvers.vtu_files import StepSeries

__all__ = [
    "SCHEMA",
    "AnalysisOptions",
    "BaseKind",
    "BaseOptions",
    "DamageClass",
    "FunctionSettlement",
    "LameParameters",
    "LengthUnit",
    "LinearSettlement",
    "MasonryLaw",
    "Material",
    "PeckTrough",
    "Settlement",
    "SettlementTable",
    "SettlementTrough",
    "Soil",
    "StepMode",
    "StepSeries",
    "SteppingOptions",
    "WallState",
    "analyse",
    "assess_damage",
    "assessment_to_dict",
    "base_displacement",
    "beam_check_to_dict",
    "crack_damage_class",
    "elasticity_matrix",
    "equivalent_beam_check",
    "horizontal_movement",
    "horizontal_strain",
    "lame_parameters",
    "max_settlement",
    "principal_stress",
    "read_response",
    "read_settlement_table",
    "response_to_dict",
    "settlement_record",
    "settlement_slope",
    "settlement_trough",
    "soil_trough_width",
    "strain_damage_class",
    "swap_horizontal",
    "trough_settlement",
    "trough_volume",
    "trough_width",
    "write_response",
]
