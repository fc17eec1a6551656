"""Facades from files and into them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from fd2fem.drawings.facade_dxf import facade_from_dxf
from fd2fem.drawings.facade_json import facade_from_dict, facade_to_dict
from fd2fem.drawings.facade_toml import facade_from_toml
from fd2fem.errors import InputError
from fd2fem.model import Facade

__all__ = ["read_facade", "write_facade"]


def read_facade(path: Path, *, thickness: float | None = None) -> Facade:
    """Read a facade: facade.json, a TOML list of rectangles or a DXF drawing, by the suffix.

    Parameters
    ----------
    path : Path
    thickness : float, m, or None
        At the ground, in place of the file's, whose storeys keep theirs; where neither says, 0.35 m.

    Raises
    ------
    InputError
        If the file is missing, of another kind, or not a facade; one line that names the place.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if path.is_dir():
        msg = f"{path} is a folder: name a facade.json, TOML or DXF file."
        raise InputError(msg)
    if not path.exists():
        msg = f"{path}: no such file."
        raise InputError(msg)
    if suffix == ".dxf":
        return facade_from_dxf(path, thickness=thickness)
    if suffix == ".toml":
        return facade_from_toml(_text(path), source=str(path), thickness=thickness)
    if suffix == ".json":
        facade = _read_json(path)
        return facade if thickness is None else replace(facade, thickness=thickness)
    msg = f"{path} is not read as a facade; convert to facade.json, TOML or DXF."
    raise InputError(msg)


def write_facade(facade: Facade, path: Path) -> None:
    """Write a facade.json; reading it gives the same facade, to the last bit.

    Raises
    ------
    InputError
        If the file cannot be written, or the facade's record holds what JSON cannot.
    """
    text = json.dumps(facade_to_dict(facade), indent=2, ensure_ascii=False, allow_nan=False)
    try:
        Path(path).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        msg = f"{path} cannot be written: {error.strerror}."
        raise InputError(msg) from error


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        msg = f"{path} cannot be read: {error.strerror}."
        raise InputError(msg) from error
    except UnicodeDecodeError as error:
        msg = f"{path} is not text: byte {error.start + 1} is no UTF-8."
        raise InputError(msg) from error


def _read_json(path: Path) -> Facade:
    try:
        data = json.loads(_text(path), parse_constant=_no_constant)
    except (json.JSONDecodeError, RecursionError) as error:
        msg = f"{path} is not JSON: {error}."
        raise InputError(msg) from error
    except _ConstantError as error:
        msg = f"{path} is not JSON: it holds {error}."
        raise InputError(msg) from error
    return facade_from_dict(data, source=str(path))


class _ConstantError(Exception):
    """NaN or Infinity, which Python's parser would accept."""


def _no_constant(name: str) -> NoReturn:
    raise _ConstantError(name)
