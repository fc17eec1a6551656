"""The whole chain, a line per step: scan, facade, solid, mesh, response, comparison, report."""

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from time import perf_counter
from typing import TypeVar

import numpy as np

from fd2fem.config import PipelineOptions
from fd2fem.drawings import write_facade
from fd2fem.errors import InputError
from fd2fem.exchange import write_facade_solid
from fd2fem.loading import load_facade
from fd2fem.meshing import mesh_facade, mesh_quality, read_mesh, write_mesh
from fd2fem.model import (
    Comparison,
    Facade,
    FacadeFrame,
    Model,
    PointCloud,
    QuantityComparison,
    Response,
    RunResult,
)
from fd2fem.reconstruction import reconstruct
from fd2fem.report import draw_cracks, write_report
from fd2fem.scans import (
    Density,
    ScannerOptions,
    Scene,
    resample_to,
    simulate_scan,
    step_for_spacing,
    street_scene,
)
from solvers import StepSeries, WallState, analyse, write_response
from validation import (
    NoCommonWallError,
    compare_facades,
    compare_responses,
    judge,
    response_notes,
    write_comparison,
)

__all__ = [
    "analyse_file",
    "compare_models",
    "run",
    "scan_facade",
    "survey_frame",
]

T = TypeVar("T")
Progress = Callable[[str], None]

ORIGINAL_COUNTS = {"building1": 264_931, "building2": 190_865, "building3": 650_306}
"""Points of the original scans (NS00), table 1 of the paper."""


def scan_facade(
    facade: Facade,
    *,
    scanner: ScannerOptions,
    scene: Scene | None = None,
    density: Density = Density.NS00,
    original_points: int | None = None,
) -> PointCloud:
    """Scan a facade virtually.

    Parameters
    ----------
    facade : Facade
    scanner : ScannerOptions
    scene : Scene or None
        What stands around; ``None``: a street.
    density : Density
        Of the paper's data sets: original, or re-sampled to 20, 50 or 75 mm.
    original_points : int or None
        Choose the angular step so that about so many points fall on the wall.
    """
    if original_points is not None:
        spacing = float(np.sqrt(facade.wall_area / original_points))
        step = step_for_spacing(facade, spacing, stations=scanner.stations)
        scanner = replace(scanner, angular_step=step)
    scene = street_scene(facade, seed=scanner.seed, stations=scanner.stations) if scene is None else scene
    cloud = simulate_scan(facade, options=scanner, scene=scene)
    return resample_to(cloud, density, seed=scanner.seed)


def survey_frame() -> FacadeFrame:
    """Where the demonstration puts its facade: national grid coordinates, turned by 37 degrees."""
    angle = np.radians(37.0)
    right = np.array([np.cos(angle), np.sin(angle), 0.0])
    inward = np.array([-np.sin(angle), np.cos(angle), 0.0])
    return FacadeFrame(np.array([715_830.0, 734_120.0, 12.5]), np.array([right, inward, [0.0, 0.0, 1.0]]))


def compare_models(candidate: Model, reference: Model, *, options: PipelineOptions) -> Comparison:
    """Hold a candidate against a reference, in geometry and response as far as both have them.

    Raises
    ------
    InputError
        If they have nothing in common.
    """
    geometry: Comparison | None = None
    quantities: tuple[QuantityComparison, ...] = ()
    notes: tuple[str, ...] = ()
    if candidate.facade is not None and reference.facade is not None:
        geometry = compare_facades(
            candidate.facade,
            reference.facade,
            tolerance=options.comparison.tolerance,
            level=options.comparison.level,
        )
    if candidate.response is not None and reference.response is not None:
        try:
            quantities = compare_responses(
                candidate.response, reference.response, tolerance=options.comparison.tolerance
            )
            notes = response_notes(candidate.response, reference.response)
        except NoCommonWallError as error:
            if geometry is None:
                raise
            # The facades do not match: that is a verdict, not a mistake of the user's.
            return replace(geometry, passed=False, reasons=(*geometry.reasons, str(error).rstrip(".")))
    if geometry is None and not quantities:
        msg = "Nothing to compare: give two facades, or two analysed folders."
        raise InputError(msg)
    return judge(geometry, quantities, tolerance=options.comparison.tolerance, notes=notes)


