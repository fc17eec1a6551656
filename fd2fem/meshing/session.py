"""gmsh is one per process: this opens it, quietly, for one model at a time and closes it again."""

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType

from fd2fem.errors import SYSTEM_LIBRARIES, NumericsError

__all__ = ["gmsh_session", "silent_stdout"]

_ONE_AT_A_TIME = threading.RLock()
_QUIET: Mapping[str, float] = {"General.Terminal": 0.0}


def _load_gmsh() -> ModuleType:
    """Import gmsh, whose wheel needs system libraries even without a screen."""
    try:
        import gmsh
    except OSError as error:
        msg = (
            f"gmsh could not load a system library ({error}): install them, on Debian and Ubuntu with "
            f"'apt-get install {SYSTEM_LIBRARIES}'."
        )
        raise NumericsError(msg) from error
    module: ModuleType = gmsh
    return module


@contextmanager
def gmsh_session(options: Mapping[str, float | str] | None = None) -> Iterator[ModuleType]:
    """Give gmsh with an empty model and `options` set; leave no trace of either.

    Threads take turns. A gmsh that the caller opened stays open, with its models and options.

    Parameters
    ----------
    options : mapping of str to float or str
        gmsh's own options, by its names.

    Raises
    ------
    NumericsError
        If gmsh lacks a system library.
    """
    with _ONE_AT_A_TIME:
        gmsh = _load_gmsh()
        opened = not gmsh.isInitialized()
        if opened:
            # A user's .gmshrc must not change the mesh; signals belong to the main thread.
            gmsh.initialize(readConfigFiles=False, interruptible=False)
            _handle_signals_again()
        current = gmsh.model.getCurrent()
        before: dict[str, float | str] = {}
        try:
            for name, value in {**_QUIET, **(options or {})}.items():
                before[name] = _set_option(gmsh, name, value)
            gmsh.model.add("fd2fem")
            yield gmsh
        finally:
            if opened:
                gmsh.finalize()
            else:
                gmsh.model.remove()
                gmsh.model.setCurrent(current)
                for name, value in before.items():
                    _set_option(gmsh, name, value)


def _handle_signals_again() -> None:
    """Give the signals that end a process back to Python, from which gmsh has taken them."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and callable(handler := signal.getsignal(number)):
            signal.signal(number, handler)


@contextmanager
def silent_stdout() -> Iterator[None]:
    """Let nothing reach the process's standard output, not even from libraries that write to it directly.

    Where it is closed already, nothing is to be done.
    """
    try:
        kept = os.dup(1)
    except OSError:
        yield
        return
    if sys.stdout is not None:
        sys.stdout.flush()
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def _set_option(gmsh: ModuleType, name: str, value: float | str) -> float | str:
    """Set one option and return what it was."""
    if isinstance(value, str):
        text: str = gmsh.option.getString(name)
        gmsh.option.setString(name, value)
        return text
    number: float = gmsh.option.getNumber(name)
    gmsh.option.setNumber(name, value)
    return number
