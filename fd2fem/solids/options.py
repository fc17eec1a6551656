"""How the solid is written."""

from dataclasses import dataclass

from fd2fem.errors import InputError

__all__ = ["SolidOptions"]


@dataclass(frozen=True)
class SolidOptions:
    """Options of :func:`~fd2fem.solids.write_solid`.

    Attributes
    ----------
    anf_order : int, default 2
        Order (degree + 1) of the lines and areas in the neutral file: 2 is what ANSYS writes itself,
        4 gives the 4 and 16 control points of the paper's Appendix A. Both are exact.
    step_name : str, default "facade"
        Name of the product in the STEP file, printable ASCII.

    Raises
    ------
    InputError
        If the order is neither 2 nor 4, or the name is empty or not printable ASCII.
    """

    anf_order: int = 2
    step_name: str = "facade"

    def __post_init__(self) -> None:
        if self.anf_order not in {2, 4}:
            msg = f"Invalid 'anf_order': expected 2 or 4, got {self.anf_order}."
            raise InputError(msg)
        if not self.step_name.strip() or not (self.step_name.isascii() and self.step_name.isprintable()):
            msg = f"Invalid 'step_name': expected a name in printable ASCII, got {self.step_name!r}."
            raise InputError(msg)
