"""The example with meshio, for one format: the normals of a sphere of triangles and quads, whose normals are known, come back with all else as it was.

    meshio_cases.py EXAMPLE FOLDER FORMAT COMMAND...    exits 77 where meshio lacks the format
"""
import subprocess
import sys

import meshio
import numpy as np

example, folder, ending, *command = sys.argv[1:]
ROUND, HIGH = 48, 24


def sphere():
    u, v = np.meshgrid(2 * np.pi * np.arange(ROUND) / ROUND, np.pi * (0.5 + np.arange(HIGH)) / HIGH)
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1).reshape(-1, 3)
    at = np.arange(ROUND * HIGH).reshape(HIGH, ROUND)
    quads = np.stack([at[:-1], at[1:], np.roll(at, -1, 1)[1:], np.roll(at, -1, 1)[:-1]], -1).reshape(-1, 4)
    cut = len(quads) // 3
    triangles = np.concatenate([quads[:cut, [0, 1, 2]], quads[:cut, [0, 2, 3]]])
    return np.concatenate([points, [(9, 9, 9)]]), triangles, quads[cut:]  # the last point has no face


points, triangles, quads = sphere()
cells = [("triangle", triangles), ("quad", quads)]
before, after = "%s/before.%s" % (folder, ending), "%s/after.%s" % (folder, ending)
try:
    meshio.Mesh(points, cells, point_data={"heat": points[:, 2]}).write(before)
except (ImportError, meshio.WriteError) as error:
    print(error)
    sys.exit(77)
subprocess.run([sys.executable, example, before, after, *command], check=True)
mesh = meshio.read(after)
assert np.array_equal(mesh.points, points), "other points"
assert len(mesh.cells) == len(cells) and all(np.array_equal(block.data, data) for block, (_, data) in zip(mesh.cells, cells)), "other cells"
assert np.array_equal(mesh.point_data["heat"], points[:, 2]), "other point data"
normals = mesh.point_data["Normals"]
assert np.array_equal(normals[-1], [0, 0, 0]), "a point without a face has a normal"
away = ROUND  # the first and the last row have a hole beside them
angles = np.degrees(np.arccos(np.clip((normals[away:-1 - away] * points[away:-1 - away]).sum(1), -1, 1)))
assert np.allclose(np.linalg.norm(normals[:-1], axis=1), 1, atol=1e-6), "normals are not of length 1"
assert angles.max() < 1.5, "wrong by %g degrees" % angles.max()
print("%s: worst %.3f degrees" % (ending, angles.max()))
