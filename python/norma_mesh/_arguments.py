"""Looks at arguments and turns them into the addresses, counts and strides that the extension takes.

Arrays that the library can read as they lie are not copied: float32 and float64 positions whose
three numbers lie side by side, whatever lies between the rows, and indices of 32, 16 or 8 bits
without a sign (or with one, where none is negative) that are packed. Anything else is converted
once. Whatever is wrong is named in the text of a ValueError, TypeError or IndexError.
"""
from __future__ import annotations

import math
import operator
import os
import re
from typing import Any, Literal, NamedTuple, NoReturn, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _norma

Array = NDArray[Any]
Floats = NDArray[np.float32]
Indices = NDArray[np.uint32]
#: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each three
#: positions are a triangle. None beside an object that has faces.
Faces = Union[ArrayLike, Sequence[ArrayLike], Tuple[ArrayLike, ArrayLike], Literal["soup"], None]
Weight = Literal["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"]
Weld = Union[Literal["exact", "none"], float]  #: equal positions share a normal, none do, or those within a distance
Fallback = Union[Literal["zero", "nearest"], Sequence[float], Array]
NonManifold = Literal["hard", "smooth"]
TangentMode = Literal["mikk", "steady"]
Encoding = Literal["oct8", "oct12", "oct16", "10-10-10-2"]
Profile = Literal["auto", "render", "print", "generated"]

POINTS = ("Points alone are no surface: estimate their normals from neighbours (Open3D's estimate_normals), "
          "or make a mesh of them first")
WEIGHTS = {name: number for number, name in enumerate(_norma.weights())}
NON_MANIFOLD = {"hard": 0, "smooth": 1}
ALL_THREADS = 0xFFFFFFFF

_FLOATS = {np.dtype(np.float32): 0, np.dtype(np.float64): 1}
_FLOAT32 = np.dtype(np.float32)
_UINT32 = np.dtype(np.uint32)
_PACKED_INDICES = {np.dtype(t): np.dtype(t).itemsize for t in (np.uint32, np.int32, np.uint16, np.uint8)}
_MESHES = "(n, 3) numbers and faces, or a mesh (of norma.open, trimesh, meshio, Open3D, pyvista or VTK) are needed"
_VTK_FLAT = (5, 7, 9)  # VTK's numbers for triangles, polygons and quads
_FLAT = re.compile(r"triangle|quad|polygon\d*")  #: meshio's types of cells that are faces
_NO_FACES = re.compile("(VTK_LAGRANGE_)?(vertex|line|curve|tetra|hexa|wedge|pyramid|penta_prism|polyhedron)", re.IGNORECASE)
_NAMES = {
    "mesh->positions": "positions",
    "mesh->corners": "faces",
    "mesh->corner_count": "faces",
    "mesh->face_starts": "faces",
    "mesh->face_count": "faces",
    "crease_angle_rad": "crease",
    "options->weld_distance": "weld",
    "options->fallback_normal": "fallback",
}


def choice(name: str, value: object, choices: dict[str, int]) -> int:
    """The number of a word, or a ValueError that lists the words."""
    try:
        return choices[value]  # type: ignore[index]
    except (KeyError, TypeError):
        words = ", ".join(repr(word) for word in choices)
        raise ValueError(f"{name}: one of {words} is needed, not {value!r}") from None


def number(name: str, value: object) -> float:
    """A float, or a TypeError or ValueError that names the argument."""
    try:
        result = float(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name}: a number is needed, not {type(value).__name__}") from None
    except ValueError:
        raise ValueError(f"{name}: a number is needed, not {value!r}") from None
    except OverflowError:
        raise ValueError(f"{name}: a smaller number is needed") from None
    return result


def crease_radians(crease: object) -> float:
    """A crease in degrees, in radians."""
    degrees = number("crease", crease)
    if not degrees <= 180:
        raise ValueError(f"crease: degrees up to 180 are needed, not {degrees!r}")
    return math.radians(max(degrees, -360.0))


def given_degrees(radians: float) -> float:
    """Degrees as they were given: without what their way through radians added."""
    return round(math.degrees(radians) * 1e9) / 1e9


def thread_count(threads: object) -> int:
    """None: as many threads as the machine runs at once."""
    return ALL_THREADS if threads is None else count_of("threads", threads)


def count_of(name: str, value: object, most: int = ALL_THREADS - 1) -> int:
    """From 1 to most, or a TypeError or ValueError that names the argument."""
    try:
        count = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name}: an integer is needed, not {type(value).__name__}") from None
    if not 0 < count <= most:
        raise ValueError(f"{name}: a number from 1 to {most} is needed")
    return count


