"""The options of the whole chain, and the TOML file that sets them."""

import difflib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

from fd2fem.errors import InputError
from fd2fem.meshing import MeshOptions
from fd2fem.reconstruction import ReconstructionOptions
from fd2fem.solids import SolidOptions
from solvers import AnalysisOptions, LinearSettlement, Material, PeckTrough
from validation import ComparisonOptions

__all__ = ["PipelineOptions", "options_from_dict", "read_options"]

T = TypeVar("T")

SETTLEMENTS: dict[str, type] = {"linear": LinearSettlement, "peck": PeckTrough}
"""Kinds of settlement by the name that the configuration gives them."""
PLAIN: dict[str, type] = {
    "reconstruction": ReconstructionOptions,
    "solid": SolidOptions,
    "mesh": MeshOptions,
    "comparison": ComparisonOptions,
}
"""Sections that are a record of options by themselves."""


@dataclass(frozen=True)
class PipelineOptions:
    """One record of options for each stage."""

    reconstruction: ReconstructionOptions = field(default_factory=ReconstructionOptions)
    solid: SolidOptions = field(default_factory=SolidOptions)
    mesh: MeshOptions = field(default_factory=MeshOptions)
    analysis: AnalysisOptions = field(default_factory=AnalysisOptions)
    comparison: ComparisonOptions = field(default_factory=ComparisonOptions)


def read_options(path: Path) -> PipelineOptions:
    """Read a configuration file.

    Sections: ``[reconstruction]``, ``[solid]``, ``[mesh]``, ``[material]``, ``[settlement]`` (with ``kind``
    ``"linear"`` or ``"peck"``), ``[analysis]``, ``[comparison]``; their keys are the fields of the records
    of options. What is left out keeps its default.

    Raises
    ------
    InputError
        If the file is missing, is not TOML, or holds an unknown key or a bad value.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        msg = f"Cannot read the configuration {path}: {error.strerror}."
        raise InputError(msg) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        msg = f"The configuration {path} is not TOML: {error}."
        raise InputError(msg) from error
    return options_from_dict(data, source=str(path))


def options_from_dict(data: Mapping[str, Any], *, source: str) -> PipelineOptions:
    """Check the sections of a configuration and build the options.

    Examples
    --------
    >>> options_from_dict({"mesh": {"size": 0.2}}, source="example").mesh.size
    0.2
    """
    known = {*PLAIN, "material", "settlement", "analysis"}
    for name, section in data.items():
        if name not in known:
            msg = f"{source}: unknown section [{name}]{_closest(name, known)}."
            raise InputError(msg)
        if not isinstance(section, Mapping):
            msg = f"{source}: '{name}' must be a section, [{name}]."
            raise InputError(msg)
    chosen: dict[str, Any] = {
        name: _record(cls, data[name], f"{source}: [{name}]") for name, cls in PLAIN.items() if name in data
    }
    parts: dict[str, Any] = {}
    if "material" in data:
        parts["material"] = _record(Material, data["material"], f"{source}: [material]")
    if "settlement" in data:
        parts["settlement"] = _settlement(data["settlement"], f"{source}: [settlement]")
    if "analysis" in data or parts:
        chosen["analysis"] = _analysis(data.get("analysis", {}), parts, f"{source}: [analysis]")
    return PipelineOptions(**chosen)


def _settlement(section: Mapping[str, Any], where: str) -> object:
    """The settlement record that ``kind`` names."""
    values = dict(section)
    kind = values.pop("kind", "linear")
    if not isinstance(kind, str) or kind not in SETTLEMENTS:
        msg = f"{where}: kind is {kind!r}, expected {' or '.join(map(repr, SETTLEMENTS))}."
        raise InputError(msg)
    return _record(SETTLEMENTS[kind], values, where)


def _analysis(section: Mapping[str, Any], parts: dict[str, Any], where: str) -> AnalysisOptions:
    """The options of the analysis: `parts` come from sections of their own, gravity from this one."""
    _check_keys(section, {"gravity"}, where)
    gravity = section.get("gravity", AnalysisOptions.gravity)
    if isinstance(gravity, bool) or not isinstance(gravity, int | float):
        msg = f"{where}: gravity: expected a number, got {gravity!r}."
        raise InputError(msg)
    try:
        return AnalysisOptions(gravity=float(gravity), **parts)
    except InputError as error:
        msg = f"{where}: {error}"
        raise InputError(msg) from error


def _check_keys(section: Mapping[str, Any], known: set[str], where: str) -> None:
    for name in section:
        if name not in known:
            msg = f"{where}: unknown key '{name}'{_closest(name, known)}."
            raise InputError(msg)


def _record(cls: type[T], values: Mapping[str, Any], where: str) -> T:
    """Build a record of options from a section, with one line for whatever is wrong."""
    from pydantic import TypeAdapter, ValidationError

    # Every cls is a dataclass.
    _check_keys(values, {entry.name for entry in fields(cls)}, where)  # type: ignore[arg-type]
    _check_tables(cls, values, where)
    try:
        # By way of JSON, the strict check takes a table for a record, but neither true nor "1" for a number.
        return TypeAdapter(cls).validate_json(json.dumps(values, default=str), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(str(part) for part in first["loc"])
        text = first["msg"].removeprefix("Value error, ")
        msg = f"{where}: {name + ': ' if name else ''}{text}"
        raise InputError(msg) from error


def _check_tables(cls: type, values: Mapping[str, Any], where: str) -> None:
    """Check the keys of a list of tables, whose record the field of `cls` names."""
    hints = get_type_hints(cls)
    for name, value in values.items():
        entry = next(iter(get_args(hints[name])), None)
        if not (isinstance(value, list) and is_dataclass(entry)):
            continue
        for number, table in enumerate(value, start=1):
            if isinstance(table, Mapping):
                _check_keys(table, {one.name for one in fields(entry)}, f"{where}: {name} {number}")


def _closest(name: str, known: set[str]) -> str:
    """The name that was probably meant, or all there are."""
    near = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean '{near[0]}'?" if near else f"; known are {', '.join(sorted(known))}"
