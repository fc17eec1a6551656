"""The ANSYS neutral file: keypoints, lines, areas and volumes as NURBS (Appendix A of the paper).

The file is input for Mechanical APDL (``/INPUT,facade,anf`` into an empty data base). Four records of
the auxiliary processor ``/AUX15`` carry the solid: KPT, LCURV, ASURF and VBODY. Each is a line of
comma-separated fields, a line with a CAD identifier, and lines of free-format numbers. An area's own
normal (dS/du x dS/dv) agrees with its loop; a volume lists an area with a minus sign where that
normal points into it.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import SolidModel

__all__ = ["patch_points", "write_anf"]

FloatArray = NDArray[np.float64]

HEADER = """/com,
/com,   *** VOXEL-TO-ANSYS GEOMETRY NEUTRAL FILE ***
/com,    Units:       Meters
/com,    keypoints {}  lines {}  areas {}  volumes {}
/com,
finish
/nopr
/aux15
"""
FOOTER = b"finish\n/gopr\n"
ZERO, ONE = (f"{value:.15e}" for value in (0.0, 1.0))
CHUNK = 5000
"""Records formatted at once: what bounds the memory."""


def write_anf(solid: SolidModel, path: Path, *, order: int = 2) -> None:
    """Write a solid as an ANSYS neutral file, in metres.

    Parameters
    ----------
    solid : SolidModel
    path : Path
        Written in place; an existing file is replaced.
    order : int, default 2
        Order (degree + 1) of lines and areas: 2, as ANSYS writes plane hexahedra, or 4, with the 4
        and 16 control points of the paper. Both describe the same straight lines and plane areas.

    Raises
    ------
    InputError
        If the order is neither 2 nor 4.
    """
    if order not in {2, 4}:
        msg = f"Invalid 'order': expected 2 or 4, got {order}."
        raise InputError(msg)
    counts = (len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes))
    with path.open("wb") as file:
        file.write(HEADER.format(*counts).encode("ascii"))
        _write_keypoints(file, solid)
        _write_lines(file, solid, order)
        _write_areas(file, solid, order)
        _write_volumes(file, solid)
        file.write(FOOTER)


def line_points(ends: FloatArray, order: int) -> FloatArray:
    """Control points (n, order, 3) of straight lines with the given ends (n, 2, 3), evenly spaced.

    Examples
    --------
    >>> line_points(np.array([[[0.0, 0, 0], [3, 0, 0]]]), 4)[0, :, 0].tolist()
    [0.0, 1.0, 2.0, 3.0]
    """
    t = np.linspace(0.0, 1.0, order)[:, None]
    points: FloatArray = (1.0 - t) * ends[:, :1] + t * ends[:, 1:]
    return points


def patch_points(corners: FloatArray, order: int) -> FloatArray:
    """Control points (n, order², 3) of plane quadrilaterals with corners (n, 4, 3); u runs fastest.

    The corners go round the area; u runs from the first to the second, v from the first to the
    fourth, so that dS/du x dS/dv is the normal about which they are right-handed. The surface is the
    bilinear one, which order 4 gives as exactly as order 2.

    Examples
    --------
    >>> square = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]]])
    >>> patch_points(square, 2)[0, :, :2].tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0]]
    """
    bottom = line_points(corners[:, [0, 1]], order)
    top = line_points(corners[:, [3, 2]], order)
    rows = line_points(np.stack([bottom, top], axis=2).reshape(-1, 2, 3), order)
    return rows.reshape(len(corners), order, order, 3).swapaxes(1, 2).reshape(len(corners), -1, 3)


def _point_lines(nets: FloatArray) -> list[bytes]:
    r"""Lines of three reals for each net of points (n, k, 3).

    A facade's coordinates repeat, so each is formatted once; blanks make all as long as the longest, so that
    the lines can be laid out as one array of characters.

    Examples
    --------
    >>> _point_lines(np.array([[[0.0, -1.0, 0.5]]]))
    [b'\t 0.000000000000000e+00\t-1.000000000000000e+00\t 5.000000000000000e-01\n']
    """
    values, place = np.unique(nets, return_inverse=True)
    words = [f"{value:.15e}" for value in values.tolist()]
    width = max(map(len, words))
    table = np.array(["\t" + word.rjust(width) for word in words], dtype="S")
    n, k, _ = nets.shape
    text = np.full((n, k, 3 * (width + 1) + 1), ord("\n"), dtype=np.uint8)
    text[:, :, :-1] = table[place.ravel()].view(np.uint8).reshape(n, k, -1)
    return [row.tobytes() for row in text.reshape(n, -1)]


def _knots(order: int) -> str:
    """Clamped knots 0 and 1, each as often as the order says, one a line."""
    return f"\t{ZERO}\n" * order + f"\t{ONE}\n" * order


def _in_tens(ids: tuple[int, ...]) -> bytes:
    """Lines of at most ten integers."""
    lines = (ids[start : start + 10] for start in range(0, len(ids), 10))
    return "".join("\t" + "\t".join(map(str, line)) + "\n" for line in lines).encode("ascii")


def _chunks(count: int) -> Iterator[slice]:
    """Slices of at most `CHUNK` records."""
    return (slice(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK))


def _write_keypoints(file: BinaryIO, solid: SolidModel) -> None:
    record = "kpt,%d,%.15e,%.15e,%.15e\nNULL_ID\n"
    for number, xyz in enumerate(solid.keypoints.tolist(), start=1):
        file.write((record % (number, *xyz)).encode("ascii"))


def _write_lines(file: BinaryIO, solid: SolidModel, order: int) -> None:
    form = "\t1\t2\t0\t4\t2\n" if order == 2 else "\t0\t4\t0\t8\t4\n"
    head = f"lcurv,%d,1,%d,%d,{ZERO},{ONE}\nL%d\n{form}{_knots(order)}".encode("ascii")
    for part in _chunks(len(solid.lines)):
        ends = solid.lines[part]
        points = _point_lines(line_points(solid.keypoints[ends], order))
        numbers = range(part.start + 1, part.stop + 1)
        file.writelines(
            head % (number, start, end, number) + text
            for number, (start, end), text in zip(numbers, (ends + 1).tolist(), points, strict=True)
        )


def _write_areas(file: BinaryIO, solid: SolidModel, order: int) -> None:
    head = f"asurf,%d,1,1,%d,{ZERO},{ONE},{ZERO},{ONE}\nA%d\n\t0\t%d\n".encode("ascii")
    form = "\t0\t2\t2\t0\t4\t4\t2\t2\n" if order == 2 else "\t0\t4\t4\t1\t8\t8\t4\t4\n"
    knots = (form + _knots(order) * 2).encode("ascii")
    # ANSYS writes areas of order 4 as rational, with unit weights.
    weights = (f"\t{ONE}\n" * order**2).encode("ascii") if order == 4 else b""
    for part in _chunks(len(solid.areas)):
        points = _point_lines(patch_points(solid.keypoints[solid.patches[part]], order))
        numbers = range(part.start + 1, part.stop + 1)
        file.writelines(
            head % (number, len(loop), number, len(loop)) + _in_tens(loop) + knots + text + weights
            for number, loop, text in zip(numbers, solid.areas[part], points, strict=True)
        )


def _write_volumes(file: BinaryIO, solid: SolidModel) -> None:
    for number, areas in enumerate(solid.volumes, start=1):
        head = b"vbody,%d,1,%d\nNULL_ID\n\t0\t%d\n" % (number, len(areas), len(areas))
        file.write(head + _in_tens(areas))
