"""The report: pictures of every stage and an HTML page that shows them with the figures."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

from fd2fem.model import Model, Response, RunResult
from fd2fem.report import figures, wall_figures
from fd2fem.report.tables import damage_rows, foot_rows, step_rows

__all__ = ["write_report"]

PAGE = Template("""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>fd2fem: $title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; color: #222; }
table { border-collapse: collapse; margin: 1rem 0; }
td, th { padding: .25rem .75rem; border-bottom: 1px solid #ddd; text-align: right; }
td:first-child, th:first-child { text-align: left; } img { max-width: 100%; }
.passed { color: #17722b; } .short { color: #b3261e; } figcaption { color: #555; }
</style></head><body>
<h1>$title</h1>
$verdict
$tables
$figures
</body></html>
""")

CAPTIONS = (
    ("01_scan.png", "The scan, sorted by the wall's plane."),
    ("02_boundary.png", "Boundary points by the Delaunay criterion, and where its threshold comes from."),
    ("03_openings.png", "Holes with verdict and confidence, and the quadtree."),
    ("03_rays.png", "The face's relief; what was seen through, what lies in shadow, what is attached."),
    ("04_lines.png", "Boundary lines of the wall and its openings."),
    ("05_voxels.png", "Full voxels after the flying-voxel tests."),
    ("06_mesh.png", "The mesh and the settlement imposed on its base."),
    ("07_response.png", "Response of the scan-derived model."),
    ("07_cracks.png", "Cracks of the scan-derived model, and the largest tension on the way there."),
    ("07_load_settlement.png", "Forces on its feet, largest crack and energies while the ground settles."),
    ("08_reference.png", "Response of the drawing-derived model."),
    ("09_comparison.png", "Candidate against reference."),
    ("09_cracks.png", "Cracks of both."),
)


def write_report(result: RunResult, folder: Path) -> None:
    """Write a picture of each stage and ``report.html`` to a folder.

    Parameters
    ----------
    result : RunResult
    folder : Path
        Exists.
    """
    rebuilt = result.reconstruction
    figures.draw_scan(rebuilt.points, folder / "01_scan.png")
    figures.draw_boundary(rebuilt, folder / "02_boundary.png")
    figures.draw_openings(rebuilt, folder / "03_openings.png")
    figures.draw_relief(rebuilt, folder / "03_rays.png")
    figures.draw_lines(rebuilt, folder / "04_lines.png")
    figures.draw_voxels(rebuilt, folder / "05_voxels.png")
    response = result.response
    wall_figures.draw_mesh(result.mesh, response, folder / "06_mesh.png")
    wall_figures.draw_response(response, folder / "07_response.png", title="scan-derived model")
    if response.knows_cracks:
        wall_figures.draw_cracks(response, folder / "07_cracks.png")
    if response.history:
        wall_figures.draw_steps(response, folder / "07_load_settlement.png")
    reference = result.reference or Model(None, None)
    if reference.response is not None:
        _draw_reference(response, reference.response, folder)
    if reference.facade is not None and result.comparison is not None:
        figures.draw_comparison(
            rebuilt.facade, reference.facade, result.comparison, folder / "09_comparison.png"
        )
    (folder / "report.html").write_text(_page(result, folder), encoding="utf-8")


def _draw_reference(response: Response, reference: Response, folder: Path) -> None:
    wall_figures.draw_response(reference, folder / "08_reference.png", title="drawing-derived model")
    if response.knows_cracks and reference.knows_cracks:
        wall_figures.draw_cracked_walls(response, reference, folder / "09_cracks.png")


def _page(result: RunResult, folder: Path) -> str:
    """The HTML page."""
    facade = result.reconstruction.facade
    pictures = [
        f'<figure><img src="{name}" alt="{escape(text)}"><figcaption>{escape(text)}</figcaption></figure>'
        for name, text in CAPTIONS
        if (folder / name).exists()
    ]
    return PAGE.substitute(
        title=escape(f"Facade of {facade.length:.2f} x {facade.height:.2f} m"),
        verdict=_verdict(result),
        tables="".join(
            (
                _openings_table(result),
                _filled_table(result),
                _response_table(result),
                _table(("damage of the scan-derived model", ""), damage_rows(result.response)),
                _table(("foot, x in m", "along, kN", "upwards, kN", "share"), foot_rows(result.response)),
                _table(("steps of the settlement", ""), step_rows(result.response)),
            )
        ),
        figures="\n".join(pictures),
    )


def _verdict(result: RunResult) -> str:
    """One paragraph: whether the scan-derived model answers like the drawing-derived one."""
    warnings = (
        *result.reconstruction.facade.record.get("warnings", ()),
        *result.response.solver.get("warnings", ()),
    )
    text = "".join(f'<p class="short">Warning: {escape(str(warning))}</p>' for warning in warnings)
    if result.comparison is not None:
        text += "".join(f"<p>Note: {escape(note)}.</p>" for note in result.comparison.notes)
    if result.comparison is None:
        return text + "<p>No reference was given, so nothing was compared.</p>"
    tolerance = f"{100 * result.comparison.tolerance:g} %"
    if result.comparison.passed:
        return f'{text}<p class="passed">The scan- and drawing-derived models agree within {tolerance}.</p>'
    reasons = "; ".join(escape(reason) for reason in result.comparison.reasons)
    return f'{text}<p class="short">The models do not agree within {tolerance}: {reasons}.</p>'


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """An HTML table; nothing if it has no rows."""
    if not rows:
        return ""
    lines = ["<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>\n"


def _openings_table(result: RunResult) -> str:
    """The openings found."""
    rows = [
        (
            f"{opening.id} {opening.kind}",
            f"{opening.x:.3f}",
            f"{opening.z:.3f}",
            f"{opening.width:.3f}",
            f"{opening.height:.3f}",
            f"{opening.confidence:.2f}",
            str(opening.evidence.get("verdict", "")),
        )
        for opening in result.reconstruction.facade.openings
    ]
    return _table(("opening", "x, m", "z, m", "width, m", "height, m", "confidence", "because"), rows)


def _filled_table(result: RunResult) -> str:
    """The holes that were filled."""
    holes = result.reconstruction.facade.filled_holes
    if not holes:
        return ""
    rows = [
        (
            f"{hole.outline[:, 0].min():.2f}",
            f"{hole.outline[:, 1].min():.2f}",
            f"{hole.area:.2f}",
            hole.reason,
        )
        for hole in holes
    ]
    return _table(("filled at x, m", "z, m", "area, m²", "because"), rows)


def _response_table(result: RunResult) -> str:
    """The figures of the response, beside the reference's where there is one."""
    if result.comparison is None:
        response = result.response
        values = [
            ("largest displacement, mm", f"{1000 * response.max_displacement:.1f}"),
            ("largest first principal stress, MPa", f"{response.max_principal_stress / 1e6:.3f}"),
        ]
        if response.history:
            final = f"{response.final_principal_stress / 1e6:.3f}"
            values.append(("the same in the last step, MPa", final))
        return _table(("quantity", "value"), values)
    rows = [
        (name, f"{entry['candidate']:.3f}", f"{entry['reference']:.3f}", _percent(entry["relative_error"]))
        for name, entry in result.comparison.geometry.items()
        if name in {"length", "height", "opening_area"}
    ]
    rows += [
        (item.quantity, f"{item.candidate:.4g}", f"{item.reference:.4g}", _percent(item.relative_difference))
        for item in result.comparison.response
    ]
    return _table(("quantity", "candidate", "reference", "difference"), rows)


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:+.2f} %"
