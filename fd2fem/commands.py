"""What each verb of the command line does: one call of the chain, and what the user is told of it."""

import argparse
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fd2fem.errors import InputError
from fd2fem.model import Comparison, Facade, PointCloud, RunResult

if TYPE_CHECKING:
    from fd2fem.config import PipelineOptions
    from solvers.calculix.check import CalculixCheck

__all__ = ["COMMANDS", "Command", "Summary"]

OF_A_REFERENCE = (
    "comparison.json",
    "08_reference.png",
    "09_comparison.png",
    "reference/facade.json",
    "reference/response.json",
    "reference/response.vtu",
)
"""Results that a run without a reference does not make."""
OF_A_CHECK = ("calculix.json", "calculix.inp")
"""Results that an analysis without a check does not make."""
DONE, SHORT = 0, 1
"""Exit codes: done; a comparison falls short."""

Summary = dict[str, Any]
Command = Callable[[argparse.Namespace], tuple[int, Summary]]


def _progress(args: argparse.Namespace) -> Callable[[str], None]:
    """A function that tells the user what is going on."""

    def say(text: str) -> None:
        if not args.quiet:
            sys.stderr.write(f"fd2fem: {text}\n")
            sys.stderr.flush()

    return say


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
    from fd2fem import pipeline
    from fd2fem.scans import Units

    _progress(args)(f"reading {', '.join(str(path) for path in args.scans)}")
    return pipeline.load_cloud(args.scans, units=Units(args.units), scanners=args.scanner)


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


def _run_summary(result: RunResult, folder: Path) -> Summary:
    """What a run tells on stdout."""
    from fd2fem.report import facade_summary
    from solvers import response_to_dict
    from validation import comparison_to_dict

    summary: Summary = {
        "output": str(folder),
        "facade": facade_summary(result.reconstruction.facade),
        "solid": dict(result.solid),
        "mesh": asdict(result.quality),
        "response": response_to_dict(result.response),
        "timings_s": dict(result.timings),
    }
    if result.comparison is not None:
        summary["comparison"] = comparison_to_dict(result.comparison)
    return summary


def _verdict(args: argparse.Namespace, comparison: Comparison) -> int:
    """Say how a comparison ended, and give its exit code."""
    if comparison.passed:
        _progress(args)(f"within {100 * comparison.tolerance:g} % of the reference")
        return DONE
    for reason in comparison.reasons:
        sys.stderr.write(f"fd2fem: falls short: {reason}\n")
    return SHORT


def _run_chain(
    args: argparse.Namespace, make_cloud: Callable[[], PointCloud], reference: Facade | None
) -> tuple[int, Summary]:
    """The chain from points to verdict; the points are made only once the output is known to be free."""
    from fd2fem import pipeline
    from fd2fem.output import staged_folder

    options = _options(args)
    with staged_folder(
        args.output, expected=["facade.json"], stale=OF_A_REFERENCE, force=args.force
    ) as folder:
        result = pipeline.run(
            make_cloud(), folder, reference=reference, options=options, progress=_progress(args)
        )
        summary = _run_summary(result, args.output)
    _warn(result.reconstruction.facade)
    _progress(args)(f"results in {args.output}; look at {args.output / 'report.html'}")
    code = _verdict(args, result.comparison) if result.comparison is not None else DONE
    return code, summary


def _warn(facade: Facade) -> None:
    """What the user must know even when progress is not wanted."""
    for warning in facade.record.get("warnings", ()):
        sys.stderr.write(f"fd2fem: warning: {warning}\n")


def _demo(args: argparse.Namespace) -> tuple[int, Summary]:
    from dataclasses import replace

    from fd2fem import pipeline

    drawing = replace(pipeline.load_facade(args.facade), frame=pipeline.survey_frame())
    return _run_chain(args, lambda: _simulate(args, drawing), drawing)


