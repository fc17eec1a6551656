"""Results appear whole or not at all: they are written beside their final name and renamed.

If anything fails on the way, nothing is left behind; an existing result stays unless the user says
otherwise.
"""

import filecmp
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fd2fem.errors import InputError

__all__ = ["staged_file", "staged_folder"]


@contextmanager
def staged_folder(
    folder: Path, *, expected: Sequence[str] = (), stale: Sequence[str] = (), force: bool = False
) -> Iterator[Path]:
    """Yield an empty folder whose contents move into `folder` when the block ends well.

    Parameters
    ----------
    folder : Path
        May exist and hold other files.
    expected : sequence of str
        Names of the main results, so that a clash shows before the work is done.
    stale : sequence of str
        Results of an earlier run that go if this one makes none of that name, so that old and new never mix.
    force : bool
        Replace files that exist.

    Raises
    ------
    InputError
        If `folder` is a file, cannot be written to, or holds a result already.
    """
    if folder.exists() and not folder.is_dir():
        msg = f"{folder} is a file; give a folder to write to."
        raise InputError(msg)
    _refuse_clash(folder, expected, force=force)
    # Inside the folder if there is one: it may be a mount, or a link to another file system.
    stage = _new_stage(folder if folder.is_dir() else folder.absolute().parent, folder)
    try:
        yield stage
        made = sorted(path.relative_to(stage) for path in stage.rglob("*") if path.is_file())
        # A file that is there already, to the last byte, is no clash: the facade that was analysed, say.
        new = [str(name) for name in made if not _same(stage / name, folder / name)]
        _refuse_clash(folder, new, force=force)
        if folder.exists():
            for old in stale:
                if not (stage / old).exists():
                    (folder / old).unlink(missing_ok=True)
            for name in made:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (stage / name).replace(folder / name)
        else:
            folder.parent.mkdir(parents=True, exist_ok=True)
            stage.chmod(_usual_mode(stage))
            stage.replace(folder)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


@contextmanager
def staged_file(path: Path, *, force: bool = False) -> Iterator[Path]:
    """Yield a path with the same suffix, whose file takes the name `path` when the block ends well.

    Raises
    ------
    InputError
        If `path` is a folder, exists and `force` is not given, or cannot be written to.
    """
    if path.is_dir():
        msg = f"{path} is a folder; give the name of a file to write."
        raise InputError(msg)
    _refuse_clash(path.parent, [path.name], force=force)
    stage = _new_stage(path.absolute().parent, path)
    try:
        yield stage / path.name
        path.parent.mkdir(parents=True, exist_ok=True)
        (stage / path.name).replace(path)
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _refuse_clash(folder: Path, names: Sequence[str], *, force: bool) -> None:
    """Raise if one of the files is there already."""
    if force:
        return
    for name in names:
        if (folder / name).exists():
            msg = f"{folder / name} exists; give another place, or --force to replace it."
            raise InputError(msg)


def _same(first: Path, second: Path) -> bool:
    return second.is_file() and filecmp.cmp(first, second, shallow=False)


def _new_stage(parent: Path, target: Path) -> Path:
    """A new hidden folder in `parent`, or its nearest existing parent: renaming stays on one file system."""
    while not parent.exists():
        parent = parent.parent
    if not parent.is_dir():
        msg = f"Cannot write {target}: {parent} is not a folder."
        raise InputError(msg)
    try:
        return Path(tempfile.mkdtemp(prefix=".fd2fem-", dir=parent))
    except OSError as error:
        msg = f"Cannot write {target}: {error.strerror or error}."
        raise InputError(msg) from error


def _usual_mode(stage: Path) -> int:
    """The mode that a plain mkdir gives; temporary folders are private."""
    probe = stage / ".mode"
    probe.mkdir()
    mode = probe.stat().st_mode & 0o777
    probe.rmdir()
    return mode
