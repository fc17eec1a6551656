"""What facade files may hold, as pydantic models, and their errors in one line.

This module loads pydantic; import it where something is validated.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from fd2fem.errors import InputError

__all__ = ["DrawingFile", "DrawnFrame", "DrawnOpening", "FacadeFile", "StoredOpening", "validate"]

LARGEST = 1e10
"""No length or coordinate in a file is larger, whatever its unit."""

Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
Triple = Annotated[list[Number], Field(min_length=3, max_length=3)]
Ring = Annotated[list[Pair], Field(min_length=3)]
Corner = Annotated[list[Number], Field(min_length=2, max_length=3)]
BulgedRing = Annotated[list[Corner], Field(min_length=2)]
NotNegativeInt = Annotated[int, Field(ge=0)]
Kind = Literal["window", "door"]

CLOSED = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
OPEN = ConfigDict(strict=True, allow_inf_nan=False, extra="ignore")

Model = TypeVar("Model", bound=BaseModel)

ENTRIES = {"openings": "opening", "filled_holes": "filled hole", "storeys": "storey", "arcs": "arc"}
"""What a message calls an entry of each list."""
ROUNDED = 1.0 + 1e-9
"""Sizes are written in decimals: a share of so much more or less is rounding."""


class DrawnHead(BaseModel):
    """The head of an opening of a TOML drawing."""

    model_config = CLOSED
    shape: Literal["arc", "elliptical", "pointed", "gabled"]
    rise: Positive | None = None

    def rise_over(self, width: float) -> float | None:
        """Height of the crown above the jambs: half the width where an arc's is not given."""
        return width / 2.0 if self.rise is None and self.shape == "arc" else self.rise

    def check_rise(self, width: float, height: float) -> None:
        """Raise unless an opening of this size can have such a head."""
        rise, half = self.rise_over(width), width / 2.0
        if rise is None:
            msg = f"'head.rise' is missing: only a head of shape 'arc' has one by itself, not {self.shape!r}"
            raise ValueError(msg)
        if rise > height * ROUNDED:
            msg = f"'head.rise' is {rise:g}, more than the opening's 'height' of {height:g}: correct one"
            raise ValueError(msg)
        if self.shape == "arc" and rise > half * ROUNDED:
            msg = f"'head.rise' is {rise:g}, but an arc rises by at most half the width, {half:g}"
            raise ValueError(msg)
        if self.shape == "pointed" and rise * ROUNDED < half:
            msg = f"'head.rise' is {rise:g}, but a pointed head rises by at least half the width, {half:g}"
            raise ValueError(msg)


class DrawnOpening(BaseModel):
    """An opening of a TOML drawing: a rectangle, perhaps with a head, an ellipse, or an outline."""

    model_config = CLOSED
    kind: Kind | None = None
    shape: Literal["rectangle", "ellipse"] = "rectangle"
    head: DrawnHead | None = None
    x: Number | None = None
    z: Number | None = None
    width: Positive | None = None
    height: Positive | None = None
    outline: BulgedRing | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        _check_one_shape(self.outline, {name: getattr(self, name) for name in ("x", "z", "width", "height")})
        if self.head is not None and (self.outline is not None or self.shape == "ellipse"):
            other = "outline" if self.outline is not None else "shape"
            msg = f"has both 'head' and '{other}': leave one out"
            raise ValueError(msg)
        if self.shape == "ellipse" and self.outline is not None:
            msg = "has both 'shape' and 'outline': leave one out"
            raise ValueError(msg)
        if self.head is not None and self.width is not None and self.height is not None:
            self.head.check_rise(self.width, self.height)
        return self


class DrawnFrame(BaseModel):
    """Where the (0, 0) of a TOML drawing stands in the world, and where its x axis points."""

    model_config = CLOSED
    origin: Triple = [0.0, 0.0, 0.0]
    heading: float = 0.0


class DrawnStorey(BaseModel):
    """Where the wall's thickness changes."""

    model_config = CLOSED
    z: Number
    thickness: Positive


class DrawingFile(BaseModel):
    """A TOML drawing: the wall and a list of openings."""

    model_config = CLOSED
    name: str = ""
    source: str = ""
    units: Literal["m", "mm"] = "m"
    length: Positive | None = None
    height: Positive | None = None
    outline: BulgedRing | None = None
    thickness: Positive | None = None
    storeys: list[DrawnStorey] = []
    frame: DrawnFrame | None = None
    openings: list[DrawnOpening] = []

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        _check_one_shape(self.outline, {"length": self.length, "height": self.height})
        return self


class StoredFrame(BaseModel):
    """The frame of a facade.json: world = origin + x·X + y·Y + z·Z."""

    model_config = OPEN
    origin: Triple
    x: Triple
    y: Triple
    z: Triple


class StoredSigma(BaseModel):
    """Standard errors of the edges of an opening, m."""

    model_config = OPEN
    left: NotNegative = 0.0
    right: NotNegative = 0.0
    bottom: NotNegative = 0.0
    top: NotNegative = 0.0


