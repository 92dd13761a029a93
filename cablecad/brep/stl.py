"""Binary STL files out: bare triangles in mm, for printers and for programs that read nothing else.

The format has neither names nor colours nor a unit, and 7 digits of each coordinate.
"""

from __future__ import annotations

import logging
import math

import numpy as np

from cablecad.brep.model import MeshNode

_log = logging.getLogger(__name__)

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

_ROUNDING = 2.0**-24
"""Of a number of 24 bits, as a share of it."""

_FREE = 0.4
"""What a mesh leaves of its tolerance, at least: 0.42 was the least of some 180 cables."""

_HEADER = b"cablecad, binary STL, lengths in mm"
"""It must not begin with `solid`, as STL in text does."""


def stl_bytes(root: MeshNode, *, finest: float) -> bytes:
    """All triangles of a tree of meshes as a binary STL file.

    Args:
        root: From `mesh_scene`.
        finest: The detail that shall not drown in rounding [mm]; if it does a warning is logged.
    """
    corners = np.concatenate([patch.mesh.vertices[patch.mesh.triangles] for patch in root.placed_patches()])
    rounding = _ROUNDING * float(np.abs(corners).max(initial=0.0))
    if math.sqrt(3.0) * rounding > _FREE * finest:
        _log.warning(
            "STL keeps 7 digits: so far from the origin coordinates are rounded by up to %.2g mm, too much for the "
            "mesh's %.2g mm; move the scene nearer to the origin, or write .glb or .step",
            rounding,
            finest,
        )
    rounded = corners.astype("<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(normals, axis=1)
    records = np.zeros(len(corners), dtype=_RECORD)
    records["corners"] = rounded
    records["normal"] = np.divide(normals, sizes[:, None], out=np.zeros_like(normals), where=sizes[:, None] > 0.0)
    return _HEADER.ljust(80) + np.uint32(len(records)).tobytes() + records.tobytes()
