"""What facade files may hold, as pydantic models, and their errors in one line.

This module loads pydantic; import it where something is validated.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from fd2fem.errors import InputError

__all__ = ["DrawingFile", "DrawnFrame", "DrawnOpening", "FacadeFile", "StoredOpening", "validate"]

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
Ring = Annotated[list[Pair], Field(min_length=3)]
Kind = Literal["window", "door"]

CLOSED = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
OPEN = ConfigDict(strict=True, allow_inf_nan=False, extra="ignore")

Model = TypeVar("Model", bound=BaseModel)


class DrawnOpening(BaseModel):
    """An opening of a TOML drawing: a rectangle, or an outline."""

    model_config = CLOSED
    kind: Kind | None = None
    x: float | None = None
    z: float | None = None
    width: Positive | None = None
    height: Positive | None = None
    outline: Ring | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        _check_one_shape(self.outline, {name: getattr(self, name) for name in ("x", "z", "width", "height")})
        return self


class DrawnFrame(BaseModel):
    """Where the (0, 0) of a TOML drawing stands in the world, and where its x axis points."""

    model_config = CLOSED
    origin: Triple = [0.0, 0.0, 0.0]
    heading: float = 0.0


class DrawingFile(BaseModel):
    """A TOML drawing: the wall and a list of openings."""

    model_config = CLOSED
    name: str = ""
    source: str = ""
    units: Literal["m", "mm"] = "m"
    length: Positive | None = None
    height: Positive | None = None
    outline: Ring | None = None
    thickness: Positive | None = None
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


class StoredOpening(BaseModel):
    """An opening of a facade.json; rectangle and outline may both be there."""

    model_config = OPEN
    id: int | None = None
    kind: Kind
    x: float | None = None
    z: float | None = None
    width: Positive | None = None
    height: Positive | None = None
    area: Positive | None = None
    outline: Ring | None = None
    confidence: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    evidence: dict[str, Any] = {}
    sigma: StoredSigma = StoredSigma()

    @model_validator(mode="after")
    def _some_shape(self) -> Self:
        if self.outline is None:
            _check_one_shape(None, {name: getattr(self, name) for name in ("x", "z", "width", "height")})
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
    openings: list[StoredOpening]
    filled_holes: list[StoredHole] = []

    @model_validator(mode="after")
    def _some_shape(self) -> Self:
        if self.outline is None:
            _check_one_shape(None, {"length": self.length, "height": self.height})
        ids = [opening.id for opening in self.openings if opening.id is not None]
        if len(set(ids)) < len(ids):
            msg = f"openings have the same 'id': {ids}"
            raise ValueError(msg)
        return self


def _check_one_shape(outline: Ring | None, sizes: Mapping[str, float | None]) -> None:
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
    if len(loc) > 1 and loc[0] in {"openings", "filled_holes"} and isinstance(loc[1], int):
        place = f"{'opening' if loc[0] == 'openings' else 'filled hole'} {loc[1] + 1}: "
        loc = loc[2:]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).lstrip(".")
    return place, f"'{key}'" if key else ""
