"""How sparse a scan may be: Building 1 at the three densities of the paper's Table 2.

One cleaned virtual scan is re-sampled so that no two points are closer than 20, 50 and 75 mm; each cloud
is reconstructed and held against the drawing. The threshold on the triangles' sides is the paper's 0.175 m:
points at least 75 mm apart are 0.1 m apart on average, too far for the default threshold to be sure of an
opening of 0.4 m.
"""

from fd2fem.drawings import stand_in
from fd2fem.reconstruction import ReconstructionOptions, reconstruct
from fd2fem.scans import Density, ScannerOptions, Scene, resample_to, simulate_scan
from validation import compare_facades

QUANTITIES = ("length", "height", "opening_area")

drawing = stand_in("building1")
scan = simulate_scan(drawing, options=ScannerOptions(angular_step=0.05, seed=1), scene=Scene.empty())
options = ReconstructionOptions(threshold=0.175, thickness=drawing.thickness)

errors = {}
for density in (Density.S20, Density.S50, Density.S75):
    facade = reconstruct(resample_to(scan, density), options=options).facade
    geometry = compare_facades(facade, drawing).geometry
    errors[density.value] = {name: geometry[name]["relative_error"] for name in QUANTITIES}

worst = max(abs(error) for row in errors.values() for error in row.values())

if __name__ == "__main__":
    print("       " + "".join(f"{name:>14s}" for name in QUANTITIES))
    for density, row in errors.items():
        print(f"{density:7s}" + "".join(f"{error:>+14.2%}" for error in row.values()))
