"""A facade as a STEP solid and as an ANSYS neutral file, and both read back.

The solid is a prism, so its volume is known in closed form::

    V = (length x height - Σ width x height of the openings) x thickness

The neutral file holds keypoints, lines, areas and volumes (Appendix A of the paper), shared between
neighbouring voxels; its volume follows from the areas alone by the divergence theorem, V = ⅓ Σ ∮ p·n dA.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from fd2fem.model import Facade, Opening, OpeningKind, rectangle
from fd2fem.reconstruction import voxelise
from fd2fem.solids import (
    SolidOptions,
    facade_from_step,
    read_anf,
    solid_from_voxels,
    solid_volumes,
    write_solid,
)

window = Opening(1, OpeningKind.WINDOW, rectangle(1.5, 1.0, 1.0, 1.2))
facade = Facade(rectangle(0, 0, 4.0, 3.0), 0.35, (window,))
voxels = voxelise(facade, max_size=0.5)
solid = solid_from_voxels(voxels)

with TemporaryDirectory() as folder:
    report = write_solid(facade, voxels, Path(folder), options=SolidOptions(anf_order=2))
    anf_volume = float(solid_volumes(read_anf(Path(folder) / report.anf)).sum())
    back = facade_from_step(Path(folder) / report.step)
    sizes = {name: (Path(folder) / name).stat().st_size for name in (report.step, report.anf, report.apdl)}

step_volume = back.wall_area * back.thickness

if __name__ == "__main__":
    print(f"{len(voxels.state)} voxels; volume {voxels.volume:.6f} m³")
    print(f"STEP: {report.step_faces} faces, {report.step_volume:.6f} m³; as a facade {step_volume:.6f} m³")
    print(
        f"neutral file: {report.keypoints} keypoints, {report.lines} lines, {report.areas} areas, "
        f"{report.volumes} volumes, {anf_volume:.6f} m³"
    )
    print(", ".join(f"{name} {size / 1024:.0f} kB" for name, size in sizes.items()))
