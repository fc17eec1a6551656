import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fd2fem.meshing import text_rows
from fd2fem.meshing.text_rows import write_list, write_rows

INTEGERS = st.lists(st.integers(-(10**9), 10**9), max_size=40)


@given(INTEGERS, st.integers(1, 17))
def test_a_list_reads_back(numbers, per_line):
    stream = io.StringIO()
    write_list(stream, "%d", np.array(numbers, dtype=int), per_line=per_line, between=", ")
    lines = [[int(field) for field in line.split(",")] for line in stream.getvalue().splitlines()]
    assert [number for line in lines for number in line] == numbers
    assert all(len(line) == per_line for line in lines[:-1])
    assert not lines or 1 <= len(lines[-1]) <= per_line


@pytest.mark.parametrize("count", [0, 1, 6, 7, 8, 21, 22])
def test_parts_join(monkeypatch, count):
    monkeypatch.setattr(text_rows, "AT_ONCE", 7)
    table = np.random.default_rng(count).normal(size=(count, 3))
    stream = io.StringIO()
    write_rows(stream, "%.17g %.17g %.17g\n", table)
    back = [[float(field) for field in line.split()] for line in stream.getvalue().splitlines()]
    assert back == table.tolist()
