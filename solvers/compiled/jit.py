"""numba, typed; and chunks of elements on all cores.

Functions are compiled at their first call and kept on disk for the next process. They release Python's
lock, so that plain threads run them side by side. numba, which takes most of a second to load, is not needed
before.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

__all__ = ["CHUNK", "compiled", "in_chunks"]

_MODULES = Path(__file__).parent


def _forget_stale() -> None:
    """Delete compiled code that is older than any of the package's sources.

    numba looks at a function's own file alone: a change in a function that it calls would go unnoticed.
    """
    newest = max(source.stat().st_mtime for source in _MODULES.glob("*.py"))
    for index in _MODULES.glob("__pycache__/*.nbi"):
        if index.stat().st_mtime < newest:
            index.unlink(missing_ok=True)


_forget_stale()

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

CHUNK = 512
"""Elements per chunk: what bounds the memory of their matrices."""


class _Compiled:
    """A function that numba is asked for when it is called, or when another one that calls it is compiled."""

    _lock = threading.Lock()

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self._function = function
        self._dispatcher: Any = None

    def _dispatch(self) -> Any:
        # Two threads must not both make one, and compile it twice.
        with self._lock:
            if self._dispatcher is None:
                from numba import njit

                self._dispatcher = njit(cache=True, nogil=True, error_model="numpy")(self._function)
        return self._dispatcher

    @property
    def _numba_type_(self) -> Any:
        """By which numba knows it within another function."""
        return self._dispatch()._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        return (self._dispatcher or self._dispatch())(*arguments)


def compiled(function: F) -> F:
    """Compile a function of numbers and arrays."""
    return cast("F", _Compiled(function))


def in_chunks(count: int, task: Callable[[slice], T]) -> Iterator[tuple[slice, T]]:
    """Results of a task for chunks of elements, in order; on as many cores as there are.

    Examples
    --------
    >>> [(part.start, part.stop, size) for part, size in in_chunks(700, lambda part: part.stop - part.start)]
    [(0, 512, 512), (512, 700, 188)]
    """
    parts = [slice(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]
    workers = min(_cores(), len(parts)) or 1
    with ThreadPoolExecutor(workers) as pool:
        # One more than there are cores is under way, so that none waits while a result is used.
        waiting = deque((part, pool.submit(task, part)) for part in parts[: workers + 1])
        for following in [*parts[workers + 1 :], *[None] * len(waiting)]:
            part, result = waiting.popleft()
            yield part, result.result()
            if following is not None:
                waiting.append((following, pool.submit(task, following)))


def _cores() -> int:
    """Cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
