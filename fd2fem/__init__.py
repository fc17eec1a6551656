"""From a laser scan of a masonry facade to a finite element model that can be trusted.

The records that flow between the stages are in :mod:`fd2fem.model`, the stages in the packages
beside it, and the whole chain in :mod:`fd2fem.pipeline`. Nothing heavy loads here: gmsh, cadquery
and matplotlib load on first use.
"""

__version__ = "0.1.0"

__all__ = ["__version__"]
