"""The solid as plain Mechanical APDL commands: the way in when the neutral file is refused.

Keypoints (K), lines (L), areas (A, AL) and volumes (VA) are made in the order of the record, so that
in an empty data base they get its numbers. No signs are needed: VA takes areas in any order and sense.
"""

from collections.abc import Iterator
from pathlib import Path

from fd2fem.model import SolidModel

__all__ = ["write_apdl"]

HEADER = """/COM, solid model by K / L / A / VA, in metres
/COM, keypoints {}  lines {}  areas {}  volumes {}
FINISH
/NOPR
/PREP7
CSYS,0
NUMSTR,DEFA
"""
FOOTER = "ALLSEL,ALL\n/GOPR\nFINISH\n"
MOST = 10
"""Fields that AL and VA take; longer lists are selected."""


def write_apdl(solid: SolidModel, path: Path) -> None:
    """Write a solid as a deck of APDL commands, in metres.

    A loop of four lines becomes ``A`` of its keypoints, which takes the lines between them; a longer
    one ``AL`` of its lines. More than ten lines or areas are selected first, then ``AL,ALL`` or
    ``VA,ALL`` follows.

    Parameters
    ----------
    solid : SolidModel
    path : Path
        Written in place; an existing file is replaced.
    """
    counts = (len(solid.keypoints), len(solid.lines), len(solid.areas), len(solid.volumes))
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(HEADER.format(*counts))
        file.writelines(
            f"K,{number},{x:.15e},{y:.15e},{z:.15e}\n"
            for number, (x, y, z) in enumerate(solid.keypoints.tolist(), start=1)
        )
        file.writelines(f"L,{start},{end}\n" for start, end in (solid.lines + 1).tolist())
        file.writelines(_areas(solid))
        for areas in solid.volumes:
            file.write(_volume([abs(area) for area in areas]))
        file.write(FOOTER)


def _areas(solid: SolidModel) -> Iterator[str]:
    """A or AL for each area, with the loop's sense."""
    for loop, patch in zip(solid.areas, (solid.patches + 1).tolist(), strict=True):
        if len(loop) == 4:
            yield "A,{},{},{},{}\n".format(*patch)
        elif len(loop) <= MOST:
            # The first line alone says which way the normal points; the manual gives no sign to the others.
            yield f"AL,{loop[0]},{','.join(str(abs(line)) for line in loop[1:])}\n"
        else:
            yield f"{_select('LSEL', 'LINE', [abs(line) for line in loop])}AL,ALL,{loop[0]}\nLSEL,ALL\n"


def _volume(areas: list[int]) -> str:
    """VA for a volume."""
    if len(areas) <= MOST:
        return f"VA,{','.join(map(str, areas))}\n"
    return f"{_select('ASEL', 'AREA', areas)}VA,ALL\nASEL,ALL\n"


def _select(command: str, item: str, numbers: list[int]) -> str:
    """Commands that select exactly these numbers."""
    modes = ["S"] + ["A"] * (len(numbers) - 1)
    return "".join(
        f"{command},{mode},{item},,{number}\n" for mode, number in zip(modes, numbers, strict=True)
    )
