"""Elastic analysis beside scikit-fem's assembly and CalculiX.

``python benchmarks/elastic.py MESH ELEMENT SOLVER`` analyses a mesh file: the process that is measured.
"""

import json
import os
import resource
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
from timing import Seconds, head, row, timed, timed_process

from fd2fem.drawings import stand_in
from fd2fem.meshing import MeshOptions, mesh_facade, quadratic_mesh, read_mesh, write_mesh
from fd2fem.model import VolumeMesh
from solvers import (
    AnalysisOptions,
    analyse,
    base_displacement,
    lame_parameters,
    read_response,
    write_response,
)
from solvers.compiled.pattern import build_pattern
from solvers.fem.assembly import add_up, elastic_body, stiffness
from solvers.fem.elements import ElementType, Space, displacement_space
from solvers.fem.linear_solvers import SolverName

MESH_SIZE = 0.17
"""Element edge, m: about 43,000 unknowns in Building 1, in 20-node hexahedra."""
ANALYSES = (
    (ElementType.HEXAHEDRON8, "C3D8", 0.1),
    (ElementType.HEXAHEDRON8, "C3D8", 0.055),
    (ElementType.HEXAHEDRON20, "C3D20", 0.17),
    (ElementType.HEXAHEDRON20, "C3D20", 0.09),
)
"""Elements, CalculiX's name of them, and their edge, m, in Building 1."""
LARGE_ANALYSES = ((ElementType.INCOMPATIBLE, 0.0325), (ElementType.HEXAHEDRON20, 0.055))
"""About a million unknowns, solved by multigrid."""
INTORDER = 5
"""27 points in a hexahedron, as ours; scikit-fem's own choice would be 343."""
OPTIONS = AnalysisOptions()
ENVIRONMENT = {"OMP_NUM_THREADS": str(os.cpu_count())}
"""Of the processes that are measured, where the caller's does not say otherwise."""


def stock_stiffness(mesh: VolumeMesh) -> Any:
    """The same stiffness by scikit-fem's own form."""
    import skfem
    from skfem.models.elasticity import linear_elasticity

    order = [6, 2, 5, 7, 1, 3, 4, 0]  # VTK's corners as scikit-fem's reference element has them
    grid = skfem.MeshHex(mesh.nodes.T.copy(), mesh.elements[:, order].T.copy())
    basis = skfem.Basis(grid, skfem.ElementVector(skfem.ElementHexS2()), intorder=INTORDER)
    lame = lame_parameters(OPTIONS.material)
    return skfem.asm(linear_elasticity(lame.first, lame.shear), basis)


def assembly() -> None:
    """Our stiffness matrix beside scikit-fem's stock form, on the same mesh and points."""
    mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=MESH_SIZE))
    space = displacement_space(mesh)
    material = OPTIONS.material
    ours, stock = stiffness(space, material), stock_stiffness(mesh)
    # The two number their unknowns differently, so it is the sorted diagonals that must agree.
    own, other = (np.sort(matrix.diagonal()) for matrix in (ours, stock))
    difference = np.abs(own - other).max() / own.max()
    head(f"Stiffness matrix, {len(mesh.elements):,} 20-node hexahedra, {space.unknowns:,} unknowns")
    peer = timed(lambda: stock_stiffness(mesh))
    row("solvers.fem.assembly.stiffness", timed(lambda: stiffness(space, material), 3), "scikit-fem", peer)
    body, prescribed = elastic_body(space, material), np.zeros(space.unknowns, dtype=bool)
    pattern = build_pattern(space.connectivity, points=len(space.points), prescribed=prescribed, upper=True)
    again = timed(lambda: add_up(body, pattern, np.zeros(space.unknowns)), 3)
    row("  upper triangle, pattern known", again, "scikit-fem", peer)
    print(f"  largest difference of the diagonals {difference:.1e} of the largest; intorder {INTORDER}")


def write_deck(space: Space, name: str, path: Path) -> None:
    """The same analysis for CalculiX: the same nodes and elements, self-weight, the base moved."""
    material = OPTIONS.material
    x = space.points[:, 0]
    moved = base_displacement(OPTIONS.settlement, x[space.base], extent=(x.min(), x.max()))
    with path.open("w", encoding="ascii") as deck:
        deck.write("*NODE, NSET=ALL\n")
        numbers = np.arange(1, len(space.points) + 1)
        np.savetxt(deck, np.column_stack([numbers, space.points]), fmt="%d, %.12e, %.12e, %.12e")
        deck.write(f"*ELEMENT, TYPE={name}, ELSET=WALL\n")
        for number, nodes in enumerate(space.connectivity + 1, start=1):
            lines = [", ".join(map(str, part)) for part in (nodes[:15], nodes[15:]) if len(part)]
            deck.write(f"{number}, " + ",\n".join(lines) + "\n")
        deck.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{material.young}, {material.poisson}\n")
        deck.write(f"*DENSITY\n{material.density}\n*SOLID SECTION, ELSET=WALL, MATERIAL=M\n")
        deck.write("*STEP\n*STATIC\n*BOUNDARY\n")
        for node, values in zip(space.base + 1, moved, strict=True):
            deck.writelines(f"{node}, {axis}, {axis}, {value:.12e}\n" for axis, value in enumerate(values, 1))
        deck.write(f"*DLOAD\nWALL, GRAV, {OPTIONS.gravity}, 0., 0., -1.\n")
        deck.write("*NODE PRINT, NSET=ALL\nU\n*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n")


