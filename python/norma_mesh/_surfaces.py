"""Points on surfaces: the nearest ones, random ones; and normals of height maps."""
from __future__ import annotations

import operator
from typing import Any, Literal, NamedTuple, Optional, Tuple, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _norma
from ._arguments import Array, Faces, Floats, Mesh, as_array, mesh, number, options, output, refuse, stride, unpacked, vectors
from ._calls import attribute, corner_normals, face_normals, index_corners, vertex_normals
from ._results import NormalReport, report_of

_CLOSEST = np.dtype([("point", "f8", 3), ("distance", "f8"), ("face", "u4"), ("corners", "u4", 3), ("weights", "f8", 3)])
_ON_EDGE = 1e-12  # a weight that is 0 but for rounding


class Closest(NamedTuple):
    """The points of a mesh that are nearest to others, a row for each."""

    points: NDArray[np.float64]  #: (n, 3)
    distances: NDArray[np.float64]  #: NaN: none, the point is not finite or the mesh has no area
    faces: NDArray[np.int64]  #: -1: none
    normals: NDArray[np.float32]  #: (n, 3), interpolated and unit; zero: none
    sides: NDArray[np.int8]  #: 1: the point is on the side that faces look to (outside), -1: on the other, 0: on the surface
    corners: NDArray[np.int64]  #: (n, 3) corners of the face, with
    weights: NDArray[np.float64]  #: (n, 3) their weights there: `attribute[corners]` is interpolated by them


class Samples(NamedTuple):
    """Random points of a surface."""

    points: NDArray[np.float64]  #: (n, 3)
    normals: NDArray[np.float32]  #: (n, 3), interpolated and unit
    faces: NDArray[np.int64]
    corners: NDArray[np.int64]  #: (n, 3) corners of the face, with
    weights: NDArray[np.float64]  #: (n, 3) their weights there


def _corners(m: Mesh) -> NDArray[np.int64]:
    return np.arange(m.corner_count) if m.corners is None else m.corners.reshape(-1).astype(np.int64)


def _starts(m: Mesh) -> NDArray[np.int64]:
    return np.arange(m.face_count + 1) * 3 if m.starts is None else m.starts.astype(np.int64)


def triangles(positions: Array, corners: Array, starts: NDArray[np.int64]) -> Tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Convex polygons as fans: for each triangle its face, its three corners by number, and the product of its sides."""
    sizes = np.maximum(np.diff(starts) - 2, 0)
    of = np.repeat(np.arange(len(sizes)), sizes)
    step = np.arange(len(of)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    fans = np.stack([starts[of], starts[of] + step + 1, starts[of] + step + 2], 1)
    a, b, c = (positions[corners[fans[:, k]]].astype(np.float64) for k in range(3))
    across = np.cross(b - a, c - a)
    if len(of) > len(sizes):
        concave = np.flatnonzero((across * face_normals(positions, (corners, starts))[of]).sum(1) < -1e-9 * np.abs(across).sum(1))
        if concave.size:
            raise ValueError(f"faces[{of[concave[0]]}]: convex polygons are needed; cut this one into triangles")
    return of, fans, across


def _normals_at_corners(whole: Any, m: Mesh, normals: Optional[ArrayLike]) -> Array:
    """Given ones, those of a file's mesh, or those that norma computes at creases of 60 degrees."""
    if normals is None and getattr(whole, "corner_normals", None) is not None:
        return np.asarray(whole.corner_normals)
    if normals is None:
        return corner_normals(m.positions, (_corners(m), _starts(m)))
    array: Array = attribute("normals", normals, 3, m, None)[0]
    return array if len(array) == m.corner_count and len(array) != len(m.positions) else array[_corners(m)]


def _unit(sums: Array) -> Floats:
    sums = np.where(np.isfinite(sums), sums, 0)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.divide(sums, length, out=np.zeros_like(sums), where=length > 0).astype(np.float32)


def _pseudonormals(m: Mesh, own: NDArray[np.int64], corners: NDArray[np.int64], weights: NDArray[np.float64]) -> Array:
    """The vector whose side decides (Baerentzen and Aanaes 2005): that of the face, the sum of those of the faces at
    an edge, or the sum by angles at a position."""
    index = _corners(m)
    starts = _starts(m)
    flat = face_normals(m.positions, (index, starts)).astype(np.float64)
    place = index_corners(m.positions + 0.0).indices.astype(np.int64)[index]  # equal positions are one; -0 is 0
    result = flat[own]
    used = weights > _ON_EDGE
    at_corner = used.sum(1) == 1
    if at_corner.any():
        which = corners[at_corner, used[at_corner].argmax(1)]
        result[at_corner] = vertex_normals(m.positions, (index, starts))[index[which]]
    on_edge = np.flatnonzero(used.sum(1) == 2)
    if on_edge.size:
        after = np.arange(1, len(index) + 1)
        after[starts[1:][np.diff(starts) > 0] - 1] = starts[:-1][np.diff(starts) > 0]
        key = np.sort(np.stack([place, place[after]], 1), 1) @ np.array([int(place.max()) + 1, 1])
        of = np.repeat(np.arange(m.face_count), np.diff(starts))
        pair = np.sort(place[corners[on_edge][used[on_edge]].reshape(-1, 2)], 1) @ np.array([int(place.max()) + 1, 1])
        edges, found = np.unique(pair, return_inverse=True)  # those asked for: sorting all takes longer than the search
        number = np.minimum(np.searchsorted(edges, key), len(edges) - 1)
        along = np.flatnonzero(edges[number] == key)
        sums = np.stack([np.bincount(number[along], flat[of[along], k], len(edges)) for k in range(3)], 1)
        # Else a cut through a polygon: the face's own.
        real = np.bincount(number[along], minlength=len(edges))[found] > 0
        result[on_edge[real]] = sums[found[real]]
    return result


