"""The options of the whole chain, and the TOML file that sets them."""

import difflib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

from fd2fem.errors import InputError
from fd2fem.meshing import MeshOptions
from fd2fem.reconstruction import ReconstructionOptions
from fd2fem.solids import SolidOptions
from solvers import (
    AnalysisOptions,
    BaseOptions,
    LengthUnit,
    LinearSettlement,
    MasonryLaw,
    Material,
    PeckTrough,
    Settlement,
    SettlementTable,
    SettlementTrough,
    SteppingOptions,
    read_settlement_table,
)
from validation import ComparisonOptions

__all__ = ["PipelineOptions", "options_from_dict", "read_options"]

T = TypeVar("T")

SETTLEMENTS: dict[str, type] = {
    "linear": LinearSettlement,
    "table": SettlementTable,
    "peck": PeckTrough,
    "trough": SettlementTrough,
}
"""Kinds of settlement by the name that the configuration gives them."""
PLAIN: dict[str, type] = {
    "reconstruction": ReconstructionOptions,
    "solid": SolidOptions,
    "mesh": MeshOptions,
    "comparison": ComparisonOptions,
}
"""Sections that are a record of options by themselves."""
PARTS: dict[str, type] = {
    "material": Material,
    "masonry": MasonryLaw,
    "base": BaseOptions,
    "stepping": SteppingOptions,
}
"""Sections that are a part of the options of the analysis."""


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
    ``"linear"``, ``"table"``, ``"peck"`` or ``"trough"``), ``[analysis]``, ``[comparison]``; their keys are
    the fields of the records of options. What is left out keeps its default. A table of settlements is given
    by its columns, or as a ``file`` beside the configuration. ``[masonry]``, even an empty one, makes the
    wall crack; ``[base]`` is the joint under it, ``[stepping]`` how the settlement is applied.

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
    return options_from_dict(data, source=str(path), folder=path.parent)


def options_from_dict(data: Mapping[str, Any], *, source: str, folder: Path = Path()) -> PipelineOptions:
    """Check the sections of a configuration and build the options.

    Parameters
    ----------
    data : mapping
        Content of the file.
    source : str
        File that a message names.
    folder : Path
        Where the files that it names lie.

    Examples
    --------
    >>> options_from_dict({"mesh": {"size": 0.2}}, source="example").mesh.size
    0.2
    """
    known = {*PLAIN, *PARTS, "settlement", "analysis"}
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
    parts: dict[str, Any] = {
        name: _record(cls, data[name], f"{source}: [{name}]") for name, cls in PARTS.items() if name in data
    }
    if "settlement" in data:
        parts["settlement"] = _settlement(data["settlement"], f"{source}: [settlement]", folder)
    if "analysis" in data or parts:
        chosen["analysis"] = _analysis(data.get("analysis", {}), parts, f"{source}: [analysis]")
    return PipelineOptions(**chosen)


def _settlement(section: Mapping[str, Any], where: str, folder: Path) -> Settlement:
    """The settlement record that ``kind`` names."""
    values = dict(section)
    kind = values.pop("kind", "linear")
    if not isinstance(kind, str) or kind not in SETTLEMENTS:
        *first, last = map(repr, SETTLEMENTS)
        msg = f"{where}: kind is {kind!r}, expected {', '.join(first)} or {last}."
        raise InputError(msg)
    if kind == "table" and "file" in values:
        return _table(values, where, folder)
    record: Settlement = _record(SETTLEMENTS[kind], values, where)
    return record


def _table(values: Mapping[str, Any], where: str, folder: Path) -> SettlementTable:
    """The settlement table in a file of its own."""
    _check_keys(values, {"file", "unit"}, where)
    unit, units = values.get("unit", "m"), [unit.value for unit in LengthUnit]
    if unit not in units or not isinstance(values["file"], str):
        msg = f'{where}: expected file = "name of a CSV file" and unit = {" or ".join(map(repr, units))}.'
        raise InputError(msg)
    return read_settlement_table(folder / values["file"], unit=LengthUnit(unit))


def _analysis(section: Mapping[str, Any], parts: dict[str, Any], where: str) -> AnalysisOptions:
    """The options of the analysis: `parts` come from sections of their own, the others from this one."""
    own = {entry.name for entry in fields(AnalysisOptions)} - {*PARTS, "settlement"}
    _check_keys(section, own, where)
    try:
        return replace(_record(AnalysisOptions, section, where), **parts)
    except InputError as error:
        text = str(error)
        msg = text if text.startswith(where) else f"{where}: {text}"
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
    """Check the keys of tables, and of lists of them, whose record the field of `cls` names."""
    hints = get_type_hints(cls)
    for name, value in values.items():
        if isinstance(value, Mapping) and is_dataclass(hints[name]):
            _check_keys(value, {one.name for one in fields(hints[name])}, f"{where}: {name}")
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
