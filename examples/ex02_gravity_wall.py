"""A plain wall under its own weight, beside the closed form.

Without lateral contraction (ν = 0) every column of the wall carries what stands on it, whatever its base is
held by: σ_zz = -ρ g (H - z), so that the top sinks by::

    u_top = -∫₀ᴴ ρ g (H - z) / E dz = -ρ g H² / (2 E)

The displacement is quadratic in z and the elements are quadratic: the answer is exact.
"""

from fd2fem.meshing import MeshOptions, mesh_facade
from fd2fem.model import Facade, rectangle
from solvers import AnalysisOptions, LinearSettlement, Material, analyse

WIDTH, HEIGHT, THICKNESS = 4.0, 6.0, 0.35  # m
brick = Material(young=3.48e9, poisson=0.0, density=1900.0, source="example")
at_rest = LinearSettlement(vertical_left=0, vertical_right=0, horizontal_left=0, horizontal_right=0)

wall = Facade(rectangle(0, 0, WIDTH, HEIGHT), THICKNESS)
mesh = mesh_facade(wall, options=MeshOptions(size=0.5))
response = analyse(mesh, options=AnalysisOptions(material=brick, settlement=at_rest, gravity=9.81))

u_top = response.displacement[mesh.group_nodes("top"), 2].mean()
base_stress = response.stress[mesh.group_nodes("base"), 2].mean()
reaction = response.reaction[2]

if __name__ == "__main__":
    weight = brick.density * 9.81  # N/m³
    print(f"u_top     {u_top:.6e} m   by hand {-weight * HEIGHT**2 / (2 * brick.young):.6e} m")
    print(f"σ_zz base {base_stress:.6e} Pa  by hand {-weight * HEIGHT:.6e} Pa")
    print(f"reaction  {reaction:.6e} N   by hand {weight * WIDTH * HEIGHT * THICKNESS:.6e} N")
