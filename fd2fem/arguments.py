"""The words of the command line."""

import argparse
import math
import sys
from pathlib import Path
from typing import NoReturn

from fd2fem import __version__

__all__ = ["AT_FAULT", "build_parser"]

AT_FAULT = 2
"""Exit code for bad input, wrong words included."""


UNITS = ("auto", "m", "cm", "mm", "ft", "us-ft", "in")
FACADE_HELP = "facade.json, TOML or DXF drawing, STEP solid, or building1, building2, building3"
CONFIG_HELP = (
    "settings: sections reconstruction, solid, mesh, material, masonry, base, settlement, stepping, "
    "analysis, comparison"
)


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """Print the line and leave with the code for bad input."""
        sys.stderr.write(f"{self.prog}: {message}; see {self.prog} --help\n")
        raise SystemExit(AT_FAULT)


def build_parser() -> argparse.ArgumentParser:
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

    def command(name: str, text: str) -> argparse.ArgumentParser:
        return commands.add_parser(name, help=text, description=text, parents=[common])

    demo = command("demo", "the whole chain on a scan that the package simulates")
    _demo_arguments(demo)

    run = command("run", "from a scan to a verdict")
    _scan_arguments(run)
    run.add_argument("--reference", metavar="REF", help="measured drawing to compare with")

    rebuild = command("reconstruct", "a scan to facade.json")
    _scan_arguments(rebuild)

    solid = command("solid", "a facade to STEP, ANSYS neutral file and APDL decks")
    _facade_arguments(solid, "FACADE")
    _solid_arguments(solid)

    mesh = command("mesh", "a facade or CAD solid to a mesh; format by suffix")
    mesh.add_argument("facade", metavar="FACADE|STEP", help=FACADE_HELP)
    _mesh_arguments(mesh)
    mesh.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help=".msh, .vtu, .inp, .cdb or .med"
    )
    mesh.add_argument("--config", type=Path, metavar="C.toml", help=CONFIG_HELP)

    analysis = command("analyse", "settlement analysis of a facade or a mesh")
    _facade_arguments(analysis, "FACADE|MESH")
    _analysis_arguments(analysis)

    compare = command("compare", "a candidate against a reference: facades or analysed folders")
    compare.add_argument("candidate", metavar="CANDIDATE", help="facade or analysed folder")
    compare.add_argument("reference", metavar="REFERENCE", help="facade or analysed folder")
    compare.add_argument(
        "--tolerance", type=float, metavar="SHARE", help="between 0 and 1, both excluded (default 0.05)"
    )
    compare.add_argument("-o", "--output", type=Path, metavar="DIR")
    compare.add_argument("--config", type=Path, metavar="C.toml", help=CONFIG_HELP)

    scan = command("scan", "scan a facade virtually, for planning and tests")
    scan.add_argument("facade", metavar="FACADE", help="a drawing, or building1, building2, building3")
    scan.add_argument("-o", "--output", type=Path, required=True, metavar="SCAN", help=".laz or .las")
    _simulation_arguments(scan)
    return parser


def _demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", type=Path, default=Path("fd2fem-demo"), metavar="DIR")
    _simulation_arguments(parser)
    parser.add_argument("--facade", default="building1", help="drawing to scan (default building1)")
    parser.add_argument("--config", type=Path, metavar="C.toml", help=CONFIG_HELP)


def _scan_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scans",
        type=Path,
        nargs="+",
        metavar="SCAN",
        help="LAS, LAZ, E57, PLY, PCD, PTS, PTX, XYZ, CSV or TXT file",
    )
    parser.add_argument(
        "--scanner",
        type=_position,
        action="append",
        default=[],
        metavar="X,Y,Z",
        help="position of the scanner, world coordinates in m; for several, one per scan or file in order",
    )
    parser.add_argument("--units", choices=UNITS, default="auto", help="of the scan (default auto)")
    parser.add_argument(
        "--wall",
        type=int,
        metavar="N",
        help="which wall of the scan, from 1, as facade.json lists them (default 1, the one that stands out)",
    )
    parser.add_argument("--config", type=Path, metavar="C.toml", help=CONFIG_HELP)
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results"
    )


def _facade_arguments(parser: argparse.ArgumentParser, name: str) -> None:
    parser.add_argument("facade", metavar=name, help=FACADE_HELP)
    parser.add_argument("--config", type=Path, metavar="C.toml", help=CONFIG_HELP)
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results"
    )


def _analysis_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--state",
        type=Path,
        metavar="FILE",
        help="keep each step of a wall that cracks in this file, and go on from it if it is there",
    )
    parser.add_argument(
        "--check",
        choices=["calculix"],
        help="have another program analyse the same mesh under the same loads, and compare",
    )


def _solid_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--form",
        choices=["merged", "voxels"],
        help="what facade.step holds: the wall as one solid (default), or each voxel as one",
    )
    parser.add_argument(
        "--also", choices=["iges", "brep"], action="append", help="a further CAD format; repeat for both"
    )
    parser.add_argument(
        "--anf-order",
        type=int,
        choices=[2, 4],
        help="order of the neutral file's lines and areas (default 2; 4: 4 and 16 control points)",
    )


def _mesh_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--size", type=float, metavar="M", help="element edge (default from the wall)")
    parser.add_argument(
        "--order",
        type=int,
        choices=[1, 2],
        help="1: nodes at corners only; 2: 20-node hexahedra (default: 2 in .inp, else 1)",
    )
    parser.add_argument(
        "--elements", choices=["hexahedra", "tetrahedra"], help="of a facade (default hexahedra)"
    )
    parser.add_argument("--corner-size", type=float, metavar="M", help="element edge at corners of openings")


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
    parser.add_argument("--seed", type=int, default=0, help="of noise, street and re-sampling (default 0)")


def _position(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError as error:
        msg = f"expected X,Y,Z, got {text!r}"
        raise argparse.ArgumentTypeError(msg) from error
    if not all(map(math.isfinite, (x, y, z))):
        msg = f"expected finite coordinates X,Y,Z, got {text!r}"
        raise argparse.ArgumentTypeError(msg)
    return x, y, z
