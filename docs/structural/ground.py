"""The trough of a tunnel, and what it does to an equivalent beam."""

import numpy as np

from solvers import PeckTrough, horizontal_strain, settlement_slope, settlement_trough
from solvers.damage.beam_strains import (
    EquivalentBeam,
    ZoneKind,
    bending_strain,
    combined_diagonal_strain,
    diagonal_strain,
)
from solvers.damage.classes import distortion_strain
from solvers.ground.trough import horizontal_movement
from structural.rows import Row, Rows, read_targets


def trough_rows() -> Rows:
    """The settlement trough of a tunnel."""
    values = read_targets("structural")["trough"]
    trough = settlement_trough(
        PeckTrough(values["volume_loss"], values["diameter"], values["depth"], k=values["k"])
    )
    yield Row("trough, distance to the inflection, m", "Peck; O'Reilly & New", values["width"], trough.width)
    yield Row("trough, largest settlement, mm", "Peck", 1e3 * values["smax"], 1e3 * trough.smax)
    x = np.linspace(0.0, 4.0 * trough.width, 40_001)
    slope = settlement_slope(x, smax=trough.smax, width=trough.width)
    strain = horizontal_strain(x, smax=trough.smax, width=trough.width, depth=trough.depth)
    moved = horizontal_movement(x, smax=trough.smax, width=trough.width, depth=trough.depth)
    yield Row("trough, largest slope", "Peck", values["largest_slope"], float(np.abs(slope).max()))
    source = "O'Reilly & New"
    yield Row(
        "trough, horizontal strain over the axis", source, values["strain_over_axis"], float(strain.min())
    )
    yield Row("trough, largest horizontal strain", source, values["largest_strain"], float(strain.max()))
    largest = 1e3 * float(np.abs(moved).max())
    yield Row("trough, largest horizontal movement, mm", source, 1e3 * values["largest_horizontal"], largest)


def damage_rows() -> Rows:
    """Strains of the equivalent beam and their combinations."""
    values = read_targets("damage")
    for kind, slenderness, bending, diagonal in values["beam"]["rows"]:
        beam = EquivalentBeam(ZoneKind(kind), length=float(slenderness), height=1.0)
        case = f"{kind} beam, L/H = {slenderness}, strain per Δ/L"
        yield Row(f"{case}, bending", "Burland & Wroth", bending, bending_strain(1.0, beam))
        yield Row(f"{case}, diagonal", "Burland & Wroth", diagonal, diagonal_strain(1.0, beam))
    both = values["combination"]
    found = combined_diagonal_strain(both["diagonal"], both["horizontal"], poisson=both["poisson"])
    yield Row("diagonal with horizontal strain", "Mair, Taylor & Burland", both["principal"], found)
    turned = values["distortion"]
    found = distortion_strain(turned["angular_distortion"], turned["lateral_strain"])
    yield Row("distortion with lateral strain", "Son & Cording", turned["principal_strain"], found)
