"""The command line: it parses, calls one function, prints, and turns errors into exit codes.

0: done, and within the tolerance where one was asked for. 1: a comparison falls short. 2: the input is at
fault. 3: the numerics failed. Progress goes to stderr, results to files, ``--json`` to stdout.
"""

import json
import re
import signal
import sys
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from fd2fem.arguments import AT_FAULT, build_parser
from fd2fem.commands import COMMANDS
from fd2fem.errors import SYSTEM_LIBRARIES, Fd2femError, InputError

__all__ = ["main"]

FAILED, SIGNALLED = 3, 128


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv : sequence of str or None
        Arguments without the program's name; ``None``: those of the process.
    """
    args = build_parser().parse_args(argv)
    try:
        with _stoppable():
            code, summary = COMMANDS[args.verb](args)
        if args.json:
            sys.stdout.write(json.dumps(summary, indent=1) + "\n")
            sys.stdout.flush()
    except KeyboardInterrupt as stop:
        sys.stderr.write("fd2fem: stopped\n")
        return SIGNALLED + (stop.args[0] if stop.args else signal.SIGINT)
    except Exception as error:  # noqa: BLE001  a user must never meet a traceback unasked
        text, code = _diagnose(error)
        if args.debug:
            traceback.print_exception(error)
        else:
            sys.stderr.write(f"fd2fem: {' '.join(text.split())}\n")
        return code
    return code


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let the signals that end a process end it as Ctrl-C does, so that nothing is left behind."""

    def stop(number: int, _: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt(number)

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        names = []
    before = {name: signal.signal(getattr(signal, name), stop) for name in names}
    try:
        yield
    finally:
        for name, handler in before.items():
            signal.signal(getattr(signal, name), handler)


def _diagnose(error: Exception) -> tuple[str, int]:
    """What to tell the user of an error, and the exit code."""
    if isinstance(error, Fd2femError):
        # The user knows nothing of the folder that results are made in.
        text = re.sub(r"[^\s']*[\\/]\.fd2fem-\w+[\\/]", "", str(error))
        return text, AT_FAULT if isinstance(error, InputError) else FAILED
    if isinstance(error, ImportError) and ("shared object" in str(error) or "DLL" in str(error)):
        text = f"a library did not load ({error}); on Debian and Ubuntu: apt-get install {SYSTEM_LIBRARIES}"
        return text, FAILED
    if isinstance(error, MemoryError):
        return "out of memory: thin the scan or take larger elements", FAILED
    if isinstance(error, OSError):
        where = f" {error.filename}" if error.filename and ".fd2fem-" not in str(error.filename) else ""
        return f"cannot read or write{where}: {error.strerror or error}", AT_FAULT
    return f"internal error ({type(error).__name__}: {error}); run again with --debug and report it", FAILED