def closest(
    points: ArrayLike,
    positions: Any,
    faces: Faces = None,
    *,
    normals: Optional[ArrayLike] = None,
    threads: Optional[int] = None,
) -> Closest:
    """The nearest point of a mesh for each point, with its distance, face, interpolated normal, and the
    side of the surface that the point is on.

    points: (n, 3) numbers.
    positions: (n, 3) numbers, or a whole mesh: of `norma.open`, trimesh, meshio, Open3D, pyvista, VTK.
    faces: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each
        three positions are a triangle. It may be left out beside an object that has faces, and beside
        (positions, faces) or (positions, faces, normals) as one. Polygons are cut.
    normals: what is interpolated: one for each position or for each corner. None: those of a mesh of
        `norma.open`, otherwise those of `norma.corner_normals`.
    sides: by the faces at the nearest point, weighted by angle (Baerentzen and Aanaes 2005): right for
        closed surfaces whose winding agrees (`norma.orient`).

    >>> import norma_mesh as norma
    >>> found = norma.closest([[0.2, 0.2, 3]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> found.points.round(6).tolist(), found.distances.tolist(), found.faces.tolist(), found.sides.tolist()
    ([[0.2, 0.2, 0.0]], [3.0], [0], [1])
    """
    positions, faces, normals = unpacked(positions, faces, normals)
    m = mesh(positions, faces)
    places, kind = vectors("points", points)
    count = places.shape[0]
    found = np.empty(count, _CLOSEST)
    given = (int(places.__array_interface__["data"][0]), count, stride(places) or places.itemsize * 3, kind, 0, 0)
    answer = _norma.closest(m.call, given, options(threads=threads), int(found.__array_interface__["data"][0]), count)
    if answer is not None:
        refuse(answer, m)
    none = found["face"] == 0xFFFFFFFF
    own = np.where(none, -1, found["face"].astype(np.int64))
    distances = np.where(none, np.nan, found["distance"])
    corners, weights = found["corners"].astype(np.int64), found["weights"].copy()
    result = np.zeros((count, 3), np.float32)
    sides = np.zeros(count, np.int8)
    there = np.flatnonzero(~none)
    if there.size:
        at_corners = _normals_at_corners(positions, m, normals)
        sums = (at_corners[corners[there]].astype(np.float64) * weights[there, :, None]).sum(1)
        result[there] = _unit(sums)
        apart = places[there].astype(np.float64) - found["point"][there]
        across = (apart * _pseudonormals(m, own[there], corners[there], weights[there])).sum(1)
        sides[there] = np.where(distances[there] > 0, np.sign(across), 0)
    return Closest(found["point"].copy(), distances, own, result, sides, corners, weights)


def _uniform(seed: int, count: int) -> NDArray[np.float64]:
    """Numbers from 0 to below 1, the same for a seed in every version of numpy: PCG64's own bits."""
    raw: NDArray[np.uint64] = np.asarray(np.random.PCG64(seed).random_raw(count), np.uint64)
    return (raw >> np.uint64(11)) * 2.0**-53


