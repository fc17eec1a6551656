import builtins
import os
import signal
import sys
import threading

import gmsh
import pytest

from fd2fem.errors import NumericsError
from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.meshing.session import gmsh_session
from fd2fem.model import Facade, rectangle


def test_gmsh_is_closed_even_after_an_error():
    with pytest.raises(ZeroDivisionError), gmsh_session():
        raise ZeroDivisionError
    assert not gmsh.isInitialized()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="this system has no such signals")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_the_signals_that_end_a_process_still_reach_python(name):
    # gmsh.initialize gives them back to the system, which ends the process on the spot.
    number, caught = getattr(signal, name), []
    before = signal.signal(number, lambda number, _: caught.append(number))
    try:
        with gmsh_session():
            os.kill(os.getpid(), number)
        assert caught == [number]
    finally:
        signal.signal(number, before)


def test_a_session_of_the_caller_survives():
    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("theirs")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 7.0)
        with gmsh_session({"Mesh.MeshSizeMax": 1.0, "Geometry.OCCTargetUnit": "M"}):
            assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 1.0
            assert gmsh.model.getCurrent() == "fd2fem"
        assert gmsh.model.getCurrent() == "theirs"
        assert "fd2fem" not in gmsh.model.list()
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 7.0
        assert gmsh.option.getString("Geometry.OCCTargetUnit") == ""
    finally:
        gmsh.finalize()


def test_threads_take_turns():
    facade = Facade(outline=rectangle(0, 0, 2, 2), thickness=0.5)
    options = MeshOptions(size=0.25)
    counts = []
    threads = [
        threading.Thread(target=lambda: counts.append(len(mesh_facade(facade, options=options).elements)))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert counts == [8 * 8 * 2] * 4


def test_nothing_is_printed(capfd):
    mesh_facade(Facade(outline=rectangle(0, 0, 2, 2), thickness=0.5))
    printed = capfd.readouterr()
    assert printed.out == ""
    assert printed.err == ""


def test_a_missing_system_library_is_explained(monkeypatch):
    real_import = builtins.__import__

    def no_library(name, *args, **kwargs):
        if name == "gmsh":
            msg = "libGLU.so.1: cannot open shared object file: No such file or directory"
            raise OSError(msg)
        return real_import(name, *args, **kwargs)

    monkeypatch.delitem(sys.modules, "gmsh")
    monkeypatch.setattr(builtins, "__import__", no_library)
    with (
        pytest.raises(NumericsError, match=r"libGLU\.so\.1.*apt-get install libgl1 libglu1-mesa"),
        gmsh_session(),
    ):
        pass
