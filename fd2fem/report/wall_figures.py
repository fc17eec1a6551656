"""Pictures of a mesh and of how the wall answers: displacement, stress, cracks, and the way there."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fd2fem.model import Response, VolumeMesh
from fd2fem.model.topology import FACETS
from fd2fem.report.canvas import (
    BOUNDARY,
    CANDIDATE,
    INK,
    REFERENCE,
    WALL,
    height_of,
    new_figure,
    patches,
    save,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_cracked_walls", "draw_cracks", "draw_mesh", "draw_response", "draw_steps"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

FACING = 0.5
"""A facet is of the front if its outward normal has more than this part across the wall."""
SHORT, THIN = 0.03, 1e-5
"""Cracks narrower than this part of the widest, or this, m, get no line: they would hide the others."""
INTACT = "#efe9e2"


class Front(NamedTuple):
    """What is seen of a mesh from outside: `corners` (f, 3 or 4), nodes; `owner` (f,), elements."""

    corners: IntArray
    owner: IntArray


def front_of(mesh: VolumeMesh) -> Front:
    """The facets that face outwards, of a mesh with or without groups."""
    corners = np.array(FACETS[mesh.kind])[:, : mesh.kind.facet_corners]
    facets = mesh.elements[:, corners].reshape(-1, corners.shape[1])
    owner = np.repeat(np.arange(len(mesh.elements)), len(corners))
    _, first, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    outer = np.sort(first[count == 1])
    ring = mesh.nodes[facets[outer]]
    normal = np.cross(ring[:, 1] - ring[:, 0], ring[:, -1] - ring[:, 0])
    seen = outer[-normal[:, 1] > FACING * np.linalg.norm(normal, axis=1)]
    return Front(facets[seen], owner[seen])


def _plan(mesh: VolumeMesh) -> FloatArray:
    return mesh.nodes[:, [0, 2]]


def draw_mesh(mesh: VolumeMesh, response: Response, path: Path) -> None:
    """The mesh with its named groups, and the imposed displacements (figures 19b and 20b)."""
    figure, axes = new_figure(2, height=height_of(_plan(mesh)))
    front = _plan(mesh)[front_of(mesh).corners]
    patches(axes[0], list(front), "#f2e3d3", edge=INK)
    axes[0].set_title(f"{len(mesh.elements):,} elements")
    patches(axes[1], list(front), "#f2e3d3")
    base = mesh.group_nodes("base")
    base = base[np.abs(mesh.nodes[base, 1]) < 1e-9]
    where, move = mesh.nodes[base], response.displacement[base]
    scale = 0.1 * np.ptp(mesh.nodes[:, 2]) / max(np.abs(move).max(), 1e-12)
    axes[1].quiver(
        where[:, 0],
        where[:, 2],
        move[:, 0] * scale,
        move[:, 2] * scale,
        angles="xy",
        scale_units="xy",
        scale=1,
        color=BOUNDARY,
        width=0.004,
    )
    reach = 0.12 * np.ptp(mesh.nodes[:, 2])
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    axes[1].set(xlim=(low[0] - reach, high[0] + reach), ylim=(low[2] - reach, high[2] + reach))
    axes[1].set_title(f"displacements of the base, x{scale:.0f}")
    save(figure, path)


def draw_response(response: Response, path: Path, *, title: str) -> None:
    """Displacement on the deformed wall and first principal stress (figures 19c-d and 20c-d)."""
    mesh = response.mesh
    figure, axes = new_figure(2, height=height_of(_plan(mesh)), width=4.8)
    scale = 0.05 * np.ptp(mesh.nodes[:, 2]) / max(response.max_displacement, 1e-12)
    moved = mesh.nodes + scale * response.displacement
    size = 1000.0 * np.linalg.norm(response.displacement, axis=1)
    tension = response.principal_stress[:, 0] / 1e6
    # Singular at the corners: the colours stop at the 99th percentile, the title gives the maximum.
    top = float(np.percentile(tension, 99))
    corners = front_of(mesh).corners
    triangles = np.concatenate([corners[:, [0, k, k + 1]] for k in range(1, corners.shape[1] - 1)])
    for axis, nodes, values, limit, text in (
        (axes[0], moved, size, None, f"displacement, mm (x{scale:.0f}): max {size.max():.1f}"),
        (axes[1], mesh.nodes, tension, top, _stress_title(response, tension)),
    ):
        picture = axis.tripcolor(
            nodes[:, 0], nodes[:, 2], triangles, values, shading="gouraud", cmap="turbo", vmax=limit
        )
        figure.colorbar(picture, ax=axis, shrink=0.6)
        axis.set_title(text, fontsize=9)
    figure.suptitle(title, fontsize=10)
    save(figure, path)


def _stress_title(response: Response, tension: FloatArray) -> str:
    if not response.history:
        return f"σ1, MPa: max {tension.max():.2f} (colours end at 99 %)"
    largest = response.max_principal_stress / 1e6
    last = f"σ1 after the last step, MPa: max {tension.max():.2f} (colours end at 99 %)"
    return f"{last}\nlargest of all steps {largest:.2f}"


def draw_cracks(response: Response, path: Path) -> None:
    """The cracks of a wall, and the largest tension that its elements have carried on the way."""
    mesh = response.mesh
    figure, axes = new_figure(2, height=height_of(_plan(mesh)), width=4.8)
    _crack_map(figure, axes[0], response, top=response.max_crack_opening, title="cracks")
    front, stress = front_of(mesh), response.largest_stress / 1e6
    picture = _colours(axes[1], mesh, front, stress[front.owner], "turbo", (0.0, float(stress.max())))
    figure.colorbar(picture, ax=axes[1], shrink=0.6)
    axes[1].set_title(f"largest σ1 of all steps, MPa: max {stress.max():.2f}", fontsize=9)
    save(figure, path)


def draw_cracked_walls(candidate: Response, reference: Response, path: Path) -> None:
    """The cracks of two walls side by side, in the same colours."""
    top = max(candidate.max_crack_opening, reference.max_crack_opening)
    figure, axes = new_figure(2, height=height_of(_plan(reference.mesh)), width=4.8)
    for axis, response, title in ((axes[0], candidate, "candidate"), (axes[1], reference, "reference")):
        _crack_map(figure, axis, response, top=top, title=title)
    save(figure, path)


def _crack_map(figure: "Figure", axis: "Axes", response: Response, *, top: float, title: str) -> None:
    """Elements of the front by the width of their cracks, with a line along each."""
    from matplotlib.collections import LineCollection

    mesh, front = response.mesh, front_of(response.mesh)
    opening = np.ma.masked_equal(response.crack_opening[front.owner], 0.0)
    picture = _colours(axis, mesh, front, 1000.0 * opening, "YlOrRd", (0.0, 1000.0 * top or 1.0))
    if top == 0.0:
        axis.set_title(f"{title}: none", fontsize=9)
        return
    figure.colorbar(picture, ax=axis, shrink=0.6)
    ends = crack_lines(response, front, narrowest=max(SHORT * top, THIN))
    for colour, width in (("white", 2.2), (INK, 0.9)):
        axis.add_collection(LineCollection(list(ends), colors=colour, linewidths=width))
    widest = 1000.0 * response.max_crack_opening
    axis.set_title(f"{title}: width, mm: max {widest:.2f}; lines along them", fontsize=9)


def crack_lines(response: Response, front: Front, *, narrowest: float) -> FloatArray:
    """Ends (k, 2, 2), m, in x and z, of a line along the crack in each facet's element that is wider than so.

    A crack that is slanted across the wall gets a shorter one; one parallel to its face, none.
    """
    drawn = response.crack_opening[front.owner] > narrowest
    ring = _plan(response.mesh)[front.corners[drawn]]
    size = np.sqrt(np.ptp(ring, axis=1).prod(axis=1))
    # Along the crack: the normal, turned by a right angle in the wall's plane.
    along = response.crack_normal[front.owner[drawn]][:, [2, 0]] * [-1.0, 1.0]
    middle, arm = ring.mean(axis=1), 0.4 * size[:, None] * along
    return np.stack([middle - arm, middle + arm], axis=1)


def _colours(
    axis: "Axes", mesh: VolumeMesh, front: Front, values: FloatArray, cmap: str, limits: tuple[float, float]
) -> Any:
    """Fill the facets of the front by a value each; where it is masked, as intact wall."""
    from matplotlib import colormaps
    from matplotlib.collections import PolyCollection

    colours = colormaps[cmap].with_extremes(bad=INTACT)
    picture = PolyCollection(
        list(_plan(mesh)[front.corners]), array=values, cmap=colours, edgecolors="#bbb4ab", linewidths=0.2
    )
    picture.set_clim(*limits)
    axis.add_collection(picture)
    axis.autoscale_view()
    return picture


def draw_steps(response: Response, path: Path) -> None:
    """The load-settlement curve: forces on the feet, the largest crack, energies."""
    history = response.history
    settled = 1000.0 * np.array([step["settlement"] for step in history])
    across, text = (settled, "settlement, mm") if settled.any() else (_column(response, "share"), "share")
    figure, axes = new_figure(3, height=3.4)
    feet = np.array([step["feet"] for step in history]) / 1000.0
    colours = WALL, REFERENCE, "#4c8c4a", BOUNDARY
    for number in range(feet.shape[1]):
        colour = colours[number % len(colours)]
        axes[0].plot(across, feet[:, number, 2], "-", color=colour, label=f"foot {number + 1}, upwards")
        axes[0].plot(across, feet[:, number, 0], "--", color=colour, label=f"foot {number + 1}, along")
    axes[1].plot(
        across, 1000.0 * _column(response, "max_crack_opening"), "-", color=CANDIDATE, label="crack, mm"
    )
    axes[1].plot(across, _column(response, "max_principal_stress") / 1e6, ":", color=INK, label="σ1, MPa")
    stored, taken = _column(response, "strain_energy"), _column(response, "dissipated_energy")
    axes[2].plot(
        across, _column(response, "external_work"), "-", color=INK, label="work of weight and ground"
    )
    axes[2].plot(across, stored + taken, "-", color=REFERENCE, label="stored and dissipated")
    axes[2].plot(across, taken, "-", color=BOUNDARY, label="dissipated")
    titles = "forces of the ground, kN", "largest crack and σ1", "energies, J"
    for axis, title in zip(axes, titles, strict=True):
        axis.set_aspect("auto")
        axis.set(xlabel=text, ylabel="")
        axis.set_title(title, fontsize=9)
        axis.grid(color="#dddddd", linewidth=0.5)
        axis.legend(fontsize=6, ncols=1 + len(axis.lines) // 10)
    save(figure, path)


def _column(response: Response, name: str) -> FloatArray:
    return np.array([step[name] for step in response.history], dtype=float)