def weld_of(weld: Weld) -> Tuple[int, float]:
    """The number of a weld, and its distance."""
    if weld == "exact":
        return 0, 0.0
    if weld == "none":
        return 1, 0.0
    if isinstance(weld, str):
        raise ValueError(f"weld: 'exact', 'none' or a distance is needed, not {weld!r}")
    distance = number("weld", weld)
    if not 0 <= distance < math.inf:
        raise ValueError(f"weld: a finite distance of at least 0 is needed, not {distance!r}")
    return 2, distance


def options(
    weight: Weight = "angle",
    weld: Weld = "exact",
    fallback: Fallback = "zero",
    non_manifold: NonManifold = "hard",
    threads: Optional[int] = None,
    normal_stride: int = 0,
) -> Tuple[Any, ...]:
    """The second argument of the extension's calls on meshes."""
    mode, distance = weld_of(weld)
    kind, given = 0, (0.0, 0.0, 0.0)
    if isinstance(fallback, str):
        if fallback not in ("zero", "nearest"):
            raise ValueError(f"fallback: 'zero', 'nearest' or three numbers are needed, not {fallback!r}")
        kind = int(fallback == "nearest")
    else:
        kind = 2
        three = tuple(number("fallback", part) for part in np.ravel(as_array("fallback", fallback)))
        if len(three) != 3 or not all(abs(part) <= 3.4028234e38 for part in three):
            raise ValueError(f"fallback: three finite numbers are needed, not {fallback!r}")
        given = (three[0], three[1], three[2])
    return (
        choice("weight", weight, WEIGHTS),
        mode,
        distance,
        choice("non_manifold", non_manifold, NON_MANIFOLD),
        kind,
        *given,
        normal_stride,
        0,
        thread_count(threads),
    )


def as_array(name: str, values: object) -> Array:
    """An array, or a ValueError that names what cannot be one, such as rows of different lengths."""
    if type(values) is np.ndarray:
        return values
    try:
        return np.asarray(values)
    except (ValueError, TypeError, OverflowError) as problem:
        raise ValueError(f"{name}: an array is needed: {problem}") from None


def vectors(name: str, values: ArrayLike, width: int = 3) -> Tuple[Array, int]:
    """An array of `width` floats a row that the library can read, and the number of its format."""
    array = as_array(name, values)
    if array.ndim != 2 or array.shape[1] != width:
        if array.size == 0 and array.ndim == 1:
            array = array.reshape(0, width)
        else:
            raise ValueError(f"{name}: shape (n, {width}) is needed, not {array.shape}")
    kind = _FLOATS.get(array.dtype)
    if kind is None:
        if array.dtype.kind not in "fiu":
            raise TypeError(f"{name}: numbers are needed, not {array.dtype}")
        small = array.dtype.kind == "f" and array.dtype.itemsize <= 4
        array = array.astype(np.float32 if small else np.float64)
        kind = 0 if small else 1
    row, column = array.strides
    if column != array.itemsize or (row < width * array.itemsize and array.shape[0] > 1):
        array = np.ascontiguousarray(array)
    return array, kind


def stride(array: Array) -> int:
    """Bytes from row to row, for the library."""
    return int(array.strides[0]) if array.shape[0] > 1 else 0


def output(name: str, out: object, rows: int, width: int, *inputs: Array) -> Floats:
    """The caller's array to write to, or a new one."""
    if out is None:
        return np.empty((rows, width), np.float32)
    if type(out) is not np.ndarray or out.dtype != _FLOAT32:
        found = out.dtype if isinstance(out, np.ndarray) else type(out).__name__
        raise TypeError(f"{name}: an array of float32 is needed, not {found}")
    if out.shape != (rows, width):
        raise ValueError(f"{name}: shape ({rows}, {width}) is needed, not {out.shape}")
    if not out.flags.writeable:
        raise ValueError(f"{name}: the array cannot be written")
    if out.strides[1] != 4 or (out.strides[0] < 4 * width and rows > 1):
        raise ValueError(f"{name}: the {width} numbers of a row must lie side by side, row after row")
    for array in inputs:
        if np.may_share_memory(out, array) and _overlap(out, array):
            raise ValueError(f"{name}: the array overlaps an input")
    return out


def _overlap(a: Array, b: Array) -> bool:
    try:
        return bool(np.shares_memory(a, b, max_work=100000))
    except (RuntimeError, ValueError):  # too hard to tell
        return True


