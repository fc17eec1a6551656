"""Fields of a wall as VTU files for ParaView: its final state, and a series of its states on the way."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import VolumeMesh
from solvers.damage.cracks import principal_axes
from solvers.steps.wall_state import WallState

__all__ = ["SERIES", "StepSeries", "point_fields", "write_vtu"]

FloatArray = NDArray[np.float64]

SERIES = "response.pvd"
STEPS = "steps"
ENTRY = re.compile(r'<DataSet timestep="([^"]+)" part="0" file="([^"]+)"/>')


def point_fields(displacement: FloatArray, stress: FloatArray) -> dict[str, FloatArray]:
    """Fields at the nodes: what is given, principal stresses, and the directions of the first and the third.

    Parameters
    ----------
    displacement : (n, 3) float array, m
    stress : (n, 6) float array, Pa
    """
    values, axes = principal_axes(stress)
    return {
        "displacement": displacement,
        "stress": stress,
        "principal_stress": values,
        "direction1": np.ascontiguousarray(axes[:, 0]),
        "direction3": np.ascontiguousarray(axes[:, 2]),
    }


def write_vtu(
    path: Path, mesh: VolumeMesh, *, points: Mapping[str, FloatArray], cells: Mapping[str, FloatArray]
) -> None:
    """Write fields at the nodes and in the elements; the file appears under its name when it is whole."""
    import meshio

    grid = meshio.Mesh(
        mesh.nodes,
        [(mesh.kind.value, mesh.elements.astype(np.int64))],
        point_data=dict(points),
        cell_data={name: [values] for name, values in cells.items()},
    )
    part = path.with_name(f"{path.name}.part")
    grid.write(part, file_format="vtu")
    part.replace(path)


@dataclass(frozen=True, eq=False)
class StepSeries:
    """Writes states of a wall to a folder as the analysis finds them: ``steps/step_0000.vtu`` and so on.

    ``response.pvd`` lists them, with the share of the settlement as the time. An analysis that goes on from a
    state on disk adds to the files that are there.

    Attributes
    ----------
    folder : Path
    mesh : VolumeMesh
    frames : int
        States to write after the self-weight's, evenly over the settlement.
    """

    folder: Path
    mesh: VolumeMesh
    frames: int = 10

    def __post_init__(self) -> None:
        if self.frames < 1:
            msg = f"Invalid 'frames': expected at least 1, got {self.frames}."
            raise InputError(msg)

    def __call__(self, state: WallState) -> None:
        """Write a state, if it is the first one to reach another part of the settlement."""
        share = state.record.share
        listed = [entry for entry in self._listed() if entry[0] < share]
        reached = max((int(self.frames * before + 1e-9) for before, _ in listed), default=-1)
        if int(self.frames * share + 1e-9) <= reached:
            return
        name = f"{STEPS}/step_{state.index:04d}.vtu"
        (self.folder / STEPS).mkdir(parents=True, exist_ok=True)
        cells = {
            "crack_opening": state.cracks.opening,
            "crack_normal": state.cracks.normal,
            "dissipation": state.dissipation,
        }
        points = point_fields(state.displacement, state.stress)
        write_vtu(self.folder / name, self.mesh, points=points, cells=cells)
        self._list([*listed, (share, name)])

    def _listed(self) -> list[tuple[float, str]]:
        """Share and name of the states that are listed."""
        path = self.folder / SERIES
        if not path.exists():
            return []
        return [(float(share), name) for share, name in ENTRY.findall(path.read_text(encoding="utf-8"))]

    def _list(self, entries: list[tuple[float, str]]) -> None:
        lines = [f'    <DataSet timestep="{share!r}" part="0" file="{name}"/>' for share, name in entries]
        text = "\n".join(
            [
                '<?xml version="1.0"?>',
                '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
                "  <Collection>",
                *lines,
                "  </Collection>",
                "</VTKFile>",
                "",
            ]
        )
        part = self.folder / f"{SERIES}.part"
        part.write_text(text, encoding="utf-8")
        part.replace(self.folder / SERIES)
