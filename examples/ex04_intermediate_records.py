"""What lies between the points and the facade: every step leaves a record.

The leaves of the quadtree cover the wall's bounding box without gap or overlap. A leaf that is k levels
above the smallest ones is 2ᵏ of them wide, and its address is the column and row of its lower left corner
on their grid. The flying voxel then re-divides the wall along the boundary lines into full and empty
voxels, so that::

    Σ volume of the full voxels = (length x height - opening area) x thickness
"""

import numpy as np

from fd2fem.model import CellState, HoleKind, PointCloud
from fd2fem.reconstruction import ReconstructionOptions, reconstruct

rng = np.random.default_rng(5)
points = rng.uniform([0.0, -0.002, 0.0], [4.0, 0.002, 3.0], (30_000, 3))  # a wall of 4 x 3 m
x, z = points[:, 0], points[:, 2]
in_window = (x > 1.5) & (x < 2.5) & (z > 1.0) & (z < 2.2)  # with a window of 1.0 x 1.2 m
cloud = PointCloud(points[~in_window], source="an example", scanners=[[2.0, -8.0, 1.6]])
result = reconstruct(cloud, options=ReconstructionOptions(thickness=0.35))

boundary, holes, tree, lines, voxels = (
    result.boundary,
    result.holes,
    result.quadtree,
    result.lines,
    result.voxels,
)
leaves = {state.name: int((tree.state == state).sum()) for state in CellState}
smallest = tree.upper[tree.state == CellState.PARTIAL] - tree.lower[tree.state == CellState.PARTIAL]
addresses = tree.index[tree.state == CellState.PARTIAL]
edges = {(line.hole, line.side.value): line.position for line in lines}
openings = [hole for hole in holes if hole.kind is HoleKind.OPENING]
volume = voxels.volume
covered = float(np.prod(voxels.upper - voxels.lower, axis=1).sum())
facade_area = result.facade.length * result.facade.height
leaf_area = float(np.prod(tree.upper - tree.lower, axis=1).sum())
box_area = float(np.prod(tree.upper.max(axis=0) - tree.lower.min(axis=0)))

if __name__ == "__main__":
    print(f"boundary: {len(boundary.points)} points; sides over {boundary.threshold:.3f} m are a gap")
    for hole in holes:
        print(f"hole: {hole.kind}, {hole.width:.3f} x {hole.height:.3f} m, confidence {hole.confidence:.2f}")
    print(f"quadtree: depth {tree.depth}, leaves {leaves}, smallest {smallest.min(axis=0).round(3)} m")
    print(f"addresses of the first partial leaves: {addresses[:4].tolist()}")
    for line in lines:
        where = "wall" if line.hole < 0 else f"hole {line.hole}"
        print(f"line: {where}, {line.side:6s} at {line.position:.4f} ± {line.sigma:.4f} m")
    states = {state.name: int((voxels.state == state).sum()) for state in CellState}
    print(f"voxels: {states}, {volume:.4f} m³ full, {covered:.3f} m² in all")
