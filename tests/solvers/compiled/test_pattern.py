"""The fixed pattern and what is added up on it, against scipy.sparse."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array

from solvers.compiled.pattern import build_pattern, whole
from solvers.compiled.stiffness import Sums, add_elements


@st.composite
def _systems(draw):
    """Random elements of 2 to 4 nodes, with random symmetric matrices, forces and supports."""
    points = draw(st.integers(4, 12))
    nodes = draw(st.integers(2, 4))
    element = st.lists(st.integers(0, points - 1), min_size=nodes, max_size=nodes, unique=True)
    connectivity = np.array(draw(st.lists(element, min_size=1, max_size=8)), dtype=np.intp)
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    blockwise = draw(st.booleans())
    prescribed = rng.random((points, 3)) < 0.3
    if blockwise:
        prescribed[:] = prescribed[:, :1]
    # A point of no element has no row in either assembly.
    prescribed[np.setdiff1d(np.arange(points), connectivity)] = True
    prescribed = prescribed.ravel()
    if prescribed.all():
        prescribed[3 * connectivity[0, 0] : 3 * connectivity[0, 0] + 3] = False
    matrices = rng.normal(size=(len(connectivity), 3 * nodes, 3 * nodes))
    return SimpleNamespace(
        points=points,
        connectivity=connectivity,
        prescribed=prescribed,
        matrices=matrices + matrices.transpose(0, 2, 1),
        forces=rng.normal(size=(len(connectivity), 3 * nodes)),
        imposed=np.where(prescribed, rng.normal(size=3 * points), 0.0),
    )


def _whole_by_scipy(system):
    dofs = (3 * system.connectivity[:, :, None] + np.arange(3)).reshape(len(system.connectivity), -1)
    rows = np.repeat(dofs, dofs.shape[1], axis=1).ravel()
    columns = np.tile(dofs, (1, dofs.shape[1])).ravel()
    size = 3 * system.points
    forces = np.bincount(dofs.ravel(), weights=system.forces.ravel(), minlength=size)
    return coo_array((system.matrices.ravel(), (rows, columns)), shape=(size, size)).toarray(), forces


@pytest.mark.parametrize("upper", [True, False])
@settings(max_examples=60, deadline=None)
@given(system=_systems())
def test_sums_are_scipys(upper, system):
    pattern = build_pattern(
        system.connectivity, points=system.points, prescribed=system.prescribed, upper=upper
    )
    sums = Sums(np.zeros(len(pattern.columns)), np.zeros(len(system.imposed)), np.zeros(len(system.imposed)))
    for part in (slice(0, 1), slice(1, None)):
        add_elements(
            system.matrices[part],
            system.forces[part],
            system.connectivity[part],
            pattern.rows,
            system.imposed,
            sums,
        )
    K, forces = _whole_by_scipy(system)
    free = ~system.prescribed
    expected = K[np.ix_(free, free)]
    assert pattern.unknowns == free.sum()
    assert np.array_equal(pattern.equation >= 0, free)
    assert np.allclose(pattern.matrix(sums.values).toarray(), np.triu(expected) if upper else expected)
    assert np.allclose(whole(pattern, sums.values).toarray(), expected)
    assert np.allclose(sums.values[pattern.diagonal], expected.diagonal())
    assert np.allclose(sums.forces, forces)
    assert np.allclose(sums.pull[free], (K @ system.imposed)[free])
    # PARDISO wants each row's columns in ascending order, the diagonal first in an upper triangle.
    for first, end in zip(pattern.starts[:-1], pattern.starts[1:], strict=True):
        assert (np.diff(pattern.columns[first:end]) > 0).all()


@pytest.mark.parametrize(("held", "block"), [([0, 1, 2], 3), ([0, 2], 1)])
def test_blocks_where_points_are_whole(held, block):
    prescribed = np.zeros(9, dtype=bool)
    prescribed[held] = True
    pattern = build_pattern(np.array([[0, 1], [1, 2]]), points=3, prescribed=prescribed, upper=True)
    matrix = whole(pattern, np.arange(1.0, len(pattern.columns) + 1))
    assert getattr(matrix, "blocksize", (1, 1)) == (block, block)
    assert np.array_equal(matrix.toarray(), matrix.toarray().T)
    assert matrix.has_sorted_indices


def test_everything_prescribed():
    pattern = build_pattern(np.array([[0, 1]]), points=2, prescribed=np.ones(6, dtype=bool), upper=True)
    assert pattern.unknowns == 0
    assert len(pattern.columns) == 0
