"""From a point cloud to a facade: plane, boundary, holes, quadtree, boundary lines, flying voxel."""

from fd2fem.reconstruction.flying_voxel import voxelise
from fd2fem.reconstruction.options import ReconstructionOptions
from fd2fem.reconstruction.steps import reconstruct

__all__ = ["ReconstructionOptions", "reconstruct", "voxelise"]
