"""What must hold of any mesh of a facade, from closed forms and from VTK."""

import numpy as np
import pytest

from fd2fem.model import OpeningKind
from fd2fem.model.topology import FACETS

VTK_HEXAHEDRON = 12


def facet_areas(mesh, name):
    """Vector area (f, 3) of each facet of a group."""
    corner = mesh.nodes[mesh.groups[name][:, :4]]
    return np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2


def group_area(mesh, name):
    return float(np.linalg.norm(facet_areas(mesh, name), axis=1).sum())


def vtk_grid(mesh):
    """The hexahedra as VTK's own."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.nodes), deep=True))
    rows = np.hstack([np.full((len(mesh.elements), 1), 8), mesh.elements]).astype(np.int64)
    cells = vtk.vtkCellArray()
    cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(np.ascontiguousarray(rows.ravel()), deep=True))
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(VTK_HEXAHEDRON, cells)
    return grid


def vtk_quality(mesh, *, volume=False):
    """Scaled Jacobian, or volume, of each element by VTK's Verdict."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    quality = vtk.vtkMeshQuality()
    if volume:
        quality.SetHexQualityMeasureToVolume()
    else:
        quality.SetHexQualityMeasureToScaledJacobian()
    quality.SetInputData(vtk_grid(mesh))
    quality.Update()
    return vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))


def assert_conformal(mesh):
    """Each facet belongs to one element or to two; the single ones are just those of the groups."""
    facets = np.sort(mesh.elements[:, np.array(FACETS[mesh.kind])].reshape(-1, 4), axis=1)
    unique, count = np.unique(facets, axis=0, return_counts=True)
    assert set(count.tolist()) <= {1, 2}
    named = np.sort(np.vstack(list(mesh.groups.values())), axis=1)
    np.testing.assert_array_equal(np.unique(named, axis=0), unique[count == 1])
    assert len(named) == (count == 1).sum()  # none in two groups
    assert len(np.unique(mesh.nodes.round(9), axis=0)) == len(mesh.nodes)


def assert_fills(mesh, facade):
    """Volume by VTK, areas of the groups by closed form, and a closed surface."""
    assert vtk_quality(mesh, volume=True).sum() == pytest.approx(facade.volume, rel=1e-12)
    assert group_area(mesh, "front") == pytest.approx(facade.wall_area, rel=1e-9)
    assert group_area(mesh, "back") == pytest.approx(facade.wall_area, rel=1e-9)
    assert (facet_areas(mesh, "front")[:, 1] < 0).all()
    assert (facet_areas(mesh, "back")[:, 1] > 0).all()
    doors = sum(
        np.ptp(opening.outline[opening.outline[:, 1] < 1e-6, 0])
        for opening in facade.openings
        if opening.kind is OpeningKind.DOOR
    )
    foot = np.ptp(facade.outline[facade.outline[:, 1] < 1e-6, 0])
    assert group_area(mesh, "base") == pytest.approx((foot - doors) * facade.thickness, rel=1e-9)
    total = sum(facet_areas(mesh, name).sum(axis=0) for name in mesh.groups)
    np.testing.assert_allclose(total, 0.0, atol=1e-9)


def ledge_area(facade):
    """Closed form: the wall's length at each level times the step there, by shapely."""
    import shapely

    wall = shapely.Polygon(facade.outline).difference(
        shapely.union_all([shapely.Polygon(opening.outline) for opening in facade.openings])
    )
    area = 0.0
    for below, above in zip(facade.bands, facade.bands[1:], strict=False):
        line = shapely.LineString([(-1.0, above.low), (facade.length + 1.0, above.low)])
        area += wall.intersection(line).difference(wall.boundary).length * abs(
            below.thickness - above.thickness
        )
    return area
