"""Normals, tangents and matrices of arrays."""
from __future__ import annotations

import math
from typing import Any, Literal, Optional, Tuple, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _norma
from ._arguments import (
    Array,
    Encoding,
    Faces,
    Fallback,
    Floats,
    Mesh,
    NonManifold,
    TangentMode,
    Weight,
    Weld,
    as_array,
    choice,
    crease_radians,
    indices,
    integers,
    mesh,
    number,
    options,
    output,
    raise_index,
    refuse,
    stride,
    thread_count,
    vectors,
)
from ._results import Comparison, Indexed, MatrixInfo, NormalReport, OrientReport, Split, TangentReport, report_of

_FACES, _VERTICES, _CORNERS = 0, 1, 2
MODES = {"steady": 0, "mikk": 1}
_OPEN = {"kept": 0, "rays": 1}
_PER = {"vertex": 0, "corner": 1}
_ENCODINGS = {"oct8": 0, "oct12": 1, "oct16": 2, "10-10-10-2": 3}
_KINDS = (
    "identity",
    "translation",
    "rotation",
    "uniform-scale",
    "non-uniform-scale",
    "shear",
    "singular",
)


def _address(array: Optional[Array]) -> int:
    return 0 if array is None else int(array.__array_interface__["data"][0])


def _normals(
    of: int, m: Mesh, crease: float, out: Optional[Floats], settings: dict[str, Any]
) -> Tuple[Floats, NormalReport]:
    rows = (m.face_count, m.positions.shape[0], m.corner_count)[of]
    inputs = (m.positions,) if m.corners is None else (m.positions, m.corners)
    result = output("out", out, rows, 3, *inputs)
    counts = _norma.normals(
        m.call, options(normal_stride=stride(result), **settings), of, crease, _address(result), rows
    )
    if len(counts) != 6:
        refuse(counts, m)
    return result, report_of(counts)


@overload
def face_normals(
    positions: Any, faces: Faces = ..., *, weld: Weld = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: Literal[False] = ...,
) -> Floats: ...
@overload
def face_normals(
    positions: Any, faces: Faces = ..., *, weld: Weld = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: Literal[True],
) -> Tuple[Floats, NormalReport]: ...
@overload
def face_normals(
    positions: Any, faces: Faces = ..., *, weld: Weld = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: bool,
) -> Union[Floats, Tuple[Floats, NormalReport]]: ...
def face_normals(
    positions: Any,
    faces: Faces = None,
    *,
    weld: Weld = "exact",
    fallback: Fallback = "zero",
    threads: Optional[int] = None,
    out: Optional[Floats] = None,
    report: bool = False,
) -> Union[Floats, Tuple[Floats, NormalReport]]:
    """The unit normal of each face, (faces, 3) float32; concave polygons too.

    positions: (n, 3) numbers, or a whole mesh: of `norma.open`, trimesh, meshio, Open3D, pyvista, VTK.
    faces: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each
        three positions are a triangle. It may be left out only beside an object that has faces.
    fallback: what a face without a direction gets: "zero", "nearest" or three numbers.
    out: an array to write to, instead of a new one.  report: return (normals, NormalReport).

    >>> import norma_mesh as norma
    >>> norma.face_normals([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    array([[0., 0., 1.]], dtype=float32)
    """
    m = mesh(positions, faces)
    result, counts = _normals(_FACES, m, 0.0, out, {"weld": weld, "fallback": fallback, "threads": threads})
    return (result, counts) if report else result


