"""Facades as files: facade.json, TOML and DXF drawings, and stand-ins for the paper's buildings."""

from fd2fem.drawings.facade_json import facade_from_dict, facade_to_dict
from fd2fem.drawings.files import read_facade, write_facade
from fd2fem.drawings.stand_ins import STAND_INS, stand_in

__all__ = [
    "STAND_INS",
    "facade_from_dict",
    "facade_to_dict",
    "read_facade",
    "stand_in",
    "write_facade",
]
