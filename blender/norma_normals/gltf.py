"""Writes surfaces as one GLB file: a node with its world matrix and a mesh for each.

Axes stay Blender's (z up), so that places in findings are those that the viewport shows. Texture
coordinates run downwards as in glTF. A normal map is a flat picture of one texel: the rules want to
know that there is one; what its texels hold is looked at when the file is exported.
"""
from __future__ import annotations

import json
import struct
import zlib
from typing import Any, Dict, List

import numpy as np

from .surface import Material, Primitive, Surface

_FLOAT, _UINT = 5126, 5125
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class _Buffer:
    """The binary part, with its views and accessors."""

    def __init__(self) -> None:
        self.parts: List[bytes] = []
        self.size = 0
        self.views: List[Dict[str, int]] = []
        self.accessors: List[Dict[str, Any]] = []

    def view(self, data: bytes) -> int:
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data)})
        padded = data + b"\0" * (-len(data) % 4)
        self.parts.append(padded)
        self.size += len(padded)
        return len(self.views) - 1

    def accessor(self, array: np.ndarray, bounds: bool = False) -> int:
        width = 1 if array.ndim == 1 else array.shape[1]
        component = _UINT if array.dtype == np.uint32 else _FLOAT
        entry: Dict[str, Any] = {
            "bufferView": self.view(np.ascontiguousarray(array).tobytes()),
            "componentType": component,
            "count": len(array),
            "type": _TYPES[width],
        }
        if bounds:
            finite = np.where(np.isfinite(array), array, 0)
            entry["min"], entry["max"] = finite.min(0).tolist(), finite.max(0).tolist()
        self.accessors.append(entry)
        return len(self.accessors) - 1


def glb(surfaces: List[Surface], parts: List[List[Primitive]]) -> bytes:
    """The bytes of the file; parts are the primitives of each surface, which has one at least."""
    buffer = _Buffer()
    materials: List[Dict[str, Any]] = []
    root: Dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "meshes": [], "nodes": []}
    for number, (surface, primitives) in enumerate(zip(surfaces, parts)):
        base = len(materials)
        slots = surface.materials or [Material()]
        materials += [_material(slot) for slot in slots]
        made = [_primitive(buffer, p, base + min(p.material, len(slots) - 1)) for p in primitives]
        root["meshes"].append({"name": surface.name, "primitives": made})
        matrix = [float(x) for x in surface.matrix.T.reshape(-1)]
        root["nodes"].append({"name": surface.name, "mesh": number, "matrix": matrix})
    root["scenes"] = [{"nodes": list(range(len(surfaces)))}]
    root["materials"] = materials
    if any("normalTexture" in material for material in materials):
        root["images"] = [{"bufferView": buffer.view(_flat_picture()), "mimeType": "image/png"}]
        root["textures"] = [{"source": 0}]
    root["bufferViews"], root["accessors"] = buffer.views, buffer.accessors
    root["buffers"] = [{"byteLength": buffer.size}]
    return _container(root, b"".join(buffer.parts))


def _material(material: Material) -> Dict[str, Any]:
    made: Dict[str, Any] = {"name": material.name, "doubleSided": material.double_sided, "alphaMode": material.alpha_mode}
    if material.normal_map:
        made["normalTexture"] = {"index": 0}
    return made


def _primitive(buffer: _Buffer, p: Primitive, material: int) -> Dict[str, Any]:
    attributes = {"POSITION": buffer.accessor(p.positions, bounds=True), "NORMAL": buffer.accessor(p.normals)}
    if p.texcoords is not None:
        downwards = p.texcoords * np.float32([1, -1]) + np.float32([0, 1])
        attributes["TEXCOORD_0"] = buffer.accessor(downwards)
    if p.tangents is not None:
        attributes["TANGENT"] = buffer.accessor(p.tangents)
    return {"attributes": attributes, "indices": buffer.accessor(p.indices.reshape(-1)), "material": material}


def _flat_picture() -> bytes:
    """A PNG of one texel that leaves the normal as it is."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    texel = zlib.compress(b"\0\x80\x80\xff")
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", texel) + chunk(b"IEND", b"")


def _container(root: Dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(root, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return (
        struct.pack("<III", 0x46546C67, 2, total)
        + struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(binary), 0x004E4942)
        + binary
    )