@overload
def vertex_normals(
    positions: Any, faces: Faces = ..., *, weight: Weight = ..., weld: Weld = ...,
    fallback: Fallback = ..., threads: Optional[int] = ..., out: Optional[Floats] = ...,
    report: Literal[False] = ...,
) -> Floats: ...
@overload
def vertex_normals(
    positions: Any, faces: Faces = ..., *, weight: Weight = ..., weld: Weld = ...,
    fallback: Fallback = ..., threads: Optional[int] = ..., out: Optional[Floats] = ...,
    report: Literal[True],
) -> Tuple[Floats, NormalReport]: ...
@overload
def vertex_normals(
    positions: Any, faces: Faces = ..., *, weight: Weight = ..., weld: Weld = ...,
    fallback: Fallback = ..., threads: Optional[int] = ..., out: Optional[Floats] = ...,
    report: bool,
) -> Union[Floats, Tuple[Floats, NormalReport]]: ...
def vertex_normals(
    positions: Any,
    faces: Faces = None,
    *,
    weight: Weight = "angle",
    weld: Weld = "exact",
    fallback: Fallback = "zero",
    threads: Optional[int] = None,
    out: Optional[Floats] = None,
    report: bool = False,
) -> Union[Floats, Tuple[Floats, NormalReport]]:
    """The unit normal of each position, (positions, 3) float32: the weighted sum of the normals of
    the faces around it. Creases are ignored.

    positions: (n, 3) numbers, or a whole mesh: of `norma.open`, trimesh, meshio, Open3D, pyvista, VTK.
    faces: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each
        three positions are a triangle. It may be left out only beside an object that has faces.
    weight: "angle", "area", "uniform", "max", "angle-area", "visible" or "angle-lengths".
    weld: which positions share a normal: "exact" (equal ones), "none" (by index) or a distance.
    fallback: what a position without a normal gets: "zero", "nearest" or three numbers.
    threads: None uses all cores; 1 only the calling thread. The bits are the same.
    out: an array to write to, instead of a new one.  report: return (normals, NormalReport).

    >>> import norma_mesh as norma
    >>> roof = [[0, 0, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1], [2, 0, 0], [2, 1, 0]]
    >>> norma.vertex_normals(roof, [[0, 2, 3, 1], [2, 4, 5, 3]])[2]
    array([0., 0., 1.], dtype=float32)
    """
    m = mesh(positions, faces)
    settings = {"weight": weight, "weld": weld, "fallback": fallback, "threads": threads}
    result, counts = _normals(_VERTICES, m, 0.0, out, settings)
    return (result, counts) if report else result


@overload
def corner_normals(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: Literal[False] = ...,
) -> Floats: ...
@overload
def corner_normals(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: Literal[True],
) -> Tuple[Floats, NormalReport]: ...
@overload
def corner_normals(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., out: Optional[Floats] = ..., report: bool,
) -> Union[Floats, Tuple[Floats, NormalReport]]: ...
def corner_normals(
    positions: Any,
    faces: Faces = None,
    *,
    crease: float = 60.0,
    weight: Weight = "angle",
    weld: Weld = "exact",
    non_manifold: NonManifold = "hard",
    smoothing_groups: Optional[ArrayLike] = None,
    hard_edges: Optional[ArrayLike] = None,
    fallback: Fallback = "zero",
    threads: Optional[int] = None,
    out: Optional[Floats] = None,
    report: bool = False,
) -> Union[Floats, Tuple[Floats, NormalReport]]:
    """The unit normal of each corner, (corners, 3) float32, face after face: hard at edges that bend
    by more than `crease` degrees, smooth elsewhere. For triangles, `.reshape(-1, 3, 3)` gives one
    row of three normals for each face.

    smoothing_groups: a bit mask for each face; faces are smooth across an edge only if they share a
    bit.  hard_edges: for each corner whether the edge to the next corner is hard.
    non_manifold: edges of three faces and more are "hard", or "smooth" within the crease.
    The other arguments are those of `vertex_normals`.

    >>> import norma_mesh as norma
    >>> roof = [[0, 0, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1], [2, 0, 0], [2, 1, 0]]
    >>> norma.corner_normals(roof, [[0, 2, 3, 1], [2, 4, 5, 3]], crease=60).round(2)[[1, 4]]
    array([[-0.71,  0.  ,  0.71],
           [ 0.71,  0.  ,  0.71]], dtype=float32)
    """
    m = mesh(positions, faces, smoothing_groups, hard_edges)
    settings = {"weight": weight, "weld": weld, "fallback": fallback,
                "non_manifold": non_manifold, "threads": threads}
    result, counts = _normals(_CORNERS, m, crease_radians(crease), out, settings)
    return (result, counts) if report else result