def analyse_here(path: str, element: str, solver: str) -> None:
    """Mesh file to response on disk, in this process; what it took goes into a file beside them."""
    options = AnalysisOptions(element=ElementType(element), solver=SolverName(solver))
    mesh, responses = read_mesh(Path(path)), []
    # Loads compiled functions and libraries, which counts as start.
    small = mesh_facade(stand_in("building1"), options=MeshOptions(size=1.0))
    analyse(small, options=options)
    inside = timed(lambda: responses.append(analyse(mesh, options=options)))
    write_response(responses[0], Path(path).with_suffix(""))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    record = {"cpu": inside.cpu, "wall": inside.wall, "memory": memory}
    Path(path).with_suffix(".json").write_text(json.dumps(record), encoding="ascii")


def analyse_fresh(mesh: VolumeMesh, element: ElementType, folder: Path, solver: str = "auto") -> Seconds:
    """The same in a process of its own, from a mesh whose nodes carry the displacements."""
    whole = quadratic_mesh(mesh) if element is ElementType.HEXAHEDRON20 else mesh
    write_mesh(whole, folder / "wall.msh")
    command = [sys.executable, __file__, str(folder / "wall.msh"), element.value, solver]
    return timed_process(command, folder, ENVIRONMENT | os.environ)


def first_run(folder: Path) -> None:
    """What compiling costs, once per machine: a small wall with an empty cache, and again."""
    mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=1.0))
    os.environ["NUMBA_CACHE_DIR"] = str(folder / "cache")
    first, then = (analyse_fresh(mesh, ElementType.HEXAHEDRON20, folder) for _ in range(2))
    del os.environ["NUMBA_CACHE_DIR"]
    print(f"\nCompiling takes {first.cpu - then.cpu:.1f} CPU s once; start and end {then.cpu:.1f} CPU s")


def elastic_analysis(folder: Path) -> None:
    """A mesh file to results on disk, whole processes, beside CalculiX on the same mesh."""
    first_run(folder)
    head("Elastic analysis from file to file (Building 1)")
    for element, name, size in ANALYSES:
        mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=size))
        space = displacement_space(mesh, element)
        ours = analyse_fresh(mesh, element, folder)
        response = read_response(folder / "wall")
        title = f"{space.unknowns:,} unknowns, {element}"
        if shutil.which("ccx") is None:
            print(f"{title:34s} {ours.cpu:8.3f} {ours.wall:8.3f}   ccx is not on PATH: skipped")
            continue
        write_deck(space, name, folder / "deck.inp")
        peer = timed_process(["ccx", "deck"], folder, ENVIRONMENT | os.environ)
        row(title, ours, f"CalculiX (ccx), {name}", peer)
        record = json.loads((folder / "wall.json").read_text(encoding="ascii"))
        row("  without start and files", Seconds(record["cpu"], record["wall"]), "", peer)
        theirs = np.genfromtxt(folder / "deck.dat", skip_header=3)[:, 1:]
        # The quadratic mesh numbers its nodes as the space does its points.
        difference = np.abs(response.displacement - theirs).max() / np.abs(theirs).max()
        steps = "  ".join(f"{step} {took:.2f}" for step, took in response.timings.items())
        ratio = peer.wall / (response.timings["assemble"] + response.timings["solve"])
        print(f"  {response.solver['name']}; ours, wall s: {steps}")
        print(f"  the peer's wall seconds / our assemble and solve: {ratio:.2f}")
        print(f"  displacements at all nodes differ by {difference:.1e} of the largest")


def large_analysis(folder: Path) -> None:
    """A million unknowns by multigrid: time and memory."""
    print("\nElastic analysis of a million unknowns")
    for element, size in LARGE_ANALYSES:
        mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=size))
        seconds = analyse_fresh(mesh, element, folder, "amg")
        memory = json.loads((folder / "wall.json").read_text(encoding="ascii"))["memory"]
        response = read_response(folder / "wall")
        print(
            f"{response.dofs:,} unknowns, {element}: {seconds.cpu:.0f} CPU s, {seconds.wall:.0f} wall s, "
            f"at most {memory:.2f} GiB; {response.solver['name']}, residual "
            f"{response.solver['relative_residual']:.1e}"
        )


if __name__ == "__main__":
    analyse_here(*sys.argv[1:])
