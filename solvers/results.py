"""Writing a response for people and programs, and reading it back for a comparison.

A folder holds ``response.json`` (the figures) and ``response.vtu`` (the fields, for ParaView). Both are
lossless, except that the mesh's facet groups are not kept. After an analysis in steps,
``load_settlement.csv`` holds its history once more, as a table.
"""

import csv
import io
import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, Response, VolumeMesh
from fd2fem.model.checks import as_array
from solvers.vtu_files import point_fields, write_vtu

if TYPE_CHECKING:
    import meshio

__all__ = ["CURVE", "SCHEMA", "read_response", "response_to_dict", "write_response"]

SCHEMA = "fd2fem/response-1"
FIGURES = "response.json"
FIELDS = "response.vtu"
CURVE = "load_settlement.csv"

KEYS: Mapping[str, str] = MappingProxyType(
    {
        "max_displacement_m": "max_displacement",
        "max_principal_stress_pa": "max_principal_stress",
        "p95_principal_stress_pa": "p95_principal_stress",
        "p99_principal_stress_pa": "p99_principal_stress",
        "rms_stress_pa": "rms_stress",
        "weight_n": "weight",
        "strain_energy_j": "strain_energy",
        "dissipated_energy_j": "dissipated_energy",
        "max_crack_opening_m": "max_crack_opening",
        "damage_class": "damage_class",
    }
)
"""Keys of the file that hold a scalar, and the attributes of the response."""

COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "share": "share",
        "settlement_m": "settlement",
        "max_displacement_m": "max_displacement",
        "max_principal_stress_pa": "max_principal_stress",
        "max_crack_opening_m": "max_crack_opening",
        "strain_energy_j": "strain_energy",
        "dissipated_energy_j": "dissipated_energy",
        "plastic_energy_j": "plastic_energy",
        "external_work_j": "external_work",
        "iterations": "iterations",
        "residual": "residual",
        "strength_error": "strength_error",
    }
)
"""Columns of the load-settlement curve that hold a scalar, and what the history calls them."""


def response_to_dict(response: Response) -> dict[str, Any]:
    """The figures of a response as JSON values, schema "fd2fem/response-1"."""
    return {
        "schema": SCHEMA,
        "converged": True,
        **{key: getattr(response, name) for key, name in KEYS.items()},
        "final_principal_stress_pa": response.final_principal_stress,
        "reaction_n": response.reaction.tolist(),
        "feet": [dict(foot) for foot in response.feet],
        "mesh": {
            "nodes": len(response.mesh.nodes),
            "elements": len(response.mesh.elements),
            "dofs": response.dofs,
        },
        "solver": dict(response.solver),
        "timings_s": dict(response.timings),
        "history": [dict(step) for step in response.history],
        "damage": dict(response.damage),
    }


