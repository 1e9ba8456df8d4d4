"""New files from arrays: OBJ, PLY, STL and GLB."""
from __future__ import annotations

import json
import os
import struct
from typing import Any, Dict, List, Literal, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _norma
from ._arguments import Faces, Mesh, mesh, vectors
from ._calls import face_normals, index_corners
from ._files import Path, bytes_of, raise_document
from ._surfaces import triangles

_FORMATS = ("obj", "ply", "stl", "glb")


class _Surface:
    """What is written: corners as 32-bit indices, offsets of faces, attributes per position or corner."""

    def __init__(self, m: Mesh, format: str) -> None:
        points = m.positions
        if not np.isfinite(points).all():
            bad = int(np.flatnonzero(~np.isfinite(points).all(1))[0])
            raise ValueError(f"positions[{bad}]: finite numbers are needed, not {tuple(points[bad].tolist())}")
        self.positions: NDArray[Any] = points
        self.count = m.face_count
        corners = np.arange(m.corner_count) if m.corners is None else m.corners.reshape(-1)
        self.corners: NDArray[np.uint32] = corners.astype(np.uint32, copy=False)
        high = np.flatnonzero(self.corners >= len(points))
        if high.size:
            raise IndexError(f"faces: index {self.corners[high[0]]} of corner {high[0]}; an index below {len(points)} is needed")
        self.starts = np.arange(m.face_count + 1) * 3 if m.starts is None else m.starts.astype(np.int64)
        self.sizes = np.diff(self.starts)
        if len(self.sizes) and self.sizes.min() < 3:
            raise ValueError(f"faces[{int(np.argmin(self.sizes))}]: three corners or more are needed, not {self.sizes.min()}")
        self.face_of, self.fans = np.arange(self.count), np.arange(len(self.corners))
        if format in ("stl", "glb") and (self.sizes != 3).any():  # which hold triangles only
            self.face_of, fans, _ = triangles(points, self.corners, self.starts)
            self.fans = fans.ravel()
        if format == "glb" and not m.corner_count:
            raise ValueError("faces: glb holds no mesh without faces")

    def attribute(self, name: str, values: ArrayLike, width: int) -> NDArray[Any]:
        """Rows that are one for each position, or else for each corner."""
        array = vectors(name, values, width)[0]
        if len(array) not in (len(self.positions), len(self.corners)):
            raise ValueError(f"{name}: one for each of {len(self.positions)} positions or {len(self.corners)} corners is needed, not {len(array)}")
        bad = np.flatnonzero(~np.isfinite(array).all(1))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}]: finite numbers are needed, not {tuple(array[bad[0]].tolist())}")
        return array

    def split(self, attributes: Dict[str, NDArray[Any]]) -> Dict[str, NDArray[Any]]:
        """Makes all attributes per position: a position has a vertex for each set of values at its corners."""
        if all(len(array) == len(self.positions) for array in attributes.values()):
            return attributes
        each = {name: array if len(array) != len(self.positions) else array[self.corners] for name, array in attributes.items()}
        indices, first = index_corners(self.corners, *each.values())
        self.positions, self.corners = self.positions[self.corners[first]], indices
        return {name: array[first] for name, array in each.items()}


def _floats(name: str, array: NDArray[Any], format: str) -> NDArray[np.float32]:
    """Numbers for a format that holds floats; those beyond them would become infinities."""
    with np.errstate(over="ignore"):
        floats = array.astype(np.float32, copy=False)
    bad = np.flatnonzero(~np.isfinite(floats).all(1))
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: {format} holds floats of 32 bits here; finite numbers up to 3.4e38 are needed, "
                         f"not {tuple(array[bad[0]].tolist())}")
    return floats


def _lines(word: str, array: NDArray[Any]) -> str:
    number = "%.9g" if array.dtype.itemsize <= 4 else "%.17g"
    return f"{word} {' '.join([number] * array.shape[1])}\n" * len(array) % tuple(array.ravel().tolist())