def integers(name: str, values: ArrayLike) -> Array:
    """An array of integers, of any shape."""
    array = as_array(name, values)
    if array.dtype.kind not in "iu":
        if array.size == 0:
            return array.astype(np.uint32)
        raise TypeError(f"{name}: integers are needed, not {array.dtype}")
    return array if array.dtype.isnative else array.astype(array.dtype.newbyteorder("="))


def indices(name: str, array: Array) -> Array:
    """Packed indices of 4, 2 or 1 bytes, in the order of the array's elements."""
    if array.ndim not in (1, 2):
        array = array.reshape(-1)
    if array.dtype in _PACKED_INDICES and array.flags.c_contiguous and array.flags.aligned:
        return array
    converted = np.empty(array.shape, np.uint32)
    rows, row_stride = (1, 0) if array.ndim == 1 else (array.shape[0], array.strides[0])
    bad = _norma.indices(
        array.__array_interface__["data"][0],
        rows,
        array.shape[-1],
        row_stride,
        array.strides[-1],
        array.itemsize,
        array.dtype.kind == "i",
        converted.__array_interface__["data"][0],
    )
    if bad >= 0:
        raise_index(name, array, bad)
    return converted


def raise_index(name: str, array: Array, flat: int, count: Optional[int] = None) -> NoReturn:
    place = np.unravel_index(flat, array.shape)
    where = ", ".join(str(int(i)) for i in place)
    limit = f"below {count}" if count is not None else "from 0 to 4294967294"
    raise IndexError(f"{name}[{where}] is {array[place]}; an index {limit} is needed")


class Mesh(NamedTuple):
    """A mesh for the extension; the arrays must live as long as `call` is used."""

    call: Tuple[Any, ...]
    positions: Array
    corners: Optional[Array]
    starts: Optional[Indices]
    faces: Optional[Array]  #: as given, for messages
    corner_count: int
    face_count: int
    extras: Tuple[Array, ...] = ()


def _polygons(faces: Sequence[ArrayLike]) -> Tuple[Array, Array]:
    rows = [integers(f"faces[{i}]", row) for i, row in enumerate(faces)]
    for i, row in enumerate(rows):
        if row.ndim != 1:
            raise ValueError(f"faces[{i}]: a list of indices is needed, not shape {row.shape}")
    corners = np.concatenate(rows) if rows else np.empty(0, np.uint32)
    if corners.dtype.kind not in "iu":  # uint64 beside int64 becomes float64
        corners = np.concatenate([row.astype(np.int64) for row in rows])
    starts = np.zeros(len(rows) + 1, np.int64)
    np.cumsum([len(row) for row in rows], out=starts[1:])
    return corners, starts


def _face_starts(values: ArrayLike) -> Indices:
    given = integers("face_starts", values)
    if given.ndim != 1 or len(given) == 0:
        raise ValueError(f"face_starts: a list of one offset more than faces is needed, not shape {given.shape}")
    starts = indices("face_starts", given)
    return starts if starts.dtype == _UINT32 else starts.astype(np.uint32)


def _split_faces(faces: Faces) -> Tuple[Optional[Array], Optional[Indices]]:
    """(corners of any shape, offsets or None for triangles) of faces in any of their forms."""
    if faces is None:
        raise TypeError(f"faces: indices are needed; \"soup\" makes a triangle of each three positions. {POINTS}")
    if isinstance(faces, str):
        if faces != "soup":
            raise ValueError(f"faces: indices or 'soup' are needed, not {faces!r}")
        return None, None
    if isinstance(faces, tuple):
        if len(faces) != 2:
            raise ValueError(f"faces: a tuple is (corners, face_starts), not {len(faces)} parts")
        corners = integers("faces[0]", faces[0])
        if corners.ndim != 1:
            raise ValueError(f"faces[0]: a list of indices is needed, not shape {corners.shape}")
        return corners, _face_starts(faces[1])
    if isinstance(faces, list):
        lengths = {len(row) if hasattr(row, "__len__") else -1 for row in faces}
        if -1 in lengths:
            raise TypeError("faces: a list holds one list of indices for each polygon")
        if len(lengths) != 1:
            corners, starts = _polygons(faces)
            return corners, _face_starts(starts)
    array = integers("faces", faces)  # type: ignore[arg-type]
    if array.size == 0 and array.ndim == 1:
        array = array.reshape(0, 3)
    if array.ndim != 2 or (array.shape[1] < 3 and array.size):
        raise ValueError(f"faces: shape (n, 3) or (n, k) is needed, not {array.shape}")
    if array.shape[1] == 3:
        return array, None
    return array, np.arange(array.shape[0] + 1, dtype=np.uint32) * np.uint32(array.shape[1])


