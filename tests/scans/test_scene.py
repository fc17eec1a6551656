"""What stands around a facade: bodies by their geometry, the street by what a scan of it shows."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from fd2fem.errors import InputError
from fd2fem.model import Facade, Opening, OpeningKind, rectangle
from fd2fem.scans.rays import step_for_spacing
from fd2fem.scans.scanner import ScannerOptions, simulate_scan
from fd2fem.scans.scene import Foliage, Neighbour, Post, Scene, Vehicle
from fd2fem.scans.street import default_stations, street_scene
from fd2fem.scans.surfaces import Material


def ladder(length, height, *, columns, rows):
    """A facade with a regular grid of windows over a row of doors."""
    openings = []
    for row in range(rows):
        for column in range(columns):
            pitch, storey = length / columns, height / rows
            door = row == 0
            x, z = (column + 0.25) * pitch, row * storey + (0.0 if door else 0.25 * storey)
            kind = OpeningKind.DOOR if door else OpeningKind.WINDOW
            outline = rectangle(x, z, 0.45 * pitch, 0.6 * storey)
            openings.append(Opening(len(openings) + 1, kind, outline))
    return Facade(rectangle(0, 0, length, height), thickness=0.35, openings=tuple(openings))


FACADES = {
    "narrow": ladder(4.95, 12.16, columns=1, rows=4),
    "small": ladder(4.9, 13.28, columns=2, rows=4),
    "long": ladder(19.36, 17.0, columns=7, rows=4),
    "low": ladder(6.0, 3.5, columns=2, rows=1),
}


def test_leaves_thin_a_beam_exponentially():
    # Beer-Lambert: through s metres of leaves exp(-density·s) of the rays pass.
    tree = Foliage(centre=(0.0, -3.0, 3.0), radii=(1.0, 0.5, 1.0), density=1.5, trunk_radius=0.0)
    leaf = np.random.default_rng(2).random(40_000)
    ahead = np.tile([0.0, 1.0, 0.0], (len(leaf), 1))
    hits = tree.hits(np.array([0.0, -9.0, 3.0]), ahead, leaf)
    met = np.isfinite(hits.distance)
    # Binomial: sigma 0.0021 at this count.
    assert 1.0 - met.mean() == pytest.approx(np.exp(-1.5 * 1.0), abs=0.009)
    depth = hits.distance[met] - 5.5
    assert depth.min() >= 0.0
    assert depth.max() <= 1.0
    half = np.log(2.0 / (1.0 + np.exp(-1.5))) / 1.5  # median of the truncated exponential
    assert np.median(depth) == pytest.approx(half, abs=0.01)


def test_trunk_stands_under_the_crown():
    tree = Foliage(centre=(1.0, -3.0, 3.0), radii=(0.5, 0.5, 0.5), trunk_radius=0.1)
    hits = tree.hits(np.array([1.0, -9.0, 1.0]), np.array([[0.0, 1.0, 0.0]]), np.zeros(1))
    assert hits.distance[0] == pytest.approx(5.9)
    assert hits.material[0] == Material.POST


def test_vehicle_has_a_cabin_on_a_body_over_its_clearance():
    car = Vehicle(0.0, -3.0, length=4.0, width=2.0, height=1.5, clearance=0.3)

    def cast(x, z):
        return car.hits(np.array([x, -9.0, z]), np.array([[0.0, 1.0, 0.0]]), np.zeros(1)).distance[0]

    assert np.isinf(cast(0.0, 0.29))  # under the car
    assert cast(1.9, 0.5) == pytest.approx(5.0)  # the body's side, y = -4
    assert cast(0.0, 1.4) == pytest.approx(5.15)  # the cabin is narrower, y = -3.85
    assert np.isinf(cast(1.5, 1.4))  # and shorter
    assert cast(0.0, 1.49) == pytest.approx(5.15)
    assert np.isinf(cast(0.0, 1.51))


def test_neighbour_shows_its_front_and_its_flank():
    forward = Neighbour(-5.0, 0.0, -0.25, 8.0)
    front = forward.hits(np.array([-1.0, -8.0, 1.0]), np.array([[0.0, 1.0, 0.0]]), np.zeros(1))
    assert front.distance[0] == pytest.approx(7.75)
    slanted = np.array([[-3.0, 4.0, 0.0]]) / 5.0
    flank = forward.hits(np.array([5.85, -8.0, 1.0]), slanted, np.zeros(1))  # meets x = 0 at y = -0.2
    assert flank.distance[0] == pytest.approx(9.75)
    assert flank.cosine[0] == pytest.approx(0.6)


def test_bodies_know_where_no_scanner_can_stand():
    assert Post(1.0, -3.0, radius=0.2, height=2.0).contains((1.1, -3.1, 1.0))
    assert not Post(1.0, -3.0, radius=0.2, height=2.0).contains((1.1, -3.1, 2.5))
    assert Vehicle(0.0, -3.0).contains((1.0, -3.0, 0.6))
    assert not Vehicle(0.0, -3.0).contains((1.9, -3.0, 1.4))
    assert Foliage((0.0, -3.0, 3.0), (1.0, 1.0, 1.0)).contains((0.5, -3.0, 3.5))
    assert Foliage((0.0, -3.0, 3.0), (1.0, 1.0, 1.0)).contains((0.0, -3.05, 1.0))  # the trunk
    assert Neighbour(-5.0, 0.0, 0.3, 8.0).contains((-2.0, 1.0, 2.0))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Post(0, -2, radius=0), "Invalid 'radius of a post': expected a positive number, got 0"),
        (lambda: Post(0, -2, height=-1), "Invalid 'height of a post'"),
        (lambda: Vehicle(0, -3, length=0), "Invalid 'length of a vehicle'"),
        (lambda: Vehicle(0, -3, clearance=1.4), "Invalid 'clearance' of a vehicle: expected 0 to half"),
        (lambda: Foliage((0, -3, 3), (1, 0, 1)), "Invalid 'radii of foliage'"),
        (lambda: Foliage((0, -3, 3), (1, 1, 1), density=0), "Invalid 'density of foliage'"),
        (lambda: Foliage((0, -3, 3), (1, 1, 1), trunk_radius=-1), "Invalid 'trunk_radius' of foliage"),
        (lambda: Neighbour(0, 0, 0.3, 8), "Invalid 'length of a neighbour"),
        (lambda: Neighbour(0, 5, 0.3, 0), "Invalid 'height of a neighbour'"),
        (lambda: Scene(room_depth=-1), "Invalid 'room_depth' of the scene: expected 0 or more, got -1"),
        (lambda: Scene(margin=np.nan), "Invalid 'margin' of the scene"),
    ],
)
def test_bad_bodies_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()


def test_stations_by_the_length_of_the_facade():
    ((x, y, z),) = default_stations(FACADES["narrow"])
    assert (y, z) == (pytest.approx(-0.8 * 12.16), 1.6)
    assert x != pytest.approx(0.5 * 4.95)  # not symmetric
    assert abs(x - 0.5 * 4.95) < 0.3
    left, right = default_stations(FACADES["long"])
    assert left[0] == pytest.approx(0.25 * 19.36, abs=0.5)
    assert right[0] == pytest.approx(0.75 * 19.36, abs=0.5)
    assert default_stations(FACADES["low"])[0][1] == -8.0


@pytest.mark.parametrize("name", FACADES)
@pytest.mark.parametrize("seed", [0, 7])
def test_street_hides_wall_but_leaves_each_jamb_and_head(name, seed):
    facade = FACADES[name]
    options = ScannerOptions(
        angular_step=step_for_spacing(facade, 0.04), range_noise=0.0, mixed_pixels=0.0, seed=seed
    )
    scene = street_scene(facade, seed=seed)
    assert len(scene.objects) >= 2
    seen = simulate_scan(facade, options=options, scene=scene).points
    xz = seen[np.abs(seen[:, 1]) < 1e-6][:, [0, 2]]
    bare = len(simulate_scan(facade, options=options, scene=Scene.empty()))
    assert 0.01 < 1.0 - len(xz) / bare < 0.25
    tree = cKDTree(xz)
    for opening in facade.openings:
        edges = np.vstack([opening.outline[1:], opening.outline[:1]])  # right jamb, head, left jamb
        for start, end in pairwise(edges):
            along = start + np.linspace(0.0, 1.0, 50)[:, None] * (end - start)
            # Where the wall is in sight there are points within two or three spacings of the edge.
            assert (tree.query(along)[0] < 0.1).mean() > 0.5


def test_street_is_the_same_for_a_seed():
    facade = FACADES["small"]
    assert street_scene(facade, seed=3) == street_scene(facade, seed=3)
    assert street_scene(facade, seed=3) != street_scene(facade, seed=4)


def test_street_leaves_room_for_the_stations():
    facade = FACADES["low"]
    for seed in range(3):
        close = ((2.4, -2.4, 1.2),)
        scene = street_scene(facade, seed=seed, stations=close)
        assert not any(body.contains(close[0]) for body in scene.bodies)


def test_neighbours_stand_apart_from_the_wall():
    left, right = street_scene(FACADES["small"]).neighbours
    assert sorted([left.face, right.face]) == [-0.25, 0.3]
    assert (left.end, right.start) == (0.0, 4.9)
    assert left.height != right.height
