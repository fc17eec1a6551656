"""From a scan to a facade, held against the drawing it was made from.

A virtual scanner looks at the stand-in of Building 1 (4.95 x 12.16 m, four openings of 30.699 m²). The
cleaned scan, re-sampled so that no two points are closer than 20 mm, is all that the reconstruction knows.
An error is candidate - reference, relative to the reference (equation 4 of the paper)::

    δ = (scan - drawing) / drawing
"""

from fd2fem.drawings import stand_in
from fd2fem.reconstruction import ReconstructionOptions, reconstruct
from fd2fem.scans import Density, ScannerOptions, Scene, resample_to, simulate_scan
from validation import compare_facades

drawing = stand_in("building1")
scan = simulate_scan(drawing, options=ScannerOptions(angular_step=0.05, seed=1), scene=Scene.empty())
cloud = resample_to(scan, Density.S20)

result = reconstruct(cloud, options=ReconstructionOptions(thickness=drawing.thickness))
facade = result.facade
comparison = compare_facades(facade, drawing, tolerance=0.05)

length, height, opening_area = facade.length, facade.height, facade.opening_area
errors = {name: comparison.geometry[name]["relative_error"] for name in ("length", "height", "opening_area")}

if __name__ == "__main__":
    print(f"{len(scan):,} points, {len(cloud):,} after re-sampling; {len(facade.openings)} openings")
    for name, error in errors.items():
        print(
            f"{name:12s} {getattr(facade, name):7.3f}   drawing {getattr(drawing, name):7.3f}   {error:+.2%}"
        )
    for opening in facade.openings:
        print(
            f"{opening.id} {opening.kind:6s} {opening.width:.3f} x {opening.height:.3f} m "
            f"at ({opening.x:.3f}, {opening.z:.3f}), left edge ± {1000 * opening.sigma.left:.1f} mm"
        )
    print("passed" if comparison.passed else "; ".join(comparison.reasons))
