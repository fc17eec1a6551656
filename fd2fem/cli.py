"""The command line: it parses, calls one function, prints, and turns errors into exit codes.

0: done, and within the tolerance where one was asked for. 1: a comparison falls short. 2: the input is at
fault. 3: the numerics failed. Progress goes to stderr, results to files, ``--json`` to stdout.
"""

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from fd2fem import __version__
from fd2fem.errors import SYSTEM_LIBRARIES, Fd2femError, InputError, NumericsError
from fd2fem.model import Comparison, Facade, PointCloud, RunResult

if TYPE_CHECKING:
    from fd2fem.config import PipelineOptions

__all__ = ["main"]

DONE, SHORT, AT_FAULT, FAILED = 0, 1, 2, 3

Summary = dict[str, Any]
Command = Callable[[argparse.Namespace], tuple[int, Summary]]


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """Print the line and leave with the code for bad input."""
        sys.stderr.write(f"{self.prog}: {message}; see {self.prog} --help\n")
        raise SystemExit(AT_FAULT)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str or None
        Arguments without the program's name; ``None``: those of the process.
    """
    args = _parser().parse_args(argv)
    run: Command = args.command
    try:
        code, summary = run(args)
    except Fd2femError as error:
        return _report(args, error, AT_FAULT if isinstance(error, InputError) else FAILED)
    except KeyboardInterrupt:
        sys.stderr.write("fd2fem: stopped\n")
        return 130
    except OSError as error:
        return _report(args, error, AT_FAULT)
    except ImportError as error:
        text = f"a library did not load ({error}); on Debian and Ubuntu: apt-get install {SYSTEM_LIBRARIES}"
        return _report(args, NumericsError(text), FAILED, error)
    except MemoryError as error:
        return _report(
            args, MemoryError("out of memory: thin the scan or take larger elements"), FAILED, error
        )
    except Exception as error:  # noqa: BLE001  a user must never meet a traceback unasked
        kind = type(error).__name__
        wrapped = Fd2femError(f"internal error ({kind}: {error}); run again with --debug and report it")
        return _report(args, wrapped, FAILED, error)
    if args.json:
        sys.stdout.write(json.dumps(summary, indent=1) + "\n")
    return code


def _report(
    args: argparse.Namespace, error: BaseException, code: int, cause: BaseException | None = None
) -> int:
    """Print one line on what went wrong, or the traceback if it was asked for."""
    if args.debug:
        traceback.print_exception(cause or error)
    else:
        sys.stderr.write(f"fd2fem: {' '.join(str(error).split())}\n")
    return code


def _parser() -> argparse.ArgumentParser:
    """The commands and their options."""
    common = _Parser(add_help=False)
    common.add_argument("--json", action="store_true", help="print the summary as JSON on stdout")
    common.add_argument("--force", action="store_true", help="replace results that exist")
    common.add_argument("--quiet", action="store_true", help="no progress on stderr")
    common.add_argument("--debug", action="store_true", help="show the traceback of an error")
    parser = _Parser(
        prog="fd2fem",
        description="From a laser scan of a masonry facade to a finite element model that can be trusted.",
        epilog="Exit codes: 0 done, 1 comparison falls short, 2 input at fault, 3 numerics failed.",
    )
    parser.add_argument("--version", action="version", version=f"fd2fem {__version__}")
    commands = parser.add_subparsers(dest="verb", metavar="COMMAND", required=True)

    def command(name: str, run: Command, text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text, parents=[common])
        sub.set_defaults(command=run)
        return sub

    demo = command("demo", _demo, "the whole chain on a scan that the package simulates")
    demo.add_argument("-o", "--output", type=Path, default=Path("fd2fem-demo"), metavar="DIR")
    _simulation_arguments(demo)
    demo.add_argument("--facade", default="building1", help="drawing to scan (default building1)")

    run = command("run", _run, "from a scan to a verdict")
    _scan_arguments(run)
    run.add_argument("--reference", metavar="REF", help="measured drawing to compare with")

    rebuild = command("reconstruct", _reconstruct, "a scan to facade.json")
    _scan_arguments(rebuild)

    solid = command("solid", _solid, "a facade to STEP, ANSYS neutral file and APDL deck")
    _facade_arguments(solid, "FACADE")

    mesh = command("mesh", _mesh, "a facade or STEP solid to a mesh; format by suffix")
    mesh.add_argument("facade", metavar="FACADE|STEP")
    mesh.add_argument("-o", "--output", type=Path, required=True, metavar="FILE")
    mesh.add_argument("--config", type=Path, metavar="C.toml")

    analysis = command("analyse", _analyse, "settlement analysis of a facade or a mesh")
    _facade_arguments(analysis, "FACADE|MESH")

    compare = command("compare", _compare, "a candidate against a reference: facades or analysed folders")
    compare.add_argument("candidate", metavar="CANDIDATE")
    compare.add_argument("reference", metavar="REFERENCE")
    compare.add_argument("--tolerance", type=float, metavar="SHARE", help="default 0.05")
    compare.add_argument("-o", "--output", type=Path, metavar="DIR")
    compare.add_argument("--config", type=Path, metavar="C.toml")

    scan = command("scan", _scan, "scan a facade virtually, for planning and tests")
    scan.add_argument("facade", metavar="FACADE", help="a drawing, or building1, building2, building3")
    scan.add_argument("-o", "--output", type=Path, required=True, metavar="SCAN", help=".laz or .las")
    _simulation_arguments(scan)
    return parser


def _scan_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scans", type=Path, nargs="+", metavar="SCAN")
    parser.add_argument(
        "--scanner",
        type=_position,
        action="append",
        default=[],
        metavar="X,Y,Z",
        help="position of the scanner, world coordinates in m; repeat for several stations",
    )
    parser.add_argument(
        "--units", choices=["auto", "m", "mm"], default="auto", help="of the scan (default auto)"
    )
    parser.add_argument("--config", type=Path, metavar="C.toml")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")


def _facade_arguments(parser: argparse.ArgumentParser, name: str) -> None:
    parser.add_argument("facade", metavar=name)
    parser.add_argument("--config", type=Path, metavar="C.toml")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")


def _simulation_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--density",
        choices=["NS00", "S20", "S50", "S75"],
        default="NS00",
        help="original scan, or re-sampled to 20, 50 or 75 mm (default NS00)",
    )
    parser.add_argument("--clean", action="store_true", help="the wall alone: no street, rooms or glass")
    parser.add_argument(
        "--station",
        type=_position,
        action="append",
        default=[],
        metavar="X,Y,Z",
        help="scanner's position in the facade frame, m (y < 0 is outside); repeat for several",
    )
    parser.add_argument("--step", type=float, metavar="DEG", help="angular step of the scanner, degrees")
    parser.add_argument(
        "--noise", type=float, default=0.002, metavar="M", help="range noise, 1 sigma (default 0.002)"
    )
    parser.add_argument("--seed", type=int, default=0)


def _position(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError as error:
        msg = f"expected X,Y,Z, got {text!r}"
        raise argparse.ArgumentTypeError(msg) from error
    return x, y, z


def _progress(args: argparse.Namespace) -> Callable[[str], None]:
    """A function that tells the user what is going on."""

    def say(text: str) -> None:
        if not args.quiet:
            sys.stderr.write(f"fd2fem: {text}\n")
            sys.stderr.flush()

    return say


def _options(args: argparse.Namespace) -> "PipelineOptions":
    from fd2fem.config import PipelineOptions, read_options

    return read_options(args.config) if getattr(args, "config", None) else PipelineOptions()


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
    say = _progress(args)
    if comparison.passed:
        say(f"within {100 * comparison.tolerance:g} % of the reference")
        return DONE
    for reason in comparison.reasons:
        say(f"falls short: {reason}")
    return SHORT


def _run_chain(
    args: argparse.Namespace, make_cloud: Callable[[], PointCloud], reference: Facade | None
) -> tuple[int, Summary]:
    """The chain from points to verdict; the points are made only once the output is known to be free."""
    from fd2fem import pipeline
    from fd2fem.output import staged_folder

    options = _options(args)
    with staged_folder(args.output, expected=["facade.json"], force=args.force) as folder:
        result = pipeline.run(
            make_cloud(), folder, reference=reference, options=options, progress=_progress(args)
        )
        summary = _run_summary(result, args.output)
    _warn(args, result.reconstruction.facade)
    _progress(args)(f"results in {args.output}; look at {args.output / 'report.html'}")
    code = _verdict(args, result.comparison) if result.comparison is not None else DONE
    return code, summary


def _warn(args: argparse.Namespace, facade: Facade) -> None:
    for warning in facade.record.get("warnings", ()):
        _progress(args)(f"warning: {warning}")


def _demo(args: argparse.Namespace) -> tuple[int, Summary]:
    from dataclasses import replace

    from fd2fem import pipeline

    drawing = replace(pipeline.load_facade(args.facade), frame=pipeline.survey_frame())
    return _run_chain(args, lambda: _simulate(args, drawing), drawing)


def _run(args: argparse.Namespace) -> tuple[int, Summary]:
    from fd2fem import pipeline

    reference = pipeline.load_facade(args.reference) if args.reference else None
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
    _warn(args, facade)
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

    with staged_file(args.output, force=args.force) as path:
        cloud = _simulate(args, pipeline.load_facade(args.facade))
        write_las(cloud, path)
    _progress(args)(f"{len(cloud):,} points in {args.output}")
    return DONE, {"output": str(args.output), "points": len(cloud), "scanners": cloud.scanners.tolist()}