@overload
def split(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., report: Literal[False] = ...,
) -> Split: ...
@overload
def split(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., report: Literal[True],
) -> Tuple[Split, NormalReport]: ...
@overload
def split(
    positions: Any, faces: Faces = ..., *, crease: float = ..., weight: Weight = ...,
    weld: Weld = ..., non_manifold: NonManifold = ..., smoothing_groups: Optional[ArrayLike] = ...,
    hard_edges: Optional[ArrayLike] = ..., fallback: Fallback = ...,
    threads: Optional[int] = ..., report: bool,
) -> Union[Split, Tuple[Split, NormalReport]]: ...
def split(
    positions: Any,
    faces: Faces = None,
    *,
    crease: float = 60.0,
    weight: Weight = "angle",
    weld: Weld = "exact",
    non_manifold: NonManifold = "hard",
    smoothing_groups: Optional[ArrayLike] = None,
    hard_edges: Optional[ArrayLike] = None,
    fallback: Fallback = "zero",
    threads: Optional[int] = None,
    report: bool = False,
) -> Union[Split, Tuple[Split, NormalReport]]:
    """The normals of `corner_normals` as an indexed mesh: (faces, source_vertices, normals). A
    vertex is split where its corners have different normals; `attribute[source_vertices]` carries
    any attribute over.

    >>> import norma_mesh as norma
    >>> roof = [[0, 0, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1], [2, 0, 0], [2, 1, 0]]
    >>> faces, source_vertices, normals = norma.split(roof, [[0, 2, 3, 1], [2, 4, 5, 3]])
    >>> source_vertices
    array([0, 2, 3, 1, 2, 4, 5, 3], dtype=uint32)
    """
    m = mesh(positions, faces, smoothing_groups, hard_edges)
    corners = np.empty(m.corner_count, np.uint32)
    sources = np.empty(m.corner_count, np.uint32)
    normals = np.empty((m.corner_count, 3), np.float32)
    settings = options(weight, weld, fallback, non_manifold, threads)
    answer = _norma.split(m.call, settings, crease_radians(crease), _address(corners),
                          _address(sources), _address(normals), m.corner_count)
    if len(answer) != 2:
        refuse(answer, m)
    counts, vertices = answer
    result = Split(_as_given(m, corners), sources[:vertices].copy(), normals[:vertices].copy())
    return (result, report_of(counts)) if report else result


def _as_given(m: Mesh, corners: Array) -> Any:
    """Corners in the form in which the faces were given."""
    if m.faces is None:
        return corners.reshape(-1, 3)
    if m.faces.ndim == 2:
        return corners.reshape(m.faces.shape)
    return corners, m.starts


def attribute(name: str, values: ArrayLike, width: int, m: Mesh, own: Optional[ArrayLike]) -> Tuple[Any, ...]:
    array, kind = vectors(name, values, width)
    rows = array.shape[0]
    if own is not None:
        given = integers(f"{name[:-1]}_faces", own)
        chosen = indices(f"{name[:-1]}_faces", given).astype(np.uint32, copy=False).reshape(-1)
        if chosen.size != m.corner_count:
            raise ValueError(f"{name[:-1]}_faces: one index for each of {m.corner_count} corners is needed, not {chosen.size}")
        high = np.flatnonzero(chosen >= rows)
        if high.size:
            raise_index(f"{name[:-1]}_faces", given, int(high[0]), rows)
        return array, chosen, (_address(array), rows, stride(array), kind, 1, _address(chosen))
    points = m.positions.shape[0]
    if rows not in (points, m.corner_count):
        raise ValueError(f"{name}: one for each of {points} positions or {m.corner_count} corners is needed, not {rows}")
    per_corner = int(rows != points)
    return array, None, (_address(array), rows, stride(array), kind, per_corner, 0)


