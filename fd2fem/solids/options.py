"""How the solid is written."""

from dataclasses import dataclass, field, fields
from enum import StrEnum

from fd2fem.errors import InputError
from fd2fem.model.checks import check_positive

__all__ = ["EXTRA_FORMATS", "SolidForm", "SolidOptions", "Strength"]

EXTRA_FORMATS = ("iges", "brep")
"""CAD formats beside STEP, written when asked for."""


class SolidForm(StrEnum):
    """What the STEP file holds.

    MERGED: the wall as one solid of the fewest faces. VOXELS: every cell of the neutral file a solid, which
    share their faces.
    """

    MERGED = "merged"
    VOXELS = "voxels"


@dataclass(frozen=True)
class Strength:
    """Strength of masonry, for the settlement deck: Drucker-Prager, with a limit in tension.

    The defaults are the medium masonry of the paper's numerical assessment.

    Attributes
    ----------
    cohesion : float, Pa
    friction, dilatancy : float, degrees
        At least 0 and under 90; the dilatancy at most the friction.
    tension, compression : float, Pa
        Uniaxial strengths.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    cohesion: float = 6.81e6
    friction: float = 35.0
    dilatancy: float = 10.0
    tension: float = 1.15e6
    compression: float = 26.15e6

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.name not in {"friction", "dilatancy"}:
                check_positive(item.name, getattr(self, item.name))
        if not 0.0 <= self.dilatancy <= self.friction < 90.0:
            msg = (
                f"Invalid angles: expected 0 <= dilatancy <= friction < 90 degrees, got a dilatancy of "
                f"{self.dilatancy:g} and a friction of {self.friction:g}."
            )
            raise InputError(msg)


@dataclass(frozen=True)
class SolidOptions:
    """Options of :func:`~fd2fem.solids.write_solid`.

    Attributes
    ----------
    form : SolidForm, default "merged"
        What the STEP file, and IGES and BREP, hold: the merged wall, or every voxel.
    also : tuple of str
        Further CAD formats: "iges", "brep".
    anf_order : int, default 2
        Order (degree + 1) of the lines and areas in the neutral file: 2 is what ANSYS writes itself,
        4 gives the 4 and 16 control points of the paper's Appendix A. Both are exact.
    step_name : str, default "facade"
        Name of the product in the STEP file, printable ASCII.
    strength : Strength
        Of the masonry, in the settlement deck.

    Raises
    ------
    InputError
        If the order is neither 2 nor 4, a format is unknown or asked for twice, or the name is empty or not
        printable ASCII.

    Examples
    --------
    >>> SolidOptions(also=("iges",)).form.value
    'merged'
    """

    form: SolidForm = SolidForm.MERGED
    also: tuple[str, ...] = ()
    anf_order: int = 2
    step_name: str = "facade"
    strength: Strength = field(default_factory=Strength)

    def __post_init__(self) -> None:
        if self.form not in set(SolidForm):
            msg = f"Invalid 'form': expected {' or '.join(SolidForm)}, got {self.form!r}."
            raise InputError(msg)
        object.__setattr__(self, "form", SolidForm(self.form))
        object.__setattr__(self, "also", tuple(self.also))
        unknown = [name for name in self.also if name not in EXTRA_FORMATS]
        if unknown or len(set(self.also)) < len(self.also):
            msg = (
                f"Invalid 'also': expected each of {', '.join(EXTRA_FORMATS)} at most once, got {self.also}."
            )
            raise InputError(msg)
        if self.anf_order not in {2, 4}:
            msg = f"Invalid 'anf_order': expected 2 or 4, got {self.anf_order}."
            raise InputError(msg)
        if not self.step_name.strip() or not (self.step_name.isascii() and self.step_name.isprintable()):
            msg = f"Invalid 'step_name': expected a name in printable ASCII, got {self.step_name!r}."
            raise InputError(msg)
