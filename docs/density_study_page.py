"""The page of the density study: its tables and figures from what the reconstructions gave.

The paper's numbers are in `density_study_paper.json`, the prose around the tables in
`density_study_text.md`.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fd2fem.drawings import STAND_INS, stand_in
from fd2fem.scans import Density
from validation import relative_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HERE = Path(__file__).parent
PAPER: dict[str, Any] = json.loads((HERE / "density_study_paper.json").read_text(encoding="utf-8"))

QUANTITIES = {"length": "Length", "height": "Height", "opening_area": "Opening area"}
STATISTICS = {
    # Row of the paper's Tables 3 and 4: its name in the paper's numbers and in a comparison of facades.
    "Average": ("average", "mean_m"),
    "Min": ("min", "min_m"),
    "Max": ("max", "max_m"),
    "Std.": ("std", "std_m"),
    "Std. uncert.": ("standard_uncertainty", "standard_uncertainty_m"),
    "Lower est.": ("lower", "lower_m"),
    "Upper est.": ("upper", "upper_m"),
}
DIMENSIONS, POSITIONS = ("table3", "opening_dimensions"), ("table4", "opening_positions")
"""Where the paper's numbers, and where a comparison of facades, hold the statistics."""
MISPRINTED = {("table3", "building3", "lower"), ("table3", "building3", "upper")}
OURS, THEIRS = "#1a5fc2", "#c2571a"


@dataclass(frozen=True)
class Outcome:
    """What the reconstruction of one data set gave.

    Attributes
    ----------
    building : str
        Name of the stand-in.
    density : Density
    seed : int
        Of the scan and of its thinning.
    points : int
    seconds : float
        From points in memory to the facade.
    geometry : dict
        Of the comparison with the drawing (`validation.compare_facades`).
    scores : tuple of float
        Error over sigma of each measured edge of an opening.
    """

    building: str
    density: Density
    seed: int
    points: int
    seconds: float
    geometry: dict[str, Any]
    scores: tuple[float, ...]

    def error(self, quantity: str) -> float:
        """Relative error (equation 4) of the length, height or opening area, %."""
        return 100.0 * float(self.geometry[quantity]["relative_error"])