@overload
def tangents(
    positions: Any, normals: ArrayLike, texcoords: ArrayLike, faces: Faces = ..., *,
    mode: TangentMode = ..., weight: Weight = ..., normal_faces: Optional[ArrayLike] = ...,
    texcoord_faces: Optional[ArrayLike] = ..., threads: Optional[int] = ...,
    out: Optional[Floats] = ..., report: Literal[False] = ...,
) -> Floats: ...
@overload
def tangents(
    positions: Any, normals: ArrayLike, texcoords: ArrayLike, faces: Faces = ..., *,
    mode: TangentMode = ..., weight: Weight = ..., normal_faces: Optional[ArrayLike] = ...,
    texcoord_faces: Optional[ArrayLike] = ..., threads: Optional[int] = ...,
    out: Optional[Floats] = ..., report: Literal[True],
) -> Tuple[Floats, TangentReport]: ...
@overload
def tangents(
    positions: Any, normals: ArrayLike, texcoords: ArrayLike, faces: Faces = ..., *,
    mode: TangentMode = ..., weight: Weight = ..., normal_faces: Optional[ArrayLike] = ...,
    texcoord_faces: Optional[ArrayLike] = ..., threads: Optional[int] = ...,
    out: Optional[Floats] = ..., report: bool,
) -> Union[Floats, Tuple[Floats, TangentReport]]: ...
def tangents(
    positions: Any,
    normals: ArrayLike,
    texcoords: ArrayLike,
    faces: Faces = None,
    *,
    mode: TangentMode = "mikk",
    weight: Weight = "angle",
    normal_faces: Optional[ArrayLike] = None,
    texcoord_faces: Optional[ArrayLike] = None,
    threads: Optional[int] = None,
    out: Optional[Floats] = None,
    report: bool = False,
) -> Union[Floats, Tuple[Floats, TangentReport]]:
    """The tangent of each corner, (corners, 4) float32: x, y, z and a sign. The bitangent is
    sign * cross(normal, tangent); glTF, whose v runs downwards, needs the sign negated.

    normals: (n, 3), texcoords: (n, 2), one for each position or for each corner; normal_faces and
        texcoord_faces choose one for each corner where they have numbers of their own (OBJ).
    mode: "mikk" gives the bits of MikkTSpace, "steady" does not depend on the order of faces.

    >>> import norma_mesh as norma
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> norma.tangents(square, [[0, 0, 1]] * 4, uv, [[0, 1, 2, 3]])[0]
    array([1., 0., 0., 1.], dtype=float32)
    """
    m = mesh(positions, faces)
    directions, normal_corners, n = attribute("normals", normals, 3, m, normal_faces)
    coordinates, texcoord_corners, t = attribute("texcoords", texcoords, 2, m, texcoord_faces)
    inputs = [a for a in (m.positions, m.corners, directions, coordinates) if a is not None]
    result = output("out", out, m.corner_count, 4, *inputs)
    settings = options(weight=weight, threads=threads, normal_stride=stride(result))
    counts = _norma.tangents(m.call, settings, n, t, choice("mode", mode, MODES), _address(result), m.corner_count)
    del normal_corners, texcoord_corners  # had to live until here
    if len(counts) != 6:
        refuse(counts, m)
    found = TangentReport(counts[0], counts[1], counts[3])
    return (result, found) if report else result


def index_corners(*streams: ArrayLike, threads: Optional[int] = None) -> Indexed:
    """Finds the corners that agree in all streams and numbers them as vertices, in the order in
    which corners first use them: (indices, source_corners). `stream[source_corners]` holds the
    values of the vertices, as a graphics card wants them.

    streams: arrays with a value, of any type and shape, for each corner. Their bytes are compared:
        0 and -0 differ.

    >>> import norma_mesh as norma
    >>> import numpy as np
    >>> positions = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> faces = np.array([[0, 1, 2], [0, 2, 3]])
    >>> tangents = norma.tangents(positions, [[0, 0, 1]] * 4, positions[:, :2], faces)
    >>> norma.index_corners(positions[faces.ravel()], tangents).indices.reshape(-1, 3)
    array([[0, 1, 2],
           [0, 2, 3]], dtype=uint32)
    """
    arrays = [_stream(i, given) for i, given in enumerate(streams)]
    if not arrays:
        raise ValueError("streams: at least one is needed")
    count = arrays[0].shape[0]
    for i, array in enumerate(arrays):
        if array.shape[0] != count:
            raise ValueError(f"streams[{i}]: {count} values, one for each corner, are needed, not {array.shape[0]}")
    indices, sources = np.empty(count, np.uint32), np.empty(count, np.uint32)
    given = [(_address(array), array[0].nbytes if count else 1, array.strides[0] if count > 1 else 0) for array in arrays]
    answer = _norma.index_corners(given, count, thread_count(threads), _address(indices), _address(sources))
    if not isinstance(answer, int):
        refuse(answer)
    return Indexed(indices, sources[:answer].copy())