def _vtk_array(values: Any) -> Array:
    """The numbers of a vtkDataArray, which hands out its memory."""
    return np.asarray(memoryview(values))


def _padded(cells: Array) -> Faces:
    """Polygons of cells as VTK lists them: 3, a, b, c, 4, a, b, c, d."""
    if cells.size == 0:
        return np.empty((0, 3), np.uint32)
    width = int(cells[0])
    if width >= 3 and cells.size % (width + 1) == 0 and (cells[:: width + 1] == width).all():
        return cells.reshape(-1, width + 1)[:, 1:]
    polygons, at = [], 0
    while at < cells.size:
        count = int(cells[at])
        if count < 3 or at + 1 + count > cells.size:
            raise ValueError(f"faces[{at}] is {count}; the number of a face's corners is needed there: 3 or more, "
                             f"and not more than the {cells.size - at - 1} indices after it")
        polygons.append(cells[at + 1 : at + 1 + count])
        at += 1 + count
    return polygons


def _cell_blocks(blocks: Any) -> Faces:
    """The faces of meshio's cells: blocks of one type each; solids, lines and vertices are no faces."""
    parts = [np.asarray(block.data) for block in blocks if _FLAT.fullmatch(block.type)]
    others = {block.type for block in blocks if not _FLAT.fullmatch(block.type)}
    curved = {type for type in others if not _NO_FACES.match(type)}  # a surface with holes, were they left out
    if curved or not parts:
        raise TypeError(f"positions: faces (triangle, quad, polygon) are needed, not {', '.join(sorted(curved or others))}")
    if len(parts) == 1:
        return parts[0]
    corners = np.concatenate([part.reshape(-1) for part in parts])
    sizes = np.concatenate([np.full(len(part), part.shape[1], np.int64) for part in parts])
    return corners, np.concatenate([[0], np.cumsum(sizes)])


def _vtk_parts(whole: Any) -> Tuple[Array, Faces]:
    """The points and faces of a vtkPolyData, or of a vtkUnstructuredGrid whose cells are faces."""
    if hasattr(whole, "GetPolys"):
        if whole.GetNumberOfStrips():
            raise TypeError("positions: strips are no faces yet; vtkTriangleFilter makes triangles of them")
        polygons = whole.GetPolys()
    else:
        polygons, kinds = whole.GetCells(), whole.GetCellTypesArray()
        if kinds is not None and not np.isin(_vtk_array(kinds), _VTK_FLAT).all():
            raise TypeError(f"positions: faces (triangle, quad, polygon) are needed, but this {type(whole).__name__} has other cells; "
                            "take its surface, with vtkGeometryFilter or pyvista's extract_surface()")
    points = whole.GetPoints()
    if points is None or polygons is None or polygons.GetNumberOfCells() == 0:
        return np.empty((0, 3)) if points is None else _vtk_array(points.GetData()), None
    return _vtk_array(points.GetData()), (_vtk_array(polygons.GetConnectivityArray()), _vtk_array(polygons.GetOffsetsArray()))


def _tensor(values: Any) -> Array:
    """A tensor of Open3D or of torch, as an array."""
    for step in ("detach", "cpu", "numpy"):
        values = getattr(values, step)() if hasattr(values, step) else values
    return np.asarray(values)


def parts_of(whole: Any) -> Tuple[Any, Faces]:
    """Positions and faces of an object that has both by their usual names: a mesh of `norma.open`,
    trimesh, meshio, Open3D (both kinds), pyvista, vtkPolyData and vtkUnstructuredGrid."""
    if hasattr(whole, "GetPoints") and (hasattr(whole, "GetPolys") or hasattr(whole, "GetCellTypesArray")):  # VTK, pyvista
        return _vtk_parts(whole)
    vertices: Any = getattr(whole, "vertex", getattr(whole, "point", None))
    if hasattr(type(vertices), "__contains__") and not isinstance(vertices, np.ndarray):  # Open3D's tensors; a cloud has points
        faces = getattr(whole, "triangle", {})
        return (_tensor(vertices["positions"]) if "positions" in vertices else np.empty((0, 3)),
                _tensor(faces["indices"]) if "indices" in faces else None)
    positions = next((getattr(whole, name) for name in ("positions", "vertices", "points") if hasattr(whole, name)), None)
    if positions is None or isinstance(whole, np.ndarray):
        return whole, None
    faces = next((getattr(whole, name) for name in ("faces", "triangles", "cells") if hasattr(whole, name)), None)
    if isinstance(faces, list) and faces and hasattr(faces[0], "type"):
        faces = _cell_blocks(faces)
    elif faces is not None and not isinstance(faces, (tuple, list)):
        faces = as_array("faces", faces)
        faces = _padded(integers("faces", faces)) if faces.ndim == 1 else faces
    return as_array("positions", positions), faces


