import numpy as np
import pytest
import shapely

from fd2fem.model.heads import HeadKind, head_outline
from fd2fem.reconstruction.curves import head_rise
from fd2fem.reconstruction.heads import fit_head
from fd2fem.reconstruction.sampling import Sampling

LEFT, RIGHT, BOTTOM, CROWN = 1.0, 2.0, 1.0, 2.6
MIDDLE = 1.8


def sheet(pattern, spacing, rng, size=(3.0, 4.0)):
    """Points on a whole sheet of wall: evenly random, a grid, or level, upright or slanted scan lines."""
    if pattern == "random":
        return rng.uniform(0.0, size, (rng.poisson(size[0] * size[1] / spacing**2), 2))
    pitch = np.array(
        {
            "grid": (1.0, 1.0),
            "rows": (1 / 1.4, 1.4),
            "columns": (1.4, 1 / 1.4),
            "slanted": (1 / 1.4, 1.4),
        }[pattern]
    )
    x, z = (
        np.arange(-1.0 + start, extent + 1.0, step)
        for start, extent, step in zip(rng.uniform(0.0, pitch * spacing), size, pitch * spacing, strict=True)
    )
    xz = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
    if pattern == "slanted":
        xz[:, 1] += 0.3 * (xz[:, 0] - size[0] / 2.0)
    xz = xz + rng.normal(0.0, 0.001, xz.shape)
    return xz[((xz > 0.0) & (xz < size)).all(axis=1)]


def scan(kind, rise, spacing, pattern, rng, *, strays=0.0):
    """Wall points about an opening of 1.0 x 1.6 m with a head of known shape."""
    xz = sheet(pattern, spacing, rng)
    half, u = (RIGHT - LEFT) / 2.0, (xz[:, 0] - (LEFT + RIGHT) / 2.0) / ((RIGHT - LEFT) / 2.0)
    top = CROWN - rise + head_rise(kind, np.clip(u, -1.0, 1.0), rise=rise, half=half)
    inside = (np.abs(u) < 1.0) & (xz[:, 1] > BOTTOM) & (xz[:, 1] < top)
    return xz[~inside | (rng.uniform(size=len(xz)) < strays)]


def fitted(xz, spacing, *, jambs=(LEFT, RIGHT), hidden=None):
    near = (np.abs(xz[:, 0] - 1.5) < 0.9) & (xz[:, 1] > MIDDLE) & (xz[:, 1] < CROWN + 0.4)
    return fit_head(
        xz[near],
        left=jambs[0],
        right=jambs[1],
        middle=MIDDLE,
        sampling=Sampling(spacing=spacing, noise=0.001, exclusion=0.0),
        hidden=hidden,
    )


def area(head):
    return shapely.Polygon(head_outline(head, LEFT, RIGHT, BOTTOM, 0.001).ring).area


def true_area(kind, rise):
    u = np.linspace(-1.0, 1.0, 20_001)
    above = np.trapezoid(head_rise(kind, u, rise=rise, half=0.5), 0.5 * u)
    return CROWN - rise - BOTTOM + above


CURVED = [
    (HeadKind.ARC, 0.1),
    (HeadKind.ARC, 0.25),
    (HeadKind.ARC, 0.5),
    (HeadKind.ELLIPTICAL, 0.3),
    (HeadKind.POINTED, 0.87),
    (HeadKind.GABLED, 0.4),
]


@pytest.mark.parametrize("pattern", ["random", "grid", "rows", "columns", "slanted"])
@pytest.mark.parametrize(("kind", "rise"), CURVED)
def test_shapes_at_20_mm(kind, rise, pattern):
    rng = np.random.default_rng(5)
    heads = [fitted(scan(kind, rise, 0.02, pattern, rng), 0.02) for _ in range(8)]
    errors = np.array([head.crown - CROWN for head in heads])
    areas = np.array([area(head) for head in heads]) / true_area(kind, rise) - 1.0
    assert all(head.kind is not HeadKind.FLAT for head in heads)
    assert abs(errors.mean()) < 0.003
    assert np.abs(areas).max() < 0.01
    if kind is not HeadKind.ELLIPTICAL:
        assert sum(head.kind is kind for head in heads) >= 7


@pytest.mark.parametrize("pattern", ["random", "grid", "columns", "slanted"])
@pytest.mark.parametrize(
    ("kind", "rise"), [(HeadKind.ARC, 0.25), (HeadKind.ARC, 0.5), (HeadKind.POINTED, 0.87)]
)
def test_areas_at_50_mm(kind, rise, pattern):
    rng = np.random.default_rng(6)
    found = [area(fitted(scan(kind, rise, 0.05, pattern, rng), 0.05)) for _ in range(10)]
    assert np.abs(np.array(found) / true_area(kind, rise) - 1.0).max() < 0.015


