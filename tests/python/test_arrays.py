"""Calls on arrays: closed forms, forms of arguments, and refusals that name the argument."""
import math
import os
import pathlib
import signal
import threading
import time
import types
import unittest
import warnings

import numpy as np

import norma_mesh as norma

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float64)


def sphere(rows=40, columns=80):
    """Points of the unit sphere (their own normals) and triangles that face outward."""
    theta = np.linspace(0.2, math.pi - 0.2, rows)[:, None]
    phi = np.linspace(0, 2 * math.pi, columns, endpoint=False)[None]
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], -1)
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    faces = np.concatenate([np.stack([a, a + columns, b], -1), np.stack([b, a + columns, b + columns], -1)], 0)
    return points.reshape(-1, 3), faces.reshape(-1, 3)


def grid(side):
    y, x = np.mgrid[0:side, 0:side]
    points = np.stack([x, y, np.sin(x * 0.1) * np.cos(y * 0.1)], -1).reshape(-1, 3).astype(np.float32)
    a = (y[:-1, :-1] * side + x[:-1, :-1]).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + side], -1), np.stack([a + 1, a + side + 1, a + side], -1)])
    return points, faces.astype(np.uint32)


class ClosedForms(unittest.TestCase):
    def test_a_sphere(self):
        points, faces = sphere()
        normals = norma.vertex_normals(points, faces)
        inner = slice(80, -80)  # the rims are open
        cosine = (normals[inner] * points[inner]).sum(1)
        self.assertGreater(cosine.min(), math.cos(math.radians(1)))

    def test_area_weights_are_the_sum_of_cross_products(self):
        points, faces = sphere(12, 17)
        a, b, c = (points[faces[:, k]] for k in range(3))
        sums = np.zeros_like(points)
        for k in range(3):
            np.add.at(sums, faces[:, k], np.cross(b - a, c - a))
        sums /= np.linalg.norm(sums, axis=1, keepdims=True)
        self.assertLess(np.abs(norma.vertex_normals(points, faces, weight="area") - sums).max(), 1e-6)

    def test_a_cube_has_three_normals_at_each_corner(self):
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        faces, sources, normals = norma.split(corners, quads, crease=60)
        self.assertEqual((len(sources), faces.shape), (24, (6, 4)))
        self.assertTrue(np.array_equal(np.sort(np.abs(normals), 1)[:, 2], np.ones(24, np.float32)))
        smooth = norma.split(corners, quads, crease=180)
        self.assertLess(np.abs(np.abs(smooth.normals) - 1 / math.sqrt(3)).max(), 1e-6)
        self.assertEqual(len(smooth.normals), 8)

    def test_corners_that_agree_in_all_streams_share_a_vertex(self):
        random = np.random.default_rng(3)
        one, other = random.integers(0, 5, (999, 3)).astype(np.float32), random.integers(0, 4, 999).astype(np.int16)
        wide = np.zeros((999, 7), np.float32)
        wide[:, 2:5] = one
        rows = np.column_stack([one.view(np.uint32), other.astype(np.uint32)])
        for first in (one, wide[:, 2:5], one[::-1].copy()[::-1], np.asfortranarray(one)):
            indices, sources = norma.index_corners(first, other, threads=2)
            _, begins, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
            order = np.argsort(begins)
            self.assertTrue(np.array_equal(sources, begins[order]))
            self.assertTrue(np.array_equal(order[indices], inverse.reshape(-1)))
        self.assertEqual([len(part) for part in norma.index_corners(np.float32([0.0, -0.0, 0.0]))], [3, 2])
        self.assertEqual([len(part) for part in norma.index_corners(np.empty((0, 3)))], [0, 0])

    def test_streams_that_cannot_be_compared(self):
        for wrong, error in (((), ValueError), (([1, 2], [1]), ValueError), ((np.empty((2, 0)),), ValueError), ((7,), ValueError), (([object()],), TypeError)):
            with self.assertRaisesRegex(error, "^streams"):
                norma.index_corners(*wrong)

    def test_normal_matrices(self):
        model = np.array([[2, 0.5, 0, 7], [0, 3, 0, 8], [1, 0, -4, 9], [0, 0, 0, 1]])
        expected = np.linalg.inv(model[:3, :3]).T
        for kind, digits in ((np.float64, 1e-15), (np.float32, 1e-6)):
            found = norma.normal_matrix(model.astype(kind))
            self.assertEqual(found.dtype, kind)
            scale = found[0, 0] / expected[0, 0]
            self.assertGreater(scale, 0)
            self.assertLess(np.abs(found / scale - expected).max(), digits * 10)
        many = norma.normal_matrices(np.stack([model, np.eye(4)]))
        self.assertTrue(np.array_equal(many[0], norma.normal_matrix(model)))
        self.assertTrue(np.array_equal(many[1], np.eye(3)))
        info = norma.matrix_info(np.diag([1, 1, -1]))
        self.assertEqual((info.kind, info.mirrored, info.rank), ("rotation", True, 3))

    def test_normals_stay_perpendicular(self):
        model = np.array([[1.0, 2, 0], [0, 1, 0], [0, 0, 5]])
        out = norma.transform_normals(norma.normal_matrix(model), [[0, 0.6, 0.8]])[0]
        self.assertLess(abs(out @ (model @ [1, 0, 0])), 1e-6)
        self.assertLess(abs(out @ (model @ [0, 0.8, -0.6])), 1e-6)

    def test_codes(self):
        directions = np.random.default_rng(7).normal(size=(5000, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        for encoding, degrees in (("oct8", 0.638), ("oct12", 0.0396), ("oct16", 0.00248), ("10-10-10-2", 0.0793)):
            self.assertLess(abs(norma.encoding_error_deg(encoding) - degrees), degrees / 200)
            codes = norma.encode_normals(directions, encoding)
            self.assertEqual((codes.dtype, codes.shape), (np.uint32, (5000,)))
            back = norma.decode_normals(codes, encoding).astype(np.float64)
            off = np.degrees(np.arcsin(np.linalg.norm(np.cross(directions, back), axis=1)))
            self.assertLess(off.max(), norma.encoding_error_deg(encoding))
            self.assertGreater(off.max(), norma.encoding_error_deg(encoding) * 0.9)
            self.assertGreater((directions * back).sum(axis=1).min(), 0.99)
        codes, report = norma.encode_normals([[0, 0, 0], [0, np.nan, 1], [-3, 0, 0]], "oct8", report=True)
        self.assertEqual((codes.tolist(), report.cancelled, report.non_finite), ([0, 0, 0x80], 1, 1))
        wide = np.zeros((2, 4), np.float32)
        norma.decode_normals([0, 0x00008000], out=wide[:, :3])
        self.assertEqual(wide.tolist(), [[0, 0, 1, 0], [-1, 0, 0, 0]])
        self.assertEqual(norma.encode_normals(np.zeros((0, 3))).size, 0)

    def test_skins(self):
        """By the definition, in doubles: B = sum of w M, sign(det B) cof(B) n, and B t made perpendicular."""
        r = np.random.default_rng(3)
        matrices = r.normal(size=(5, 4, 4)) + 2 * np.eye(4)
        matrices[:, 3] = [0, 0, 0, 1]
        matrices[4, 0, :3] *= -1
        joints, weights = r.integers(0, 5, size=(300, 3)), r.uniform(0, 1, (300, 3)).astype(np.float32)
        points, normals, tangents = (r.normal(size=(300, 3)).astype(np.float32) for _ in range(3))
        whole = np.einsum("nk,nkij->nij", weights.astype(float), matrices.astype(np.float32).astype(float)[joints])
        b = whole[:, :3, :3]
        expected = np.linalg.inv(b).transpose(0, 2, 1) @ normals[:, :, None].astype(float)
        expected = expected[:, :, 0] / np.linalg.norm(expected[:, :, 0], axis=1)[:, None]
        skin = norma.Skin(matrices, joints.astype(np.uint8), weights)
        moved = np.einsum("nij,nj->ni", whole, np.c_[points, np.ones(300)])[:, :3]
        self.assertLess(np.abs(skin.positions(points) - moved).max(), 1e-5)
        out, report = skin.normals(normals, report=True)
        self.assertLess(np.abs(out - expected).max(), 1e-5)
        self.assertEqual((report.cancelled, report.non_finite), (0, 0))
        signed = np.c_[tangents, np.ones(300, np.float32)]
        turned = skin.tangents(signed, out)
        self.assertLess(np.abs((turned[:, :3] * out).sum(axis=1)).max(), 1e-6)
        self.assertTrue(np.array_equal(turned[:, 3], np.sign(np.linalg.det(b))))
        place = points.copy()
        self.assertIs(skin.positions(place, out=place), place)
        self.assertTrue(np.array_equal(place, skin.positions(points)))
        flat = norma.Skin([np.diag([1, 0, 0, 1])], [[0]], [[1]])
        self.assertEqual(flat.normals([[0, 0, 1]], fallback=(0, 1, 0)).tolist(), [[0, 1, 0]])
        quarter = norma.Skin([np.eye(4), [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]], [[0, 1]], [[0.5, 0.5]], blend="dual-quaternion")
        self.assertLess(np.abs(quarter.positions([[1, 0, 0]]) - [[0.5 ** 0.5, 0.5 ** 0.5, 0]]).max(), 1e-6)

    def test_tangents_follow_u(self):
        uv = SQUARE[:, :2] @ np.array([[0, 1], [-1, 0]])  # u = -y, v = x
        found, report = norma.tangents(SQUARE, np.tile([0, 0, 1.0], (4, 1)), uv, [[0, 1, 2, 3]], report=True)
        self.assertLess(np.abs(found - [0, -1, 0, 1]).max(), 1e-6)
        self.assertEqual(report.degenerate, 0)
        indexed = norma.tangents(SQUARE, [[0, 0, 1]], uv, [[0, 1, 2, 3]], normal_faces=[[0, 0, 0, 0]])
        self.assertTrue(np.array_equal(indexed, found))
        tilted = [[0.1, 0, 1], [0, 0.2, 1], [0.3, 0, 1], [0, 0.4, 1]]
        by_corner = norma.tangents(SQUARE, tilted[::-1], uv, [[0, 1, 2, 3]])
        for numbers in ([[[3, 2], [1, 0]]], [[3, 2, 1, 0]], [3, 2, 1, 0]):
            indexed = norma.tangents(SQUARE, tilted, uv, [[0, 1, 2, 3]], normal_faces=np.array(numbers))
            self.assertTrue(np.array_equal(indexed, by_corner))

    def test_a_plan_gives_what_a_call_gives(self):
        points, faces = sphere(15, 20)
        plan = norma.Plan(points, faces)
        normals = plan.update(points)
        self.assertTrue(np.array_equal(normals, norma.vertex_normals(points, faces)))
        points[33] *= 1.2
        self.assertIs(plan.update(points, moved=[33]), normals)
        self.assertTrue(np.array_equal(normals, norma.vertex_normals(points, faces)))
        corners = norma.Plan(points, faces, per="corner", crease=30)
        self.assertTrue(np.array_equal(corners.update(points), norma.corner_normals(points, faces, crease=30)))
        self.assertGreater(plan.nbytes, 0)

    def test_orientation(self):
        points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        outward = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        mixed = outward.copy()
        mixed[[0, 2], 1:] = outward[[0, 2], :0:-1]
        found, report = norma.orient(points, mixed, report=True)
        self.assertTrue(np.array_equal(found, outward))
        self.assertEqual((report.closed, report.reversed_faces), (1, 2))
        corners, starts = norma.orient(points, (mixed.ravel(), [0, 3, 6, 9, 12]))
        self.assertTrue(np.array_equal(corners.reshape(-1, 3), outward))


class Compare(unittest.TestCase):
    """Known angles, and surfaces in another order."""

    def test_octahedron_in_a_sphere(self):
        points, faces = sphere(90, 91)
        points = points / np.linalg.norm(points, axis=1)[:, None]
        eight = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
        corners = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
        flat = norma.corner_normals(eight, corners, crease=0)
        found = norma.compare((points, faces, points), (eight, corners, flat), max_deg=50)
        self.assertFalse(found.same_faces)
        self.assertLess(abs(found.p50_deg - np.degrees(np.arccos(3**-0.5))), 1.5)
        self.assertAlmostEqual(found.share_above, 2 / 3)  # the sphere is open at its poles

    def test_another_order(self):
        points, faces = sphere(9, 11)
        normals = norma.vertex_normals(points, faces)
        found = norma.compare((points, faces, normals), (points, faces[::-1], normals))
        self.assertLess(found.max_deg, 1e-4)
        self.assertEqual((found.same_faces, found.missing), (False, 0))
        normals[3] = np.nan
        found = norma.compare((points, faces, points), (points, faces, normals))
        self.assertTrue(found.same_faces)
        self.assertEqual(found.missing, int(np.count_nonzero(np.isnan(found.angles) & (found.areas > 0))))
        self.assertGreater(found.missing, 0)

    def test_refusals(self):
        points, faces = sphere(4, 5)
        good = (points, faces, points)
        for bad, kind in (((points, faces), TypeError), ((points, faces, points[1:]), ValueError)):
            with self.assertRaises(kind):
                norma.compare(good, bad)
        with self.assertRaises(ValueError):
            norma.compare(good, good, max_deg=-1)
        with self.assertRaises(IndexError):
            norma.compare((points, [[0, 1, 999]], points), good)


class Forms(unittest.TestCase):
    """The same mesh in any dress gives the same bits."""

    def setUp(self):
        self.points, self.faces = sphere(9, 11)
        self.points = self.points.astype(np.float32)
        self.expected = norma.vertex_normals(self.points, self.faces)

    def same(self, points, faces, **options):
        self.assertTrue(np.array_equal(norma.vertex_normals(points, faces, **options), self.expected))

    def test_positions(self):
        rows = np.zeros((len(self.points), 8), np.float32)
        rows[:, 2:5] = self.points
        record = np.zeros(len(self.points), [("id", "u1"), ("at", "<f4", 3)])
        record["at"] = self.points
        for points in (
            self.points.astype(np.float64),
            self.points.astype(">f4"),
            np.asfortranarray(self.points),
            rows[:, 2:5],
            record["at"],
            self.points[::-1][::-1],
            self.points.tolist(),
        ):
            self.same(points, self.faces)
        backwards = norma.vertex_normals(self.points[::-1], len(self.points) - 1 - self.faces)
        self.assertTrue(np.array_equal(backwards[::-1], self.expected))

    def test_faces(self):
        for kind in (np.int64, np.uint64, np.int32, np.uint32, np.int16, np.uint16, np.uint8, np.int8, ">i4"):
            self.same(self.points, self.faces.astype(kind))
        self.same(self.points, np.asfortranarray(self.faces))
        self.same(self.points, self.faces.tolist())
        self.same(self.points, (self.faces.ravel(), np.arange(len(self.faces) + 1) * 3))
        self.same(self.points, np.repeat(self.faces, 2, 0)[::2])
        whole = type("Mesh", (), {"vertices": self.points, "faces": self.faces})()
        self.same(whole, None)
        o3d = type("Mesh", (), {"vertices": self.points, "triangles": self.faces})()
        self.same(o3d, None)

    def test_polygons(self):
        a = norma.face_normals(SQUARE, [[0, 1, 2, 3], [0, 1, 2]])
        self.assertTrue(np.array_equal(a, [[0, 0, 1]] * 2))
        self.assertTrue(np.array_equal(norma.face_normals(SQUARE, [[0, 1, 2, 3]]), [[0, 0, 1]]))
        self.assertTrue(np.array_equal(norma.face_normals(SQUARE[:3], "soup"), [[0, 0, 1]]))
        faces = norma.split(SQUARE, [[0, 1, 2, 3], [0, 1, 2]]).faces
        self.assertEqual(len(faces[0]), 7)

    def test_nothing(self):
        for faces in ([], np.empty((0, 3), int), "soup"):
            self.assertEqual(norma.vertex_normals([], faces).shape, (0, 3))
        self.assertEqual(norma.corner_normals(SQUARE, []).shape, (0, 3))
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy's comparison of an array with a word, which later ones answer by an array
            self.assertEqual(norma.vertex_normals(SQUARE, [], fallback=np.array([0.0, 0.0, 1.0]))[0].tolist(), [0, 0, 1])
        normals, report = norma.vertex_normals(SQUARE, [], report=True, fallback=(0, 0, 1))
        self.assertTrue(np.array_equal(normals, [[0, 0, 1]] * 4))
        self.assertEqual(report.unreferenced, 4)

    def test_out(self):
        out = np.full((len(self.points), 3), 7, np.float32)
        self.assertIs(norma.vertex_normals(self.points, self.faces, out=out), out)
        self.assertTrue(np.array_equal(out, self.expected))
        rows = np.full((len(self.points), 6), 7, np.float32)
        rows[:, :3] = self.points
        norma.vertex_normals(rows[:, :3], self.faces, out=rows[:, 3:])
        self.assertTrue(np.array_equal(rows[:, 3:], self.expected))
        self.assertTrue(np.array_equal(rows[:, :3], self.points))

    def test_inputs_stay(self):
        points, faces = self.points.copy(), self.faces.copy()
        points.flags.writeable = faces.flags.writeable = False
        norma.split(points, faces)
        norma.orient(points, faces)
        self.same(points, faces)

    def test_threads_and_welds(self):
        for threads in (1, 2, 7, None):
            self.same(self.points, self.faces, threads=threads)
        twice = np.concatenate([self.points, self.points])
        faces = np.concatenate([self.faces[::2], self.faces[1::2] + len(self.points)])
        both = norma.vertex_normals(twice, faces)
        self.assertLess(np.abs(both[: len(self.points)] - self.expected).max(), 1e-6)
        apart = norma.vertex_normals(twice, faces, weld="none")
        self.assertGreater(np.abs(apart - both).max(), 1e-3)
        near = norma.vertex_normals(twice * np.float32(1.0), faces, weld=1e-6)
        self.assertTrue(np.array_equal(near, both))


class OtherLibraries(unittest.TestCase):
    """Meshes of other libraries, whole: the arrays taken are those that were put in."""

    TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
    POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 2]])  # every three of them have another normal

    def same(self, whole, faces=TRIANGLES):
        expected = norma.corner_normals(self.POINTS, faces, crease=0)
        self.assertTrue(np.array_equal(norma.corner_normals(whole, crease=0), expected))

    def test_stand_ins(self):
        points, faces, named = self.POINTS, self.TRIANGLES, types.SimpleNamespace
        self.same(named(vertices=points, faces=faces))  # trimesh
        self.same(named(vertices=points, triangles=faces))  # Open3D
        tensor = lambda array: named(cpu=lambda: named(numpy=lambda: array))
        self.same(named(vertex={"positions": tensor(points)}, triangle={"indices": tensor(faces)}))  # Open3D, tensors
        self.same(named(points=points, faces=np.array([3, 0, 1, 2, 3, 0, 2, 3])))  # pyvista
        self.same(named(points=points, faces=np.array([4, 0, 1, 2, 3, 3, 0, 1, 2])), [[0, 1, 2, 3], [0, 1, 2]])
        blocks = [named(type="line", data=[[0, 1]]), named(type="triangle", data=faces), named(type="quad", data=[[0, 1, 2, 3]])]
        self.same(named(points=points, cells=blocks), [[0, 1, 2], [0, 2, 3], [0, 1, 2, 3]])  # meshio
        for whole in named(points=points), named(vertices=points, triangles=None), named(vertex={"positions": points}, triangle={}):
            with self.assertRaisesRegex(TypeError, "^positions: an object with vertices needs faces.*estimate_normals"):
                norma.vertex_normals(whole)
        with self.assertRaisesRegex(TypeError, "^positions: faces .* are needed, not tetra"):
            norma.vertex_normals(named(points=points, cells=[named(type="tetra", data=[[0, 1, 2, 3]])]))
        for type_ in "vertex", "line3", "tetra", "tetra10", "hexahedron20", "VTK_LAGRANGE_CURVE", "VTK_LAGRANGE_WEDGE":
            self.same(named(points=points, cells=[named(type=type_, data=[[0, 1, 2, 3]]), named(type="triangle", data=faces)]))
        for type_ in "triangle6", "quad8", "quad9", "VTK_LAGRANGE_TRIANGLE", "VTK_LAGRANGE_QUADRILATERAL":
            with self.assertRaisesRegex(TypeError, rf"^positions: faces .* are needed, not {type_}$"):
                norma.vertex_normals(named(points=points, cells=[named(type="tetra", data=[[0, 1, 2, 3]]), named(type="triangle", data=faces), named(type=type_, data=[[0] * 9])]))

    def test_clouds_of_tensors(self):
        named = types.SimpleNamespace
        for whole in named(point={"positions": self.POINTS}), named(point={}), named(vertex={}, triangle={}):
            for call in norma.vertex_normals, lambda cloud: norma.sample(cloud, 5), norma.check:
                with self.assertRaisesRegex(TypeError, "^positions: an object with vertices needs faces.*estimate_normals"):
                    call(whole)

    def test_what_is_no_mesh_is_named(self):
        document = norma.open("assets/goathead.obj")
        for whole, words in (("a.obj", "str; norma.open"), (pathlib.Path("a.obj"), "PosixPath; norma.open"), (b"ply", "bytes; norma.open"), (document, "Document; give one of its meshes"),
                             ({"positions": self.POINTS}, "dict$"), (None, "NoneType$"), (3.5, "float$"), (iter(self.POINTS), "iterator$")):
            for faces in None, self.TRIANGLES:
                with self.assertRaisesRegex(TypeError, rf"^positions: \(n, 3\) numbers and faces, or a mesh \(of norma.open, trimesh.*\) are needed, not \w*{words}"):
                    norma.vertex_normals(whole, faces)

    def test_grids_of_vtk(self):
        points, named = self.POINTS.astype(np.float64), types.SimpleNamespace
        data, connectivity, offsets = points, np.array([0, 1, 2, 0, 2, 3]), np.array([0, 3, 6])
        cells = named(GetNumberOfCells=lambda: 2, GetConnectivityArray=lambda: connectivity, GetOffsetsArray=lambda: offsets)
        grid = lambda kinds: named(GetPoints=lambda: named(GetData=lambda: data), GetCells=lambda: cells, GetCellTypesArray=lambda: np.uint8(kinds))
        self.same(grid([5, 5]))
        with self.assertRaisesRegex(TypeError, r"^positions: faces .* are needed, but this SimpleNamespace has other cells; .*extract_surface"):
            norma.vertex_normals(grid([5, 10]))

    def test_lists_of_cells_that_do_not_add_up(self):
        for cells, at, count in (([0, 1, 2, -1, 0, 2, 3, -1], 0, 0), ([3, 0, 1, 2, -1, 0, 2, 3], 4, -1), ([-1, 0, 1, 2], 0, -1),
                                 ([3, 0, 1, 2, 4, 0, 2, 3], 4, 4), ([3, 0, 1, 2, 2, 0, 2], 4, 2), ([1, 0, 1, 2], 0, 1), ([2**62, 0, 1, 2], 0, 2**62)):
            with self.assertRaisesRegex(ValueError, rf"^faces\[{at}\] is {count}; the number of a face's corners"):
                norma.vertex_normals(types.SimpleNamespace(points=self.POINTS, faces=np.array(cells)))
        with self.assertRaisesRegex(TypeError, "^faces: integers are needed"):
            norma.vertex_normals(types.SimpleNamespace(points=self.POINTS, faces=np.array([3.0, 0, 1, 2])))

    def test_a_mesh_of_a_file(self):
        mesh = norma.open("assets/goathead.obj").meshes[0]
        self.assertTrue(np.array_equal(norma.vertex_normals(mesh), norma.vertex_normals(mesh.positions, mesh.faces)))

    def test_meshio(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("meshio is not installed")
        from meshio._mesh import topological_dimension
        for type_, dimension in topological_dimension.items():  # every type that meshio knows
            if type_ not in ("triangle", "quad", "polygon"):
                whole = types.SimpleNamespace(points=self.POINTS, cells=[types.SimpleNamespace(type=type_, data=[[0, 1, 2, 3]]), *meshio.Mesh(self.POINTS, [("triangle", self.TRIANGLES)]).cells])
                if dimension != 2:
                    self.same(whole)
                else:
                    self.assertRaisesRegex(TypeError, f"are needed, not {type_}$", norma.vertex_normals, whole)
        self.same(meshio.Mesh(self.POINTS, [("triangle", self.TRIANGLES)]))
        self.same(meshio.Mesh(self.POINTS, [("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 2]])]), [[0, 1, 2, 3], [0, 1, 2]])

    def test_vtk(self):
        try:
            from vtkmodules.util.numpy_support import numpy_to_vtk
            from vtkmodules.vtkCommonCore import vtkPoints
            from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        except ImportError:
            self.skipTest("VTK is not installed")
        for kind in np.float32, np.float64:
            points, cells, whole = vtkPoints(), vtkCellArray(), vtkPolyData()
            points.SetData(numpy_to_vtk(self.POINTS.astype(kind), deep=True))
            for face in [[0, 1, 2, 3], [0, 1, 2]]:
                cells.InsertNextCell(len(face), face)
            whole.SetPoints(points)
            with self.assertRaisesRegex(TypeError, "^positions: an object with vertices needs faces"):
                norma.vertex_normals(whole)
            whole.SetPolys(cells)
            self.same(whole, [[0, 1, 2, 3], [0, 1, 2]])

    def test_open3d(self):
        try:
            import open3d
        except ImportError:
            self.skipTest("Open3D is not installed")
        mesh = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(self.POINTS), open3d.utility.Vector3iVector(self.TRIANGLES))
        self.same(mesh)
        self.same(open3d.t.geometry.TriangleMesh.from_legacy(mesh))
        cloud = open3d.t.geometry.PointCloud(open3d.core.Tensor(self.POINTS))
        for bare in cloud, open3d.t.geometry.PointCloud(), open3d.t.geometry.TriangleMesh():
            with self.assertRaisesRegex(TypeError, "^positions: an object with vertices needs faces.*estimate_normals"):
                norma.vertex_normals(bare)


class Words(unittest.TestCase):
    def test_docstrings_stand_alone(self):
        named = {name: getattr(norma, name) for name in norma.__all__ if callable(getattr(norma, name))}
        named.update({f"Document.{name}": part for name, part in vars(norma.Document).items() if callable(part) and not name.startswith("_")})
        for name, part in named.items():
            self.assertTrue(part.__doc__, name)
            self.assertNotRegex(part.__doc__, r"(?i)\bas for\b", name)


class Refusals(unittest.TestCase):
    def refused(self, kind, words, call, *arguments, **options):
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        self.assertIn(words, str(caught.exception))

    def test_positions_and_faces(self):
        v = norma.vertex_normals
        f = [[0, 1, 2]]
        self.refused(ValueError, "positions: shape (n, 3)", v, SQUARE[:, :2], f)
        self.refused(TypeError, "positions: numbers", v, [["a", "b", "c"]], f)
        self.refused(TypeError, "positions: numbers", v, SQUARE + 1j, f)
        self.refused(TypeError, "positions: numbers", v, SQUARE > 0, f)
        self.refused(ValueError, "positions: an array is needed", v, [[0, 0, 0], [1, 0]], f)
        self.refused(TypeError, "positions: an object with vertices needs faces", v, types.SimpleNamespace(vertices=SQUARE))
        self.refused(ValueError, "faces: shape", v, SQUARE, [[0, 1], [1, 2]])
        self.refused(ValueError, "faces[1]: an array is needed", v, SQUARE, [[0, 1, 2], [[0], [1, 2]]])
        self.refused(IndexError, "faces[0, 2] is 9; an index below 4", v, SQUARE, [[0, 1, 9]])
        self.refused(IndexError, "faces[1, 0] is -1", v, SQUARE, np.array([[0, 1, 2], [-1, 1, 2]], np.int64))
        self.refused(IndexError, "faces[1, 0] is -1", v, SQUARE, np.array([[0, 1, 2], [-1, 1, 2]], np.int32))
        self.refused(IndexError, "faces[0, 1] is 4294967296", v, SQUARE, np.array([[0, 2**32, 2]]))
        self.refused(IndexError, "faces[0][1] is 77", v, SQUARE, ([0, 77, 2], [0, 3]))
        self.refused(TypeError, "faces: integers", v, SQUARE, [[0.0, 1, 2]])
        self.refused(ValueError, "faces: shape", v, SQUARE, np.arange(3))
        self.refused(ValueError, "faces: a tuple is (corners, face_starts)", v, SQUARE, (1, 2, 3))
        self.refused(ValueError, "face", v, SQUARE, ([0, 1, 2], [0, 2]))
        self.refused(ValueError, "face", v, SQUARE, ([0, 1, 2], [0, 2, 1, 3]))
        self.refused(ValueError, "face", v, SQUARE, "soup")
        self.refused(ValueError, "faces: indices or 'soup' are needed, not 'cloud'", v, SQUARE, "cloud")

    def test_points_without_faces(self):
        n, t = np.tile([0, 0, 1.0], (3, 1)), SQUARE[:3, :2]
        cloud = types.SimpleNamespace(points=SQUARE[:3])  # as Open3D's
        for call in (norma.face_normals, norma.vertex_normals, norma.corner_normals, norma.split, norma.orient, norma.Plan,
                     lambda points, *faces: norma.tangents(points, n, t, *faces)):
            for missing in ((), (None,)):
                self.refused(TypeError, "faces: indices are needed; \"soup\" makes a triangle of", call, SQUARE[:3], *missing)
            self.assertIsNotNone(call(SQUARE[:3], "soup"))
            self.refused((TypeError, ValueError), "", call, cloud)
        self.assertEqual(norma.split(SQUARE[:3], "soup").faces.shape, (1, 3))

    def test_an_index_out_of_range_deep_in_a_long_array(self):
        points, faces = grid(60)
        for place, index in ((2999, -1), (2048, 2**32 - 1), (5, 2**32), (6961, 2**40)):
            wrong = faces.astype(np.int64)
            wrong[place, 1] = index
            self.refused(IndexError, f"faces[{place}, 1] is {index}", norma.vertex_normals, points, wrong)
        self.refused(IndexError, "faces[2999, 1] is 3600", norma.vertex_normals, points,
                     np.where(np.arange(len(faces))[:, None] * 3 + np.arange(3) == 8998, 3600, faces.astype(np.int64)))

    def test_options(self):
        v, c = norma.vertex_normals, norma.corner_normals
        f = [[0, 1, 2]]
        self.refused(ValueError, "weight: one of 'angle'", v, SQUARE, f, weight="angel")
        self.refused(ValueError, "weight: one of", v, SQUARE, f, weight=None)
        self.refused(ValueError, "weight: one of", v, SQUARE, f, weight=["angle"])
        self.refused(ValueError, "crease: a smaller number", c, SQUARE, f, crease=10**400)
        self.refused(ValueError, "weld: ", v, SQUARE, f, weld="most")
        self.refused(ValueError, "weld: ", v, SQUARE, f, weld=-1.0)
        self.refused(ValueError, "weld: ", v, SQUARE, f, weld=float("nan"))
        self.refused(ValueError, "threads: ", v, SQUARE, f, threads=-1)
        self.refused(TypeError, "threads: ", v, SQUARE, f, threads=1.5)
        self.refused(ValueError, "fallback: ", v, SQUARE, f, fallback="none")
        self.refused(ValueError, "fallback: ", v, SQUARE, f, fallback=[0, 1])
        self.refused(ValueError, "fallback: ", v, SQUARE, f, fallback=[0, float("nan"), 1])
        self.refused(ValueError, "crease: ", c, SQUARE, f, crease=float("nan"))
        self.refused(ValueError, "crease: ", c, SQUARE, f, crease=181)
        self.refused(TypeError, "crease: ", c, SQUARE, f, crease=None)
        self.refused(ValueError, "non_manifold: ", c, SQUARE, f, non_manifold="soft")
        self.refused(ValueError, "hard_edges: an array is needed", c, SQUARE, f, hard_edges=[[1], [1, 0]])
        self.refused(ValueError, "fallback: an array is needed", v, SQUARE, f, fallback=[[1], [1, 0]])
        self.refused(ValueError, "smoothing_groups: one for each of 1 faces", c, SQUARE, f, smoothing_groups=[1, 2])
        self.refused(ValueError, "hard_edges: one for each of 3 corners", c, SQUARE, f, hard_edges=[1])
        self.refused(ValueError, "mode: ", norma.tangents, SQUARE, SQUARE, SQUARE[:, :2], f, mode="mik")
        self.refused(ValueError, "texcoords: one for each", norma.tangents, SQUARE, SQUARE, SQUARE[:1, :2], f)
        self.refused(IndexError, "texcoord_faces[0, 2] is 7", norma.tangents, SQUARE, SQUARE, SQUARE[:, :2], f,
                     texcoord_faces=[[0, 1, 7]])
        self.refused(ValueError, "per: ", norma.Plan, SQUARE, f, per="face")

    def test_outputs(self):
        v = norma.vertex_normals
        f = [[0, 1, 2]]
        points = SQUARE.astype(np.float32)
        self.refused(TypeError, "out: an array of float32", v, points, f, out=np.empty((4, 3)))
        self.refused(TypeError, "out: an array of float32", v, points, f, out=[1])
        self.refused(ValueError, "out: shape (4, 3)", v, points, f, out=np.empty((5, 3), np.float32))
        readonly = np.empty((4, 3), np.float32)
        readonly.flags.writeable = False
        self.refused(ValueError, "out: the array cannot be written", v, points, f, out=readonly)
        self.refused(ValueError, "out: the array overlaps", v, points, f, out=points)
        self.refused(ValueError, "out: the 3 numbers", v, points, f, out=np.empty((3, 4), np.float32).T)

    def test_skins(self):
        self.refused(IndexError, "joints[0, 1] is 7; an index below 1", norma.Skin([np.eye(4)], [[0, 7]], [[1, 1]]).normals, [[0, 0, 1]])
        self.refused(ValueError, "weights[1]", norma.Skin([np.eye(4)], [[0, 0]] * 2, [[1, 0], [0, np.nan]]).normals, [[0, 0, 1]] * 2)
        self.refused(ValueError, "normals: shape", norma.Skin([np.eye(4)], [[0], [0]], [[1], [1]]).normals, [[0, 0, 1]])
        self.refused(ValueError, "weights: the shape of joints", norma.Skin, [np.eye(4)], [[0]], [[1, 2]])
        self.refused(ValueError, "blend", norma.Skin, [np.eye(4)], [[0]], [[1]], blend="cubic")

    def test_plans_and_matrices(self):
        plan = norma.Plan(SQUARE, [[0, 1, 2]])
        self.refused(ValueError, "positions: the plan has 4, not 3", plan.update, SQUARE[:3])
        self.refused(ValueError, "out: moved needs", plan.update, SQUARE, moved=[1])
        plan.update(SQUARE)
        self.refused(IndexError, "moved[1] is 4", plan.update, SQUARE, moved=[0, 4])
        self.refused(IndexError, "moved[0] is -1", plan.update, SQUARE, moved=[-1])
        self.refused(ValueError, "model: shape", norma.normal_matrix, np.eye(2))
        self.refused(TypeError, "model: numbers", norma.normal_matrix, [["a"] * 3] * 3)
        self.refused(ValueError, "model: the upper 3x3", norma.normal_matrix, np.full((3, 3), np.nan))
        bad = np.stack([np.eye(4)] * 3)
        bad[1, 0, 0] = np.inf
        for kind in (np.float32, np.float64):
            self.refused(ValueError, "models[1]: the upper 3x3", norma.normal_matrices, bad.astype(kind))
        self.refused(ValueError, "matrix: shape", norma.transform_normals, np.eye(4), [[0, 0, 1]])
        self.refused(ValueError, "encoding: one of 'oct8'", norma.encode_normals, [[0, 0, 1]], "oct10")
        self.refused(ValueError, "encoding: one of", norma.encoding_error_deg, 3)
        self.refused(ValueError, "codes[1] is -1", norma.decode_normals, [0, -1])
        self.refused(TypeError, "codes: integers", norma.decode_normals, [0.5])
        self.refused(ValueError, "codes: shape", norma.decode_normals, [[0]])


class Threads(unittest.TestCase):
    def test_the_lock_is_given_up(self):
        points, faces = grid(1200)
        turns, done = [0], threading.Event()

        def count():
            while not done.is_set():
                turns[0] += 1
                time.sleep(0.0005)

        thread = threading.Thread(target=count)
        thread.start()
        before = turns[0]
        start = time.perf_counter()
        norma.corner_normals(points, faces, threads=1)
        took, after = time.perf_counter() - start, turns[0]
        done.set()
        thread.join()
        self.assertGreater(took, 0.01)  # else it shows nothing
        self.assertGreater(after - before, 2)

    @unittest.skipIf(os.name == "nt", "no SIGINT for one's own process here")
    def test_an_interrupt_ends_a_long_call(self):
        points, faces = grid(2000)
        timer = threading.Timer(0.12, os.kill, (os.getpid(), signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt):
            timer.start()  # within: on a busy machine, it is over before the next line
            for _ in range(1000):
                norma.corner_normals(points, faces, threads=1)
        timer.join()
        self.assertEqual(norma.vertex_normals(points, faces).shape, points.shape)


if __name__ == "__main__":
    unittest.main()
