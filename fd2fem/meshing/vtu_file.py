"""VTK's unstructured grids, for ParaView."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import ElementKind, VolumeMesh

__all__ = ["write_vtu"]

FACET_NAMES = {
    ElementKind.HEXAHEDRON: "quad",
    ElementKind.HEXAHEDRON20: "quad8",
    ElementKind.TETRA10: "triangle6",
}
"""meshio's names of the facets."""

Marks = NDArray[np.int8]


def write_vtu(mesh: VolumeMesh, path: Path) -> None:
    """Write an unstructured grid: the elements first, then the facets of the groups as cells of their own.

    Each group is an array of its name twice over: of the cells, 1 on the group's facets, which a
    threshold in ParaView turns into the surface; and of the points, 1 on its nodes. They are 0 elsewhere.
    Coordinates are kept to the last bit.
    """
    import meshio

    facets = {name: table for name, table in mesh.groups.items() if len(table)}
    cells = [(mesh.kind.value, np.array(mesh.elements))]
    sizes = [len(mesh.elements)]
    if facets:
        cells.append((FACET_NAMES[mesh.kind], np.concatenate(list(facets.values()))))
        sizes.append(len(cells[1][1]))
    on_points: dict[str, Marks] = {}
    on_cells: dict[str, list[Marks]] = {}
    start = 0
    for name, table in mesh.groups.items():
        on_points[name] = np.zeros(len(mesh.nodes), dtype=np.int8)
        on_points[name][table] = 1
        on_cells[name] = [np.zeros(size, dtype=np.int8) for size in sizes]
        if len(table):
            on_cells[name][1][start : start + len(table)] = 1
            start += len(table)
    grid = meshio.Mesh(np.array(mesh.nodes), cells, point_data=on_points, cell_data=on_cells)
    grid.write(path, file_format="vtu")
