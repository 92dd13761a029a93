"""GLB files out: binary glTF 2.0, the format any viewer and browser shows.

glTF counts in metres with Y up; the root node turns and scales, so everything below it is in mm with Z up, as in the
scene. A geometry that occurs several times is stored once. Colours are linear in glTF, sRGB in a scene. The same scene
gives the same bytes.

Source: Khronos, glTF 2.0 specification, https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cablecad.brep.document import Color
from cablecad.brep.model import MeshNode, Patch
from cablecad.mesh import Mesh

_GLB, _VERSION, _JSON, _BIN = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963

_METRES = 1e-3
_Y_UP = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The quaternion (x, y, z, w) of a quarter turn about -X: Z becomes Y, Y becomes -Z."""

NO_COLOR: Color = (0.7, 0.72, 0.74, 1.0)
"""Of what has no colour of its own: glTF's default, bare metal, is black in most viewers."""


def glb_bytes(root: MeshNode, *, generator: str) -> bytes:
    """A tree of meshes as a GLB file.

    Args:
        root: From `mesh_scene`.
        generator: The program that made it, for the file's `asset`.
    """
    return _Glb(generator).bytes(root)


class _Glb:
    """A file as it grows."""

    def __init__(self, generator: str) -> None:
        self._binary = bytearray()
        self._json: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": []}
        for key in ("nodes", "meshes", "materials", "accessors", "bufferViews"):
            self._json[key] = []
        self._materials: dict[Color | None, int] = {}
        self._accessors: dict[int, dict[str, Any]] = {}
        self._meshes: dict[tuple[Any, ...], int] = {}
        # Keys are ids of objects, which must live as long as the keys do.
        self._alive: list[Mesh] = []

    def bytes(self, root: MeshNode) -> bytes:
        top = self._node(root)
        self._json["nodes"][top] |= {"rotation": list(_Y_UP), "scale": [_METRES] * 3}
        self._json["scenes"].append({"name": root.name, "nodes": [top]})
        self._json["buffers"] = [{"byteLength": len(self._binary)}]
        found = {key: value for key, value in self._json.items() if value != []}
        text = json.dumps(found, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self._binary) + b"\0" * (-len(self._binary) % 4)
        length = 12 + 8 + len(text) + 8 + len(binary)
        header = struct.pack("<III", _GLB, _VERSION, length)
        chunks = struct.pack("<II", len(text), _JSON) + text + struct.pack("<II", len(binary), _BIN) + binary
        return header + chunks

    def _node(self, node: MeshNode) -> int:
        """Add a node after those below it; its number."""
        made: dict[str, Any] = {"name": node.name}
        turn, move = node.placement[:, :3], node.placement[:, 3]
        if not np.array_equal(turn, np.eye(3)):
            matrix = np.vstack([node.placement, [0.0, 0.0, 0.0, 1.0]])
            made["matrix"] = matrix.T.ravel().tolist()  # column by column
        elif move.any():
            made["translation"] = move.tolist()
        if node.patches:
            made["mesh"] = self._mesh(node.name, node.patches)
        children = [self._node(child) for child in node.children]
        if children:
            made["children"] = children
        self._json["nodes"].append(made)
        return len(self._json["nodes"]) - 1

    def _mesh(self, name: str, patches: tuple[Patch, ...]) -> int:
        key = tuple((id(patch.mesh), patch.color) for patch in patches)
        if key not in self._meshes:
            primitives = [{**self._geometry(patch.mesh), "material": self._material(patch.color)} for patch in patches]
            self._json["meshes"].append({"name": name, "primitives": primitives})
            self._meshes[key] = len(self._json["meshes"]) - 1
        return self._meshes[key]

    def _geometry(self, mesh: Mesh) -> dict[str, Any]:
        if id(mesh) not in self._accessors:
            self._alive.append(mesh)
            positions = mesh.vertices.astype("<f4")
            kind, code = ("<u2", _SHORT) if len(positions) < 65536 else ("<u4", _INT)
            bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
            normals = mesh.normals.astype("<f4")
            self._accessors[id(mesh)] = {
                "attributes": {
                    "POSITION": self._accessor(positions, _FLOAT, "VEC3", _ARRAY_BUFFER, **bounds),
                    "NORMAL": self._accessor(normals, _FLOAT, "VEC3", _ARRAY_BUFFER),
                },
                "indices": self._accessor(mesh.triangles.astype(kind).ravel(), code, "SCALAR", _ELEMENT_ARRAY_BUFFER),
            }
        return self._accessors[id(mesh)]

    def _accessor(self, values: NDArray[Any], code: int, kind: str, target: int, **bounds: Any) -> int:
        self._binary += b"\0" * (-len(self._binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": values.nbytes, "target": target}
        self._binary += values.tobytes()
        self._json["bufferViews"].append(view)
        accessor = {"bufferView": len(self._json["bufferViews"]) - 1, "componentType": code, "count": len(values)}
        self._json["accessors"].append({**accessor, "type": kind, **bounds})
        return len(self._json["accessors"]) - 1

    def _material(self, color: Color | None) -> int:
        if color not in self._materials:
            red, green, blue, alpha = NO_COLOR if color is None else color
            surface = {
                "baseColorFactor": [*(round(_linear(value), 6) for value in (red, green, blue)), round(alpha, 6)],
                "metallicFactor": 0.0,
                "roughnessFactor": 0.5,
            }
            # Both sides: a part need not be closed.
            made: dict[str, Any] = {"pbrMetallicRoughness": surface, "doubleSided": True}
            if alpha < 1.0:
                made["alphaMode"] = "BLEND"
            self._json["materials"].append(made)
            self._materials[color] = len(self._json["materials"]) - 1
        return self._materials[color]


def _linear(value: float) -> float:
    """From sRGB to linear light; IEC 61966-2-1."""
    return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)