def run(
    cloud: PointCloud,
    folder: Path,
    *,
    reference: Facade | None = None,
    options: PipelineOptions,
    progress: Progress,
) -> RunResult:
    """From a scan to a verdict, with every result written to `folder`.

    Parameters
    ----------
    cloud : PointCloud
    folder : Path
        Exists and is empty.
    reference : Facade or None
        The measured drawing; the same load on a mesh of the same element size.
    options : PipelineOptions
    progress : callable
        Takes a line of text for the user.

    Returns
    -------
    RunResult
    """
    clock: dict[str, float] = {}
    progress(f"reconstructing the facade from {len(cloud):,} points")
    if reference is not None:
        like = replace(options.reconstruction, thickness=reference.thickness, storeys=reference.storeys)
        options = replace(options, reconstruction=like)
    reconstruction = _timed(clock, "reconstruct", lambda: reconstruct(cloud, options=options.reconstruction))
    facade = reconstruction.facade
    write_facade(facade, folder / "facade.json")
    progress(f"building the solid: {len(facade.openings)} openings, {facade.wall_area:.2f} m² of wall")
    solid = _timed(clock, "solid", lambda: write_facade_solid(facade, folder, options=options))
    progress("meshing")
    mesh = _timed(clock, "mesh", lambda: mesh_facade(facade, options=options.mesh))
    quality = mesh_quality(mesh)
    write_mesh(mesh, folder / "mesh.msh")
    progress(f"analysing {quality.elements:,} elements")
    response = _timed(
        clock,
        "analyse",
        lambda: analyse(
            mesh, options=options.analysis, on_step=lambda found: progress(_how_far(found, options))
        ),
    )
    write_response(response, folder)
    other, comparison = None, None
    if reference is not None:
        progress("analysing the reference and comparing")
        other = _timed(clock, "reference", lambda: _reference(reference, folder / "reference", options))
        comparison = compare_models(Model(facade, response), other, options=options)
        write_comparison(comparison, folder / "comparison.json")
    result = RunResult(
        cloud, reconstruction, asdict(solid), mesh, quality, response, other, comparison, timings=clock
    )
    progress("drawing the figures")
    _timed(clock, "report", lambda: write_report(result, folder))
    return result


def _reference(facade: Facade, folder: Path, options: PipelineOptions) -> Model:
    """Mesh and analyse the drawing like the candidate."""
    folder.mkdir()
    write_facade(facade, folder / "facade.json")
    response = analyse(mesh_facade(facade, options=options.mesh), options=options.analysis)
    write_response(response, folder)
    return Model(facade, response)


def analyse_file(
    name: str,
    folder: Path,
    *,
    options: PipelineOptions,
    progress: Progress,
    state: Path | None = None,
) -> Response:
    """Analyse a facade or a mesh from a file and write the response (and the facade) to `folder`.

    A wall that cracks is followed in steps, which ParaView shows as ``response.pvd``; ``cracks.png`` is drawn
    of its cracks. With `state`, a file, an analysis that was stopped goes on from its last step.
    """
    if Path(name).suffix.lower() == ".msh":
        mesh = read_mesh(Path(name))
    else:
        facade = load_facade(name)
        write_facade(facade, folder / "facade.json")
        progress("meshing")
        mesh = mesh_facade(facade, options=options.mesh)
    progress(f"analysing {len(mesh.elements):,} elements")
    series = StepSeries(folder, mesh)

    def on_step(found: WallState) -> None:
        series(found)
        progress(_how_far(found, options))

    response = analyse(mesh, options=options.analysis, state=state, on_step=on_step)
    write_response(response, folder)
    if response.knows_cracks:
        draw_cracks(response, folder / "cracks.png")
    return response


def _how_far(found: WallState, options: PipelineOptions) -> str:
    """What a user is told of a step."""
    step = found.record
    words = f"{100 * step.share:.1f} % of the settlement"
    if options.analysis.masonry is None:
        return words
    return f"{words}, cracks up to {1000 * step.max_crack_opening:.2f} mm"


def _timed(clock: dict[str, float], name: str, step: Callable[[], T]) -> T:
    """Run a step and note how long it took, s."""
    start = perf_counter()
    result = step()
    clock[name] = round(perf_counter() - start, 3)
    return result
