"""Normals from Python beside what others do: nanoseconds a triangle, the best of several runs in turn.

    bench_python.py [TRIANGLES]      with norma_mesh installed; Open3D is measured where it is installed

trimesh's method (4.x, `trimesh.geometry.weighted_vertex_normals` with angles as weights) is written
down here in numpy and scipy's place taken by np.add.at's faster form, bincount.
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


def trimesh_method(points, faces):
    """Face normals by cross products; angles at corners; sums by vertex; unit."""
    triangles = points[faces]
    vectors = np.diff(triangles[:, [0, 1, 2, 0]], axis=1)
    normals = np.cross(vectors[:, 0], vectors[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    unit = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
    angles = np.empty((len(faces), 3))
    angles[:, 0] = np.arccos(np.clip(-(unit[:, 0] * unit[:, 2]).sum(1), -1, 1))
    angles[:, 1] = np.arccos(np.clip(-(unit[:, 0] * unit[:, 1]).sum(1), -1, 1))
    angles[:, 2] = np.pi - angles[:, 0] - angles[:, 1]
    sums = np.empty_like(points, np.float64)
    for axis in range(3):
        sums[:, axis] = np.bincount(faces.ravel(), (angles * normals[:, axis, None]).ravel(), len(points))
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


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
        narrow = faces.astype(np.uint32)
        out = np.empty_like(points)
        runs = {
            "norma, angle, int64 faces, one thread": lambda: norma.vertex_normals(points, faces, threads=1),
            "norma, angle, uint32 faces, one thread": lambda: norma.vertex_normals(points, narrow, threads=1, out=out),
            "norma, area, uint32 faces, by index, one thread": lambda: norma.vertex_normals(points, narrow, weight="area", weld="none", threads=1, out=out),
            "norma, area, int64 faces, by index, one thread": lambda: norma.vertex_normals(points, faces, weight="area", weld="none", threads=1),
            "norma, angle, uint32 faces, all threads": lambda: norma.vertex_normals(points, narrow, out=out),
            "norma, corners with creases, all threads": lambda: norma.corner_normals(points, narrow),
            "trimesh's method, angle": lambda: trimesh_method(points, faces),
        }
        try:
            runs["Open3D, area"] = open3d_method(points, faces)
        except ImportError:
            print("Open3D is not installed")
        difference = np.abs(trimesh_method(points, faces) - norma.vertex_normals(points, faces)).max()
        best = dict.fromkeys(runs, float("inf"))
        for _ in range(5):
            for name, run in runs.items():
                start = time.perf_counter()
                run()
                best[name] = min(best[name], time.perf_counter() - start)
        print("shuffled" if shuffled else "rows of neighbours", f"(largest difference to trimesh's method {difference:.1e})")
        for name, took in best.items():
            print(f"  {name:50} {took / len(faces) * 1e9:8.1f}")
    one = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.uint32([[0, 1, 2]])
    points, faces = grid(1000, False)
    calls = {
        "vertex_normals, 1 triangle": lambda: norma.vertex_normals(*one),
        f"vertex_normals, {len(faces)} triangles, int64 faces": lambda: norma.vertex_normals(points, faces),
        "normal_matrix": lambda: norma.normal_matrix(np.eye(4)),
    }
    for name, call in calls.items():
        print(f"a call of {name}: {least(call) * 1e6:.1f} microseconds")


def least(call):
    best = float("inf")
    for _ in range(20000):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


if __name__ == "__main__":
    main()