# ---- Tables ---------------------------------------------------------------------------------------------


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; the first column is text, the others are numbers."""
    rule = ["---", *["---:"] * (len(header) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [header, rule, *rows])


def title(building: str) -> str:
    """`building1` as the paper writes it."""
    return building.replace("building", "Building ")


def of_building(outcomes: Iterable[Outcome], building: str) -> dict[Density, list[Outcome]]:
    """Outcomes of a building by density, each in the order of the seeds."""
    mine = sorted((o for o in outcomes if o.building == building), key=lambda o: o.seed)
    return {density: [o for o in mine if o.density is density] for density in Density}


def overall_table(outcomes: Sequence[Outcome]) -> str:
    """Table 2: length, height and opening area in the drawing, by the paper, and in the first scan."""
    units = zip(QUANTITIES.values(), ("m", "m", "m²"), strict=True)
    header = ["", *(f"{label}, {unit}: {who}" for label, unit in units for who in ("paper", "ours"))]
    rows = []
    for building in STAND_INS:
        paper, drawing = PAPER["table2"][building], stand_in(building)
        notes = {"opening_area": "ᵃ"} if building == "building2" else {}
        row = [f"**{title(building)}**, drawing"]
        for name in QUANTITIES:
            row += [f"{paper['drawing'][name]:.3f}{notes.get(name, '')}", f"{getattr(drawing, name):.3f}"]
        rows.append(row)
        for k, (density, scans) in enumerate(of_building(outcomes, building).items()):
            row = [density.value]
            for name in QUANTITIES:
                value = paper[name][k]
                row.append("–" if value is None else f"{value:.3f}{notes.get(name, '')}")
                row.append(f"{scans[0].geometry[name]['candidate']:.3f}")
            rows.append(row)
    return table(header, rows)


def statistics_table(outcomes: Sequence[Outcome], source: tuple[str, str]) -> str:
    """Table 3 (`DIMENSIONS`) or 4 (`POSITIONS`): errors of the openings, mm, in the first scan."""
    which, key = source
    parts = []
    for building in STAND_INS:
        paper, ours = PAPER[which][building], of_building(outcomes, building)
        header = [f"{title(building)} (n = {paper['n']})"]
        header += [f"{density}: {who}" for density in Density for who in ("paper", "ours")]
        rows = []
        for label, (printed, computed) in STATISTICS.items():
            note = "ᵇ" if (which, building, printed) in MISPRINTED else ""
            row = [label]
            for value, density in zip(paper[printed], Density, strict=True):
                row += [f"{value:.1f}{note}", tenths(1e3 * ours[density][0].geometry[key][computed])]
            rows.append(row)
        parts.append(table(header, rows))
    return "\n\n".join(parts)


def tenths(value: float) -> str:
    """One decimal; -0.04 is 0.0."""
    return f"{round(value, 1) + 0.0:.1f}"


def span(values: Sequence[float]) -> str:
    """From the smallest to the largest, signed."""
    return f"{min(values):+.2f} … {max(values):+.2f}"


def seeds_table(outcomes: Sequence[Outcome]) -> str:
    """The range over the scans: overall errors in %, statistics of the openings in mm."""
    header = ["", *(f"{label}, %" for label in QUANTITIES.values())]
    header += [f"{what}, {row}, mm" for what in ("Dimensions", "Positions") for row in ("average", "std.")]
    rows = []
    for building in STAND_INS:
        for density, scans in of_building(outcomes, building).items():
            row = [f"{title(building)}, {density}"]
            row += [span([scan.error(name) for scan in scans]) for name in QUANTITIES]
            for _, key in (DIMENSIONS, POSITIONS):
                row.append(span([1e3 * scan.geometry[key]["mean_m"] for scan in scans]))
                row.append(f"≤ {max(1e3 * scan.geometry[key]['std_m'] for scan in scans):.1f}")
            rows.append(row)
    return table(header, rows)


def by_density(outcomes: Sequence[Outcome], cell: Callable[[list[Outcome]], str]) -> str:
    """A table of one cell per building and density, each made from all scans of the two."""
    rows = [[title(building), *map(cell, of_building(outcomes, building).values())] for building in STAND_INS]
    return table(["", *Density], rows)


def share_inside(outcomes: Iterable[Outcome]) -> str:
    """Share of the true edges within 1.96 sigma of the edge found, and of how many edges."""
    scores = np.concatenate([outcome.scores for outcome in outcomes])
    return f"{np.mean(np.abs(scores) <= 1.96):.1%} of {len(scores)}"


def sigma_table(outcomes: Sequence[Outcome]) -> str:
    """How honest sigma is: shares by building and density, and of all buildings together."""
    total = [share_inside(o for o in outcomes if o.density is density) for density in Density]
    return f"{by_density(outcomes, share_inside)}\n| all | {' | '.join(total)} |"


def time_table(outcomes: Sequence[Outcome]) -> str:
    """Median time of the reconstruction, and points of the first scan."""

    def cell(scans: list[Outcome]) -> str:
        return f"{np.median([scan.seconds for scan in scans]):.2f} s ({scans[0].points:,} points)"

    return by_density(outcomes, cell)


def largest_table(outcomes: Sequence[Outcome]) -> str:
    """The largest relative errors by density, all buildings and scans."""
    rows = []
    for name, label in QUANTITIES.items():
        errors = [[abs(o.error(name)) for o in outcomes if o.density is density] for density in Density]
        rows.append([label, *(f"{max(values):.2f} %" for values in errors)])
    return table(["", *Density], rows)


def counts(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many data sets and openings there were, and how many openings were missed and invented."""
    openings = [outcome.geometry["openings"] for outcome in outcomes]
    return {
        "scans": len({outcome.seed for outcome in outcomes}),
        "datasets": len(outcomes),
        "openings": sum(len(o["matched"]) + len(o["missing"]) for o in openings),
        "missing": sum(len(o["missing"]) for o in openings),
        "extra": sum(len(o["extra"]) for o in openings),
    }


# ---- Figures --------------------------------------------------------------------------------------------


