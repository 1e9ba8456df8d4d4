"""Normals of a mesh whose faces lie on the ranks of mpi4py, by norma_mpi_vertex_normals through ctypes, beside what is usually done instead.

    mpirun -n 4 python3 mpi4py_seams.py LIBRARY [MODEL.obj]    LIBRARY: libnorma-mpi.so, of the MPI that mpi4py was built with

With a model, each rank has a run of its faces. A rank that sums its own faces alone gets other normals than its neighbour along the border between them, and the mean of the ranks' normals is wrong as well.
To add up the sums of all ranks (Allreduce) is right, but for the last bits, which depend on the number of ranks.

Without one, the mesh is a slope of small triangles with high, thin walls on it, and each face is on a random rank. Where a wall stands, its two sides weigh up to a million times as much as the slope, and
cancel. Sums of float32, with Allreduce too, get normals that are off by degrees. libnorma-mpi sums at one place, in doubles and in the order of faces.
"""
import ctypes
import hashlib
import sys

import numpy as np
from mpi4py import MPI


class View(ctypes.Structure):
    _fields_ = [("data", ctypes.c_void_p), ("count", ctypes.c_size_t), ("stride", ctypes.c_size_t), ("format", ctypes.c_int)]


class Mesh(ctypes.Structure):
    _fields_ = [("positions", View), ("corners", ctypes.c_void_p), ("corner_count", ctypes.c_size_t), ("corner_size", ctypes.c_size_t),
                ("face_starts", ctypes.c_void_p), ("face_count", ctypes.c_size_t), ("smoothing_groups", ctypes.c_void_p), ("hard_edges", ctypes.c_void_p)]


class Options(ctypes.Structure):  # as in norma.h; zeros are the defaults
    _fields_ = [("struct_size", ctypes.c_size_t), ("weight", ctypes.c_int), ("weld", ctypes.c_int), ("weld_distance", ctypes.c_double),
                ("non_manifold", ctypes.c_int), ("fallback", ctypes.c_int), ("fallback_normal", ctypes.c_float * 3), ("normal_stride", ctypes.c_size_t),
                ("reasons", ctypes.c_void_p), ("threads", ctypes.c_uint32), ("isa", ctypes.c_int), ("allocator", ctypes.c_void_p * 3),
                ("parallel_for", ctypes.c_void_p), ("parallel_for_user", ctypes.c_void_p), ("progress", ctypes.c_void_p), ("progress_user", ctypes.c_void_p)]


FORMAT_DOUBLE = 1
WEIGHT_AREA = 1


def normals_of(library, comm, points, corners, vertex_ids, face_ids):
    """points: (n, 3) doubles, those that the faces of this rank use; corners: (m, 3) uint32; ids: uint64. Returns (n, 3) floats."""
    handle = (ctypes.c_int if MPI._sizeof(MPI.Comm) == ctypes.sizeof(ctypes.c_int) else ctypes.c_void_p).from_address(MPI._addressof(comm))
    mesh = Mesh(View(points.ctypes.data, len(points), 0, FORMAT_DOUBLE), corners.ctypes.data, corners.size)
    options = Options(struct_size=ctypes.sizeof(Options), weight=WEIGHT_AREA)
    normals = np.zeros((len(points), 3), np.float32)
    result = library.norma_mpi_vertex_normals(
        handle, ctypes.byref(mesh), ctypes.c_void_p(vertex_ids.ctypes.data), ctypes.c_void_p(face_ids.ctypes.data), ctypes.byref(options),
        ctypes.c_void_p(normals.ctypes.data), ctypes.c_size_t(len(points)), None)
    if result:
        raise RuntimeError("norma_mpi_vertex_normals: %d" % result)
    return normals


SIDE, HIGH, EVERY = 65, 1200.0, 8  # vertices along the slope, height of walls in squares, columns between walls