@pytest.mark.parametrize("spacing", [0.02, 0.05, 0.075, 0.09])
@pytest.mark.parametrize("pattern", ["random", "grid", "rows", "columns", "slanted"])
def test_rectangles_stay_rectangles(pattern, spacing):
    # Also with mixed pixels in the corners and jambs that are off by a fifth of the spacing.
    rng = np.random.default_rng(7)
    for _ in range(12):
        xz = scan(HeadKind.FLAT, 0.0, spacing, pattern, rng, strays=0.02)
        jambs = np.array([LEFT, RIGHT]) + rng.normal(0.0, spacing / 5.0, 2)
        assert fitted(xz, spacing, jambs=tuple(jambs)).kind is HeadKind.FLAT


def test_arch_with_strays_is_an_arch():
    rng = np.random.default_rng(8)
    heads = [fitted(scan(HeadKind.ARC, 0.5, 0.02, "random", rng, strays=0.02), 0.02) for _ in range(8)]
    assert all(abs(head.crown - CROWN) < 0.01 for head in heads)
    areas = np.array([area(head) for head in heads])
    assert np.abs(areas / true_area(HeadKind.ARC, 0.5) - 1.0).max() < 0.01


def test_sigma_is_honest():
    rng = np.random.default_rng(9)
    heads = [fitted(scan(HeadKind.ARC, 0.25, 0.02, "random", rng), 0.02) for _ in range(60)]
    scores = np.array([(head.crown - CROWN) / head.sigma for head in heads])
    assert np.mean(np.abs(scores) < 1.96) > 0.8
    assert scores.std() > 0.5


@pytest.mark.parametrize(("kind", "rise"), [(HeadKind.FLAT, 0.0), (HeadKind.ARC, 0.5)])
def test_shadow_on_a_corner_does_not_decide(kind, rise):
    def shadow(xz):
        return (xz[:, 0] < LEFT + 0.35) & (xz[:, 1] > CROWN - 0.4) & (xz[:, 1] < CROWN + 0.15)

    rng = np.random.default_rng(10)
    for _ in range(8):
        xz = scan(kind, rise, 0.02, "random", rng)
        head = fitted(xz[~shadow(xz)], 0.02, hidden=shadow)
        assert head.kind in {kind, HeadKind.ELLIPTICAL if rise else kind}
        assert head.crown == pytest.approx(CROWN, abs=0.01)


def test_keystone_does_not_make_an_arch():
    rng = np.random.default_rng(11)
    xz = scan(HeadKind.FLAT, 0.0, 0.02, "random", rng)
    stone = rng.uniform([1.4, CROWN - 0.1], [1.6, CROWN], (50, 2))
    head = fitted(np.vstack([xz, stone]), 0.02)
    assert head.kind is HeadKind.FLAT
    assert head.crown == pytest.approx(CROWN, abs=0.01)


def test_shouldered_head_is_irregular_and_keeps_its_area():
    # Corner blocks of 0.25 x 0.4 m leave a T: no arch, no rectangle.
    rng = np.random.default_rng(12)
    xz = sheet("random", 0.02, rng)
    u = np.abs(xz[:, 0] - 1.5)
    top = np.where(u < 0.25, CROWN, CROWN - 0.4)
    xz = xz[~((u < 0.5) & (xz[:, 1] > BOTTOM) & (xz[:, 1] < top))]
    head = fitted(xz, 0.02)
    assert head.kind is HeadKind.IRREGULAR
    assert area(head) == pytest.approx(1.6 - 0.2, rel=0.02)


def test_order_of_the_points_does_not_matter():
    rng = np.random.default_rng(13)
    xz = scan(HeadKind.ARC, 0.25, 0.02, "random", rng)
    first, second = fitted(xz, 0.02), fitted(rng.permutation(xz), 0.02)
    assert first.crown == pytest.approx(second.crown, abs=1e-9)
    assert first.springing == pytest.approx(second.springing, abs=1e-9)


def test_nothing_above_the_opening_leaves_it_flat():
    rng = np.random.default_rng(14)
    xz = scan(HeadKind.FLAT, 0.0, 0.05, "random", rng)
    beside = xz[(xz[:, 0] < LEFT) | (xz[:, 0] > RIGHT)]
    assert fitted(beside, 0.05).kind is HeadKind.FLAT
