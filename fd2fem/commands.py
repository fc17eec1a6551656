"""What each verb of the command line does: one call of the chain, and what the user is told of it."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from fd2fem.errors import InputError
from fd2fem.messages import (
    DONE,
    Say,
    Summary,
    progress,
    response_words,
    run_summary,
    tell_check,
    tell_verdict,
    warn,
)
from fd2fem.model import Facade, PointCloud

if TYPE_CHECKING:
    from fd2fem.config import PipelineOptions

__all__ = ["COMMANDS", "Command", "Summary"]

OF_A_REFERENCE = (
    "comparison.json",
    "08_reference.png",
    "09_comparison.png",
    "09_cracks.png",
    "reference/facade.json",
    "reference/response.json",
    "reference/response.vtu",
)
"""Results that a run without a reference does not make."""
OF_STEPS = ("load_settlement.csv", "cracks.png", "07_cracks.png", "07_load_settlement.png")
"""Results that an analysis in one solve does not make."""
CRACKED_WALLS = "compared_cracks.png"
"""What a comparison draws of two walls that crack."""
OF_A_CHECK = ("calculix.json", "calculix.inp")
"""Results that an analysis without a check does not make."""
Command = Callable[[argparse.Namespace], tuple[int, Summary]]


def _progress(args: argparse.Namespace) -> Say:
    return progress(quiet=args.quiet)


def _options(args: argparse.Namespace) -> "PipelineOptions":
    from dataclasses import replace

    from fd2fem.config import PipelineOptions, read_options
    from fd2fem.meshing import ElementShape
    from fd2fem.solids import SolidForm

    options = read_options(args.config) if getattr(args, "config", None) else PipelineOptions()
    if getattr(args, "wall", None) is not None:
        options = replace(options, reconstruction=replace(options.reconstruction, wall=args.wall))
    return replace(
        options,
        solid=replace(options.solid, **_given(args, form=SolidForm, also=tuple, anf_order=int)),
        mesh=replace(
            options.mesh, **_given(args, size=float, order=int, elements=ElementShape, corner_size=float)
        ),
    )


def _given(args: argparse.Namespace, **types: Callable[[Any], Any]) -> dict[str, Any]:
    """The arguments among these that the command has and the user gave, each as its type."""
    values = {name: getattr(args, name, None) for name in types}
    return {name: types[name](value) for name, value in values.items() if value is not None}


def _cloud(args: argparse.Namespace) -> PointCloud:
    from fd2fem import loading
    from fd2fem.scans import Units

    _progress(args)(f"reading {', '.join(str(path) for path in args.scans)}")
    return loading.load_cloud(args.scans, units=Units(args.units), scanners=args.scanner)


def _simulate(args: argparse.Namespace, facade: Facade) -> PointCloud:
    """The virtual scan that the options describe."""
    from fd2fem import pipeline
    from fd2fem.scans import Density, ScannerOptions, Scene

    given = {"angular_step": args.step} if args.step is not None else {}
    scanner = ScannerOptions(stations=tuple(args.station), range_noise=args.noise, seed=args.seed, **given)
    original = None if args.step is not None else pipeline.ORIGINAL_COUNTS.get(args.facade)
    _progress(args)("scanning virtually")
    return pipeline.scan_facade(
        facade,
        scanner=scanner,
        scene=Scene.empty() if args.clean else None,
        density=Density(args.density),
        original_points=original,
    )


def _run_chain(
    args: argparse.Namespace, make_cloud: Callable[[], PointCloud], reference: Facade | None
) -> tuple[int, Summary]:
    """The chain from points to verdict; the points are made only once the output is known to be free."""
    from fd2fem import pipeline
    from fd2fem.output import staged_folder

    options = _options(args)
    with staged_folder(
        args.output, expected=["facade.json"], stale=(*OF_A_REFERENCE, *OF_STEPS), force=args.force
    ) as folder:
        result = pipeline.run(
            make_cloud(), folder, reference=reference, options=options, progress=_progress(args)
        )
        summary = run_summary(result, args.output)
    warn(result.reconstruction.facade, result.response)
    _progress(args)(f"results in {args.output}; look at {args.output / 'report.html'}")
    code = tell_verdict(_progress(args), result.comparison) if result.comparison is not None else DONE
    return code, summary


def _demo(args: argparse.Namespace) -> tuple[int, Summary]:
    from dataclasses import replace

    from fd2fem import loading, pipeline

    drawing = replace(loading.load_facade(args.facade), frame=pipeline.survey_frame())
    return _run_chain(args, lambda: _simulate(args, drawing), drawing)


def _run(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import loading

    reference = loading.load_facade(args.reference) if args.reference is not None else None
    return _run_chain(args, lambda: _cloud(args), reference)


def _reconstruct(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem.drawings import write_facade
    from fd2fem.output import staged_folder
    from fd2fem.reconstruction import reconstruct
    from fd2fem.report import facade_summary

    options = _options(args).reconstruction
    with staged_folder(args.output, expected=["facade.json"], force=args.force) as folder:
        facade = reconstruct(_cloud(args), options=options).facade
        write_facade(facade, folder / "facade.json")
    warn(facade)
    summary = facade_summary(facade)
    _progress(args)(
        f"{facade.length:.3f} x {facade.height:.3f} m, {len(facade.openings)} openings of "
        f"{facade.opening_area:.2f} m², {len(facade.filled_holes)} filled holes"
    )
    return DONE, {"output": str(args.output), "facade": summary}


def _solid(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import exchange, loading
    from fd2fem.output import staged_folder

    options = _options(args)
    with staged_folder(args.output, expected=["facade.step"], force=args.force) as folder:
        report = exchange.write_facade_solid(loading.load_facade(args.facade), folder, options=options)
    _progress(args)(f"{report.volumes:,} volumes of {report.volume:.4f} m³, in {args.output}")
    return DONE, {"output": str(args.output), "solid": asdict(report)}


def _mesh(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import exchange, loading
    from fd2fem.meshing import mesh_quality
    from fd2fem.output import staged_file

    options = _options(args)
    with staged_file(args.output, force=args.force) as path:
        mesh = loading.load_mesh(args.facade, options=options)
        quality = mesh_quality(mesh)
        exchange.export_mesh(mesh, path, options=options)
    _progress(args)(
        f"{quality.elements:,} elements, scaled Jacobian at least {quality.min_scaled_jacobian:.2f}"
    )
    return DONE, {"output": str(args.output), "mesh": asdict(quality)}


def _analyse(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import exchange, pipeline
    from fd2fem.output import staged_folder
    from solvers import response_to_dict
    from solvers.calculix.check import check_to_dict

    options, check = _options(args), None
    if args.check:
        exchange.require_calculix(options)
    old = [f"steps/{path.name}" for path in (args.output / "steps").glob("step_*.vtu")]
    stale = [*OF_A_CHECK, *OF_STEPS, "response.pvd", *old]
    with staged_folder(args.output, expected=["response.json"], stale=stale, force=args.force) as folder:
        response = pipeline.analyse_file(
            args.facade, folder, options=options, progress=_progress(args), state=args.state
        )
        if args.check:
            _progress(args)("checking with CalculiX")
            check = exchange.check_with_calculix(response, folder, options=options)
    warn(response)
    _progress(args)(f"{response_words(response)}, in {args.output}")
    if args.state is not None:
        args.state.unlink(missing_ok=True)  # the results are safe
    summary: Summary = {"output": str(args.output), "response": response_to_dict(response)}
    if check is None:
        return DONE, summary
    return tell_check(_progress(args), check), summary | {"check": check_to_dict(check)}


def _compare(args: argparse.Namespace) -> tuple[int, Summary]:
    from dataclasses import replace

    from fd2fem import loading, pipeline
    from fd2fem.output import staged_folder
    from fd2fem.report import draw_cracked_walls
    from validation import comparison_to_dict, write_comparison

    options = _options(args)
    if args.tolerance is not None:
        options = replace(options, comparison=replace(options.comparison, tolerance=args.tolerance))
    candidate, reference = loading.load_model(args.candidate), loading.load_model(args.reference)
    comparison = pipeline.compare_models(candidate, reference, options=options)
    if args.output is not None:
        with staged_folder(
            args.output, expected=["comparison.json"], stale=[CRACKED_WALLS], force=args.force
        ) as folder:
            write_comparison(comparison, folder / "comparison.json")
            found = [model.response for model in (candidate, reference) if model.response is not None]
            if len(found) == 2 and all(response.knows_cracks for response in found):
                draw_cracked_walls(found[0], found[1], folder / CRACKED_WALLS)
    return tell_verdict(_progress(args), comparison), comparison_to_dict(comparison)


def _scan(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import loading
    from fd2fem.output import staged_file
    from fd2fem.scans import write_las

    if args.output.suffix.lower() not in {".las", ".laz"}:
        msg = f"{args.output} must end in .las or .laz."
        raise InputError(msg)
    with staged_file(args.output, force=args.force) as path:
        cloud = _simulate(args, loading.load_facade(args.facade))
        write_las(cloud, path)
    _progress(args)(f"{len(cloud):,} points in {args.output}")
    return DONE, {"output": str(args.output), "points": len(cloud), "scanners": cloud.scanners.tolist()}


COMMANDS: Mapping[str, Command] = {
    "demo": _demo,
    "run": _run,
    "reconstruct": _reconstruct,
    "solid": _solid,
    "mesh": _mesh,
    "analyse": _analyse,
    "compare": _compare,
    "scan": _scan,
}