def _stream(number: int, values: ArrayLike) -> NDArray[Any]:
    """An array whose values, the rows, are of at least one byte and without gaps."""
    array = as_array(f"streams[{number}]", values)
    if array.dtype.hasobject:
        raise TypeError(f"streams[{number}]: numbers are needed, not {array.dtype}")
    if array.ndim == 0 or 0 in array.shape[1:]:
        raise ValueError(f"streams[{number}]: a value for each corner is needed, not shape {array.shape}")
    one = array[:1]
    if not one.flags.c_contiguous or (array.shape[0] > 1 and array.strides[0] < one.nbytes):
        array = np.ascontiguousarray(array)
    return array


_SAMPLE = np.dtype([("area", "f8"), ("angle", "f4"), ("distance", "f4"), ("face", "u4"), ("normal", "f4", 3)])


def compare(
    base: Any,
    other: Any,
    *,
    max_deg: float = 0.0,
    threads: Optional[int] = None,
) -> Comparison:
    """By how many degrees the normals of one surface differ from those of another: corner by corner
    if both have the same faces, else at the nearest points of the base, whose normals are
    interpolated there.

    base, other: (positions, faces, normals), with a normal for each position or for each corner; or a
        mesh of `norma.open` that has normals.
    max_deg: the largest angle allowed, for `share_above`.

    >>> import norma_mesh as norma
    >>> roof, faces = [[0, 0, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1], [2, 0, 0], [2, 0, 1]], [[0, 1, 3, 2], [2, 3, 5, 4]]
    >>> flat, smooth = norma.corner_normals(roof, faces, crease=0), norma.vertex_normals(roof, faces)
    >>> found = norma.compare((roof, faces, flat), (roof, faces, smooth), max_deg=30)
    >>> round(found.max_deg, 3), round(found.share_above, 3), found.same_faces
    (45.0, 0.5, True)
    """
    most = number("max_deg", max_deg)
    if not 0 <= most <= 180:
        raise ValueError(f"max_deg: degrees from 0 to 180 are needed, not {max_deg!r}")
    surfaces: list[Any] = []
    held: list[Any] = []
    for name, given in (("base", base), ("other", other)):
        if getattr(given, "corner_normals", None) is not None:
            given = given.positions, given.faces, given.corner_normals
        if not isinstance(given, tuple) or len(given) != 3:
            raise TypeError(f"{name}: a tuple of positions, faces and normals is needed, or a file's mesh with normals")
        m = mesh(given[0], given[1])
        each = np.arange(m.corner_count, dtype=np.uint32)
        rows = as_array("normals", given[2]).shape[:1]
        own = each if rows == (m.corner_count,) and rows != m.positions.shape[:1] else None
        held.append((m, each, attribute("normals", given[2], 3, m, own)))
        surfaces += [m.call, held[-1][2][2]]
    count = held[1][0].corner_count
    samples = np.empty(count, _SAMPLE)
    answer = _norma.compare(surfaces[0], surfaces[1], surfaces[2], surfaces[3], options(threads=threads),
                            math.radians(most), _address(samples), count)
    if len(answer) == 4:
        refuse(answer)
    same, corners, missing, area, p50, p99, largest, d50, d99, furthest, share, worst = answer
    angles, distances = samples["angle"].astype(float), samples["distance"].astype(float)
    angles[angles < 0] = np.nan
    distances[distances < 0] = np.nan
    faces = samples["face"].astype(np.int64)
    faces[faces == 0xFFFFFFFF] = -1
    return Comparison(bool(same), corners, missing, area, math.degrees(p50), math.degrees(p99), math.degrees(largest),
                      d50, d99, furthest, share, worst, np.degrees(angles), distances, samples["area"].copy(), faces,
                      samples["normal"].copy())


