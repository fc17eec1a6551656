"""Imports point down only: records, then stages, then options and pipeline, then the command line."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("fd2fem", "solvers", "validation")
RECORDS = {"fd2fem.model", "fd2fem.errors"}
STAGES = {"scans", "drawings", "reconstruction", "solids", "meshing", "report"}

# What each layer may import of the three packages; a layer may always import itself.
ALLOWED = {
    "fd2fem": set(),
    "fd2fem.errors": set(),
    "fd2fem.model": {"fd2fem.errors"},
    **{f"fd2fem.{stage}": RECORDS for stage in STAGES},
    "solvers": RECORDS,
    "validation": RECORDS,
    "fd2fem.output": {"fd2fem.errors"},
}
ALLOWED["fd2fem.config"] = RECORDS | {f"fd2fem.{stage}" for stage in STAGES} | {"solvers", "validation"}
ALLOWED["fd2fem.exchange"] = ALLOWED["fd2fem.config"] | {"fd2fem.config"}
ALLOWED["fd2fem.loading"] = ALLOWED["fd2fem.config"] | {"fd2fem.config"}
ALLOWED["fd2fem.messages"] = RECORDS | {"fd2fem.report", "solvers", "validation"}
ALLOWED["fd2fem.pipeline"] = ALLOWED["fd2fem.exchange"] | {
    "fd2fem.exchange", "fd2fem.loading", "fd2fem.output",
}  # fmt: skip
ALLOWED["fd2fem.arguments"] = {"fd2fem.errors", "fd2fem"}  # fd2fem: the version
ALLOWED["fd2fem.commands"] = ALLOWED["fd2fem.pipeline"] | {"fd2fem.messages", "fd2fem.pipeline"}
ALLOWED["fd2fem.cli"] = {"fd2fem.errors", "fd2fem.arguments", "fd2fem.commands"}
ALLOWED["fd2fem.__main__"] = {"fd2fem.cli"}

HEAVY = (
    "gmsh", "cadquery", "OCP", "matplotlib", "vtk", "vtkmodules", "pandas",
    "meshio", "skfem", "laspy", "ezdxf", "numba", "llvmlite",
)  # fmt: skip


def _modules():
    """Dotted name and file of every module of the three packages."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


MODULES = dict(_modules())


def _layer(module):
    """The longest prefix of a module's name that is a layer: fd2fem.scans.las is of fd2fem.scans."""
    parts = module.split(".")
    names = [".".join(parts[:size]) for size in range(len(parts), 0, -1)]
    found = [name for name in names if name in ALLOWED and (name != "fd2fem" or module == "fd2fem")]
    assert found, f"{module} belongs to no layer: give it one in ALLOWED"
    return found[0]


def _imports(source, module, *, is_package):
    """Every module of ours that a source imports, inside functions too."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".")
                kept = parts[: len(parts) - node.level + (1 if is_package else 0)]
                base = ".".join([*kept, base] if base else kept)
            # "from fd2fem import scans" imports a module, "from fd2fem import __version__" does not.
            found |= {
                f"{base}.{alias.name}" if f"{base}.{alias.name}" in MODULES else base for alias in node.names
            }
    return {name for name in found if name.split(".")[0] in PACKAGES}


def _forbidden(source, module, *, is_package=False):
    """What a source imports against the layers."""
    own = _layer(module)
    used = {name: _layer(name) for name in _imports(source, module, is_package=is_package)}
    return sorted(name for name, layer in used.items() if layer != own and layer not in ALLOWED[own])


@pytest.mark.parametrize("module", sorted(MODULES))
def test_module_imports_nothing_above_or_beside_it(module):
    path = MODULES[module]
    source = path.read_text(encoding="utf-8")
    assert _forbidden(source, module, is_package=path.name == "__init__.py") == []


def test_every_stage_is_there():
    assert {_layer(module) for module in MODULES} == ALLOWED.keys()


@pytest.mark.parametrize(
    ("module", "source", "found"),
    [
        ("fd2fem.model.mesh", "from fd2fem.scans import read_scan", ["fd2fem.scans"]),
        ("fd2fem.errors", "import fd2fem.model", ["fd2fem.model"]),
        ("fd2fem.scans.las", "from fd2fem.reconstruction import reconstruct", ["fd2fem.reconstruction"]),
        ("fd2fem.solids.cad", "from ..meshing.quality import mesh_quality", ["fd2fem.meshing.quality"]),
        ("fd2fem.report.page", "from fd2fem import meshing", ["fd2fem.meshing"]),
        ("fd2fem.meshing.quads", "def f():\n    import solvers.fem.stress", ["solvers.fem.stress"]),
        ("fd2fem.meshing.quads", "from fd2fem import pipeline", ["fd2fem.pipeline"]),
        ("solvers.fem.stress", "from fd2fem.meshing import mesh_facade", ["fd2fem.meshing"]),
        ("solvers.fem.stress", "import validation", ["validation"]),
        ("validation.verdict", "def f():\n    from solvers import analyse", ["solvers"]),
        ("fd2fem.output", "from fd2fem.model import Facade", ["fd2fem.model"]),
        ("fd2fem.config", "from fd2fem.pipeline import run", ["fd2fem.pipeline"]),
        ("fd2fem.pipeline", "from fd2fem.cli import main", ["fd2fem.cli"]),
        ("fd2fem", "from fd2fem.pipeline import run", ["fd2fem.pipeline"]),
        (
            "fd2fem.scans.las",
            "import numpy\nfrom fd2fem.model import PointCloud\nfrom .raw import RawScan",
            [],
        ),
    ],
)
def test_the_walk_sees_an_import_across_the_layers(module, source, found):
    assert _forbidden(source, module) == found


def test_a_package_may_name_its_own_modules_relatively():
    assert _forbidden("from .raw import RawScan", "fd2fem.scans", is_package=True) == []


def _heavy_after(module, heavy=HEAVY):
    """Heavy modules that a fresh interpreter has loaded after one import."""
    code = f"import sys, {module}\nprint(*sorted(set({heavy!r}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.parametrize("module", ["fd2fem", "fd2fem.cli", "fd2fem.pipeline", "solvers", "validation"])
def test_importing_stays_light(module):
    assert _heavy_after(module) == []


@pytest.mark.parametrize("module", ["fd2fem.cli", "solvers"])
def test_a_command_that_computes_nothing_needs_no_scipy(module):
    assert _heavy_after(module, ("scipy",)) == []


def test_the_search_for_heavy_modules_finds_one():
    assert "meshio" in _heavy_after("meshio")
