"""An analysis that was killed goes on from its last step, and ends where it would have ended."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from fd2fem.errors import InputError
from fd2fem.model import ElementKind, VolumeMesh
from solvers import AnalysisOptions, LinearSettlement, MasonryLaw, SteppingOptions
from solvers.steps.masonry_analysis import analyse_steps, prepare, snapshots

OPTIONS = AnalysisOptions(
    masonry=MasonryLaw(), settlement=LinearSettlement(0, 0, -0.001, 0.002), stepping=SteppingOptions(steps=10)
)

SCRIPT = """
import json, sys, time
from pathlib import Path
from test_restart import OPTIONS, small_wall
from solvers.steps.masonry_analysis import analyse_steps

state, pause, result = Path(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3])
found = analyse_steps(small_wall(), options=OPTIONS, state=state, on_step=lambda _: time.sleep(pause))
result.write_text(json.dumps([found.displacement.tolist(), [dict(step) for step in found.history]]))
"""


def small_wall():
    """Hexahedra of 0.25 m, eight by one by four."""
    shape = 9, 2, 5
    number = np.arange(np.prod(shape)).reshape(shape)
    low, high = slice(None, -1), slice(1, None)
    corners = [
        number[a, b, c] for c in (low, high) for a, b in ((low, low), (high, low), (high, high), (low, high))
    ]
    elements = np.stack(corners, axis=-1).reshape(-1, 8)
    nodes = 0.25 * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    base = elements[(nodes[elements[:, :4], 2] == 0.0).all(axis=1)][:, [0, 3, 2, 1]]
    return VolumeMesh(nodes, elements, ElementKind.HEXAHEDRON, {"base": base})


@pytest.fixture(scope="module")
def wall():
    return small_wall()


@pytest.fixture(scope="module")
def whole(wall):
    return analyse_steps(wall, options=OPTIONS)


def _stop_after(wall, count, state):
    """Leave an analysis after some steps, as if the machine had gone down."""
    for snapshot in snapshots(prepare(wall, options=OPTIONS), state=state):
        if len(snapshot.history) == count:
            return


def _same(ours, theirs):
    assert np.array_equal(ours.displacement, theirs.displacement)
    assert np.array_equal(ours.stress, theirs.stress)
    assert np.array_equal(ours.crack_opening, theirs.crack_opening)
    assert [dict(step) for step in ours.history] == [dict(step) for step in theirs.history]


@pytest.mark.parametrize("count", [1, 6])
def test_the_answer_is_the_same_to_the_last_digit(wall, whole, tmp_path, count):
    state = tmp_path / "deep" / ".state.npz"
    _stop_after(wall, count, state)
    assert whole.dissipated_energy > 1.0
    _same(analyse_steps(wall, options=OPTIONS, state=state), whole)
    # Once more, from the end.
    _same(analyse_steps(wall, options=OPTIONS, state=state), whole)
    assert [path.name for path in state.parent.iterdir()] == [".state.npz"]


def _start(state, pause, result):
    """The analysis in a process of its own."""
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(state), str(pause), str(result)],
        env=os.environ | {"PYTHONPATH": paths},
    )


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on(tmp_path):
    # All runs are in processes of their own: what else has been loaded into one may change the order in which
    # the direct solver's threads add, and cracks magnify rounding.
    assert _start(tmp_path / "unbroken.npz", 0.0, tmp_path / "unbroken.json").wait() == 0
    state = tmp_path / ".state.npz"
    for _ in range(2):
        before = state.stat().st_mtime_ns if state.exists() else 0
        process = _start(state, 0.3, tmp_path / "killed.json")
        while process.poll() is None and (not state.exists() or state.stat().st_mtime_ns == before):
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert not (tmp_path / "killed.json").exists()
    assert _start(state, 0.0, tmp_path / "resumed.json").wait() == 0
    assert (tmp_path / "resumed.json").read_text() == (tmp_path / "unbroken.json").read_text()


@pytest.mark.parametrize(
    "change",
    [
        {"masonry": MasonryLaw(fracture_energy=50.0)},
        {"settlement": LinearSettlement(0, 0, -0.001, 0.001)},
        {"stepping": SteppingOptions(steps=20)},
        {"gravity": 9.8},
    ],
    ids=lambda change: next(iter(change)),
)
def test_the_state_of_another_analysis_is_refused(wall, tmp_path, change):
    state = tmp_path / ".state.npz"
    _stop_after(wall, 1, state)
    with pytest.raises(InputError, match="another mesh or other options"):
        analyse_steps(wall, options=dataclasses.replace(OPTIONS, **change), state=state)


def test_the_state_of_another_mesh_is_refused(wall, tmp_path):
    state = tmp_path / ".state.npz"
    _stop_after(wall, 1, state)
    nodes = wall.nodes.copy()
    nodes[-1, 0] += 1e-9
    with pytest.raises(InputError, match="another mesh"):
        analyse_steps(VolumeMesh(nodes, wall.elements, wall.kind, wall.groups), options=OPTIONS, state=state)


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut short"])
def test_a_damaged_state_is_refused(wall, tmp_path, content):
    state = tmp_path / ".state.npz"
    state.write_bytes(content)
    with pytest.raises(InputError, match="remove it to begin anew"):
        analyse_steps(wall, options=OPTIONS, state=state)