@overload
def orient(
    positions: Any, faces: Faces = ..., *, open: Literal["kept", "rays"] = ..., weld: Weld = ...,
    threads: Optional[int] = ..., report: Literal[False] = ...,
) -> Any: ...
@overload
def orient(
    positions: Any, faces: Faces = ..., *, open: Literal["kept", "rays"] = ..., weld: Weld = ...,
    threads: Optional[int] = ..., report: Literal[True],
) -> Tuple[Any, OrientReport]: ...
@overload
def orient(
    positions: Any, faces: Faces = ..., *, open: Literal["kept", "rays"] = ..., weld: Weld = ...,
    threads: Optional[int] = ..., report: bool,
) -> Any: ...
def orient(
    positions: Any,
    faces: Faces = None,
    *,
    open: Literal["kept", "rays"] = "kept",
    weld: Weld = "exact",
    threads: Optional[int] = None,
    report: bool = False,
) -> Any:
    """Faces wound so that neighbours agree and closed surfaces face outward: a new array in the form
    of `faces`. Faces that are turned keep their first corner.

    open: open parts are "kept" as most of their faces are, or turned by "rays", a guess.

    >>> import norma_mesh as norma
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> norma.orient(corners, [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    array([[0, 2, 1],
           [0, 1, 3],
           [1, 2, 3],
           [0, 3, 2]])
    """
    m = mesh(positions, faces)
    reverse = np.empty(m.face_count, np.uint8)
    answer = _norma.orient(m.call, options(weld=weld, threads=threads), choice("open", open, _OPEN),
                           _address(reverse), m.face_count)
    if len(answer) != 12:
        refuse(answer, m)
    given = np.arange(m.corner_count, dtype=np.uint32).reshape(-1, 3) if m.faces is None else m.faces
    turned = given.copy()
    if given.ndim == 2:
        which = reverse.astype(bool)
        turned[which, 1:] = given[which, :0:-1]
        result: Any = turned
    else:
        starts = m.starts
        assert starts is not None
        for face in np.flatnonzero(reverse):
            first, end = int(starts[face]) + 1, int(starts[face + 1])
            turned[first:end] = given[first:end][::-1]
        result = (turned, starts)
    return (result, OrientReport(*answer)) if report else result


class Plan:
    """Normals of a mesh that moves: what depends on topology alone is kept, and an update only
    measures faces and sums. Fans and shared positions are those of the mesh at creation.

    per: "vertex" or "corner".  crease: degrees; 180 lets every angle pass.

    >>> import numpy as np, norma_mesh as norma
    >>> positions = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> plan = norma.Plan(positions, [[0, 1, 2]])
    >>> normals = plan.update(positions)
    >>> positions[2] = 0, 0, 1
    >>> plan.update(positions, moved=[2], out=normals)[0]
    array([ 0., -1.,  0.], dtype=float32)
    """

    def __init__(
        self,
        positions: Any,
        faces: Faces = None,
        *,
        per: Literal["vertex", "corner"] = "vertex",
        crease: float = 180.0,
        weld: Weld = "exact",
        non_manifold: NonManifold = "hard",
        smoothing_groups: Optional[ArrayLike] = None,
        hard_edges: Optional[ArrayLike] = None,
        threads: Optional[int] = None,
    ) -> None:
        m = mesh(positions, faces, smoothing_groups, hard_edges)
        of = choice("per", per, _PER)
        answer = _norma.plan(m.call, options(weld=weld, non_manifold=non_manifold, threads=threads),
                             of, crease_radians(crease))
        if isinstance(answer, tuple):
            refuse(answer, m)
        self._plan = answer
        self._positions = m.positions.shape[0]
        self._rows = m.corner_count if of else self._positions
        self._last: Optional[Floats] = None

    @property
    def nbytes(self) -> int:
        """The size of the plan in bytes."""
        return int(_norma.plan_bytes(self._plan))

    def update(
        self,
        positions: ArrayLike,
        moved: Optional[ArrayLike] = None,
        *,
        weight: Weight = "angle",
        fallback: Fallback = "zero",
        threads: Optional[int] = None,
        out: Optional[Floats] = None,
        report: bool = False,
    ) -> Any:
        """The normals at new positions, (vertices or corners, 3) float32.

        moved: the vertices that moved since `out` was right; only normals that they change are
            written. Without `out`, the array of the last update is updated and returned.
        """
        points, kind = vectors("positions", positions)
        if points.shape[0] != self._positions:
            raise ValueError(f"positions: the plan has {self._positions}, not {points.shape[0]}")
        if moved is not None and out is None:
            if self._last is None:
                raise ValueError("out: moved needs the normals of an earlier update")
            out = self._last
        result = output("out", out, self._rows, 3, points)
        which = None
        if moved is not None:
            given = integers("moved", moved).reshape(-1)
            which = indices("moved", given).astype(np.uint32, copy=False)
            high = np.flatnonzero(which >= self._positions)
            if high.size:
                raise_index("moved", given, int(high[0]), self._positions)
            if which.size == 0:
                which = np.zeros(1, np.uint32)[:0]
        call = (_address(points), points.shape[0], stride(points), kind, 0, 0, 0, 0, 0, 0, 0)
        settings = options(weight=weight, fallback=fallback, threads=threads, normal_stride=stride(result))
        counts = _norma.plan_update(self._plan, call, settings, _address(which),
                                    0 if which is None else which.size, _address(result), self._rows)
        if len(counts) != 6:
            refuse(counts)
        self._last = result
        return (result, report_of(counts)) if report else result


