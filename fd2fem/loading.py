"""What the commands take: scans, facades, meshes and analysed folders, by name or file."""

from collections.abc import Sequence
from pathlib import Path

from fd2fem.config import PipelineOptions
from fd2fem.drawings import STAND_INS, read_facade, stand_in
from fd2fem.errors import InputError
from fd2fem.meshing import mesh_facade, mesh_step
from fd2fem.model import Facade, Model, PointCloud, VolumeMesh
from fd2fem.scans import Units, read_scans
from fd2fem.solids import CAD_SUFFIXES, facade_from_step
from solvers import read_response

__all__ = ["load_cloud", "load_facade", "load_mesh", "load_model"]


def load_cloud(
    paths: Sequence[Path], *, units: Units = Units.AUTO, scanners: Sequence[Sequence[float]] = ()
) -> PointCloud:
    """Read one or more scans; `scanners` (world frame, m) replaces the positions that the files hold.

    As many as there are scans or files, they belong to one each; a single one to all.
    """
    return read_scans(paths, units=units, scanners=scanners)


def load_facade(name: str) -> Facade:
    """Read a facade by the name of a stand-in, or from facade.json, a TOML or DXF drawing or a CAD solid.

    Raises
    ------
    InputError
        If there is no such file, or it is not a facade.
    """
    if not name:
        msg = "The name of a facade is empty; give a file, or building1, building2 or building3."
        raise InputError(msg)
    path = Path(name)
    if name in STAND_INS:
        return stand_in(name)
    if path.is_dir():
        path = path / "facade.json"
    if path.suffix.lower() in CAD_SUFFIXES:
        return facade_from_step(path)
    return read_facade(path)


def load_model(name: str) -> Model:
    """Read what a comparison takes: a facade, or an analysed folder with its facade if it holds one."""
    path = Path(name)
    if not path.is_dir():
        return Model(load_facade(name), None)
    has_facade, has_response = (path / "facade.json").is_file(), (path / "response.json").is_file()
    if not (has_facade or has_response):
        msg = f"{path} holds neither facade.json nor response.json; give a facade or an analysed folder."
        raise InputError(msg)
    return Model(
        load_facade(name) if has_facade else None,
        read_response(path) if has_response else None,
    )


def load_mesh(name: str, *, options: PipelineOptions) -> VolumeMesh:
    """Mesh a facade, or any CAD solid (tetrahedra)."""
    if Path(name).suffix.lower() in CAD_SUFFIXES:
        return mesh_step(Path(name), options=options.mesh)
    return mesh_facade(load_facade(name), options=options.mesh)
