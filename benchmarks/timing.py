"""Measuring, and printing what was measured beside a peer."""

import resource
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time


@dataclass(frozen=True)
class Seconds:
    """What one measurement took."""

    cpu: float
    wall: float


def timed(task: Callable[[], object], repeat: int = 1) -> Seconds:
    """Best of `repeat` runs of a task."""
    runs = []
    for _ in range(repeat):
        wall, cpu = perf_counter(), process_time()
        task()
        runs.append(Seconds(process_time() - cpu, perf_counter() - wall))
    return min(runs, key=lambda run: run.cpu)


def timed_process(command: list[str], folder: Path, env: dict[str, str]) -> Seconds:
    """A whole process, from its start to its end."""
    before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    subprocess.run(command, cwd=folder, env=env, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Seconds(cpu, perf_counter() - wall)


def row(name: str, ours: Seconds, peer_name: str, peer: Seconds) -> None:
    """Print one comparison."""
    print(
        f"{name:34s} {ours.cpu:8.3f} {ours.wall:8.3f}   {peer_name:34s} {peer.cpu:8.3f} {peer.wall:8.3f}   "
        f"{peer.cpu / ours.cpu:6.2f} {peer.wall / ours.wall:6.2f}"
    )


def head(title: str) -> None:
    """Print the columns' names."""
    print(f"\n{title}")
    print(f"{'ours':34s} {'CPU s':>8s} {'wall s':>8s}   {'peer':34s} {'CPU s':>8s} {'wall s':>8s}   ", end="")
    print(f"{'CPU':>6s} {'wall':>6s}")
