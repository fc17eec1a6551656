"""What goes to other programs: solids, meshes with their loads, and CalculiX's second opinion."""

from pathlib import Path

from fd2fem.config import PipelineOptions
from fd2fem.meshing import front_cells, quadratic_mesh, write_mesh
from fd2fem.model import ElementKind, Facade, LoadCase, Response, VolumeMesh, VoxelModel, WallCells
from fd2fem.reconstruction import voxelise
from fd2fem.solids import SolidReport, write_solid
from solvers import AnalysisOptions, analyse, base_displacement
from solvers.calculix.check import CalculixCheck, comparable_element, compare_with_calculix, write_check
from solvers.calculix.files import find_calculix, run_calculix
from solvers.fem.elements import ElementType

__all__ = [
    "check_with_calculix",
    "export_mesh",
    "facade_cells",
    "load_case",
    "require_calculix",
    "write_facade_solid",
]


def facade_cells(facade: Facade, *, options: PipelineOptions) -> VoxelModel | WallCells:
    """What the volumes of the neutral file are made of, exactly the wall.

    Voxels where all edges are level or upright; else quadrilaterals that follow the slanted and curved ones.
    """
    size = options.reconstruction.voxel_limit
    return voxelise(facade, max_size=size) if facade.rectilinear else front_cells(facade, size=size)


def write_facade_solid(facade: Facade, folder: Path, *, options: PipelineOptions) -> SolidReport:
    """Write the solid of a facade in all its forms, and the deck of its settlement."""
    return write_solid(
        facade,
        facade_cells(facade, options=options),
        folder,
        options=options.solid,
        case=load_case(options.analysis, extent=(0.0, facade.length)),
    )


def load_case(options: AnalysisOptions, *, extent: tuple[float, float]) -> LoadCase:
    """What other programs need to analyse the wall as we do; `extent`: its ends along x, m."""
    return LoadCase(
        young=options.material.young,
        poisson=options.material.poisson,
        density=options.material.density,
        gravity=options.gravity,
        base=lambda points: base_displacement(options.settlement, points, extent=extent),
    )


def export_mesh(mesh: VolumeMesh, path: Path, *, options: PipelineOptions) -> None:
    """Write a mesh in the format of the path's suffix, with material and loads where the format has them.

    A file for CalculiX or Abaqus gets 20-node hexahedra unless `MeshOptions.order` says 1: with the 8-node
    ones of the mesh, which lock in bending, it would not compute what `analyse` does.
    """
    if path.suffix.lower() == ".inp" and options.mesh.order == 0:
        mesh = quadratic_mesh(mesh)
    write_mesh(mesh, path, case=load_case(options.analysis, extent=_extent(mesh)))


def require_calculix(options: PipelineOptions) -> None:
    """Refuse a check that cannot be made, before the work is done.

    Raises
    ------
    InputError
        If the analysis is not linear, or CalculiX is not installed.
    """
    comparable_element(ElementKind.HEXAHEDRON20, options.analysis)
    find_calculix()


def check_with_calculix(response: Response, folder: Path, *, options: PipelineOptions) -> CalculixCheck:
    """Hold a linear response against CalculiX; write ``calculix.inp``, its deck, and ``calculix.json``.

    8-node hexahedra that are analysed as 20-node ones go to CalculiX as those, and are analysed as those once
    more: its integration points need the displacements in the middle of the edges.
    """
    mesh, case = response.mesh, options.analysis
    if comparable_element(mesh.kind, case) is ElementType.HEXAHEDRON20:
        mesh = quadratic_mesh(mesh)
    full = response if mesh is response.mesh else analyse(mesh, options=case)
    deck = folder / "calculix.inp"
    write_mesh(mesh, deck, case=load_case(case, extent=_extent(mesh)))
    check = compare_with_calculix(response, run_calculix(deck), options=case, full=full)
    write_check(check, folder / "calculix.json")
    return check


def _extent(mesh: VolumeMesh) -> tuple[float, float]:
    """The wall's ends along x, m."""
    return float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