def unpacked(positions: Any, faces: Faces, normals: Any) -> Tuple[Any, Faces, Any]:
    """Positions, faces and normals as they are given, or from (positions, faces) or (positions, faces, normals)."""
    if faces is not None or not isinstance(positions, tuple) or len(positions) not in (2, 3):
        return positions, faces, normals
    if parts_of(positions[0])[0] is not positions[0] or as_array("positions", positions[0]).ndim != 2:
        return positions, faces, normals
    return positions[0], positions[1], positions[2] if len(positions) == 3 and normals is None else normals


def _refuse_whole(given: Any) -> NoReturn:
    """Raises what to give instead of something that is neither an array nor a mesh."""
    hint = ""
    if isinstance(given, (str, bytes, os.PathLike)):
        hint = "; norma.open() reads a file, and has its meshes"
    elif hasattr(given, "meshes"):
        hint = "; give one of its meshes"
    raise TypeError(f"positions: {_MESHES}, not {type(given).__name__}{hint}")


def mesh(
    positions: Any,
    faces: Faces,
    smoothing_groups: Optional[ArrayLike] = None,
    hard_edges: Optional[ArrayLike] = None,
) -> Mesh:
    """A mesh from positions and faces, or from an object that has both (see `parts_of`)."""
    whole = positions
    if faces is None:
        positions, faces = parts_of(whole)
        if faces is None and positions is not whole:
            raise TypeError(f"positions: an object with vertices needs faces (triangles, cells) too. {POINTS}")
    positions = as_array("positions", positions)
    if positions.ndim == 0:
        _refuse_whole(whole)
    points, kind = vectors("positions", positions)
    given, starts = _split_faces(faces)
    corners = None if given is None else indices("faces", given)
    corner_count = points.shape[0] if corners is None else corners.size
    face_count = corner_count // 3 if starts is None else len(starts) - 1
    groups_at, hard_at = 0, 0
    extras: Tuple[Array, ...] = ()
    if smoothing_groups is not None:
        groups = indices("smoothing_groups", integers("smoothing_groups", smoothing_groups).reshape(-1))
        groups = groups if groups.dtype == _UINT32 else groups.astype(np.uint32)
        if groups.size != face_count:
            raise ValueError(f"smoothing_groups: one for each of {face_count} faces is needed, not {groups.size}")
        groups_at, extras = groups.__array_interface__["data"][0], (*extras, groups)
    if hard_edges is not None:
        hard = np.ascontiguousarray(as_array("hard_edges", hard_edges) != 0).reshape(-1).view(np.uint8)
        if hard.size != corner_count:
            raise ValueError(f"hard_edges: one for each of {corner_count} corners is needed, not {hard.size}")
        hard_at, extras = hard.__array_interface__["data"][0], (*extras, hard)
    call = (
        points.__array_interface__["data"][0],
        points.shape[0],
        stride(points),
        kind,
        0 if corners is None else corners.__array_interface__["data"][0],
        corner_count,
        4 if corners is None else corners.itemsize,
        0 if starts is None else starts.__array_interface__["data"][0],
        face_count,
        groups_at,
        hard_at,
    )
    return Mesh(call, points, corners, starts, given, corner_count, face_count, extras)


def refuse(answer: Any, of: Optional[Mesh] = None) -> NoReturn:
    """Raises what the library's refusal means."""
    result, argument, index, expected = answer
    name = _NAMES.get(argument, argument.replace("options->", "").replace("mesh->", "") or "arguments")
    if result == -4:
        raise MemoryError(expected)
    if result == -3 and name == "faces" and of is not None and of.faces is not None:
        raise_index("faces" if of.faces.ndim == 2 else "faces[0]", of.faces, index, of.positions.shape[0])
    place = f"{name}[{index}]" if index >= 0 else name
    if result == -3:
        raise IndexError(f"{place}: {expected}")
    raise ValueError(f"{place}: {expected}")
