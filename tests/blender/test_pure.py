"""The parts of the add-on that need no Blender, from the zip: surfaces, files, findings, fixes, weights.

    test_pure.py ADD-ON.zip [-v]
"""
import os
import sys
import tempfile
import types
import unittest
import zipfile

import numpy as np

ZIP = sys.argv.pop(1)
folder = tempfile.TemporaryDirectory()
with zipfile.ZipFile(ZIP) as archive:
    NAMES = archive.namelist()
    archive.extractall(folder.name)
package = types.ModuleType("norma_normals")  # its own __init__ registers the add-on with Blender
package.__path__ = [os.path.join(folder.name, "norma_normals")]
sys.modules["norma_normals"] = package
from norma_normals import findings, fixing, gltf, norma_mesh, surface, weighted  # noqa: E402

QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]], np.uint32)
CUBE = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
OUTWARD = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]], np.float32)


def cube(quads=QUADS, normals=None, name="Cube", **options):
    starts = np.arange(len(quads) + 1, dtype=np.uint32) * 4
    first = starts[:-1, None]
    triangles = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]], 1).reshape(-1, 3).astype(np.uint32)
    shading = np.repeat(OUTWARD[: len(quads)] if normals is None else normals, 4, 0).astype(np.float32)
    faces = np.repeat(np.arange(len(quads)), 2).astype(np.uint32)
    return surface.Surface(name, CUBE, quads.reshape(-1), starts, shading, triangles, faces, **options)


def turned(face):
    quads = QUADS.copy()
    quads[face] = quads[face][::-1]
    return quads


class Files(unittest.TestCase):
    def test_vertices_are_shared_where_all_is_equal(self):
        (part,) = surface.primitives(cube())
        self.assertEqual((len(part.positions), part.indices.shape), (24, (12, 3)))
        smooth = cube()
        smooth.normals = CUBE[smooth.corners] / np.float32(3**0.5)
        (part,) = surface.primitives(smooth)
        self.assertEqual(len(part.positions), 8)

    def test_rows_are_told_apart_as_by_sorting(self):
        random = np.random.default_rng(41)
        for vertices, kinds, count in ((50, 3, 2000), (1, 40, 500), (400, 1, 400), (1, 1, 0)):
            rows = np.stack([random.integers(0, vertices, count), random.integers(0, kinds, count), random.integers(0, 2, count)], 1).astype(np.uint32)
            first, of = surface._distinct(list(rows.T))
            self.assertTrue(np.array_equal(rows[first][of], rows))
            self.assertEqual(first.tolist(), sorted(np.unique(rows, axis=0, return_index=True)[1].tolist()))

    def test_each_material_is_a_primitive(self):
        parts = surface.primitives(cube(face_materials=np.array([0, 0, 1, 1, 1, 2])))
        self.assertEqual([(part.material, len(part.indices)) for part in parts], [(0, 4), (1, 6), (2, 2)])

    def test_a_reader_finds_what_was_written(self):
        whole = cube(texcoords=np.tile(np.float32([[0, 0], [1, 0], [1, 1], [0, 1]]), (6, 1)))
        with tempfile.TemporaryDirectory() as place:
            path, _ = findings.exported([whole], place)
            (mesh,) = norma_mesh.open(path).meshes
        corners = mesh.faces.reshape(-1)
        expected = whole.triangles.reshape(-1)
        np.testing.assert_array_equal(mesh.positions[corners], CUBE[whole.corners[expected]])
        np.testing.assert_array_equal(mesh.normals[corners], whole.normals[expected])
        np.testing.assert_array_equal(mesh.texcoords[corners], whole.texcoords[expected] * [1, -1] + [0, 1])

    def test_the_zip_is_whole(self):
        for name in ("__init__.py", "blender_manifest.toml", "LICENSE", "norma_mesh/__init__.py", "norma_mesh/_norma.abi3.so"):
            self.assertIn("norma_normals/" + name, NAMES)
        with open(os.path.join(package.__path__[0], "blender_manifest.toml")) as file:
            manifest = file.read()
        self.assertNotIn("@", manifest)
        self.assertIn(f'version = "{norma_mesh.__version__}"', manifest)


