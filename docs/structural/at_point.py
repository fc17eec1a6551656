"""The masonry law at a point."""

import material_point as point
import numpy as np

from structural.rows import Row, Rows, read_targets


def strength_rows() -> Rows:
    """The masonry law where its strength has a closed form, MPa."""
    values = read_targets("masonry")
    found = -point.triaxial_test(0.0, -0.02).stress[2] / 1e6
    strength = values["uniaxial_compression"]["strength"]
    yield Row("uniaxial compression, MPa", "Mohr-Coulomb", strength, found)
    cone = values["cone"]
    yield Row("slope of the cone", "Drucker & Prager", cone["alpha"], point.LAW.alpha)
    yield Row("slope of its flow potential", "Drucker & Prager", cone["eta"], point.LAW.eta)
    uncracked = point.MaterialPoint(strength=point.NEVER)
    found = uncracked.drive({2: 0.0028}).stress[2] / 1e6
    yield Row("uniaxial tension, no cracks, MPa", "Drucker & Prager", cone["tension"], found)
    pressed = point.MaterialPoint()
    found = -pressed.drive({0: -0.07, 1: -0.07}).stress[0] / 1e6
    yield Row("biaxial compression, MPa", "Drucker & Prager", cone["biaxial_compression"], found)
    triaxial = values["triaxial"]
    for confinement, stress in zip(triaxial["confinement"], triaxial["axial_stress"], strict=True):
        found = point.triaxial_test(confinement * 1e6, -0.03).stress[2] / 1e6
        yield Row(f"triaxial compression at {confinement:g} MPa, MPa", "Mohr-Coulomb", stress, found)
    uncracked = point.LAW._replace(eta=0.0)
    found = point.MaterialPoint(uncracked, strength=point.NEVER).move([0, 0, 0, 0.02, 0, 0]).stress[3] / 1e6
    yield Row("pure shear, no cracks, MPa", "Drucker & Prager", values["pure_shear"]["strength"], found)
    found = point.MaterialPoint(strength=point.NEVER).move([0.01, 0.01, 0.01, 0, 0, 0]).stress[0] / 1e6
    yield Row("apex of the cone, no cracks, MPa", "Drucker & Prager", values["apex"]["mean_stress"], found)
    edge = point.MaterialPoint(ductility=np.inf).move([0.016, 0.016, -0.017, 0, 0, 0]).stress[2] / 1e6
    yield Row("edge of cone and two cracks, MPa", "closed form", values["corner"]["least_stress"], edge)


def program_rows() -> Rows:
    """The masonry law against other programs."""
    values = read_targets("masonry")
    aster = values["code_aster"]
    found = point.aster_test(aster, aster["share"])
    for share, stress, (ours, _) in zip(aster["share"], aster["axial_stress"], found, strict=True):
        yield Row(f"softening cone at {100 * share:g} %, MPa", "Code_Aster SSNV168a", stress, ours)
    for share, strain, (_, ours) in zip(aster["share"], aster["p"], found, strict=True):
        yield Row(f"its plastic strain at {100 * share:g} %", "Code_Aster SSNV168a", strain, ours)
    triaxial = values["opensees"]["triaxial"]
    for confinement, lateral in zip(triaxial["confinement"], triaxial["lateral_strain"], strict=True):
        ours = point.triaxial_test(confinement * 1e6, triaxial["axial_strain"]).strain[0]
        yield Row(f"lateral strain at {confinement:g} MPa", "OpenSeesPy DruckerPrager", lateral, ours)
    for number, path in enumerate(values["opensees"]["paths"], start=1):
        ours = path_difference(path)
        yield Row(f"strain path {number}, largest difference, MPa", "OpenSeesPy DruckerPrager", 0.0, ours)
    softening = values["asd_concrete"]
    pulled = point.MaterialPoint(
        ductility=point.MASONRY.fracture_energy / (0.1 * point.MASONRY.tensile_strength)
    )
    ours = [pulled.drive({0: strain}).stress[0] / 1e6 for strain in softening["strain"]]
    worst = float(np.abs(np.subtract(ours, softening["stress"])).max())
    yield Row("softening, largest difference, MPa", "OpenSeesPy ASDConcrete3D", 0.0, worst)


def path_difference(path: dict[str, list[float]]) -> float:
    """Largest difference in stress, MPa, at the end of a strain path."""
    driven = point.MaterialPoint(strength=9.7e6, ductility=np.inf)
    for share in (0.25, 0.5, 0.75, 1.0):
        driven.move(share * np.array(path["strain"]))
    return float(np.abs(driven.stress / 1e6 - path["stress"]).max())