def _run(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import pipeline

    reference = pipeline.load_facade(args.reference) if args.reference is not None else None
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
    _warn(facade)
    summary = facade_summary(facade)
    _progress(args)(
        f"{facade.length:.3f} x {facade.height:.3f} m, {len(facade.openings)} openings of "
        f"{facade.opening_area:.2f} m², {len(facade.filled_holes)} filled holes"
    )
    return DONE, {"output": str(args.output), "facade": summary}


def _solid(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import exchange, pipeline
    from fd2fem.output import staged_folder

    options = _options(args)
    with staged_folder(args.output, expected=["facade.step"], force=args.force) as folder:
        report = exchange.write_facade_solid(pipeline.load_facade(args.facade), folder, options=options)
    _progress(args)(f"{report.volumes:,} volumes of {report.volume:.4f} m³, in {args.output}")
    return DONE, {"output": str(args.output), "solid": asdict(report)}


def _mesh(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import exchange, pipeline
    from fd2fem.meshing import mesh_quality
    from fd2fem.output import staged_file

    options = _options(args)
    with staged_file(args.output, force=args.force) as path:
        mesh = pipeline.load_mesh(args.facade, options=options)
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
    stale = [*OF_A_CHECK, "response.pvd", *old]
    with staged_folder(args.output, expected=["response.json"], stale=stale, force=args.force) as folder:
        response = pipeline.analyse_file(
            args.facade, folder, options=options, progress=_progress(args), state=args.state
        )
        if args.check:
            _progress(args)("checking with CalculiX")
            check = exchange.check_with_calculix(response, folder, options=options)
    _progress(args)(
        f"largest displacement {1000 * response.max_displacement:.1f} mm, largest principal stress "
        f"{response.max_principal_stress / 1e6:.3f} MPa, in {args.output}"
    )
    if args.state is not None:
        args.state.unlink(missing_ok=True)  # the results are safe
    summary: Summary = {"output": str(args.output), "response": response_to_dict(response)}
    if check is None:
        return DONE, summary
    return _checked(args, check), summary | {"check": check_to_dict(check)}


def _checked(args: argparse.Namespace, check: "CalculixCheck") -> int:
    """Say how a check by CalculiX ended, and give its exit code."""
    for difference in check.differences:
        says = (
            f"{difference.quantity} differs from CalculiX's by at most {difference.relative:.1e} of its "
            f"largest, {difference.scale:.4g} {difference.unit} ({difference.place})"
        )
        if difference.relative > check.limit:
            sys.stderr.write(f"fd2fem: falls short: {says}, more than {check.limit:g}\n")
        else:
            _progress(args)(says)
    _progress(args)(
        f"CalculiX {check.version} took {check.seconds:.2f} s, our own analysis {check.own_seconds:.2f} s"
    )
    return DONE if check.passed else SHORT


def _compare(args: argparse.Namespace) -> tuple[int, Summary]:
    from dataclasses import replace

    from fd2fem import pipeline
    from fd2fem.output import staged_folder
    from validation import comparison_to_dict, write_comparison

    options = _options(args)
    if args.tolerance is not None:
        options = replace(options, comparison=replace(options.comparison, tolerance=args.tolerance))
    candidate, reference = pipeline.load_model(args.candidate), pipeline.load_model(args.reference)
    comparison = pipeline.compare_models(candidate, reference, options=options)
    if args.output is not None:
        with staged_folder(args.output, expected=["comparison.json"], force=args.force) as folder:
            write_comparison(comparison, folder / "comparison.json")
    return _verdict(args, comparison), comparison_to_dict(comparison)


def _scan(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import pipeline
    from fd2fem.output import staged_file
    from fd2fem.scans import write_las

    if args.output.suffix.lower() not in {".las", ".laz"}:
        msg = f"{args.output} must end in .las or .laz."
        raise InputError(msg)
    with staged_file(args.output, force=args.force) as path:
        cloud = _simulate(args, pipeline.load_facade(args.facade))
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
