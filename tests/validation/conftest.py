"""Facades, meshes and responses made by hand."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fd2fem.model import ElementKind, Facade, Opening, OpeningKind, Response, VolumeMesh, rectangle

ORACLE = Path(__file__).parents[1] / "oracles" / "flying_voxel_tables.toml"


@pytest.fixture(scope="session")
def paper() -> dict[str, Any]:
    return tomllib.loads(ORACLE.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def facade_of() -> Callable[..., Facade]:
    """A facade from rectangles (x, z, width, height); ids count from 1 in the order given."""

    def build(openings: Sequence[Sequence[float]], length: float = 10.0, height: float = 8.0) -> Facade:
        made = [Opening(i, OpeningKind.WINDOW, rectangle(*o)) for i, o in enumerate(openings, 1)]
        return Facade(rectangle(0, 0, length, height), 0.35, tuple(made))

    return build


@pytest.fixture(scope="session")
def grid_mesh() -> Callable[..., VolumeMesh]:
    """Hexahedra between the given coordinates, in VTK's order; cells of `holes` (i, k) in x, z left out."""

    def build(
        xs: Sequence[float],
        ys: Sequence[float],
        zs: Sequence[float],
        holes: Sequence[tuple[int, int]] = (),
    ) -> VolumeMesh:
        number = np.arange(len(xs) * len(ys) * len(zs)).reshape(len(xs), len(ys), len(zs))
        corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        elements = np.array(
            [
                [number[i + a, j + b, k + c] for a, b, c in corner]
                for i in range(len(xs) - 1)
                for j in range(len(ys) - 1)
                for k in range(len(zs) - 1)
                if (i, k) not in set(holes)
            ]
        )
        nodes = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), axis=-1).reshape(-1, 3)
        used, packed = np.unique(elements, return_inverse=True)
        return VolumeMesh(nodes[used], packed.reshape(elements.shape), ElementKind.HEXAHEDRON, {})

    return build


@pytest.fixture(scope="session")
def response_on() -> Callable[..., Response]:
    """A response with the displacement field `move` (a function of the nodes) and stated scalars."""

    def build(mesh: VolumeMesh, move: Callable[..., Any], **scalars: Any) -> Response:
        n = len(mesh.nodes)
        made = Response(
            mesh=mesh,
            displacement=move(mesh.nodes),
            stress=np.zeros((n, 6)),
            principal_stress=np.zeros((n, 3)),
            reaction=np.array([0.0, 0.0, 3.0e5]),
            weight=3.0e5,
            max_displacement=0.0996,
            max_principal_stress=1.05e6,
            p95_principal_stress=4.0e5,
            p99_principal_stress=6.0e5,
            rms_stress=1.0e5,
            strain_energy=1000.0,
            dofs=3 * n,
        )
        return replace(made, **scalars)

    return build
