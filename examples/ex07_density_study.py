"""How sparse a scan may be: Building 1 at the four densities of the paper's Table 2.

One cleaned virtual scan with as many points as the paper's is thinned until no two points are closer than 20,
50 and 75 mm; each cloud is reconstructed by the default options and held against the drawing.
`docs/density_study.py` does the same for all three buildings, and sets it beside the paper's tables.
"""

from fd2fem.drawings import stand_in
from fd2fem.pipeline import ORIGINAL_COUNTS, scan_facade
from fd2fem.reconstruction import ReconstructionOptions, reconstruct
from fd2fem.scans import Density, ScannerOptions, Scene, resample_to
from validation import compare_facades

QUANTITIES = ("length", "height", "opening_area")

drawing = stand_in("building1")
scan = scan_facade(
    drawing,
    scanner=ScannerOptions(seed=0),
    scene=Scene.empty(),
    original_points=ORIGINAL_COUNTS["building1"],
)
options = ReconstructionOptions(thickness=drawing.thickness)

errors = {}
for density in Density:
    facade = reconstruct(resample_to(scan, density), options=options).facade
    geometry = compare_facades(facade, drawing).geometry
    errors[density.value] = {name: geometry[name]["relative_error"] for name in QUANTITIES}

worst = max(abs(error) for row in errors.values() for error in row.values())

if __name__ == "__main__":
    print("       " + "".join(f"{name:>14s}" for name in QUANTITIES))
    for density, row in errors.items():
        print(f"{density:7s}" + "".join(f"{error:>+14.2%}" for error in row.values()))
