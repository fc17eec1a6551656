"""Our linear analysis held against CalculiX, node by node and integration point by integration point."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, Response
from solvers.calculix.files import CalculixResult
from solvers.calculix.points import order_of_points
from solvers.calculix.tables import DIGITS
from solvers.fem.assembly import body_force, elastic_body, internal_force
from solvers.fem.elements import ElementType, Space, displacement_space
from solvers.fem.rules import space_rule, stiffness_order
from solvers.fem.stress import point_stress
from solvers.options import AnalysisOptions, element_of

__all__ = [
    "LIMIT",
    "SCHEMA",
    "CalculixCheck",
    "Difference",
    "check_to_dict",
    "comparable_element",
    "compare_with_calculix",
    "write_check",
]

SCHEMA = "fd2fem/calculix-1"

LIMIT = 1e-6
"""Largest difference relative to the largest value. Seven digits may hide half of it."""

FLOOR = 1e-6
"""Where the wall moves as a rigid body, what is left of stresses and forces is rounding. They are never held
against less than this part of E u / h and E u h: what an element of the mean size h carries if it is drawn
out by the largest displacement u. Nor is the total reaction held against less than this part of all forces
that add up to it."""

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Difference:
    """The largest difference of a quantity from CalculiX's.

    Attributes
    ----------
    quantity, unit : str
    largest : float
        In the unit.
    scale : float
        Largest absolute value of CalculiX, in the unit.
    place : str
        Where the difference is; nodes and elements counted from 1, as in the deck.
    """

    quantity: str
    unit: str
    largest: float
    scale: float
    place: str

    @property
    def relative(self) -> float:
        """The difference by the scale; 0 if there is nothing but zeros."""
        return self.largest / self.scale if self.scale > 0.0 else self.largest

    @property
    def resolution(self) -> float:
        """What rounding to the printed digits alone may make of `relative`: at most 5e-7.

        Examples
        --------
        >>> Difference("displacement", "m", 0.0, 1.0, "node 1").resolution
        5e-07
        """
        if not self.scale > 0.0:
            return 0.0
        return float(0.5 * 10.0 ** (np.floor(np.log10(self.scale)) - DIGITS + 1) / self.scale)


@dataclass(frozen=True)
class CalculixCheck:
    """What the comparison found.

    Attributes
    ----------
    differences : tuple of Difference
        Displacement, stress, reaction by node, total reaction.
    limit : float
        Largest relative difference allowed.
    version : str
        Of CalculiX.
    nodes, elements, points : int
        Nodes, elements and integration points compared.
    seconds : float
        Wall time of CalculiX, from reading the deck to writing the results.
    own_seconds : float
        Wall time of our assembly, solution and stresses on the deck's mesh; the first analysis after an
        installation compiles as well.
    """

    differences: tuple[Difference, ...]
    limit: float
    version: str
    nodes: int
    elements: int
    points: int
    seconds: float
    own_seconds: float

    @property
    def passed(self) -> bool:
        """Whether every difference is within the limit."""
        return all(difference.relative <= self.limit for difference in self.differences)

    @property
    def worst(self) -> Difference:
        """The largest of the relative differences."""
        return max(self.differences, key=lambda difference: difference.relative)


def comparable_element(kind: ElementKind, options: AnalysisOptions) -> ElementType:
    """The element of an analysis that CalculiX can repeat.

    Raises
    ------
    InputError
        If the analysis is not linear, or CalculiX does not have the element.
    """
    if not options.linear:
        msg = "CalculiX checks only elastic walls that are tied to the ground: leave out --check."
        raise InputError(msg)
    element = element_of(kind, options)
    if element is ElementType.INCOMPATIBLE:
        msg = (
            "CalculiX has no hexahedra with our incompatible modes: take 20-node ones, or leave out --check."
        )
        raise InputError(msg)
    return element


def compare_with_calculix(
    response: Response, result: CalculixResult, *, options: AnalysisOptions, full: Response | None = None
) -> CalculixCheck:
    """Compare a response with CalculiX's results on the same mesh under the same loads.

    Parameters
    ----------
    response : Response
    result : CalculixResult
    options : AnalysisOptions
        Of the response.
    full : Response, optional
        The analysis of the deck's mesh, where that is another one: the deck of an 8-node mesh has the 20-node
        elements that it is analysed with, and stresses at their points need the displacements of all nodes.
        The nodes of the response's mesh must come first in it.

    Returns
    -------
    check : CalculixCheck
        Displacements of both responses, the stresses and nodal reactions of `full`, and the reaction of
        `response`, each relative to CalculiX's largest (but see `FLOOR`).

    Raises
    ------
    InputError
        If the analysis is not linear, its element is none of CalculiX's, the mesh has no group "base", or
        the results belong to another mesh.
    """
    comparable_element(response.mesh.kind, options)
    full = full or response
    space = displacement_space(full.mesh, comparable_element(full.mesh.kind, options))
    _check_same_mesh(response, full, result, space)
    displacement = full.displacement.copy()
    points = point_stress(space, options.material, displacement=displacement, order=stiffness_order(space))
    body = elastic_body(space, options.material)
    force, _ = internal_force(body, displacement)
    load = body_force(space, [0.0, 0.0, -options.material.density * options.gravity]).reshape(-1, 3)
    size = float(points.volume.sum() / len(points.volume)) ** (1.0 / 3.0)
    floor = FLOOR * options.material.young * float(np.abs(result.displacement).max())
    differences = (
        _displacement_difference(response, full, result),
        _stress_difference(points.stress[:, order_of_points(space)], result, floor=floor / size),
        _reaction_difference(force[space.base], result, floor=floor * size),
        # What CalculiX prints leaves out the weight that falls on the base nodes themselves.
        _total_difference(response.reaction + load[space.base].sum(axis=0), result, floor=floor * size),
    )
    return CalculixCheck(
        differences=differences,
        limit=LIMIT,
        version=result.version,
        nodes=len(result.displacement),
        elements=len(result.stress),
        points=result.stress.shape[0] * result.stress.shape[1],
        seconds=result.seconds,
        own_seconds=float(sum(full.timings.values())),
    )


def check_to_dict(check: CalculixCheck) -> dict[str, Any]:
    """The check as JSON values, schema "fd2fem/calculix-1"."""
    return {
        "schema": SCHEMA,
        "passed": check.passed,
        "limit": check.limit,
        "printed_digits": DIGITS,
        "version": check.version,
        "nodes": check.nodes,
        "elements": check.elements,
        "points": check.points,
        "differences": [
            {
                "quantity": difference.quantity,
                "unit": difference.unit,
                "largest": difference.largest,
                "scale": difference.scale,
                "relative": difference.relative,
                "resolution": difference.resolution,
                "place": difference.place,
            }
            for difference in check.differences
        ],
        "timings_s": {"calculix": check.seconds, "fd2fem": check.own_seconds},
    }


def write_check(check: CalculixCheck, path: Path) -> None:
    """Write a check as JSON."""
    text = json.dumps(check_to_dict(check), indent=2, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _check_same_mesh(response: Response, full: Response, result: CalculixResult, space: Space) -> None:
    """Refuse results of another mesh."""
    own, points = len(response.mesh.nodes), len(space_rule(space, stiffness_order(space)).weights)
    found = len(result.displacement), result.stress.shape[:2]
    expected = len(space.points), (len(space.connectivity), points)
    if (
        found != expected
        or len(full.mesh.nodes) != expected[0]
        or not np.array_equal(result.base, space.base)
        or not np.array_equal(response.mesh.nodes, full.mesh.nodes[:own])
    ):
        msg = (
            f"CalculiX's results are of {found[0]} nodes and {found[1][0]} elements of {found[1][1]} points, "
            f"ours of {expected[0]}, {expected[1][0]} and {expected[1][1]}: they must be of the same mesh."
        )
        raise InputError(msg)


def _displacement_difference(response: Response, full: Response, result: CalculixResult) -> Difference:
    off = np.abs(full.displacement - result.displacement).max(axis=1)
    own = len(response.displacement)
    off[:own] = np.maximum(off[:own], np.abs(response.displacement - result.displacement[:own]).max(axis=1))
    node = int(off.argmax())
    scale = float(np.abs(result.displacement).max())
    return Difference("displacement", "m", float(off[node]), scale, f"node {node + 1}")


def _stress_difference(stress: FloatArray, result: CalculixResult, *, floor: float) -> Difference:
    off = np.abs(stress - result.stress).max(axis=2)
    element, point = np.unravel_index(int(off.argmax()), off.shape)
    scale = max(float(np.abs(result.stress).max()), floor)
    place = f"element {element + 1}, integration point {point + 1}"
    return Difference("stress", "Pa", float(off[element, point]), scale, place)


def _reaction_difference(force: FloatArray, result: CalculixResult, *, floor: float) -> Difference:
    off = np.abs(force - result.force).max(axis=1)
    worst = int(off.argmax())
    scale = max(float(np.abs(result.force).max()), floor)
    return Difference("reaction", "N", float(off[worst]), scale, f"node {result.base[worst] + 1}")


def _total_difference(total: FloatArray, result: CalculixResult, *, floor: float) -> Difference:
    off = float(np.abs(total - result.total_force).max())
    # Without weight the forces cancel but for rounding.
    rounding = FLOOR * float(np.abs(result.force).sum())
    scale = max(float(np.abs(result.total_force).max()), rounding, floor)
    return Difference("total reaction", "N", off, scale, "sum over the base")
