"""What makes a neutral file sound, checked on its text with no code of the package.

The rules are those that every public file written by ANSYS itself obeys: clamped knots, curves from keypoint
to keypoint, loops closed head to tail and right-handed about their surface's normal, a sign for each area of
a volume that makes this normal point outwards; and those of a conformal model: an area bounds one volume, or
two with opposite signs, and no keypoint lies on another one or inside a line.
"""

import re
from collections import Counter, defaultdict
from dataclasses import dataclass
from math import comb

import numpy as np


@dataclass
class Sound:
    """What a sound file holds."""

    keypoints: int
    lines: int
    areas: int
    volumes: list[float]
    outer_surface: float


def records(text):
    """Command, fields and numbers of each record, split by a regular expression."""
    body = text.split("/aux15\n")[1].split("finish")[0]
    for part in re.split(r"^(?=kpt|lcurv|asurf|vbody)", body, flags=re.MULTILINE)[1:]:
        head, _, *data = part.splitlines()
        command, *fields = head.split(",")
        yield command, [float(f) for f in fields], [float(w) for line in data for w in line.split()]


def check_anf(text):
    """Assert that a text is a sound neutral file with one solid."""
    tables = {"kpt": {}, "lcurv": {}, "asurf": {}, "vbody": {}}
    for command, fields, data in records(text):
        number = int(fields[0])
        assert number not in tables[command], f"{command} {number} twice"
        tables[command][number] = (fields[1:], data)
    announced = re.search(r"keypoints (\d+)  lines (\d+)  areas (\d+)  volumes (\d+)", text)
    assert [int(n) for n in announced.groups()] == [len(table) for table in tables.values()]
    points = {number: np.array(xyz) for number, (xyz, _) in tables["kpt"].items()}
    size = np.ptp(np.array(list(points.values())), axis=0).max()
    ends = check_lines(tables["lcurv"], points, size)
    check_apart(points, ends, size)
    loops, vectors, moments = check_areas(tables["asurf"], ends, points, size)
    volumes, outer = check_volumes(tables["vbody"], loops, vectors, moments)
    assert {abs(e) for loop in loops.values() for e in loop} == set(ends), "lines that bound no area"
    assert {k for pair in ends.values() for k in pair} == set(points), "keypoints that end no line"
    return Sound(len(points), len(ends), len(loops), volumes, outer)


def check_knots(knots, order):
    assert knots == [knots[0]] * order + [knots[-1]] * order
    assert knots[0] < knots[-1]


def check_lines(table, points, size):
    """Ends of each line; asserts a straight curve between them, and no line twice."""
    ends = {}
    for number, ((kind, start, end, low, high), data) in table.items():
        _, order, rational, knots, count = map(int, data[:5])
        assert (kind, rational, knots, count) == (1, 0, 2 * order, order)
        assert len(data) == 5 + knots + 3 * count
        check_knots(data[5 : 5 + knots], order)
        assert (low, high) == (data[5], data[4 + knots])
        control = np.reshape(data[5 + knots :], (count, 3))
        a, b = points[int(start)], points[int(end)]
        t = np.linspace(0.0, 1.0, count)[:, None]
        assert np.abs(control - (a + (b - a) * t)).max() <= 1e-12 * size, "a curve leaves its keypoints"
        ends[number] = (int(start), int(end))
    assert len({frozenset(pair) for pair in ends.values()}) == len(ends), "two lines of the same ends"
    return ends


def check_apart(points, ends, size):
    """No keypoint on another one, or inside a line."""
    xyz = np.array(list(points.values()))
    place = {number: index for index, number in enumerate(points)}
    between = np.linalg.norm(xyz[:, None] - xyz, axis=2) + np.eye(len(xyz)) * size
    assert between.min() > 1e-8 * size, "keypoints coincide"
    a, b = (xyz[[place[pair[k]] for pair in ends.values()]] for k in (0, 1))
    length = np.linalg.norm(b - a, axis=1)
    to_a, to_b = (np.linalg.norm(xyz[:, None] - end, axis=2) for end in (a, b))
    inside = (to_a + to_b < length * (1 + 1e-12)) & (to_a > 1e-9 * size) & (to_b > 1e-9 * size)
    assert not inside.any(), "a keypoint lies inside a line"


