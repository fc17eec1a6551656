"""Does the scan-derived model answer like the drawing-derived one: errors, intervals, responses, verdict.

`reference` is always the drawing-derived model and `candidate` the scan-derived one; an error is
candidate - reference. Equations 4 to 13 are those of Appendix B of Truong-Hong, Laefer, Hinks & Carr,
"Flying voxel method with Delaunay triangulation criterion for façade/feature detection for computation".
"""

from validation.criterion import ComparisonOptions, relative_error, within_tolerance
from validation.geometry import OpeningMatches, compare_facades, match_openings
from validation.intervals import (
    ConfidenceInterval,
    mean_error,
    normal_interval,
    normal_interval_from_moments,
    standard_deviation,
    standard_uncertainty,
    t_interval,
    t_interval_from_moments,
)
from validation.response import compare_responses, response_notes
from validation.sampling import (
    CommonDisplacements,
    NoCommonWallError,
    common_displacements,
    without_rigid_motion,
)
from validation.verdict import comparison_to_dict, judge, write_comparison

__all__ = [
    "CommonDisplacements",
    "ComparisonOptions",
    "ConfidenceInterval",
    "NoCommonWallError",
    "OpeningMatches",
    "common_displacements",
    "compare_facades",
    "compare_responses",
    "comparison_to_dict",
    "judge",
    "match_openings",
    "mean_error",
    "normal_interval",
    "normal_interval_from_moments",
    "relative_error",
    "response_notes",
    "standard_deviation",
    "standard_uncertainty",
    "t_interval",
    "t_interval_from_moments",
    "within_tolerance",
    "without_rigid_motion",
    "write_comparison",
]
