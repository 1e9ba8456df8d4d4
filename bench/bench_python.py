"""Normals from Python beside what others do: nanoseconds a triangle, the best of several runs in turn.

    bench_python.py [TRIANGLES]      with norma_mesh installed; Open3D is measured where it is installed

Each library gets the arrays that it keeps itself: trimesh doubles and indices of 64 bits, Open3D its
own vectors. trimesh's method (4.x, `Trimesh.vertex_normals`) is written down here in numpy; scipy's
sparse matrix, which trimesh multiplies by, has its place taken by bincount, which is faster.
Two times: on the clock, and of the processors, which other programs on the machine disturb less.
"""
import sys
import time

import numpy as np

import norma_mesh as norma


def grid(triangles, shuffled):
    side = max(2, int((triangles / 2) ** 0.5) + 1)
    y, x = np.mgrid[0:side, 0:side]
    points = np.stack([x * 0.01, y * 0.01, np.sin(x * 0.05) * np.cos(y * 0.07)], -1).reshape(-1, 3)
    a = (y[:-1, :-1] * side + x[:-1, :-1]).ravel()
    faces = np.stack([a, a + 1, a + side, a + 1, a + side + 1, a + side], -1).reshape(-1, 3)
    if shuffled:
        random = np.random.RandomState(1)
        order = random.permutation(len(points))
        points, faces = points[np.argsort(order)], order[faces][random.permutation(len(faces))]
    return points.astype(np.float32), np.ascontiguousarray(faces, np.int64)


def unit(vectors):
    lengths = np.sqrt((vectors * vectors).sum(axis=1))
    lengths[lengths < 1e-12] = 1
    return vectors / lengths[:, None]


def trimesh_method(points, faces):
    """Face normals by cross products; angles at corners; faces without a normal left out; sums by vertex; unit."""
    triangles = points[faces]
    u, v, w = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0], triangles[:, 2] - triangles[:, 1]
    normals = unit(np.cross(u, w))
    u, v, w = unit(u), unit(v), unit(w)
    angles = np.zeros((len(faces), 3))
    angles[:, 0] = np.arccos(np.clip((u * v).sum(axis=1), -1, 1))
    angles[:, 1] = np.arccos(np.clip((-u * w).sum(axis=1), -1, 1))
    angles[:, 2] = np.pi - angles[:, 0] - angles[:, 1]
    angles[(angles < 1e-8).any(axis=1), :] = 0
    kept = (normals**2).sum(axis=1) > 0.5
    faces, normals, angles = faces[kept], normals[kept], angles[kept]
    sums = np.empty_like(points)
    for axis in range(3):
        sums[:, axis] = np.bincount(faces.ravel(), (angles * normals[:, axis, None]).ravel(), len(points))
    return unit(sums)


def open3d_method(points, faces):
    import open3d

    mesh = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(points.astype(np.float64)),
                                        open3d.utility.Vector3iVector(faces.astype(np.int32)))

    def run():
        mesh.triangle_normals.clear()
        mesh.vertex_normals.clear()
        mesh.compute_vertex_normals()

    return run


def main():
    triangles = int(sys.argv[1]) if len(sys.argv) > 1 else 1000000
    print(f"norma_mesh {norma.__version__}, numpy {np.__version__}, {triangles} triangles, ns a triangle")
    for shuffled in (False, True):
        points, faces = grid(triangles, shuffled)
        doubles, narrow, out = points.astype(np.float64), faces.astype(np.uint32), np.empty_like(points)
        signed = faces.astype(np.int32)
        runs = {
            "norma, float64, int64 (as trimesh has them)": lambda: norma.vertex_normals(doubles, faces),
            "norma, float32, int64": lambda: norma.vertex_normals(points, faces),
            "norma, float32, uint32": lambda: norma.vertex_normals(points, narrow),
            "norma, float32, uint32, out": lambda: norma.vertex_normals(points, narrow, out=out),
            "  one thread": lambda: norma.vertex_normals(points, narrow, out=out, threads=1),
            "norma, float32, int32, by index, area": lambda: norma.vertex_normals(points, signed, weight="area", weld="none"),
            "  by index": lambda: norma.vertex_normals(points, narrow, weld="none", out=out),
            "  by index, area": lambda: norma.vertex_normals(points, narrow, weight="area", weld="none", out=out),
            "  by index, area, one thread": lambda: norma.vertex_normals(points, narrow, weight="area", weld="none", out=out, threads=1),
            "norma, corners with creases": lambda: norma.corner_normals(points, narrow),
            "trimesh's method, angle, one thread": lambda: trimesh_method(doubles, faces),
        }
        try:
            runs["Open3D, area, by index"] = open3d_method(points, faces)
        except ImportError:
            print("Open3D is not installed")
        difference = np.abs(trimesh_method(doubles, faces) - norma.vertex_normals(doubles, faces)).max()
        best = {name: (float("inf"), float("inf")) for name in runs}
        for _ in range(7):
            for name, run in runs.items():
                start = time.perf_counter(), time.process_time()
                run()
                took = time.perf_counter() - start[0], time.process_time() - start[1]
                best[name] = min(best[name][0], took[0]), min(best[name][1], took[1])
        print("shuffled" if shuffled else "rows of neighbours", f"(largest difference to trimesh's method {difference:.1e}); clock, processors")
        for name, took in best.items():
            print(f"  {name:50} {took[0] / len(faces) * 1e9:8.1f} {took[1] / len(faces) * 1e9:8.1f}")
    for kind in np.float32, np.float64:
        heights = np.random.RandomState(1).normal(size=(1000, 1000)).astype(kind)
        slopes, normals = least(lambda: np.gradient(heights), 50), least(lambda: norma.heightmap_normals(heights), 50)
        print(f"a million heights, {kind.__name__}: heightmap_normals {normals * 1e3:.1f} ms, numpy's gradient {slopes * 1e3:.1f} ms")
    one = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.uint32([[0, 1, 2]])
    points, faces = grid(1000, False)
    calls = {
        "vertex_normals, 1 triangle": lambda: norma.vertex_normals(*one),
        f"vertex_normals, {len(faces)} triangles, int64 faces": lambda: norma.vertex_normals(points, faces),
        "normal_matrix": lambda: norma.normal_matrix(np.eye(4)),
    }
    for name, call in calls.items():
        print(f"a call of {name}: {least(call) * 1e6:.1f} microseconds")


def least(call, times=20000):
    best = float("inf")
    for _ in range(times):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


if __name__ == "__main__":
    main()
