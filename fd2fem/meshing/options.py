"""How fine a mesh is to be, and how good it must be."""

from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise

from fd2fem.errors import InputError
from fd2fem.model import Facade
from fd2fem.model.checks import check_positive

__all__ = [
    "DEFAULT_OPTIONS",
    "ElementShape",
    "MeshOptions",
    "check_fineness",
    "default_size",
    "divisions",
    "slabs",
]

ROUND_UP_FROM = 0.37
"""Fraction of an element from which one more is made. Drawings are full of halves of the usual element
sizes (1.25 m at 0.1 m), where rounding at one half would let a millimetre decide."""

LARGEST = 0.25
"""Default size of the elements, m, of a usual facade."""
OF_THICKNESS = 0.72
"""Default size over the least thickness at most: a little less than the size that gives two layers."""
OF_SIDE = 1.0 / 12.0
"""Default size over the shorter side of the wall at most."""
MOST_ELEMENTS = 40_000.0
"""The default size is not so small that there are more elements than about this."""
FINEST = 5_000_000.0
"""More elements than this are refused: a slip of the unit would otherwise eat the machine's memory."""
MOST_ACROSS = 100
"""More elements than this through the wall, or across a pier, are refused for the same reason."""
SMALLEST_CORNER = 0.01
"""Size at the corners of openings over that elsewhere at least."""


class ElementShape(StrEnum):
    """Shape of the elements."""

    HEXAHEDRA = "hexahedra"
    TETRAHEDRA = "tetrahedra"


@dataclass(frozen=True)
class MeshOptions:
    """What a mesh should be like.

    Attributes
    ----------
    size : float or None, m
        Target edge of an element; edges lie between about two thirds and four thirds of it. None: from the
        wall, see `default_size`.
    layers : int
        Elements through the wall where it is thickest; 0: as many as `divisions` finds for the size, at
        least one.
    pier_elements : int
        At least so many elements across each pier and spandrel.
    min_scaled_jacobian : float
        Worst element that passes; 1 is a brick, 0 a folded element.
    elements : ElementShape
        Hexahedra, or tetrahedra of 10 nodes.
    order : int
        Of hexahedra: 1 for 8 nodes, 2 for 20 nodes; 0 for what the file format wants, which is 8 nodes but
        for CalculiX and Abaqus.
    corner_size : float or None, m
        Target edge of an element at the corners of openings, from where elements grow to `size`; None:
        they are as large there as elsewhere.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    size: float | None = None
    layers: int = 0
    pier_elements: int = 2
    min_scaled_jacobian: float = 0.3
    elements: ElementShape = ElementShape.HEXAHEDRA
    order: int = 0
    corner_size: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("size", self.size), ("corner_size", self.corner_size)):
            if value is not None:
                check_positive(name, value)
        for name, count, least in (("layers", self.layers, 0), ("pier_elements", self.pier_elements, 1)):
            if int(count) != count or not least <= count <= MOST_ACROSS:
                msg = f"Invalid '{name}': expected a whole number from {least} to {MOST_ACROSS}, got {count}."
                raise InputError(msg)
        if self.order not in (0, 1, 2):
            msg = f"Invalid 'order': expected 1, 2, or 0 for what the file format wants, got {self.order}."
            raise InputError(msg)
        if not 0.0 <= self.min_scaled_jacobian < 1.0:
            msg = (
                "Invalid 'min_scaled_jacobian': expected a number from 0 up to, not including, 1, "
                f"got {self.min_scaled_jacobian}."
            )
            raise InputError(msg)
        if self.size is not None and self.corner_size is not None and self.corner_size > self.size:
            msg = f"Invalid 'corner_size': {self.corner_size:g} m is more than the size of {self.size:g} m."
            raise InputError(msg)

    def size_for(self, facade: Facade) -> float:
        """Target edge of an element of this wall, m."""
        return default_size(facade) if self.size is None else self.size

    def for_wall(self, facade: Facade) -> "MeshOptions":
        """The same options with a size that is a number.

        Raises
        ------
        InputError
            If there would be too many elements.
        """
        size = self.size_for(facade)
        check_fineness(facade.volume, size=size, corner_size=self.corner_size)
        return replace(self, size=size)


DEFAULT_OPTIONS = MeshOptions()


def check_fineness(volume: float, *, size: float, corner_size: float | None = None) -> None:
    """Refuse elements so small that a volume, m³, would have more of them than a machine can hold.

    Raises
    ------
    InputError
        If there would be more than five million, or elements at corners of less than a hundredth of `size`.
    """
    count = volume / size**3
    if count > FINEST:
        msg = (
            f"Elements of {size:g} m would be {count:.2g} in {volume:.4g} m³, more than {FINEST:.0e}: "
            "take larger ones."
        )
        raise InputError(msg)
    if corner_size is not None and corner_size < SMALLEST_CORNER * size:
        msg = (
            f"Invalid 'corner_size': {corner_size:g} m is less than a hundredth of the size of {size:g} m; "
            "take a larger one."
        )
        raise InputError(msg)


def default_size(facade: Facade) -> float:
    """Element size for a wall, m, where none is asked for.

    0.25 m; less where two elements would not fit through the thinnest part of the wall, or twelve along its
    shorter side; but no less than gives about 40,000 elements.

    Examples
    --------
    >>> from fd2fem.model import rectangle
    >>> default_size(Facade(rectangle(0, 0, 19.36, 17.0), 0.35))
    0.25
    >>> round(default_size(Facade(rectangle(0, 0, 6, 4.5), 0.12)), 6)
    0.0864
    """
    thinnest = min(band.thickness for band in facade.bands)
    wanted = min(LARGEST, OF_THICKNESS * thinnest, OF_SIDE * min(facade.length, facade.height))
    return float(max(wanted, (facade.volume / MOST_ELEMENTS) ** (1.0 / 3.0)))


def divisions(length: float, size: float) -> int:
    """Elements of about `size` along `length`, both in m: at least one.

    Examples
    --------
    >>> [divisions(length, 0.25) for length in (0.01, 0.34, 0.35, 1.0)]
    [1, 1, 2, 4]
    """
    return max(1, int(length / size + 1.0 - ROUND_UP_FROM))


def slabs(facade: Facade, *, size: float, layers: int = 0) -> tuple[tuple[float, int], ...]:
    """Depth at which each slab of the wall ends, m, and its elements: the back's depths, in order.

    Where the thickness changes with the storeys, a slab lies between one depth of the back and the next.

    Parameters
    ----------
    facade : Facade
    size : float, m
        Target thickness of a layer.
    layers : int
        Elements through the thickest part, about, in place of `size`; 0: by `size`.

    Examples
    --------
    >>> from fd2fem.model import Storey, rectangle
    >>> wall = Facade(rectangle(0, 0, 6, 9), 0.5, storeys=(Storey(3.0, 0.38), Storey(6.0, 0.25)))
    >>> slabs(wall, size=0.1)
    ((0.25, 3), (0.38, 1), (0.5, 1))
    """
    depths = sorted({band.thickness for band in facade.bands})
    target = depths[-1] / layers if layers else size
    return tuple((deep, divisions(deep - near, target)) for near, deep in pairwise((0.0, *depths)))
