"""The errors that fd2fem raises.

The tree, with the exit code that the command line gives for each::

    Fd2femError
    ├── InputError (ValueError)      2   a file, option or record is at fault
    │   └── ReconstructionError      2   the points do not show a facade
    └── NumericsError                3   the numerics failed
        ├── MeshError                3   no usable mesh
        └── ConvergenceError         3   the solution does not satisfy equilibrium

Every message is one line: what is wrong, where, and what to do.
"""

__all__ = [
    "SYSTEM_LIBRARIES",
    "ConvergenceError",
    "Fd2femError",
    "InputError",
    "MeshError",
    "NumericsError",
    "ReconstructionError",
]


SYSTEM_LIBRARIES = "libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
"""Debian's packages of the shared libraries that the wheels of gmsh and OpenCASCADE need."""


class Fd2femError(Exception):
    """Anything that fd2fem reports to its user."""


class InputError(Fd2femError, ValueError):
    """A file, an option or a record is at fault."""


class ReconstructionError(InputError):
    """The points do not show a facade."""


class NumericsError(Fd2femError):
    """The input was accepted, but the numerics failed."""


class MeshError(NumericsError):
    """No usable mesh could be made."""


class ConvergenceError(NumericsError):
    """The solution does not satisfy equilibrium to the stated tolerance."""
