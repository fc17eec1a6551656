"""The command deck, carried out by a small interpreter of the six commands it uses."""

import numpy as np
import pytest

from fd2fem.model import VoxelModel, WallCells
from fd2fem.solids import solid_from_cells, solid_from_voxels, write_apdl


class Deck:
    """Keypoints, lines, areas and volumes as Mechanical APDL would number them in an empty data base."""

    def __init__(self, text):
        self.points, self.lines, self.areas, self.volumes = [], [], [], []
        self.chosen = {"LINE": set(), "AREA": set()}
        for line in text.splitlines():
            command, *fields = line.split(",")
            getattr(self, "do_" + command.strip("/").lower())(*fields)

    def do_k(self, number, *xyz):
        assert int(number) == len(self.points) + 1
        self.points.append([float(v) for v in xyz])

    def do_l(self, a, b):
        assert {int(a), int(b)} not in self.lines
        self.lines.append({int(a), int(b)})

    def do_a(self, *keypoints):
        ring = [int(k) for k in keypoints]
        sides = [{a, b} for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
        self.areas.append({self.lines.index(side) + 1 for side in sides})  # raises if A had to make a line

    def do_al(self, *lines):
        numbers = self.chosen["LINE"] if lines[0] == "ALL" else {abs(int(i)) for i in lines}
        assert len(lines) <= 10
        assert lines[0] != "ALL" or abs(int(lines[1])) in numbers
        self.areas.append(set(numbers))

    def do_va(self, *areas):
        assert len(areas) <= 10
        self.volumes.append(set(self.chosen["AREA"]) if areas[0] == "ALL" else {int(i) for i in areas})

    def do_lsel(self, mode, item="LINE", _="", number=""):
        self.select(mode, item, number)

    def do_asel(self, mode, item="AREA", _="", number=""):
        self.select(mode, item, number)

    def select(self, mode, item, number):
        if mode in {"S", "ALL"}:
            self.chosen[item] = set()
        if mode != "ALL":
            self.chosen[item].add(int(number))

    def do_allsel(self, *_):
        self.chosen = {"LINE": set(), "AREA": set()}

    def ignore(self, *_):
        pass

    do_com = do_finish = do_nopr = do_gopr = do_prep7 = do_csys = do_numstr = ignore


@pytest.mark.parametrize("neighbours", [1, 2, 6, 7, 8])
def test_deck_makes_the_solid_with_our_numbers(tmp_path, make_voxels, neighbours):
    """The more neighbours, the longer the big box's loops and shell: A, AL, and then selections."""
    boxes = [(0, 0, 2, neighbours), *((2, i, 3, i + 1) for i in range(neighbours))]
    solid = solid_from_voxels(make_voxels(boxes))
    write_apdl(solid, tmp_path / "deck.inp")
    text = (tmp_path / "deck.inp").read_text()
    deck = Deck(text)
    assert np.array(deck.points) == pytest.approx(solid.keypoints, abs=1e-15)
    assert deck.lines == [{a + 1, b + 1} for a, b in solid.lines.tolist()]
    assert deck.areas == [{abs(i) for i in loop} for loop in solid.areas]
    assert deck.volumes == [{abs(i) for i in areas} for areas in solid.volumes]
    assert ("AL,ALL" in text) == (neighbours > 7)
    assert ("VA,ALL" in text) == (neighbours > 5)
    assert "in metres" in text


def test_walls_with_windows(tmp_path, make_wall):
    solid = solid_from_voxels(make_wall(4.0, 3.0, [(1.1, 0.9, 2.3, 2.2)]))
    write_apdl(solid, tmp_path / "deck.inp")
    deck = Deck((tmp_path / "deck.inp").read_text())
    assert deck.areas == [{abs(i) for i in loop} for loop in solid.areas]
    assert len(deck.volumes) == len(solid.volumes)


def test_walls_of_varying_thickness_and_of_quadrilaterals(tmp_path):
    """Slabs share the areas between them; quadrilaterals are areas like any other."""
    voxels = VoxelModel([[0, 0], [2, 0], [2, 1]], [[2, 2], [3, 1], [3, 2]], [1, 1, 1], [0.5, 0.3, 0.2])
    corners = [[0, 0], [4, 0], [3, 2], [1, 2], [6, 0], [5, 2]]
    cells = WallCells(corners, [[0, 1, 2, 3], [1, 4, 5, 2]], [0.5, 0.4])
    for solid in (solid_from_voxels(voxels), solid_from_cells(cells)):
        write_apdl(solid, tmp_path / "deck.inp")
        deck = Deck((tmp_path / "deck.inp").read_text())
        assert np.array(deck.points) == pytest.approx(solid.keypoints, abs=1e-15)
        assert deck.areas == [{abs(i) for i in loop} for loop in solid.areas]
        assert deck.volumes == [{abs(i) for i in areas} for areas in solid.volumes]
