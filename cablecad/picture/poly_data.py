"""From numpy to VTK: triangles and polylines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array
from cablecad.mesh import Triangles

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkPolyData


def poly_data(
    vertices: Array, triangles: Triangles, *, normals: Array | None = None, colors: Array | None = None
) -> Any:
    """Triangles as VTK takes them."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    data = _with_points(vertices)
    cells = vtkCellArray()
    count = len(triangles)
    cells.SetData(_ids(np.arange(0, 3 * count + 1, 3)), _ids(np.asarray(triangles).ravel()))
    data.SetPolys(cells)
    if normals is not None:
        data.GetPointData().SetNormals(numpy_to_vtk(np.ascontiguousarray(normals, dtype=np.float32), deep=True))
    if colors is not None:
        bytes_ = np.ascontiguousarray(np.rint(255.0 * colors), dtype=np.uint8)
        data.GetPointData().SetScalars(numpy_to_vtk(bytes_, deep=True))
    return data


def poly_lines(lines: list[Array]) -> vtkPolyData:
    """Polylines as VTK takes them."""
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    points = np.concatenate(lines)
    data = _with_points(points)
    cells = vtkCellArray()
    cells.SetData(_ids(np.cumsum([0] + [len(line) for line in lines])), _ids(np.arange(len(points))))
    data.SetLines(cells)
    return data


def _with_points(places: Array) -> vtkPolyData:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    data, points = vtkPolyData(), vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=np.float32), deep=True))
    data.SetPoints(points)
    return data


def _ids(values: NDArray[Any]) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray

    return numpy_to_vtkIdTypeArray(np.ascontiguousarray(values, dtype=np.int64), deep=True)