def _obj(s: _Surface, attributes: Dict[str, NDArray[Any]]) -> bytes:
    parts = [_lines("v", s.positions)]
    columns = [s.corners]
    for name, word in (("texcoords", "vt"), ("normals", "vn")):
        if name in attributes:
            parts.append(_lines(word, attributes[name]))
            per_corner = len(attributes[name]) != len(s.positions)
            columns.append(np.arange(len(s.corners), dtype=np.uint32) if per_corner else s.corners)
    corner = {1: " %d", 3: " %d/%d/%d"}.get(len(columns), " %d/%d" if "texcoords" in attributes else " %d//%d")
    numbers = np.stack(columns, 1) + np.uint32(1)
    if len(s.sizes) and (s.sizes == s.sizes[0]).all():
        form = ("f" + corner * int(s.sizes[0]) + "\n") * s.count
    else:
        form = "".join(["f" + corner * size + "\n" for size in s.sizes.tolist()])
    return ("".join(parts) + form % tuple(numbers.ravel().tolist())).encode()


def _ply(s: _Surface, attributes: Dict[str, NDArray[Any]]) -> bytes:
    attributes = s.split({name: _floats(name, array, "ply") for name, array in attributes.items()})
    kind = "f4" if s.positions.dtype.itemsize <= 4 else "f8"
    fields = [(axis, "<" + kind) for axis in "xyz"]
    fields += [(axis, "<f4") for axis in ("nx", "ny", "nz") * ("normals" in attributes)]
    fields += [(axis, "<f4") for axis in ("s", "t") * ("texcoords" in attributes)]
    rows = np.empty(len(s.positions), fields)
    columns = [s.positions] + [attributes[name] for name in ("normals", "texcoords") if name in attributes]
    for (name, _), values in zip(fields, np.concatenate([c.astype(np.float64, copy=False) for c in columns], 1).T):
        rows[name] = values
    wide = bool(len(s.sizes)) and int(s.sizes.max()) > 255
    names = {"<f4": "float", "<f8": "double"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}",
              *(f"property {names[type_]} {name}" for name, type_ in fields),
              f"element face {s.count}", f"property list {'uint' if wide else 'uchar'} uint vertex_indices", "end_header", ""]
    count = np.dtype("<u4" if wide else "u1")
    at = s.starts[:-1] * 4 + np.arange(s.count) * count.itemsize  # of each face's count
    body = np.zeros(len(s.corners) * 4 + s.count * count.itemsize, np.uint8)
    counts = np.zeros(len(body), bool)
    for k in range(count.itemsize):
        body[at + k] = s.sizes >> (8 * k) & 255
        counts[at + k] = True
    body[~counts] = s.corners.astype("<u4").view(np.uint8)
    return "\n".join(header).encode() + rows.tobytes() + body.tobytes()


