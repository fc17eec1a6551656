"""The state of a long analysis on disk, so that it goes on from its last step when it was stopped."""

import hashlib
import json
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fd2fem.errors import InputError
from solvers.compiled.cracking import Motion, PointFields
from solvers.options import AnalysisOptions
from solvers.steps.course import Course
from solvers.steps.stepping import LoadStep, Snapshot
from solvers.steps.wall_model import WallModel

__all__ = ["fingerprint", "read_state", "write_state"]

FORMAT = "fd2fem/state-2"


def fingerprint(model: WallModel, settled: NDArray[np.float64], options: AnalysisOptions) -> str:
    """Digest of all that an analysis depends on: mesh, ground, law and steps.

    Parameters
    ----------
    model : WallModel
    settled : (k, 3) float array, m
        Displacement of the base when the whole settlement is applied.
    options : AnalysisOptions
        Its settlement is not looked at: a function has no content that could be compared.
    """
    digest = hashlib.sha256(FORMAT.encode())
    body, support = model.body, model.support
    ours = body.points, body.connectivity, *body.rule, model.weight, support.prescribed, support.springs
    for array in (*ours, settled):
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    parts = options.material, options.masonry, options.base, options.stepping
    digest.update(repr(parts).encode())
    return digest.hexdigest()


def write_state(path: Path, state: Snapshot, course: Course, key: str) -> None:
    """Write a state; it appears under its name when it is whole, and replaces the one before.

    Parameters
    ----------
    path : Path
        Its folder is made if need be.
    state : Snapshot
    course : Course
        Up to the state.
    key : str
        Of `fingerprint`.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = state.motion._asdict() | state.fields._asdict()
    history = json.dumps([asdict(step) for step in state.history])
    part = path.with_name(f"{path.name}.part")
    with part.open("wb") as file:
        np.savez(
            file,
            format=FORMAT,
            key=key,
            history=history,
            size=state.size,
            next_size=state.next_size,
            kappa_before=state.kappa_before,
            dissipated=state.dissipated,
            force=state.force,
            largest_stress=course.largest_stress,
            feet=course.feet,
            **arrays,
        )
    part.replace(path)


def read_state(path: Path, key: str) -> tuple[Snapshot, Course]:
    """Read a state that `write_state` wrote, and the course up to it.

    Raises
    ------
    InputError
        If the file is damaged, or belongs to another mesh or other options.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            if str(file["format"]) != FORMAT or str(file["key"]) != key:
                msg = f"{path} is the state of another mesh or other options: remove it to begin anew."
                raise _OtherStateError(msg)
            arrays = dict(file)
            return _snapshot(arrays), Course(arrays["largest_stress"], arrays["feet"])
    except _OtherStateError:
        raise
    except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile) as error:
        # Not numpy's own words: on a text file they speak of loading it unsafely.
        msg = f"{path} is damaged, or not the state of an analysis: remove it to begin anew."
        raise InputError(msg) from error


class _OtherStateError(InputError):
    """The state is whole, but of something else."""


def _snapshot(arrays: dict[str, NDArray[np.float64]]) -> Snapshot:
    steps = json.loads(str(arrays["history"]))
    history = tuple(LoadStep(**(step | {"reaction": tuple(step["reaction"])})) for step in steps)
    return Snapshot(
        motion=Motion(*(arrays[name] for name in Motion._fields)),
        fields=PointFields(*(arrays[name] for name in PointFields._fields)),
        kappa_before=arrays["kappa_before"],
        dissipated=arrays["dissipated"],
        force=arrays["force"],
        size=float(arrays["size"]),
        next_size=float(arrays["next_size"]),
        history=history,
    )
