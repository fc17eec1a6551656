"""The settlement deck, read by a small interpreter of APDL: structure, names, tables, constants."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from fd2fem.model import LoadCase, VoxelModel
from fd2fem.solids import SolidOptions, Strength, solid_from_voxels, write_settlement_deck

# Every command the deck may use, after the public command reference, with the processors that know it.
ANYWHERE = {
    "FINISH", "/CLEAR", "/FILNAME", "/TITLE", "/UNITS", "/INPUT", "/PREP7", "/SOLU", "/POST1", "ALLSEL",
    "NSEL", "CM", "CMSEL", "*GET", "*IF", "*ELSE", "*ENDIF", "*DO", "*ENDDO", "*MSG", "*AFUN", "*DIM",
}  # fmt: skip
WITHIN = {
    "/PREP7": {
        "VSUM", "MP", "ET", "KEYOPT", "R", "TB", "TBDATA", "VATT", "ESIZE", "MSHAPE", "MSHKEY", "EXTOPT",
        "VSWEEP", "NUMCMP",
    },
    "/SOLU": {
        "ANTYPE", "NLGEOM", "NROPT", "AUTOTS", "OUTRES", "ACEL", "D", "KBC", "TIME", "NSUBST", "SOLVE",
    },
    "/POST1": {"SET", "NSORT", "PLCRACK", "PLNSOL"},
    None: set(),
}  # fmt: skip
FUNCTIONS = {"ABS", "SIN", "COS", "NDNEXT"}


class Deck:
    """What a deck does with a given MODEL."""

    def __init__(self, text, model):
        self.parameters, self.tables, self.components, self.log = {}, {}, set(), []
        self.model, self.degrees, self.processor, self.open = model, False, None, []
        lines = iter(text.splitlines())
        for line in lines:
            command = line.split("!")[0].rstrip()
            if not command.strip():
                continue
            assert len(line) <= 120
            if "=" in command and re.match(r"\s*[A-Z]\w*(\([\d,]+\))?=", command):
                self.assign(command.strip())
            else:
                name, *fields = command.strip().split(",")
                assert name in ANYWHERE | WITHIN[self.processor], f"{name} in {self.processor}"
                if name == "*MSG":
                    fields.append(next(lines))
                self.run(name, fields)
        assert self.open == []

    @property
    def live(self):
        return all(taken for _, taken in self.open)

    def number(self, text):
        """The value of an expression; every name in it must be known."""
        names = set(re.findall(r"(?<![\w.])[A-Z]\w*", text))
        assert names <= FUNCTIONS | set(self.parameters), f"{text}: {names} of {sorted(self.parameters)}"
        turn = math.pi / 180 if self.degrees else 1.0
        known = {
            "ABS": abs,
            "NDNEXT": lambda n: n + 1,
            "SIN": lambda a: math.sin(a * turn),
            "COS": lambda a: math.cos(a * turn),
        }
        return eval(text, {"__builtins__": {}}, known | self.parameters)

    def assign(self, command):
        name, value = command.split("=")
        if "(" in name:
            table, place = re.fullmatch(r"(\w+)\(([\d,]+)\)", name).groups()
            index = tuple(int(i) for i in place.split(","))
            assert np.isnan(self.tables[table][index]), f"{name} twice"
            self.tables[table][index] = float(value)
        else:
            result = self.model if name == "MODEL" else self.number(value)
            if self.live:
                self.parameters[name] = result

    def run(self, name, fields):
        handler = getattr(self, "do_" + name.strip("/*").lower(), None)
        if handler is not None:
            handler(*fields)
        if self.live:
            self.log.append((name, fields))

    def do_if(self, a, relation, b, then):
        assert then == "THEN"
        assert relation in {"EQ", "NE", "GT"}
        left, right = self.number(a), self.number(b)
        self.open.append(("IF", {"EQ": left == right, "NE": left != right, "GT": left > right}[relation]))

    def do_else(self):
        kind, taken = self.open.pop()
        assert kind == "IF"
        self.open.append(("IF", not taken))

    def do_endif(self):
        assert self.open.pop()[0] == "IF"

    def do_do(self, name, first, last):
        self.number(first), self.number(last)
        self.parameters[name] = self.number(first)
        self.open.append(("DO", True))

    def do_enddo(self):
        assert self.open.pop()[0] == "DO"

    def do_get(self, name, *_):
        self.parameters[name] = {"NVOLGOT": self.volumes, "VOLGOT": self.parameters.get("VOLEXP")}.get(
            name, 1.0
        )

    volumes = 2

    def do_msg(self, kind, *fields):
        *values, text = fields
        assert kind in {"INFO", "ERROR"}
        assert len(re.findall("%[IG]", text)) == len(values)
        for value in values:
            self.number(value)

    def do_afun(self, unit):
        self.degrees = unit == "DEG"

    def do_dim(self, name, kind, rows, columns, planes, *variables):
        assert kind == "TABLE"
        if variables == ("X", "TIME"):
            assert planes == "1"
            shape = (int(rows) + 1, int(columns) + 1)
        else:
            assert variables == ("X", "Y", "TIME")
            shape = (int(rows) + 1, int(columns) + 1, int(planes) + 1)
        self.tables[name] = np.full(shape, np.nan)

    def do_cm(self, name, kind):
        assert kind == "NODE"
        self.components.add(name)

    def do_cmsel(self, mode, name):
        assert mode == "S"
        assert name in self.components

    def do_prep7(self):
        self.processor = "/PREP7"

    def do_solu(self):
        self.processor = "/SOLU"

    def do_post1(self):
        self.processor = "/POST1"

    def do_finish(self):
        self.processor = None

    def taken(self, name):
        return [fields for command, fields in self.log if command == name]


WALL = solid_from_voxels(VoxelModel([[0, 0], [0, 3]], [[4, 3], [4, 5]], [1, 1], [0.5, 0.3]))


def trough(points):
    """A Gaussian trough at x = 1, with movement towards it."""
    sunk = 0.02 * np.exp(-((points[:, 0] - 1.0) ** 2) / (2 * 1.5**2))
    return np.column_stack([-sunk * (points[:, 0] - 1.0) / 10, np.zeros(len(points)), -sunk])


def case_of(base=trough, **values):
    return LoadCase(
        **{"young": 3.48e9, "poisson": 0.16, "density": 1900.0, "gravity": 9.81, "base": base} | values
    )


def written(folder, case, strength=None, solid=WALL):
    write_settlement_deck(folder / "deck.inp", case, solid, strength=strength or Strength())
    return (folder / "deck.inp").read_text(encoding="ascii")


@pytest.fixture(params=[0, 1, 2, 3])
def deck(request, tmp_path):
    return Deck(written(tmp_path, case_of()), request.param)


def test_every_model_has_its_element_and_material(deck):
    element = "SOLID65" if deck.model == 3 else "SOLID185"
    assert deck.taken("ET") == [["1", element]]
    kinds = [fields[0] + "".join(fields[4:]) for fields in deck.taken("TB")]
    assert (
        kinds
        == {0: [], 1: ["EDPLYFUN", "EDPLFPOT"], 2: ["CONCRMW", "CONCRDILA", "CONCRHSD6"], 3: ["CONCR", "DP"]}[
            deck.model
        ]
    )
    assert [deck.number(fields[2]) for fields in deck.taken("MP")] == [3.48e9, 0.16, 1900.0]
    assert deck.taken("VATT") == [["1", "REALN", "1"]]
    assert deck.parameters["REALN"] == (deck.model == 3)
    assert len(deck.taken("PLCRACK")) == (deck.model == 3)


def test_weight_comes_first_and_the_base_moves_in_the_second_step(deck):
    order = [name for name, _ in deck.log if name in {"ACEL", "D", "TIME", "SOLVE"}]
    assert order == ["ACEL", "D", "D", "D", "TIME", "SOLVE", "TIME", "SOLVE"]
    assert [deck.number(value) for value in deck.taken("ACEL")[0]] == [0, 0, 9.81]
    assert deck.taken("TIME") == [["1"], ["2"]]
    for direction, (nodes, freedom, table) in zip("XYZ", deck.taken("D"), strict=True):
        assert (nodes, freedom) == ("ALL", f"U{direction}")
        assert table.strip("%") in deck.tables
    solving = [name for name, _ in deck.log]
    assert solving[solving.index("D") - 1] == "CMSEL"  # the base, and nothing else, is held


def test_tables_hold_the_movement_of_the_base(deck):
    assert list(deck.tables) == ["UXBASE", "UYBASE", "UZBASE"]
    for direction, table in enumerate(deck.tables.values()):
        assert table[0, 1:].tolist() == [0, 1, 2]
        x, rest, still, moved = table[1:].T
        assert (x[0], x[-1]) == (0.0, 4.0)
        assert (np.diff(x) > 0).all()
        assert not np.isnan(table.ravel()[1:]).any()
        assert not rest.any()
        assert not still.any()
        assert moved.tolist() == trough(np.column_stack([x, 0 * x, 0 * x]))[:, direction].tolist()
        between = np.linspace(0, 4, 1001)
        true = trough(np.column_stack([between, 0 * between, 0 * between]))[:, direction]
        assert np.abs(np.interp(between, x, moved) - true).max() < 1.5e-6


def test_geometry_is_the_neutral_file_and_is_checked(deck):
    assert deck.taken("/INPUT") == [["facade", "anf"]]
    assert deck.parameters["VOLEXP"] == pytest.approx(4 * (3 * 0.5 + 2 * 0.3), rel=1e-14)
    assert deck.parameters["H"] == pytest.approx(0.15)


@pytest.mark.parametrize(("volumes", "complaints"), [(3, 0), (2, 1)])
def test_a_lost_volume_is_noticed(tmp_path, monkeypatch, volumes, complaints):
    monkeypatch.setattr(Deck, "volumes", volumes)
    deck = Deck(written(tmp_path, case_of()), 1)
    assert len([fields for fields in deck.taken("*MSG") if fields[0] == "ERROR"]) == complaints


def test_drucker_prager_meets_mohr_coulomb_in_compression(tmp_path):
    """With σ1 = -f alone, q = f and the mean stress -f/3: f = 2 c cos φ / (1 - sin φ)."""
    deck = Deck(written(tmp_path, case_of()), 1)
    deck.degrees = True
    (alpha, yielding), (potential,) = (
        [deck.number(v) for v in fields[1:]] for fields in deck.taken("TBDATA")
    )
    phi, psi = math.radians(35.0), math.radians(10.0)
    assert yielding / (1 - alpha / 3) == pytest.approx(
        2 * 6.81e6 * math.cos(phi) / (1 - math.sin(phi)), rel=1e-12
    )
    assert yielding / (1 - alpha / 3) == pytest.approx(26.1638e6, rel=1e-5)
    assert alpha == pytest.approx(3 * math.sqrt(3) * 0.272957, rel=1e-5)  # α of α I1 + √J2 = k
    assert potential == pytest.approx(6 * math.sin(psi) / (3 - math.sin(psi)), rel=1e-12)


def test_concretes_get_the_strengths(tmp_path):
    strength = Strength(cohesion=1e6, friction=30.0, dilatancy=5.0, tension=2e5, compression=4e6)
    text = written(tmp_path, case_of(), strength)
    willam, relaxed, drucker = ([*fields[1:]] for fields in Deck(text, 3).taken("TBDATA"))
    deck = Deck(text, 3)
    assert [deck.number(v) for v in willam] == [0.3, 0.9, 2e5, -1]
    assert relaxed == ["0.6"]
    assert [deck.number(v) for v in drucker] == [1e6, 30.0, 5.0]
    menetrey, dilatancy, _ = Deck(text, 2).taken("TBDATA")
    assert [deck.number(v) for v in menetrey[1:]] == pytest.approx([4e6, 2e5, 4.8e6])
    assert deck.number(dilatancy[1]) == 5.0


def test_reactions_of_both_steps_are_set_against_the_weight(deck):
    assert deck.parameters["WEIGHT"] == pytest.approx(1900.0 * 9.81 * deck.parameters["VOLGOT"])
    told = [fields for fields in deck.taken("*MSG") if fields[0] == "INFO"]
    assert [fields[1:-1] for fields in told] == [["NSTEP", "UMAX", "S1MAX"], ["FZSUM", "WEIGHT"]]


def test_header_says_for_every_part_that_it_was_never_run(tmp_path):
    header = written(tmp_path, case_of()).split("FINISH")[0]
    assert "NOTHING IN THIS DECK HAS EVER BEEN RUN IN ANSYS" in header
    for part in (
        "neutral file",
        "command deck",
        "elastic",
        "EDP",
        "concrete",
        "SOLID65",
        "mesh",
        "tables",
        "solution",
    ):
        assert re.search(rf"^! {part}.*never$", header, re.MULTILINE), part
    assert all(line.startswith("!") for line in header.splitlines())


def test_straight_movement_needs_few_points_and_wild_one_is_cut_off(tmp_path):
    straight = case_of(lambda p: np.outer(0.01 - 0.002 * p[:, 0], [1.0, 0.0, -1.0]))
    assert len(Deck(written(tmp_path, straight), 1).tables["UZBASE"]) == 1 + 17
    wild = case_of(lambda p: np.outer(np.sin(500 * p[:, 0]), [0.0, 0.0, 0.01]))
    assert len(Deck(written(tmp_path, wild), 1).tables["UZBASE"]) == 1 + 513


@pytest.mark.parametrize(("bend", "across"), [(0.0, 2), (0.02, 9), (1e-4, 5), (5e-5, 3)])
def test_movement_that_varies_through_the_wall_has_a_table_over_y_too(tmp_path, bend, across):
    def skew(points):
        return np.outer(
            points[:, 0] * 1e-3 + points[:, 1] * 2e-3 + bend * points[:, 1] ** 2, [1.0, 0.5, -1.0]
        )

    tables = Deck(written(tmp_path, case_of(skew)), 2).tables
    assert [table.shape for table in tables.values()] == [(1 + 17, 1 + across, 1 + 3)] * 3
    for direction, table in enumerate(tables.values()):
        assert table[0, 0, 1:].tolist() == [0, 1, 2]
        x, y = table[1:, 0, 1], table[0, 1:, 1]
        assert (x[0], x[-1], y[0], y[-1]) == (0, 4, 0, 0.5)
        for plane in (2, 3):
            assert table[1:, 0, plane].tolist() == x.tolist()
            assert table[0, 1:, plane].tolist() == y.tolist()
        assert not table[1:, 1:, 1:3].any()
        points = np.array([[a, b, 0.0] for a in x for b in y])
        assert table[1:, 1:, 3].ravel().tolist() == skew(points)[:, direction].tolist()


@settings(max_examples=20, deadline=None)
@given(
    left=st.floats(-5.0, 5.0),
    length=st.floats(0.5, 40.0),
    ends=st.lists(st.floats(-0.1, 0.1), min_size=2, max_size=2),
)
def test_base_may_lie_anywhere(tmp_path_factory, left, length, ends):
    solid = solid_from_voxels(VoxelModel([[left, 0]], [[left + length, 3]], [1], 0.4))
    case = case_of(lambda p: np.outer(np.interp(p[:, 0], [left, left + length], ends), [0, 0, 1.0]))
    table = Deck(written(tmp_path_factory.mktemp("deck"), case, solid=solid), 1).tables["UZBASE"]
    assert table[1, 0] == pytest.approx(left, abs=1e-12)
    assert table[-1, 0] == pytest.approx(left + length, abs=1e-12)
    assert table[[1, -1], 3] == pytest.approx(ends, abs=1e-12)


@pytest.mark.parametrize(
    ("base", "match"),
    [
        (lambda p: np.full((len(p), 3), np.nan), "three finite numbers"),
        (lambda p: np.zeros((len(p), 2)), "three finite numbers"),
    ],
)
def test_movements_that_no_table_holds(tmp_path, base, match):
    with pytest.raises(InputError, match=match) as caught:
        written(tmp_path, case_of(base))
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({"cohesion": 0.0}, "Invalid 'cohesion'"),
        ({"tension": -1.0}, "Invalid 'tension'"),
        ({"compression": math.nan}, "Invalid 'compression'"),
        ({"friction": 90.0}, "Invalid angles"),
        ({"dilatancy": 40.0}, "Invalid angles"),
        ({"dilatancy": -1.0}, "Invalid angles"),
    ],
)
def test_strengths_are_checked(values, match):
    with pytest.raises(InputError, match=match):
        Strength(**values)


def test_strength_is_the_papers():
    assert SolidOptions().strength == Strength(6.81e6, 35.0, 10.0, 1.15e6, 26.15e6)
