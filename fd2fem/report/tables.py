"""Short tables of records, for people and for ``--json``."""

from typing import Any

import numpy as np

from fd2fem.model import Facade, Response

__all__ = ["damage_rows", "facade_summary", "foot_rows", "step_rows"]

Rows = list[tuple[str, ...]]


def facade_summary(facade: Facade) -> dict[str, Any]:
    """The figures of a facade that a user looks at first; JSON values, metres.

    Examples
    --------
    >>> from fd2fem.model import Facade, rectangle
    >>> facade_summary(Facade(rectangle(0, 0, 5, 6), 0.35))["length"]
    5.0
    """
    return {
        "length": facade.length,
        "height": facade.height,
        "thickness": facade.thickness,
        "storeys": [{"z": storey.z, "thickness": storey.thickness} for storey in facade.storeys],
        "opening_area": facade.opening_area,
        "openings": [
            {
                "id": opening.id,
                "kind": opening.kind.value,
                "x": opening.x,
                "z": opening.z,
                "width": opening.width,
                "height": opening.height,
                "confidence": opening.confidence,
            }
            for opening in facade.openings
        ],
        "filled_holes": [{"area": hole.area, "reason": hole.reason} for hole in facade.filled_holes],
        "points": dict(facade.record.get("points", {})),
        "warnings": list(facade.record.get("warnings", ())),
    }


def damage_rows(response: Response) -> Rows:
    """Classes of damage, name and value, in the words that people class by."""
    damage = response.damage
    if not damage:
        return []
    rows = []
    if "crack_class" in damage:
        rows.append(
            (
                f"by {damage['visible_cracks']} visible cracks, up to {1000 * damage['crack_width']:.2f} mm",
                f"{damage['crack_class']}, {damage['crack_label']}",
            )
        )
    beam = damage["equivalent_beam"]
    return [
        *rows,
        (
            f"by the strain of its bays, {100 * damage['tensile_strain']:.3f} %",
            f"{damage['strain_class']}, {damage['strain_label']}",
        ),
        (
            f"of an equivalent beam on the same ground, {100 * beam['tensile_strain']:.3f} %",
            f"{beam['damage_class']}, {beam['damage_label']}",
        ),
    ]


def foot_rows(response: Response) -> Rows:
    """What the ground does to each foot: its ends, force along the wall and upwards, share of the weight."""
    return [
        (
            f"{number}: {foot['x_m'][0]:.2f} to {foot['x_m'][1]:.2f}",
            f"{foot['reaction_n'][0] / 1000:.2f}",
            f"{foot['reaction_n'][2] / 1000:.2f}",
            "–" if foot["share_of_weight"] is None else f"{100 * foot['share_of_weight']:.1f} %",
        )
        for number, foot in enumerate(response.feet, start=1)
    ]


def step_rows(response: Response) -> Rows:
    """How an analysis in steps went, and where the work of the loads is; empty after a single solve."""
    if not response.history:
        return []
    last, sizes = response.history[-1], np.diff([step["share"] for step in response.history])
    equal = 1.0 / response.solver["stepping"]["steps"] if response.solver.get("stepping") else sizes.max()
    # The last step ends at the whole settlement and may be short for that.
    cut = int((sizes[:-1] < (1.0 - 1e-9) * equal).sum())
    stored, taken, work = last["strain_energy"], last["dissipated_energy"], last["external_work"]
    rows: Rows = [
        ("steps; of them smaller than asked for", f"{len(sizes)}; {cut}"),
        ("iterations", f"{sum(step['iterations'] for step in response.history)}"),
        ("work of weight and ground, J", f"{work:.2f}"),
        ("of it stored", f"{stored:.2f}"),
    ]
    if not response.knows_cracks:
        return rows
    crushing, error = last["plastic_energy"], max(step["strength_error"] for step in response.history)
    return [
        *rows,
        ("of it dissipated, by cracks and by crushing", f"{taken - crushing:.2f}; {crushing:.2f}"),
        (
            "of it set free by cracks that ran at once, or the error of the steps",
            f"{work - stored - taken:.2f}",
        ),
        ("largest error of the extrapolated strength", f"{100 * error:.1f} %"),
    ]
