"""What the pictures of a wall show: its front, and lines along its cracks."""

from dataclasses import replace

import numpy as np
import pytest
from exported_meshes import THICKNESS, VOLUME, all_kinds
from PIL import Image

from fd2fem.model import Response
from fd2fem.report.tables import step_rows
from fd2fem.report.wall_figures import crack_lines, draw_cracked_walls, draw_cracks, front_of


def _response(mesh, **changes):
    n = len(mesh.nodes)
    stresses = "max_principal_stress", "p95_principal_stress", "p99_principal_stress", "rms_stress"
    scalars = dict.fromkeys((*stresses, "weight", "max_displacement", "strain_energy"), 0.0)
    arrays = {"displacement": np.zeros((n, 3)), "stress": np.zeros((n, 6)), "reaction": np.zeros(3)}
    made = Response(mesh=mesh, principal_stress=np.zeros((n, 3)), dofs=3 * n, **arrays, **scalars)
    return replace(made, **changes)


@pytest.mark.parametrize("groups", [True, False])
@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10"])
def test_the_front_is_the_wall_once_whatever_the_elements(kind, groups):
    mesh = all_kinds()[kind]
    mesh = mesh if groups else replace(mesh, groups={})
    front = front_of(mesh)
    ring = mesh.nodes[front.corners]
    assert not ring[..., 1].any()
    arms = ring - ring[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(arms[:, 1:-1], arms[:, 2:]), axis=2).sum()
    assert area == pytest.approx(VOLUME / THICKNESS)
    inside = [
        set(corners) <= set(mesh.elements[e]) for corners, e in zip(front.corners, front.owner, strict=True)
    ]
    assert all(inside)


@pytest.mark.parametrize(
    ("normal", "along"),
    [((0, 0, 1), (1, 0)), ((1, 0, 0), (0, 1)), ((0.6, 0, 0.8), (0.8, -0.6)), ((0, 1, 0), (0, 0))],
)
def test_lines_run_along_the_cracks(normal, along):
    mesh = all_kinds()["hexahedron"]
    front, e = front_of(mesh), len(mesh.elements)
    opening = np.zeros(e)
    opening[front.owner[0]] = 1e-3
    response = _response(mesh, crack_opening=opening, crack_normal=np.tile(np.array(normal, float), (e, 1)))
    (line,) = crack_lines(response, front, narrowest=1e-5)
    corners = mesh.nodes[front.corners[0]][:, [0, 2]]
    assert np.allclose(line.mean(axis=0), corners.mean(axis=0))
    run = line[1] - line[0]
    assert abs(run[0] * along[1] - run[1] * along[0]) < 1e-12
    assert np.linalg.norm(run) == pytest.approx(0.8 * np.sqrt(np.ptp(corners, axis=0).prod()) * any(along))


def _step(share, **changes):
    names = "iterations strength_error strain_energy dissipated_energy plastic_energy external_work"
    return dict.fromkeys(names.split(), 1.0) | {"share": share} | changes


def test_steps_that_were_cut_are_counted():
    # By hand: quarters, of which the second was cut in two; what is left of the last one is no cut.
    shares = [0.0, 0.25, 0.375, 0.625, 0.875, 1.0]
    history = tuple(_step(share, external_work=9.0) for share in shares)
    response = _response(
        all_kinds()["hexahedron"], history=history, solver={"stepping": {"steps": 4}}, damage_class=1
    )
    rows = dict(step_rows(response))
    assert rows["steps; of them smaller than asked for"] == "5; 1"
    assert dict(step_rows(replace(response, damage_class=-1))) == {
        name: rows[name] for name in list(rows)[:4]
    }
    assert rows["of it set free by cracks that ran at once, or the error of the steps"] == "7.00"
    assert step_rows(_response(all_kinds()["hexahedron"])) == []


def test_walls_without_cracks_or_stress_are_drawn_as_well(tmp_path):
    mesh = all_kinds()["tetra10"]
    idle = _response(mesh, damage_class=0)
    draw_cracks(idle, tmp_path / "one.png")
    draw_cracked_walls(idle, idle, tmp_path / "two.png")
    # The wall itself has a colour.
    for name in ("one.png", "two.png"):
        with Image.open(tmp_path / name) as picture:
            pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3)
        assert (np.abs(pixels - np.array([0xEF, 0xE9, 0xE2])).max(axis=1) < 3).mean() > 0.05
