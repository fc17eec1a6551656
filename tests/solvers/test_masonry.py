"""The equations of the masonry law and what it refuses."""

import re

import numpy as np
import pytest

from fd2fem.errors import InputError
from solvers.masonry import (
    MasonryLaw,
    characteristic_length,
    check_band,
    cone_intercept,
    cone_slope,
    point_law,
    softening_strain,
)
from solvers.materials import Material


@pytest.mark.parametrize("angle", [5.0, 20.0, 35.0, 50.0])
@pytest.mark.parametrize("confinement", [0.0, 3e6, 2e7])
def test_cone_touches_mohr_coulomb_in_triaxial_compression(angle, confinement):
    # Mohr-Coulomb: s1 - s3 = 2 c cos(phi) - (s1 + s3) sin(phi), solved for s3 at s1 = s2 = -confinement.
    sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    s3 = (-confinement * (1 + sine) - 2 * 6.81e6 * cosine) / (1 - sine)
    i1, root_j2 = s3 - 2 * confinement, (-confinement - s3) / np.sqrt(3)
    cone = cone_slope(angle) * i1 + root_j2
    assert cone == pytest.approx(cone_intercept(6.81e6, angle), rel=1e-12)


def test_softening_strain_takes_the_fracture_energy():
    # The area under ft exp(-kappa / ku) is ft ku; times the band's width, the fracture energy.
    law, band = MasonryLaw(), np.array([0.05, 0.1, 0.2])
    assert law.tensile_strength * softening_strain(law, band) * band == pytest.approx(law.fracture_energy)


def test_characteristic_length_is_irwins():
    # By hand: 30 GPa x 137 N/m / (3.33 MPa)² = 370.64 mm.
    law = MasonryLaw(tensile_strength=3.33e6, fracture_energy=137.0)
    assert characteristic_length(Material(young=3e10), law) == pytest.approx(0.370641, rel=1e-5)


def test_wide_bands_are_told():
    bands = [0.2, 0.27, 0.3]
    assert check_band(Material(), MasonryLaw(), bands[:1]) == ()
    (warning,) = check_band(Material(), MasonryLaw(), bands)
    assert warning.startswith("2 of 3 elements are wider than E Gf / ft² = 0.263 m")


def test_point_law_has_the_materials_moduli():
    law = point_law(Material(young=9e9, poisson=0.125), MasonryLaw(dilatancy_angle=0.0))
    # By hand: G = 9 / 2.25 = 4 GPa, K = 9 / (3 x 0.75) = 4 GPa, lambda = K - 2 G / 3 = 4/3 GPa.
    assert (law.shear, law.bulk, law.lame) == pytest.approx((4e9, 4e9, 4e9 / 3))
    assert law.eta == 0.0
    assert law.hardening == 0.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tensile_strength": 0.0}, "Invalid 'tensile_strength': expected a positive number, got 0.0"),
        ({"fracture_energy": -1.0}, "Invalid 'fracture_energy'"),
        ({"cohesion": float("nan")}, "Invalid 'cohesion'"),
        ({"friction_angle": 0.0}, "Invalid 'friction_angle': expected degrees between 0 and 60, got 0.0"),
        ({"friction_angle": float("nan")}, "Invalid 'friction_angle'"),
        ({"dilatancy_angle": 36.0}, "from 0 to the friction angle of 35.0, got 36.0"),
        ({"dilatancy_angle": float("nan")}, "Invalid 'dilatancy_angle'"),
        # k / (3 alpha) = c / tan(phi) = 6.81 / 0.70021 = 9.7257 MPa.
        ({"tensile_strength": 9.73e6}, "9.73e+06 Pa is more than cohesion and friction allow (9.726e+06 Pa"),
    ],
)
def test_masonry_law_refuses(values, message):
    with pytest.raises(InputError, match=re.escape(message)):
        MasonryLaw(**values)