def _stl(s: _Surface, attributes: Dict[str, NDArray[Any]]) -> bytes:
    rows = np.zeros(len(s.face_of), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = _floats("positions", s.positions, "stl")[s.corners[s.fans]].reshape(-1, 3, 3)
    rows["normal"] = _floats("normals", attributes["normals"], "stl")
    return b"norma".ljust(80, b"\0") + struct.pack("<I", len(rows)) + rows.tobytes()


def _glb(s: _Surface, attributes: Dict[str, NDArray[Any]]) -> bytes:
    s.positions = _floats("positions", s.positions, "glb")
    attributes = s.split({name: _floats(name, array, "glb") for name, array in attributes.items()})
    positions = s.positions
    names = {"normals": "NORMAL", "tangents": "TANGENT", "texcoords": "TEXCOORD_0"}
    small = len(positions) < 65536  # 65535 restarts strips
    arrays: List[Tuple[Optional[str], NDArray[Any]]] = [(None, s.corners[s.fans].astype(np.uint16 if small else np.uint32)), ("POSITION", positions)]
    arrays += [(names[name], array) for name, array in attributes.items()]
    views: List[Dict[str, Any]] = []
    accessors: List[Dict[str, Any]] = []
    body = b""
    for name, array in arrays:
        views.append({"buffer": 0, "byteOffset": len(body), "byteLength": array.nbytes, "target": 34962 if name else 34963})
        accessor: Dict[str, Any] = {"bufferView": len(accessors), "componentType": 5126 if name else 5123 if small else 5125,
                                    "count": len(array), "type": f"VEC{array.shape[1]}" if name else "SCALAR"}
        if name == "POSITION":
            accessor["min"], accessor["max"] = array.min(0).tolist(), array.max(0).tolist()
        accessors.append(accessor)
        body += array.astype(array.dtype.newbyteorder("<")).tobytes()
        body += b"\0" * (-len(body) % 4)
    primitive = {"attributes": {name: i for i, (name, _) in enumerate(arrays) if name}, "indices": 0}
    gltf = {"asset": {"version": "2.0", "generator": f"norma {_norma.version()}"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(body)}]}
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def write(
    path: Union[Path, Any],
    positions: Any,
    faces: Faces = None,
    *,
    normals: Optional[ArrayLike] = None,
    texcoords: Optional[ArrayLike] = None,
    tangents: Optional[ArrayLike] = None,
    format: Optional[Literal["obj", "ply", "stl", "glb"]] = None,
) -> None:
    """Writes a new file, whole or not at all: binary PLY, binary STL, OBJ or GLB, by the path's ending.

    path: a path, or a file object opened for bytes, such as io.BytesIO(); that needs `format`.
    positions: (n, 3) numbers, or a whole mesh: of `norma.open`, trimesh, meshio, Open3D, pyvista, VTK.
    faces: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each
        three positions are a triangle. It may be left out only beside an object that has faces.
    STL and GLB hold triangles, into which convex polygons are cut, and floats of 32 bits; OBJ and PLY hold polygons,
        and doubles if they are given.
    normals: one for each position or for each corner; in STL one for each face (None: as the winding is).
        In GLB and PLY a vertex is split where its corners differ. Lengths are written as they are given.
    texcoords: (n, 2), one for each position or for each corner; v is written as it is given.
    tangents: GLB only; (n, 4), one for each position or for each corner.

    >>> import io, norma_mesh as norma
    >>> file = io.BytesIO()
    >>> norma.write(file, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals=[[0, 0, 1]] * 3, format="ply")
    >>> norma.open(file.getvalue()).meshes[0].normals[0]
    array([0., 0., 1.], dtype=float32)
    """
    to_file = getattr(path, "write", None)
    encoded = b"" if to_file else bytes_of("path", path)
    kind = format or os.path.splitext(os.fsdecode(encoded))[1][1:].lower()
    if kind not in _FORMATS:
        what = "a file object" if to_file else repr(os.fsdecode(encoded))
        raise ValueError(f"format: one of {', '.join(map(repr, _FORMATS))} is needed for {what}, not {kind!r}")
    m = mesh(positions, faces)
    surface = _Surface(m, kind)
    attributes: Dict[str, NDArray[Any]] = {}
    if kind == "stl":
        if texcoords is not None or tangents is not None:
            raise ValueError(f"{'texcoords' if texcoords is not None else 'tangents'}: stl holds none")
        if normals is None:
            attributes["normals"] = face_normals(surface.positions, surface.corners[surface.fans].reshape(-1, 3))
        else:
            own = vectors("normals", normals)[0]
            if len(own) != surface.count:
                raise ValueError(f"normals: stl holds one for each of {surface.count} faces, not {len(own)}")
            attributes["normals"] = own[surface.face_of]
    else:
        for name, values, width in (("texcoords", texcoords, 2), ("normals", normals, 3), ("tangents", tangents, 4)):
            if values is not None:
                attributes[name] = surface.attribute(name, values, width)
        if tangents is not None and kind != "glb":
            raise ValueError(f"tangents: {kind} holds none; glb does")
    contents = {"obj": _obj, "ply": _ply, "stl": _stl, "glb": _glb}[kind](surface, attributes)
    if to_file:
        to_file(contents)
        return
    answer = _norma.save_bytes(encoded, contents)
    if answer is not None:
        raise_document(answer)