class StoredStorey(DrawnStorey):
    """Where the wall's thickness changes, m."""

    model_config = OPEN


class StoredArc(BaseModel):
    """Corners of an outline that stand for a piece of an ellipse."""

    model_config = OPEN
    first: NotNegativeInt
    last: NotNegativeInt
    centre: Pair
    radii: Annotated[list[Positive], Field(min_length=2, max_length=2)]


class StoredOpening(BaseModel):
    """An opening of a facade.json; rectangle and outline may both be there."""

    model_config = OPEN
    id: int | None = None
    kind: Kind
    x: Number | None = None
    z: Number | None = None
    width: Positive | None = None
    height: Positive | None = None
    area: Positive | None = None
    outline: Ring | None = None
    arcs: list[StoredArc] = []
    confidence: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    evidence: dict[str, Any] = {}
    sigma: StoredSigma = StoredSigma()

    @model_validator(mode="after")
    def _some_shape(self) -> Self:
        if self.outline is None:
            _check_one_shape(None, {name: getattr(self, name) for name in ("x", "z", "width", "height")})
            _check_no_arcs(self.arcs)
        return self


class StoredHole(BaseModel):
    """A filled hole of a facade.json."""

    model_config = OPEN
    outline: Ring
    reason: str = ""
    evidence: dict[str, Any] = {}


class FacadeFile(BaseModel):
    """A facade.json; its further keys are the record of the facade."""

    model_config = OPEN
    units: Literal["m"]
    frame: StoredFrame | None = None
    length: Positive | None = None
    height: Positive | None = None
    thickness: Positive | None = None
    opening_area: NotNegative | None = None
    outline: Ring | None = None
    arcs: list[StoredArc] = []
    storeys: list[StoredStorey] = []
    openings: list[StoredOpening]
    filled_holes: list[StoredHole] = []

    @model_validator(mode="after")
    def _some_shape(self) -> Self:
        if self.outline is None:
            _check_one_shape(None, {"length": self.length, "height": self.height})
            _check_no_arcs(self.arcs)
        ids = [opening.id for opening in self.openings if opening.id is not None]
        if len(set(ids)) < len(ids):
            msg = f"openings have the same 'id': {ids}"
            raise ValueError(msg)
        return self


def _check_no_arcs(arcs: list[StoredArc]) -> None:
    """Raise if there are arcs, which count the corners of an outline that is not there."""
    if arcs:
        msg = "has 'arcs' but no 'outline', whose corners they count: add it, or leave them out"
        raise ValueError(msg)


def _check_one_shape(outline: list[list[float]] | None, sizes: Mapping[str, float | None]) -> None:
    """Raise unless there is either an outline or all the sizes of a rectangle."""
    given = [name for name, value in sizes.items() if value is not None]
    missing = [name for name, value in sizes.items() if value is None]
    if outline is None and missing:
        msg = f"needs {_listed(sizes)}, or 'outline'"
        if given:
            msg = f"{', '.join(map(repr, missing))} {'is' if len(missing) == 1 else 'are'} missing"
        raise ValueError(msg)
    if outline is not None and given:
        msg = f"has both 'outline' and {', '.join(map(repr, given))}: leave one out"
        raise ValueError(msg)


def _listed(names: Mapping[str, Any]) -> str:
    *first, last = map(repr, names)
    return f"{', '.join(first)} and {last}"


def validate(model: type[Model], data: Mapping[str, Any], *, source: str) -> Model:
    """Return `data` as a `model`, or raise an `InputError` of one line that begins with `source`.

    Examples
    --------
    >>> validate(DrawnFrame, {"heading": "north"}, source="wall.toml")
    Traceback (most recent call last):
    fd2fem.errors.InputError: wall.toml: 'heading': input should be a valid number, got 'north'.
    """
    try:
        return model.model_validate(dict(data))
    except ValidationError as error:
        first, *others = error.errors(include_url=False)
        more = f" (and {len(others)} more)" if others else ""
        msg = f"{source}: {_describe(first)}{more}."
        raise InputError(msg) from error


def _describe(error: ErrorDetails) -> str:
    """One error of pydantic in the words of the file: where, what, the given value."""
    place, key = _place(error["loc"])
    match error["type"]:
        case "missing":
            return f"{place}{key} is missing"
        case "extra_forbidden":
            return f"{place}unknown key {key}"
        case "value_error":
            return f"{place}{key}{': ' * bool(key)}{error['msg'].removeprefix('Value error, ')}"
    text = error["msg"][:1].lower() + error["msg"][1:]
    given = repr(error["input"])
    return f"{place}{key}: {text}, got {given if len(given) < 60 else given[:56] + ' ...'}"


def _place(loc: tuple[int | str, ...]) -> tuple[str, str]:
    """Split a location into the list's entry, counted from 1 as people do, and the key in quotes."""
    place = ""
    while len(loc) > 1 and (entry := ENTRIES.get(str(loc[0]))) and isinstance(loc[1], int):
        place += f"{entry} {loc[1] + 1}: "
        loc = loc[2:]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).lstrip(".")
    return place, f"'{key}'" if key else ""