def panels(rows: int, *, height: float) -> "tuple[Figure, np.ndarray[Any, Any]]":
    """A figure of so many rows of axes with a column per building; no display is needed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, height), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, len(STAND_INS), sharex=True, sharey="row", squeeze=False)
    for axes in grid.flat:
        axes.axhline(0.0, color="#888888", linewidth=0.8)
        axes.set_xticks(range(len(Density)), [density.value for density in Density])
        axes.set_xlim(-0.4, len(Density) - 0.6)
        axes.grid(axis="y", color="#e4e4e4", linewidth=0.6)
        axes.set_axisbelow(True)
    for axes, building in zip(grid[0], STAND_INS, strict=True):
        axes.set_title(title(building), fontsize=10)
    return figure, grid


def draw_overall(outcomes: Sequence[Outcome], path: Path) -> None:
    """Figure 16: relative errors of length, height and opening area; ours with the range over the scans."""
    figure, grid = panels(len(QUANTITIES), height=7.0)
    for row, (name, label) in zip(grid, QUANTITIES.items(), strict=True):
        row[0].set_ylabel(f"{label}: error, %")
        for axes, building in zip(row, STAND_INS, strict=True):
            paper = PAPER["table2"][building]
            theirs = [
                np.nan if value is None else 100.0 * (relative_error(value, paper["drawing"][name]) or 0.0)
                for value in paper[name]
            ]
            ours = np.array(
                [[scan.error(name) for scan in scans] for scans in of_building(outcomes, building).values()]
            )
            x = np.arange(len(Density))
            known = np.isfinite(theirs)
            axes.plot(x[known], np.array(theirs)[known], "s--", color=THEIRS, markersize=4, label="paper")
            axes.fill_between(x, ours.min(axis=1), ours.max(axis=1), color=OURS, alpha=0.25, linewidth=0)
            axes.plot(x, ours[:, 0], "o-", color=OURS, markersize=4, label="ours")
    grid[0, 0].legend(fontsize=8)
    figure.savefig(path, dpi=100)


def draw_bounds(outcomes: Sequence[Outcome], source: tuple[str, str], path: Path) -> None:
    """Figure 17 (`DIMENSIONS`) or 18 (`POSITIONS`): 90 % bounds of the mean error, in the first scan."""
    which, key = source
    figure, grid = panels(1, height=3.6)
    grid[0, 0].set_ylabel(f"error of the openings' {key.removeprefix('opening_')}, mm")
    for axes, building in zip(grid[0], STAND_INS, strict=True):
        paper = PAPER[which][building]
        first = [scans[0].geometry[key] for scans in of_building(outcomes, building).values()]
        ours = {printed: [1e3 * row[computed] for row in first] for printed, computed in STATISTICS.values()}
        draw_intervals(axes, paper, shift=-0.12, colour=THEIRS, label="paper")
        draw_intervals(axes, ours, shift=0.12, colour=OURS, label="ours")
    grid[0, 0].legend(fontsize=8)
    figure.savefig(path, dpi=100)


def draw_intervals(axes: "Axes", rows: dict[str, Any], *, shift: float, colour: str, label: str) -> None:
    """An interval with its middle for every density; `shift` sets two of them side by side."""
    middle, lower, upper = (np.array(rows[name]) for name in ("average", "lower", "upper"))
    x, bars = np.arange(len(middle)) + shift, [middle - lower, upper - middle]
    axes.errorbar(x, middle, yerr=bars, fmt="o", color=colour, markersize=4, capsize=4, label=label)


# ---- The page -------------------------------------------------------------------------------------------


def write_study(outcomes: Sequence[Outcome], folder: Path) -> None:
    """Write the page and its figures."""
    draw_overall(outcomes, folder / "density_study_fig16.png")
    draw_bounds(outcomes, DIMENSIONS, folder / "density_study_fig17.png")
    draw_bounds(outcomes, POSITIONS, folder / "density_study_fig18.png")
    text = (HERE / "density_study_text.md").read_text(encoding="utf-8")
    page = text.format(
        largest=largest_table(outcomes),
        overall=overall_table(outcomes),
        dimensions=statistics_table(outcomes, DIMENSIONS),
        positions=statistics_table(outcomes, POSITIONS),
        seeds=seeds_table(outcomes),
        sigma=sigma_table(outcomes),
        time=time_table(outcomes),
        **counts(outcomes),
    )
    (folder / "density_study.md").write_text(page, encoding="utf-8")