def check_areas(table, ends, points, size):
    """Loop, vector (integral of the normal) and moment (of S·normal) of each area."""
    loops, vectors, moments = {}, {}, {}
    for number, ((kind, count, longest, *span), data) in table.items():
        assert (kind, count, data[0], data[1]) == (1, 1, 0, longest)
        loop = [int(line) for line in data[2 : 2 + int(longest)]]
        order = check_surface(data[2 + len(loop) :], span)
        net = np.reshape(data[10 + len(loop) + 4 * order :][: 3 * order**2], (order, order, 3))  # u fastest
        walk = [ends[line] if line > 0 else ends[-line][::-1] for line in loop]
        assert all(a[1] == b[0] for a, b in zip(walk, walk[1:] + walk[:1], strict=True)), "a loop is open"
        ring = np.array([points[a] for a, _ in walk])
        vector = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) / 2.0
        S, N, weight = surface_at(net)
        assert (N @ vector > 0).all(), "a loop runs against its surface, or the surface folds"
        assert np.abs(weight @ N - vector).max() <= 1e-10 * size**2, "loop and surface differ"
        normal = vector / np.linalg.norm(vector)
        both = np.vstack([ring, net.reshape(-1, 3)])
        assert np.ptp(both @ normal) <= 1e-12 * size, "an area is not plane"
        for corner in net[[0, 0, -1, -1], [0, -1, -1, 0]]:
            assert np.abs(ring - corner).max(axis=1).min() <= 1e-12 * size
        loops[number], vectors[number] = loop, vector
        moments[number] = weight @ np.einsum("ij,ij->i", S, N)
    assert len({frozenset(map(abs, loop)) for loop in loops.values()}) == len(loops), "an area twice"
    return loops, vectors, moments


def check_surface(data, span):
    """Order of a surface of one span."""
    form, order, order_v, rational, *counts = map(int, data[:8])
    assert (form, order_v, counts) == (0, order, [2 * order, 2 * order, order, order])
    knots = data[8 : 8 + 4 * order]
    check_knots(knots[: 2 * order], order)
    check_knots(knots[2 * order :], order)
    assert span == [0.0, 1.0, 0.0, 1.0]
    weights = data[8 + 4 * order + 3 * order**2 :]
    assert weights == ([1.0] * order**2 if rational else [])
    return order


def surface_at(net):
    """Points, normals and weights of 3 x 3 Gauss points of a Bézier surface."""
    t, w = np.polynomial.legendre.leggauss(3)
    t, w = (t + 1) / 2, w / 2
    n = len(net) - 1
    B = np.array([comb(n, i) * t**i * (1 - t) ** (n - i) for i in range(n + 1)])
    low = np.array([comb(n - 1, i) * t**i * (1 - t) ** (n - 1 - i) for i in range(n)]) * n
    S = np.einsum("jb,ia,jik->bak", B, B, net).reshape(-1, 3)
    Su = np.einsum("jb,ia,jik->bak", B, low, np.diff(net, axis=1)).reshape(-1, 3)
    Sv = np.einsum("jb,ia,jik->bak", low, B, np.diff(net, axis=0)).reshape(-1, 3)
    return S, np.cross(Su, Sv), np.outer(w, w).ravel()


def check_volumes(table, loops, vectors, moments):
    """Volume of each volume, and the surface of all that bounds only one."""
    users = defaultdict(list)
    volumes = []
    for (shells, most), data in table.values():
        assert (shells, data[0], data[1]) == (1, 0, most)
        areas = [int(area) for area in data[2:]]
        assert len(areas) == most == len({abs(area) for area in areas})
        lines = Counter()
        for area in areas:
            users[abs(area)].append(np.sign(area))
            lines.update((line if area > 0 else -line) for line in loops[abs(area)])
        assert set(lines.values()) == {1}, "a line is walked twice in one sense"
        assert all(-line in lines for line in lines), "a volume is open"
        volumes.append(sum(np.sign(area) * moments[abs(area)] for area in areas) / 3.0)
    assert min(volumes) > 0.0, "a volume is inside out"
    assert set(users) == set(loops), "an area bounds no volume"
    assert all(signs in ([1], [1, -1]) for signs in users.values()), "signs of a shared area"
    outer = sum(np.linalg.norm(vectors[area]) for area, signs in users.items() if len(signs) == 1)
    closed = sum(vectors[area] for area, signs in users.items() if len(signs) == 1)
    assert np.abs(closed).max() <= 1e-9 * outer, "the outer surface is open"
    return volumes, float(outer)