def sample(
    positions: Any,
    faces: Any = None,
    n: Any = None,
    seed: int = 0,
    *,
    normals: Optional[ArrayLike] = None,
) -> Samples:
    """Random points of a surface, spread evenly over its area, with normals. The same seed gives the
    same points: `norma.sample(mesh, n, seed)` or `norma.sample(positions, faces, n, seed)`.

    mesh: of `norma.open`, trimesh, meshio, Open3D, pyvista or VTK, (positions, faces) or (positions,
        faces, normals).  positions: (n, 3) numbers.
    faces: (n, 3) or (n, k) integers, a list of polygons, (corners, face_starts), or "soup": each
        three positions are a triangle. Polygons must be convex.
    n: how many.
    normals: what is interpolated: one for each position or for each corner. None: those of a mesh of
        `norma.open`, otherwise those of `norma.corner_normals`.

    >>> import norma_mesh as norma
    >>> found = norma.sample([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], 1000, seed=7)
    >>> found.points.mean(0).round(1).tolist(), found.normals[0].tolist()
    ([0.3, 0.3, 0.0], [0.0, 0.0, 1.0])
    """
    if isinstance(faces, (int, np.integer)) or (faces is None and n is not None):
        if isinstance(faces, (int, np.integer)):
            seed, n, faces = (n if n is not None else seed), faces, None
    try:
        count, start = operator.index(n), operator.index(seed)
    except TypeError:
        raise TypeError(f"{'seed' if isinstance(n, (int, np.integer)) else 'n'}: an integer is needed") from None
    if count < 0 or start < 0:
        raise ValueError(f"{'n' if count < 0 else 'seed'}: a number of at least 0 is needed")
    positions, faces, normals = unpacked(positions, faces, normals)
    m = mesh(positions, faces)
    starts, index = _starts(m), _corners(m)
    high = np.flatnonzero(index >= len(m.positions))
    if high.size:
        raise IndexError(f"faces: index {index[high[0]]} of corner {high[0]}; an index below {len(m.positions)} is needed")
    p = m.positions.astype(np.float64)
    of, fans, across = triangles(p, index, starts)
    areas = np.linalg.norm(across, axis=1)
    areas[~np.isfinite(areas)] = 0
    total = np.cumsum(areas)
    if count and not (len(total) and total[-1] > 0):
        raise ValueError("faces: a surface with an area is needed")
    r = _uniform(start, 3 * count).reshape(-1, 3)
    chosen = np.searchsorted(total, r[:, 0] * (total[-1] if len(total) else 0), side="right")
    chosen = np.minimum(chosen, max(int(np.flatnonzero(areas)[-1]) if count else 0, 0))
    root = np.sqrt(r[:, 1])
    weights = np.stack([1 - root, root * (1 - r[:, 2]), root * r[:, 2]], 1)
    corners = fans[chosen]
    points = (p[index[corners]] * weights[:, :, None]).sum(1)
    own = _normals_at_corners(positions, m, normals)
    return Samples(points, _unit((own[corners].astype(np.float64) * weights[:, :, None]).sum(1)), of[chosen], corners, weights)


@overload
def heightmap_normals(z: ArrayLike, spacing: Union[float, Tuple[float, float]] = ..., *, out: Optional[Floats] = ...,
                      report: Literal[False] = ...) -> Floats: ...
@overload
def heightmap_normals(z: ArrayLike, spacing: Union[float, Tuple[float, float]] = ..., *, out: Optional[Floats] = ...,
                      report: Literal[True]) -> Tuple[Floats, NormalReport]: ...
@overload
def heightmap_normals(z: ArrayLike, spacing: Union[float, Tuple[float, float]] = ..., *, out: Optional[Floats] = ...,
                      report: bool) -> Union[Floats, Tuple[Floats, NormalReport]]: ...
def heightmap_normals(
    z: ArrayLike,
    spacing: Union[float, Tuple[float, float]] = 1.0,
    *,
    out: Optional[Floats] = None,
    report: bool = False,
) -> Union[Floats, Tuple[Floats, NormalReport]]:
    """The unit normals of a height map, (rows, columns, 3) float32: of the surface (x, y, z) with x along
    columns and y along rows. Slopes are central differences, and one-sided ones at the border, as those
    of numpy's gradient: the mean of the slopes of the bilinear patches around a height.

    z: (rows, columns) numbers.  spacing: between neighbours, or that of x and of y; a negative y is that
        of an image whose rows run downwards.
    out: an array to write to.  report: return (normals, NormalReport); a normal whose slopes are not
        finite (no data) is zero and counted.

    >>> import norma_mesh as norma
    >>> norma.heightmap_normals([[0, 1, 2], [0, 1, 2]]).round(3)[0, 1]
    array([-0.707,  0.   ,  0.707], dtype=float32)
    """
    heights = as_array("z", z)
    if heights.ndim != 2:
        raise ValueError(f"z: shape (rows, columns) is needed, not {heights.shape}")
    if heights.dtype.kind not in "fiu":
        raise TypeError(f"z: numbers are needed, not {heights.dtype}")
    doubles = not (heights.dtype.kind == "f" and heights.dtype.itemsize <= 4)
    heights = np.ascontiguousarray(heights, np.float64 if doubles else np.float32)
    pair = spacing if isinstance(spacing, (tuple, list)) else (spacing, spacing)
    if len(pair) != 2:
        raise ValueError(f"spacing: a number, or that of x and of y, is needed, not {spacing!r}")
    dx, dy = (number("spacing", part) for part in pair)
    if not (np.isfinite(dx) and np.isfinite(dy) and dx and dy):
        raise ValueError(f"spacing: finite numbers other than 0 are needed, not {spacing!r}")
    rows, columns = heights.shape
    flat = None if out is None else as_array("out", out)
    if flat is not None and flat.shape != (rows, columns, 3):
        raise ValueError(f"out: shape ({rows}, {columns}, 3) is needed, not {flat.shape}")
    if flat is not None and not flat.flags.c_contiguous:
        raise ValueError("out: the numbers must lie side by side, row after row")
    result = output("out", None if flat is None else flat.reshape(-1, 3), rows * columns, 3, heights)
    wrong = _norma.height_normals(int(heights.__array_interface__["data"][0]), rows, columns, doubles, dx, dy,
                                  int(result.__array_interface__["data"][0])) if heights.size else 0
    normals = result.reshape(rows, columns, 3)
    return (normals, report_of((0, wrong, 0, 0, 0, 0))) if report else normals