def walls():
    """Points (the slope's first), faces, and the exact normals of the slope: its walls cancel."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    slope = np.stack([x, y, 0.3 * x + 0.7 * y], -1).reshape(-1, 3).astype(float)
    at = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    feet = at[:, EVERY // 2::EVERY]
    top = len(slope) + np.arange(feet.size).reshape(feet.shape)
    p, q, r, s = (part.ravel() for part in (feet[:-1], feet[1:], top[1:], top[:-1]))
    front = np.concatenate([np.stack([p, q, r], -1), np.stack([p, r, s], -1)])
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1), front, front[:, ::-1]])
    way = np.arange(feet.size) * 1.7
    points = np.concatenate([slope, slope[feet.ravel()] + HIGH * np.stack([np.sin(way), np.cos(way), np.ones_like(way)], -1)])
    return points, faces.astype(np.uint32), np.tile([-0.3, -0.7, 1], (len(slope), 1))


def model(path):
    """The triangles of an OBJ, the points that they use, and the sums of all faces in doubles."""
    with open(path) as file:
        rows = [line.split() for line in file]
    points = np.array([row[1:4] for row in rows if row[:1] == ["v"]], float)
    faces = [[int(word.split("/")[0]) for word in row[1:]] for row in rows if row[:1] == ["f"]]
    if not faces or any(len(face) != 3 or min(face) < 1 or max(face) > len(points) for face in faces):
        sys.exit(path + ": expected triangles alone, with positive indices")
    used, corners = np.unique(np.array(faces) - 1, return_inverse=True)
    points, faces = points[used], corners.reshape(-1, 3).astype(np.uint32)
    return points, faces, sums_of(points, faces, np.float64)


def sums_of(points, faces, kind):
    """At each point, the sum of the faces' normals, weighted by area."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    votes = (0.5 * np.cross(b - a, c - a)).astype(kind)
    sums = np.zeros(points.shape, kind)
    for k in range(3):
        np.add.at(sums, faces[:, k], votes)
    return sums


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def degrees(normals, exact):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(normals, exact), axis=1), (normals * exact).sum(1)))


def report(name, normals, exact):
    normals = normals[:len(exact)]
    if not (np.linalg.norm(normals, axis=1) > 0.99).all():
        raise RuntimeError(name + " normals are missing")
    print("%-28s worst %8.5f degrees, bits %s" % (
        name, degrees(normals.astype(float), exact).max(), hashlib.sha256(normals.astype(np.float32).tobytes()).hexdigest()[:16]))


def main():
    comm = MPI.COMM_WORLD
    library = ctypes.CDLL(sys.argv[1] if len(sys.argv) > 1 else "libnorma-mpi.so")
    if len(sys.argv) > 2:
        points, faces, exact = model(sys.argv[2])
        owners = np.arange(len(faces)) * comm.size // len(faces)
    else:
        points, faces, exact = walls()
        owners = np.random.default_rng(1).integers(0, comm.size, len(faces))
    face_ids = np.flatnonzero(owners == comm.rank).astype(np.uint64)
    vertex_ids, corners = np.unique(faces[face_ids], return_inverse=True)
    corners = corners.reshape(-1, 3).astype(np.uint32)
    ours = normals_of(library, comm, points[vertex_ids].copy(), corners, vertex_ids.astype(np.uint64), face_ids)
    parts = comm.gather((vertex_ids, ours))
    mine = sums_of(points, faces[face_ids], np.float32)
    sums, means = np.empty_like(mine), np.empty_like(mine)
    comm.Allreduce(mine, sums)
    comm.Allreduce(unit(mine), means)
    known = vertex_ids[vertex_ids < len(exact)]
    alone = comm.reduce(degrees(unit(mine[known]), exact[known]).max(initial=0), MPI.MAX)
    if comm.rank:
        return
    joined = np.zeros(points.shape, np.float32)
    for ids, normals in parts:
        joined[ids] = normals
    if len(sys.argv) > 2:
        print("%-28s worst %8.5f degrees" % ("each rank's faces alone:", alone))
        report("mean of the ranks' normals:", unit(means), exact)
    report("sums of float32, Allreduce:", unit(sums), exact)
    report("norma_mpi_vertex_normals:", joined, exact)


main()
