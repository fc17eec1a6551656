"""The command line: it parses, calls one function, prints, and turns errors into exit codes.

0: done, and within the tolerance where one was asked for. 1: a comparison falls short. 2: the input is at
fault. 3: the numerics failed. Progress goes to stderr, results to files, ``--json`` to stdout.
"""

import argparse
import json
import re
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

from fd2fem.arguments import AT_FAULT, build_parser
from fd2fem.errors import SYSTEM_LIBRARIES, Fd2femError, InputError
from fd2fem.model import Comparison, Facade, PointCloud, RunResult

if TYPE_CHECKING:
    from fd2fem.config import PipelineOptions

__all__ = ["main"]

OF_A_REFERENCE = (
    "comparison.json",
    "08_reference.png",
    "09_comparison.png",
    "reference/facade.json",
    "reference/response.json",
    "reference/response.vtu",
)
"""Results that a run without a reference does not make."""
DONE, SHORT, FAILED, SIGNALLED = 0, 1, 3, 128

Summary = dict[str, Any]
Command = Callable[[argparse.Namespace], tuple[int, Summary]]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str or None
        Arguments without the program's name; ``None``: those of the process.
    """
    args = build_parser().parse_args(argv)
    try:
        with _stoppable():
            code, summary = COMMANDS[args.verb](args)
        if args.json:
            sys.stdout.write(json.dumps(summary, indent=1) + "\n")
            sys.stdout.flush()
    except KeyboardInterrupt as stop:
        sys.stderr.write("fd2fem: stopped\n")
        return SIGNALLED + (stop.args[0] if stop.args else signal.SIGINT)
    except Exception as error:  # noqa: BLE001  a user must never meet a traceback unasked
        text, code = _diagnose(error)
        if args.debug:
            traceback.print_exception(error)
        else:
            sys.stderr.write(f"fd2fem: {' '.join(text.split())}\n")
        return code
    return code


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let the signals that end a process end it as Ctrl-C does, so that nothing is left behind."""

    def stop(number: int, _: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt(number)

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        names = []
    before = {name: signal.signal(getattr(signal, name), stop) for name in names}
    try:
        yield
    finally:
        for name, handler in before.items():
            signal.signal(getattr(signal, name), handler)


def _diagnose(error: Exception) -> tuple[str, int]:
    """What to tell the user of an error, and the exit code."""
    if isinstance(error, Fd2femError):
        # The user knows nothing of the folder that results are made in.
        text = re.sub(r"[^\s']*[\\/]\.fd2fem-\w+[\\/]", "", str(error))
        return text, AT_FAULT if isinstance(error, InputError) else FAILED
    if isinstance(error, ImportError) and ("shared object" in str(error) or "DLL" in str(error)):
        text = f"a library did not load ({error}); on Debian and Ubuntu: apt-get install {SYSTEM_LIBRARIES}"
        return text, FAILED
    if isinstance(error, MemoryError):
        return "out of memory: thin the scan or take larger elements", FAILED
    if isinstance(error, OSError):
        where = f" {error.filename}" if error.filename and ".fd2fem-" not in str(error.filename) else ""
        return f"cannot read or write{where}: {error.strerror or error}", AT_FAULT
    return f"internal error ({type(error).__name__}: {error}); run again with --debug and report it", FAILED


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

    options = read_options(args.config) if getattr(args, "config", None) else PipelineOptions()
    if getattr(args, "wall", None) is not None:
        options = replace(options, reconstruction=replace(options.reconstruction, wall=args.wall))
    return options


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
    from fd2fem import pipeline
    from fd2fem.output import staged_folder
    from fd2fem.solids import write_solid

    options = _options(args)
    with staged_folder(args.output, expected=["facade.step"], force=args.force) as folder:
        voxels = pipeline.facade_voxels(pipeline.load_facade(args.facade), options=options)
        report = write_solid(voxels, folder, options=options.solid)
    _progress(args)(f"{report.volumes:,} volumes of {report.volume:.4f} m³, in {args.output}")
    return DONE, {"output": str(args.output), "solid": asdict(report)}


def _mesh(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import pipeline
    from fd2fem.meshing import mesh_quality, write_mesh
    from fd2fem.output import staged_file

    options = _options(args)
    with staged_file(args.output, force=args.force) as path:
        mesh = pipeline.load_mesh(args.facade, options=options)
        quality = mesh_quality(mesh)
        write_mesh(mesh, path)
    _progress(args)(
        f"{quality.elements:,} elements, scaled Jacobian at least {quality.min_scaled_jacobian:.2f}"
    )
    return DONE, {"output": str(args.output), "mesh": asdict(quality)}


def _analyse(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import pipeline
    from fd2fem.output import staged_folder
    from solvers import response_to_dict

    options = _options(args)
    with staged_folder(args.output, expected=["response.json"], force=args.force) as folder:
        response = pipeline.analyse_file(args.facade, folder, options=options, progress=_progress(args))
    _progress(args)(
        f"largest displacement {1000 * response.max_displacement:.1f} mm, largest principal stress "
        f"{response.max_principal_stress / 1e6:.3f} MPa, in {args.output}"
    )
    return DONE, {"output": str(args.output), "response": response_to_dict(response)}


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


COMMANDS: dict[str, Command] = {
    "demo": _demo,
    "run": _run,
    "reconstruct": _reconstruct,
    "solid": _solid,
    "mesh": _mesh,
    "analyse": _analyse,
    "compare": _compare,
    "scan": _scan,
}
