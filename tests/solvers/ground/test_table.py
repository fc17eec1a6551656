"""Tables of movements, and the text files that hold them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fd2fem.errors import InputError
from solvers.ground.settlement import LengthUnit, SettlementTable, base_displacement, read_settlement_table

EXPECTED = SettlementTable(x=(0.0, 2.5, 5.0), ux=(0.001, 0.0, -0.002), uz=(-0.01, -0.0125, -0.004))
FILES = {
    "commas": "x,ux,uz\n0,0.001,-0.01\n2.5,0,-0.0125\n5,-0.002,-0.004\n",
    "another order": "uz,x,uy,ux\n-0.01,0,0,1e-3\n-.0125,2.5,0,0\n-4E-3,5.,0,-2e-3\n",
    "semicolons": "x;uz;ux\n0;-0.01;0.001\n2.5;-0.0125;0\n5;-0.004;-0.002\n",
    "decimal commas": '"x";"ux";"uz"\n0;0,001;-0,01\n2,5;0;-0,0125\n5;-0,002;-0,004\n',
    "blanks": "  x   ux    uz\n0 0.001 -0.01\n2.5\t0\t-0.0125\n  5 -0.002 -0.004",
    "comments": "# cm\n\nx, ux, uz  # m\n0, .001, -.01\n#2, 0, 0\n2.5, 0, -.0125 # crack\n\n5,-.002,-.004",
    "byte order mark and carriage returns": (
        "\ufeffX,UX,UZ\r\n0,0.001,-0.01\r\n2.5,0,-0.0125\r\n5,-0.002,-0.004\r\n"
    ),
    "units": "x [m], ux [mm], uz(mm)\n0,1,-10\n2.5,0,-12.5\n5,-2,-4\n",
    "units and blanks": "x[mm] ux (m) uz [mm]\n0 0.001 -10\n2500 0 -12.5\n5000 -0.002 -4\n",
}


@pytest.mark.parametrize("text", FILES.values(), ids=FILES.keys())
def test_one_table_in_many_forms(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode())
    table = read_settlement_table(path)
    for name in ("x", "ux", "uy", "uz"):
        assert getattr(table, name) == pytest.approx(getattr(EXPECTED, name), rel=1e-15)


def test_unit_of_the_movements_but_not_of_the_positions(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("x,ux [m],uz\n0,0.001,-10\n2.5,0,-12.5\n5,-0.002,-4\n", encoding="utf-8")
    table = read_settlement_table(path, unit=LengthUnit.MILLIMETRE)
    assert table.x == EXPECTED.x
    assert table.ux == pytest.approx(EXPECTED.ux, rel=1e-15)
    assert table.uz == pytest.approx(EXPECTED.uz, rel=1e-15)


MOVE = st.floats(-0.5, 0.5)
ROWS = st.lists(
    st.tuples(st.floats(-1e3, 1e3), MOVE, MOVE, MOVE), min_size=2, max_size=9, unique_by=lambda r: r[0]
)


@settings(max_examples=40, deadline=None)
@given(rows=ROWS, order=st.permutations(range(4)), mark=st.sampled_from([",", ";", " ", "\t", " , "]))
def test_written_table_comes_back(tmp_path_factory, rows, order, mark):
    rows = sorted(rows)
    names = "x", "ux", "uy", "uz"
    lines = [mark.join(names[k] for k in order)] + [mark.join(repr(row[k]) for k in order) for row in rows]
    path = tmp_path_factory.mktemp("tables") / "table.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    assert read_settlement_table(path) == SettlementTable(**columns)


def test_linear_between_rows():
    table = SettlementTable(x=(0, 1, 4), ux=(0, 0.01, 0.01), uy=(0.002, 0, 0), uz=(-0.01, -0.03, 0))
    moved = base_displacement(table, [0.25, 1.0, 2.0, 4.0], extent=(0.0, 4.0))
    expected = [[0.0025, 0.0015, -0.015], [0.01, 0, -0.03], [0.01, 0, -0.02], [0.01, 0, 0]]
    assert np.allclose(moved, expected, rtol=0, atol=1e-16)


@pytest.mark.parametrize("extent", [(0.0, 5.0), (0.0, 5.01), (-0.01, 5.0)])
def test_table_may_miss_the_ends_of_a_scanned_wall(extent):
    table = SettlementTable(x=(1e-9, 5.0 - 1e-7), uz=(-0.01, -0.02))
    moved = base_displacement(table, extent, extent=extent)
    assert moved[:, 2].tolist() == [-0.01, -0.02]


@pytest.mark.parametrize("extent", [(0.0, 4.95), (-0.1, 4.0), (-1.0, 9.0)])
def test_table_must_cover_the_base(extent):
    table = SettlementTable(x=(0.0, 4.5), uz=(-0.01, -0.01))
    message = f"covers x = 0 to 4.5 m, but the wall's base runs from {extent[0]:.6g} to {extent[1]:.6g} m"
    with pytest.raises(InputError, match=message):
        base_displacement(table, [1.0], extent=extent)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"x": (0.0,), "uz": (0.0,)}, "at least 2 rows, got 1"),
        ({"x": (), "uz": ()}, "at least 2 rows, got 0"),
        ({"x": (0.0, 1.0, 1.0), "uz": (0.0,) * 3}, "must ascend, but row 3 has 1.0 m after 1.0 m"),
        ({"x": (1.0, 0.0), "uz": (0.0,) * 2}, "must ascend, but row 2 has 0.0 m after 1.0 m"),
        ({"x": (0.0, float("nan")), "uz": (0.0,) * 2}, "'x': 1 of 2 values are not finite"),
        ({"x": (0.0, 1.0), "uz": (0.0, float("inf"))}, "'uz': 1 of 2 values are not finite"),
        ({"x": (0.0, 1.0), "uz": (0.0,) * 3}, "'uz': 3 values for 2 positions"),
        ({"x": (0.0, 1.0), "uz": (0.0,) * 2, "uy": (0.1,)}, "'uy': 1 values for 2 positions"),
        ({"x": (0.0, 1.0), "uz": (0.0, -10.0)}, "'uz of row 2': -10.0 m is no settlement of a wall"),
    ],
)
def test_table_refuses(columns, message):
    with pytest.raises(InputError, match=message):
        SettlementTable(**columns)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"table\.csv is empty"),
        ("# x,uz\n", "is empty"),
        ("x,ux\n0,0\n1,0\n", "line 1: the settlement table has no column 'uz'"),
        ("x,u_z\n0,0\n1,0\n", "line 1: unknown or repeated column 'u_z'; expected x, ux, uy, uz"),
        ("x,uz,uz\n0,0,0\n1,0,0\n", "repeated column 'uz'"),
        ("x,uz [cm]\n0,0\n1,0\n", r"column 'uz\[cm\]'"),
        ("0,0.1\n1,0.1\n", "line 1: unknown or repeated column '0'"),
        ("x,uz\n0,0\n\n1\n", "line 4: 1 values, expected 2"),
        ("x,uz\n0,0\n1,abc\n", "line 3: could not convert string to float: 'abc'"),
        ("x,uz\n0,0\n1,\n", "line 3: could not convert"),
        ("x;uz\n0;1.000,5\n1;0\n", "line 2: could not convert"),
        ("x,uz\n0,0\n1,nan\n", "table.csv: Invalid 'uz': 1 of 2 values are not finite"),
        ("x,uz\n0,-44.5\n1,-17.8\n", "table.csv: Invalid 'uz of row 1': -44.5 m is no settlement"),
        ("x,uz\n0,0\n", "at least 2 rows, got 1"),
    ],
)
def test_file_refuses(tmp_path, text, message):
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        read_settlement_table(path)
    assert "\n" not in str(caught.value)


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(InputError, match=r"Cannot read the settlement table .*no\.csv: No such file"):
        read_settlement_table(tmp_path / "no.csv")
    (tmp_path / "table.xls").write_bytes(b"\xd0\xcf\x11\xe0")
    with pytest.raises(InputError, match="is not text in UTF-8"):
        read_settlement_table(tmp_path / "table.xls")


@settings(max_examples=100, deadline=None)
@given(text=st.text(alphabet='xuz,; \n\t0123456789.-e#"[]m\x00é', max_size=60))
def test_any_text_is_a_table_or_one_line(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("texts") / "table.csv"
    path.write_text("x,uz\n" + text, encoding="utf-8")
    try:
        rows = len(read_settlement_table(path).x)
    except InputError as error:
        rows, message = 2, str(error)
    else:
        message = ""
    assert rows >= 2
    assert "\n" not in message