def _models(name: str, values: ArrayLike, many: bool) -> NDArray[Any]:
    array = as_array(name, values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: numbers are needed, not {array.dtype}")
    kind = np.float32 if array.dtype == np.float32 else np.float64
    tail, wanted = array.shape[int(many):], "(n, 4, 4)" if many else "(4, 4) or (3, 3)"
    if array.ndim != 2 + int(many) or tail not in ((4, 4), (3, 3)):
        raise ValueError(f"{name}: shape {wanted} is needed, not {array.shape}")
    if tail == (3, 3):
        whole = np.zeros((*array.shape[:-2], 4, 4), kind)
        whole[..., :3, :3], whole[..., 3, 3] = array, 1
        return whole
    return np.ascontiguousarray(array, kind)


def matrix_columns(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """A model as sixteen doubles, column after column."""
    return np.ascontiguousarray(_models(name, values, False).T, np.float64)


def normal_matrix(model: ArrayLike) -> NDArray[Any]:
    """The 3x3 matrix that takes normals of faces and vertices through a model, in the sense of the
    inverse transpose (under a mirror, faces are reversed). Right for singular matrices too.
    Renormalise after applying it; `transform_normals` does.

    model: (4, 4) or (3, 3) as mathematics writes it: columns are images of axes, the translation is
        the last column. The result has the type of the model, float32 or float64.

    >>> import norma_mesh as norma
    >>> norma.normal_matrix([[2, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    array([[1., 0., 0.],
           [0., 2., 0.],
           [0., 0., 2.]])
    """
    whole = _models("model", model, False)
    return _matrices(whole.reshape(1, 4, 4), "model").reshape(3, 3)


def normal_matrices(models: ArrayLike) -> NDArray[Any]:
    """The normal matrix of each model: (n, 4, 4) to (n, 3, 3), as `normal_matrix`."""
    return _matrices(_models("models", models, True), "models")


def _matrices(models: NDArray[Any], name: str) -> NDArray[Any]:
    result: NDArray[Any] = np.empty((len(models), 3, 3), models.dtype)
    answer = _norma.normal_matrices(_address(models), len(models), models.dtype == np.float64, _address(result))
    if answer is not None:
        place = f"models[{answer[2]}]" if name == "models" else name
        raise ValueError(f"{place}: the upper 3x3 has to be finite")
    return result


def matrix_info(model: ArrayLike) -> MatrixInfo:
    """What kind of matrix a model is, and by how much plain M would err on normals.

    >>> import norma_mesh as norma
    >>> info = norma.matrix_info([[2, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> info.kind, round(info.worst_error_deg, 2)
    ('non-uniform-scale', 36.87)
    """
    whole = np.ascontiguousarray(_models("model", model, False), np.float64)
    answer = _norma.matrix_info(_address(whole))
    if len(answer) != 9:
        raise ValueError("model: the upper 3x3 has to be finite")
    kind, rank, mirrored, determinant, anisotropy, worst, x, y, z = answer
    return MatrixInfo(_KINDS[kind], rank, bool(mirrored), determinant, anisotropy, math.degrees(worst), (x, y, z))


def transform_normals(matrix: ArrayLike, normals: ArrayLike, *, out: Optional[Floats] = None) -> Floats:
    """Normals through a 3x3 normal matrix, made unit: (n, 3) float32. Zero stays zero.

    out: an array to write to; may be `normals` itself if that is float32.

    >>> import norma_mesh as norma
    >>> norma.transform_normals(norma.normal_matrix([[2, 0, 0], [0, 1, 0], [0, 0, 1]]), [[1, 1, 0]]).round(3)
    array([[0.447, 0.894, 0.   ]], dtype=float32)
    """
    columns = as_array("matrix", matrix)
    if columns.shape != (3, 3):
        raise ValueError(f"matrix: shape (3, 3) is needed, not {columns.shape}")
    if columns.dtype.kind not in "fiu":
        raise TypeError(f"matrix: numbers are needed, not {columns.dtype}")
    columns = np.ascontiguousarray(columns.T, np.float32)
    array, kind = vectors("normals", normals)
    in_place = out is array
    result = output("out", out, array.shape[0], 3, *(() if in_place else (array,)))
    answer = _norma.transform_normals(_address(columns), _address(array), array.shape[0], stride(array),
                                      kind, _address(result), stride(result))
    if answer is not None:
        refuse(answer)
    return result


@overload
def encode_normals(
    normals: ArrayLike, encoding: Encoding = ..., *, report: Literal[False] = ...,
) -> NDArray[np.uint32]: ...
@overload
def encode_normals(
    normals: ArrayLike, encoding: Encoding = ..., *, report: Literal[True],
) -> Tuple[NDArray[np.uint32], NormalReport]: ...
@overload
def encode_normals(
    normals: ArrayLike, encoding: Encoding = ..., *, report: bool,
) -> Union[NDArray[np.uint32], Tuple[NDArray[np.uint32], NormalReport]]: ...
def encode_normals(
    normals: ArrayLike, encoding: Encoding = "oct16", *, report: bool = False
) -> Union[NDArray[np.uint32], Tuple[NDArray[np.uint32], NormalReport]]:
    """The nearest code of each normal, (n,) uint32, x in the lowest bits.

    normals: (n, 3) numbers of any length; zero and what is not finite become (0, 0, 1).
    encoding: octahedral with two numbers of 8, 12 or 16 bits, "oct8", "oct12" or "oct16", or
        "10-10-10-2", three numbers of 10 bits.
    report: return (codes, NormalReport), which counts normals that are zero or not finite.

    >>> import norma_mesh as norma
    >>> norma.encode_normals([[0, 0, 1], [1, 0, 0]], "oct8")
    array([  0, 127], dtype=uint32)
    """
    array, kind = vectors("normals", normals)
    codes = np.empty(array.shape[0], np.uint32)
    answer = _norma.encode_normals(_address(array), array.shape[0], stride(array), kind,
                                   choice("encoding", encoding, _ENCODINGS), _address(codes))
    if len(answer) != 6:
        refuse(answer)
    return (codes, report_of(answer)) if report else codes


def decode_normals(codes: ArrayLike, encoding: Encoding = "oct16", *, out: Optional[Floats] = None) -> Floats:
    """The unit normals of codes, (n, 3) float32.

    codes: (n,) integers of 32 bits.  out: an array to write to.
    encoding: that of the codes: "oct8", "oct12", "oct16" or "10-10-10-2".

    >>> import norma_mesh as norma
    >>> norma.decode_normals([0, 127], "oct8")
    array([[0., 0., 1.],
           [1., 0., 0.]], dtype=float32)
    """
    given = integers("codes", codes)
    if given.ndim != 1:
        raise ValueError(f"codes: shape (n,) is needed, not {given.shape}")
    wrong = np.flatnonzero((given < 0) | (given > 0xFFFFFFFF))
    if wrong.size:
        raise ValueError(f"codes[{wrong[0]}] is {given[wrong[0]]}; 32 bits are needed")
    words = np.ascontiguousarray(given, np.uint32)
    result = output("out", out, words.shape[0], 3, words)
    answer = _norma.decode_normals(_address(words), words.shape[0], choice("encoding", encoding, _ENCODINGS),
                                   _address(result), stride(result))
    if answer is not None:
        refuse(answer)
    return result


def encoding_error_deg(encoding: Encoding) -> float:
    """The largest angle between any unit vector and what its code is decoded to, proven.

    >>> import norma_mesh as norma
    >>> round(norma.encoding_error_deg("oct16"), 5)
    0.00248
    """
    return math.degrees(_norma.encoding_error_rad(choice("encoding", encoding, _ENCODINGS)))