class Findings(unittest.TestCase):
    def test_a_clean_cube(self):
        self.assertEqual(findings.check([cube()], infos=False), [])

    def test_a_turned_face_is_named(self):
        rows = findings.check([cube(name="good"), cube(turned(3), name="bad")], infos=False)
        (row,) = [row for row in rows if row.rule == "N201"]
        self.assertEqual((row.object, row.faces.tolist(), len(row.triangles)), ("bad", [3], 2))
        self.assertTrue((row.triangles[:, :, 1] == 1).all())

    def test_places_are_those_of_the_world(self):
        matrix = np.diag([1.0, 1, 1, 1])
        matrix[:3, 3] = 5, 0, 0
        row = next(row for row in findings.check([cube(turned(5), matrix=matrix)]) if row.rule == "N201")
        self.assertTrue((row.triangles[:, :, 0] == 6).all())

    def test_a_mirrored_object(self):
        mirrored = cube(matrix=np.diag([-1.0, 1, 1, 1]), materials=[surface.Material("m", True)])
        self.assertIn(("N602", "Cube"), [(row.rule, row.object) for row in findings.check([mirrored])])


class Fixes(unittest.TestCase):
    def fixed(self, surfaces, rules):
        changes, notes = fixing.fix(surfaces, True, rules)
        self.assertEqual(notes, ())
        return changes

    def test_a_turned_face(self):
        good, bad = self.fixed([cube(), cube(turned(3))], ["N301", "N201"])
        self.assertTrue(good.empty)
        self.assertEqual((np.flatnonzero(bad.turned).tolist(), bad.gone.any()), ([3], False))
        self.assertIsNone(bad.normals)

    def test_opposed_normals(self):
        (change,) = self.fixed([cube(normals=-OUTWARD)], ["N201", "N206"])
        self.assertFalse(change.turned.any())
        self.assertLess(np.abs(change.normals - np.repeat(OUTWARD, 4, 0)).max(), 1e-6)

    def test_a_face_that_is_there_twice(self):
        twice = np.concatenate([QUADS[:2], QUADS[1:2], QUADS[2:]])
        normals = np.concatenate([OUTWARD[:2], OUTWARD[1:2], OUTWARD[2:]])
        (change,) = self.fixed([cube(twice, normals)], ["N305"])
        self.assertEqual((change.gone.sum(), bool(change.gone[1] != change.gone[2]), change.turned.any()), (1, True, False))


class Weights(unittest.TestCase):
    def test_a_smooth_cube_points_to_its_corners(self):
        whole = cube()
        for weight in ("angle", "uniform"):
            normals = weighted.corner_normals(whole, weight, 180)
            self.assertLess(np.abs(normals - CUBE[whole.corners] / 3**0.5).max(), 1e-6)
        self.assertLess(np.abs(weighted.corner_normals(whole, "area", 60) - whole.normals).max(), 1e-7)

    def test_sharp_edges(self):
        whole = cube(hard_edges=np.ones(24, bool))
        self.assertLess(np.abs(weighted.corner_normals(whole, "angle", 180) - whole.normals).max(), 1e-7)
        free = weighted.corner_normals(whole, "angle", 180, keep_sharp=False)
        self.assertLess(np.abs(free - CUBE[whole.corners] / 3**0.5).max(), 1e-6)

    def test_every_weight_has_a_name_that_the_package_knows(self):
        for name, _, _ in weighted.WEIGHTS:
            norma_mesh.vertex_normals(CUBE, QUADS, weight=name)
        with self.assertRaisesRegex(ValueError, "weight") as caught:
            norma_mesh.vertex_normals(CUBE, QUADS, weight="?")
        self.assertEqual(str(caught.exception).count("'") // 2, len(weighted.WEIGHTS) + 1)  # all, and "?"

    def test_edges_between_different_normals_are_hard(self):
        whole = cube()
        pairs = {}
        ends = [(int(q[i]), int(q[(i + 1) % 4])) for q in QUADS for i in range(4)]
        edges = np.array([pairs.setdefault(frozenset(pair), len(pairs)) for pair in ends])
        self.assertEqual(len(pairs), 12)
        hard = weighted.hard_edges(whole.corners, whole.starts, edges, whole.normals, 12)
        self.assertEqual(hard.sum(), 12)
        smooth = weighted.hard_edges(whole.corners, whole.starts, edges, CUBE[whole.corners], 12)
        self.assertEqual(smooth.sum(), 0)
        one = np.where((np.arange(24) < 4)[:, None], whole.normals, CUBE[whole.corners])  # the first face alone is flat
        self.assertEqual(weighted.hard_edges(whole.corners, whole.starts, edges, one, 12).sum(), 4)


if __name__ == "__main__":
    unittest.main()