def write_response(response: Response, folder: Path) -> None:
    """Write ``response.vtu`` and then ``response.json`` into a folder, which is made if need be.

    The fields at the nodes are displacement (m), stress (Pa: xx, yy, zz, xy, yz, xz), principal_stress (Pa)
    and the directions of the first and the third principal stress; those of the elements sigma1 (Pa), the
    mean over the nodes, largest_sigma1 (Pa), over all steps, and crack_opening (m), crack_normal and
    dissipation (J). After an analysis in steps, `CURVE` goes with them. Each file appears under its name only
    when it is whole.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    cells = {
        "sigma1": response.principal_stress[response.mesh.elements, 0].mean(axis=1),
        "largest_sigma1": response.largest_stress,
        "crack_opening": response.crack_opening,
        "crack_normal": response.crack_normal,
        "dissipation": response.dissipation,
    }
    points = point_fields(response.displacement, response.stress)
    points["principal_stress"] = response.principal_stress
    write_vtu(folder / FIELDS, response.mesh, points=points, cells=cells)
    if response.history:
        _write_whole(folder / CURVE, _curve(response))
    _write_whole(folder / FIGURES, json.dumps(response_to_dict(response), indent=2, allow_nan=False) + "\n")


def _write_whole(path: Path, text: str) -> None:
    part = path.with_name(f"{path.name}.part")
    part.write_text(text, encoding="utf-8", newline="")
    part.replace(path)


def _curve(response: Response) -> str:
    """The history as CSV: a row for each step, the forces in all and on each foot, N, after the scalars."""
    forces = ["reaction", *(f"foot{number}" for number in range(1, len(response.feet) + 1))]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["step", *COLUMNS, *(f"{name}_{axis}_n" for name in forces for axis in "xyz")])
    for number, step in enumerate(response.history):
        feet = [force for foot in step["feet"] for force in foot]
        table.writerow([number, *(step[name] for name in COLUMNS.values()), *step["reaction"], *feet])
    return text.getvalue()


def read_response(folder: Path) -> Response:
    """Read what `write_response` wrote; the mesh's groups come back empty.

    Raises
    ------
    InputError
        If a file is missing, damaged, of another schema, or the two do not belong together.
    """
    folder = Path(folder)
    figures = _read_figures(folder / FIGURES)
    grid = _read_fields(folder / FIELDS)
    try:
        response = _assemble_response(figures, grid)
        counted = figures["mesh"]["nodes"], figures["mesh"]["elements"]
    except KeyError as error:
        msg = f"The response in {folder} lacks {error}: analyse again."
        raise InputError(msg) from error
    except (TypeError, ValueError) as error:
        msg = f"The response in {folder} is damaged ({error}): analyse again."
        raise InputError(msg) from error
    if counted != (len(response.mesh.nodes), len(response.mesh.elements)):
        msg = f"{FIGURES} and {FIELDS} in {folder} belong to different meshes: analyse again."
        raise InputError(msg)
    return response


def _assemble_response(figures: dict[str, Any], grid: "meshio.Mesh") -> Response:
    scalars = as_array("figures", [figures[key] for key in KEYS], (len(KEYS),)).tolist()
    named = dict(zip(KEYS.values(), scalars, strict=True))
    (block,) = grid.cells
    mesh = VolumeMesh(nodes=grid.points, elements=block.data, kind=ElementKind(block.type), groups={})
    return Response(
        mesh=mesh,
        displacement=grid.point_data["displacement"],
        stress=grid.point_data["stress"],
        principal_stress=grid.point_data["principal_stress"],
        reaction=figures["reaction_n"],
        dofs=figures["mesh"]["dofs"],
        solver=figures["solver"],
        timings=figures["timings_s"],
        crack_opening=grid.cell_data["crack_opening"][0],
        crack_normal=grid.cell_data["crack_normal"][0],
        dissipation=grid.cell_data["dissipation"][0],
        # What files of earlier versions do not hold.
        largest_stress=grid.cell_data.get("largest_sigma1", [()])[0],
        final_principal_stress=float(figures.get("final_principal_stress_pa", math.nan)),
        feet=tuple(figures.get("feet", ())),
        history=tuple(figures["history"]),
        damage=figures["damage"],
        **(named | {"damage_class": int(named["damage_class"])}),
    )


def _read_figures(path: Path) -> dict[str, Any]:
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        msg = f"{path} does not exist: give a folder that 'fd2fem analyse' wrote."
        raise InputError(msg) from error
    except (OSError, ValueError) as error:
        msg = f"{path} cannot be read ({error})."
        raise InputError(msg) from error
    schema = figures.get("schema") if isinstance(figures, dict) else None
    if schema != SCHEMA:
        msg = f"{path} has the schema {schema!r}, expected {SCHEMA!r}."
        raise InputError(msg)
    if figures.get("converged") is not True:
        msg = f"{path} does not state that the analysis converged: analyse again."
        raise InputError(msg)
    return dict(figures)


def _read_fields(path: Path) -> "meshio.Mesh":
    # meshio.read ends the process on a damaged file; the format's own reader raises.
    import zlib
    from xml.etree.ElementTree import ParseError

    from meshio import vtu
    from meshio._exceptions import CorruptionError, ReadError

    if not path.is_file():
        msg = f"{path} does not exist: give a folder that 'fd2fem analyse' wrote."
        raise InputError(msg)
    damage = CorruptionError, ReadError, ParseError, zlib.error
    slips = AssertionError, LookupError, OSError, RuntimeError, ValueError
    try:
        return vtu.read(path)
    except (*damage, *slips) as error:
        msg = f"{path} is no VTU file that can be read ({str(error) or type(error).__name__})."
        raise InputError(msg) from error
