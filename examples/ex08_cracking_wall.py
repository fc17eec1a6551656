"""Building 1 of masonry that cracks, on ground that a tunnel moves: the paper's material and load.

The wall follows the ground nearly as a rigid body (see ``ex06_settlement``: 99.1 mm by hand, 99.6 mm in the
paper). Where the base is stretched, an elastic wall would pull with many times the strength of masonry; one
that cracks opens there instead, and at no time is its stress beyond the tensile strength of 1.15 MPa. It
stands on two piers beside a door: each is a foot, of which the response lists the force of the ground.

With a folder as its argument, the script writes the figures, the load-settlement curve, the final state and a
series of ten states for ParaView, and keeps the state of the analysis: killed at any moment and started
again, it goes on.
"""

import sys
from pathlib import Path

from fd2fem.drawings import stand_in
from fd2fem.meshing import MeshOptions, mesh_facade
from solvers import AnalysisOptions, MasonryLaw, SteppingOptions, analyse, write_response
from solvers.vtu_files import StepSeries

mesh = mesh_facade(stand_in("building1"), options=MeshOptions(size=0.4))
options = AnalysisOptions(masonry=MasonryLaw(fracture_energy=100.0), stepping=SteppingOptions(steps=20))

folder = Path(sys.argv[1]) if __name__ == "__main__" and len(sys.argv) > 1 else None
state = folder / ".analysis_state.npz" if folder else None
response = analyse(mesh, options=options, state=state, on_step=StepSeries(folder, mesh) if folder else None)
elastic = analyse(mesh)

max_displacement = response.max_displacement
stress_ratio = elastic.max_principal_stress / response.max_principal_stress

if __name__ == "__main__":
    if folder and state:
        write_response(response, folder)
        state.unlink()
    for step in response.history[::4]:
        print(
            f"{100 * step['share']:4.0f} % of the settlement: {1000 * step['max_displacement']:5.1f} mm, "
            f"crack {1000 * step['max_crack_opening']:.2f} mm, {step['iterations']} iterations"
        )
    for foot in response.feet:
        x, _, z = foot["reaction_n"]
        print(f"foot from {foot['x_m'][0]:.2f} m: {x / 1e3:.1f} kN along the wall, {z / 1e3:.1f} kN upwards")
    print(
        f"largest stress {response.max_principal_stress / 1e6:.2f} MPa, in the last step "
        f"{response.final_principal_stress / 1e6:.2f}; elastic {stress_ratio:.1f} times the largest"
    )
    print(f"damage: {response.damage['crack_label']} by its cracks; {response.solver['warnings']}")
