"""Building 1 on ground that a tunnel moves: the paper's load.

The base sinks by 44.5 mm at the left end and 17.8 mm at the right one, and moves to the left by 28.3 and
17.7 mm. Some way above its base the wall follows as a rigid body: it moves with the mean of the base and
turns by θ = (44.5 - 17.8) / L. So the top left corner moves by about::

    u = √((mean horizontal + θ H)² + 44.5²),   θ H = 26.7 x 12.16 / 4.95 = 65.6 mm
      = √((23.0 + 65.6)² + 44.5²) = 99.1 mm    (the paper: 99.6 mm)

If the ground sinks most at the other end instead, the two movements of the top work against one another::

    u = √((65.6 - 23.0)² + 44.5²) = 61.6 mm
"""

from fd2fem.drawings import stand_in
from fd2fem.meshing import MeshOptions, mesh_facade, mesh_quality
from solvers import AnalysisOptions, LinearSettlement, analyse

drawing = stand_in("building1")
mesh = mesh_facade(drawing, options=MeshOptions(size=0.4))

towards = LinearSettlement(
    vertical_left=-0.0445, vertical_right=-0.0178, horizontal_left=-0.0283, horizontal_right=-0.0177
)
against = LinearSettlement(
    vertical_left=-0.0178, vertical_right=-0.0445, horizontal_left=-0.0283, horizontal_right=-0.0177
)
response = analyse(mesh, options=AnalysisOptions(settlement=towards))
other = analyse(mesh, options=AnalysisOptions(settlement=against))

max_displacement, max_displacement_other = response.max_displacement, other.max_displacement

if __name__ == "__main__":
    print(f"{mesh_quality(mesh).elements} elements, {response.dofs:,} unknowns")
    for name, result in (("sinking and moving together", response), ("against one another", other)):
        print(
            f"{name}: displacement {1000 * result.max_displacement:.1f} mm, "
            f"σ1 at 99 % of the volume {result.p99_principal_stress / 1e6:.2f} MPa"
        )
