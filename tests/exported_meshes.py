"""A small wall with an opening in every kind of element, made without a mesher."""

import numpy as np

from fd2fem.model import ElementKind, LoadCase, VolumeMesh
from solvers import AnalysisOptions, LinearSettlement, PeckTrough, base_displacement

HEX_FACETS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
# Six tetrahedra around the diagonal from corner 0 to corner 6 of a hexahedron, positive volume.
SPLIT = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
TETRA_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
TETRA_FACETS = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]

THICKNESS, VOLUME = 0.4, 0.4 * (np.pi * 2.2 - 0.9 * 1.1)
SETTLEMENTS = {
    "linear": LinearSettlement(-0.012, -0.003, -0.004, 0.002),
    "trough": PeckTrough(0.01, 2.0, 4.0, centre=0.7),
}


def hexahedra(*, parts=1, layers=2):
    """A wall of π x 0.4 x 2.2 m with an opening of 0.9 x 1.1 m; planes by no rule, none of them decimal."""
    xs = refine([0, 0.6, 1 / 0.9, 1 / 0.9 + 0.9, np.e, np.pi], parts)
    zs = refine([0, 1 / 3, 1 / 3 + 1.1, 1.9, 2.2], parts)
    ys = np.linspace(0, THICKNESS, layers + 1)
    i, j, k = np.meshgrid(*(np.arange(len(p) - 1) for p in (xs, ys, zs)), indexing="ij")
    corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    shape = len(xs), len(ys), len(zs)
    elements = np.stack([np.ravel_multi_index((i + a, j + b, k + c), shape) for a, b, c in corner], axis=-1)
    nodes = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), axis=-1).reshape(-1, 3)
    elements = elements.reshape(-1, 8)
    x, _, z = nodes[elements].mean(axis=1).T
    elements = elements[(np.abs(x - 1 / 0.9 - 0.45) > 0.45) | (np.abs(z - 1 / 3 - 0.55) > 0.55)]
    used, elements = np.unique(elements, return_inverse=True)
    mesh = nodes[used], elements.reshape(-1, 8)
    return VolumeMesh(*mesh, ElementKind.HEXAHEDRON, groups_of(*mesh, HEX_FACETS))


def refine(planes, parts):
    return np.interp(np.arange(parts * (len(planes) - 1) + 1) / parts, np.arange(len(planes)), planes)


def groups_of(nodes, elements, faces):
    """Corners of the outer facets by name; "ledges" has none."""
    facets = elements[:, faces].reshape(-1, len(faces[0]))
    _, first, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    outer = facets[np.sort(first[count == 1])]
    x, y, z = np.moveaxis(nodes[outer], -1, 0)
    lie = {"base": z == 0, "top": z == nodes[:, 2].max(), "front": y == 0, "back": y == y.max()}
    lie |= {"left": x == 0, "right": x == x.max()}
    on = {name: at.all(axis=1) for name, at in lie.items()}
    on["reveals"] = ~np.any(list(on.values()), axis=0)
    return {name: outer[at] for name, at in on.items()} | {"ledges": outer[:0]}


def tetrahedra(mesh):
    """Every hexahedron cut into six straight quadratic tetrahedra."""
    corners = mesh.elements[:, SPLIT].reshape(-1, 4)
    groups = groups_of(mesh.nodes, corners, TETRA_FACETS)
    return with_middles(mesh.nodes, corners, groups, edges=TETRA_EDGES, kind=ElementKind.TETRA10)


def hexahedra20(mesh):
    """20-node hexahedra, the middles in an order of their own: by place."""
    return with_middles(
        mesh.nodes, mesh.elements, mesh.groups, edges=HEX_EDGES, kind=ElementKind.HEXAHEDRON20
    )


def with_middles(nodes, corners, groups, *, edges, kind):
    ends = np.sort(corners[:, edges].reshape(-1, 2), axis=1)
    pairs, edge = np.unique(ends, axis=0, return_inverse=True)
    number = {tuple(pair): len(nodes) + k for k, pair in enumerate(pairs.tolist())}

    def middles(facet):
        return [number[tuple(sorted(p))] for p in zip(facet, facet[1:] + facet[:1], strict=True)]

    width = {ElementKind.HEXAHEDRON20: 8, ElementKind.TETRA10: 6}[kind]
    return VolumeMesh(
        nodes=np.vstack([nodes, nodes[pairs].mean(axis=1)]),
        elements=np.hstack([corners, len(nodes) + edge.reshape(len(corners), -1)]),
        kind=kind,
        groups={
            name: np.array([f + middles(f) for f in facets.tolist()], dtype=int).reshape(-1, width)
            for name, facets in groups.items()
        },
    )


def all_kinds():
    """One wall in 8-node and 20-node hexahedra and 10-node tetrahedra."""
    mesh = hexahedra()
    return {m.kind.value: m for m in (mesh, hexahedra20(mesh), tetrahedra(mesh))}


def load_case(mesh, options):
    """The options of our own analysis as a load case."""
    ends = float(mesh.nodes[:, 0].min()), float(mesh.nodes[:, 0].max())
    return LoadCase(
        young=options.material.young,
        poisson=options.material.poisson,
        density=options.material.density,
        gravity=options.gravity,
        base=lambda points: base_displacement(options.settlement, points[:, 0], extent=ends),
    )


def options_for(settlement, **changes):
    return AnalysisOptions(settlement=SETTLEMENTS[settlement], **changes)
