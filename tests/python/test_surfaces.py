"""Nearest points, samples and height maps, judged by closed forms, brute force and numpy's gradient."""
import unittest

import numpy as np

import norma_mesh as norma

QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
TRIANGLES = np.concatenate([QUADS[:, :3], QUADS[:, [0, 2, 3]]])


def brute(points, a, b, c):
    """The distance to each triangle by the best of a fine search over its weights, refined: no closed form shared."""
    u = np.linspace(0, 1, 201)
    s, t = np.meshgrid(u, u)
    s, t = s[s + t <= 1 + 1e-12], t[s + t <= 1 + 1e-12]
    grid = a[:, None] + s[None, :, None] * (b - a)[:, None] + t[None, :, None] * (c - a)[:, None]
    return np.array([np.sqrt(((grid - p) ** 2).sum(-1).min()) for p in points])


class ClosestPoints(unittest.TestCase):
    def test_a_cube(self):
        """A box's signed distance has a closed form; corners, edges and faces are all met."""
        rng = np.random.default_rng(3)
        points = np.concatenate([rng.uniform(-3, 3, (3000, 3)), CUBE * 1.5, CUBE * 0.5, [[2, 2, 0], [-2, 0, 2], [0, 1.25, 0], [0.9, 0.9, 0]]])
        outside = np.linalg.norm(np.maximum(np.abs(points) - 1, 0), axis=1)
        inside = np.minimum(np.max(np.abs(points) - 1, axis=1), 0)
        for positions, faces in ((CUBE, QUADS), (CUBE, TRIANGLES), (CUBE[TRIANGLES.ravel()], "soup")):
            found = norma.closest(points, positions, faces)
            self.assertLess(np.abs(found.distances - np.abs(outside + inside)).max(), 1e-12)
            self.assertTrue(np.array_equal(found.sides, np.where(outside > 0, 1, -1)))
            self.assertLess(np.abs(np.linalg.norm(found.points - points, axis=1) - found.distances).max(), 1e-12)
            corners = found.corners if isinstance(faces, str) else faces.ravel()[found.corners]
            self.assertLess(np.abs((positions[corners] * found.weights[:, :, None]).sum(1) - found.points).max(), 1e-12)

    def test_an_acute_edge(self):
        """Over an edge or corner of a thin wedge the plain face normal errs; the weighted one does not."""
        wedge = np.array([[0, 0, 0], [10, 0.1, -5], [10, 0.1, 5], [10, -0.1, -5], [10, -0.1, 5]])
        faces = norma.orient(wedge, [[0, 1, 2], [0, 4, 3], [0, 3, 1], [0, 2, 4], [1, 3, 4], [1, 4, 2]])
        rng = np.random.default_rng(4)
        points = np.concatenate([rng.normal(0, 0.3, (500, 3)) - [0.5, 0, 0], rng.uniform(-1, 1, (500, 3)) * [0, 3, 6] + [11, 0, 0]])
        outside = (points[:, 0] < 0) | (points[:, 0] > 10)
        found = norma.closest(points[outside], wedge, faces)
        self.assertEqual(set(found.sides.tolist()), {1})
        roof = np.array([[0, 0, -9], [0, 0, 9], [10, 1, -9], [10, 1, 9], [10, -1, -9], [10, -1, 9]])  # sharp along z
        faces = norma.orient(roof, [[0, 1, 3, 2], [0, 4, 5, 1], [2, 3, 5, 4], [0, 2, 4], [1, 5, 3]])
        points = rng.uniform(-1, 1, (500, 3)) * [0, 2, 8] - [0.5, 0, 0]
        self.assertEqual(set(norma.closest(points, roof, faces).sides.tolist()), {1})

    def test_random_triangles_by_brute_force(self):
        rng = np.random.default_rng(5)
        soup, points = rng.normal(size=(60, 3)).astype(np.float32), rng.normal(size=(50, 3))
        found = norma.closest(points, soup, "soup")
        a, b, c = soup.astype(float).reshape(-1, 3, 3).transpose(1, 0, 2)
        near = brute(points, a, b, c)
        self.assertTrue((found.distances <= near + 1e-9).all())
        self.assertLess((near - found.distances).max(), 0.03)  # the pitch of the search

    def test_normals(self):
        points = np.array([[0.3, 0.4, 2], [5, 5, 5]])
        flat = norma.closest(points, CUBE, QUADS, normals=CUBE)
        expected = np.array([0.3, 0.4, 1]) / np.linalg.norm([0.3, 0.4, 1])
        self.assertLess(np.abs(flat.normals[0] - expected).max(), 1e-6)
        self.assertTrue(np.allclose(flat.normals[1], 3**-0.5))
        self.assertTrue(np.array_equal(norma.closest(points[:1], CUBE, QUADS).normals[0], [0, 0, 1]))

    def test_a_surface_in_a_tuple(self):
        points, normals = [[0, 0, 3], [2, 2, 2]], -CUBE
        for whole, apart, options in (((CUBE, QUADS), (CUBE, QUADS), {}), ((CUBE, QUADS, normals), (CUBE, QUADS), {"normals": normals})):
            for a, b in zip(norma.closest(points, whole), norma.closest(points, *apart, **options)):
                self.assertTrue(np.array_equal(a, b))
            for a, b in zip(norma.sample(whole, 9, 2), norma.sample(*apart, 9, 2, **options)):
                self.assertTrue(np.array_equal(a, b))

    def test_nothing_near(self):
        found = norma.closest([[np.nan, 0, 0], [0, 0, 2]], CUBE, QUADS)
        self.assertEqual((found.faces[0], np.isnan(found.distances[0]), found.sides[0]), (-1, True, 0))
        self.assertEqual(found.distances[1], 1)
        empty = norma.closest([[0, 0, 0]], [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
        self.assertEqual((empty.faces.tolist(), empty.sides.tolist()), ([-1], [0]))
        with self.assertRaisesRegex(IndexError, "^faces"):
            norma.closest([[0, 0, 0]], CUBE, [[0, 1, 9]])
        with self.assertRaisesRegex(ValueError, "^points: shape"):
            norma.closest([0, 0, 0], CUBE, QUADS)


class Sampling(unittest.TestCase):
    def test_by_area(self):
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 5], [3, 0, 5], [0, 3, 5], [1, 1, 1]], np.float64)
        faces = [[0, 1, 2], [6, 6, 6], [3, 4, 5]]
        found = norma.sample(points, faces, 20000, seed=11)
        share = (found.faces == 2).mean()
        self.assertLess(abs(share - 0.9), 4 * np.sqrt(0.9 * 0.1 / 20000))
        self.assertNotIn(1, found.faces)
        self.assertTrue(((found.weights >= 0) & (found.weights <= 1)).all())
        big = found.points[found.faces == 2]
        self.assertTrue(np.allclose(big[:, 2], 5, rtol=1e-14) and (big[:, :2].sum(1) <= 3 + 1e-12).all())
        self.assertLess(np.abs(big.mean(0) - [1, 1, 5]).max(), 0.03)  # the centre
        near = (big[:, :2].sum(1) < 1.5).mean()  # a quarter of the triangle
        self.assertLess(abs(near - 0.25), 4 * np.sqrt(0.25 * 0.75 / len(big)))
        again = norma.sample(points, faces, 20000, seed=11)
        self.assertTrue(np.array_equal(again.points, found.points))
        self.assertFalse(np.array_equal(norma.sample(points, faces, 20000, seed=12).points, found.points))

    def test_forms_and_normals(self):
        mesh = norma.open("assets/goathead.obj").meshes[0]
        found = norma.sample(mesh, 500, 3)
        self.assertTrue(np.array_equal(found.points, norma.sample(mesh.positions, mesh.faces, 500, 3).points))
        self.assertLess(norma.closest(found.points, mesh).distances.max(), 1e-5 * np.ptp(mesh.positions, axis=0).max())
        self.assertTrue(np.allclose(np.linalg.norm(found.normals, axis=1), 1, atol=1e-6))
        cube = norma.sample(CUBE, QUADS, 300, 1)
        self.assertLess(np.abs(np.abs(cube.normals).max(1) - 1).max(), 1e-7)
        self.assertLess(np.abs(cube.points[cube.normals > 0.5] - 1).max(), 1e-14)
        with self.assertRaisesRegex(ValueError, r"^faces\[0\]: convex"):
            norma.sample([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], [[3, 0, 1, 2]], 5)
        with self.assertRaisesRegex(ValueError, "^faces: a surface with an area"):
            norma.sample(np.zeros((3, 3)), [[0, 1, 2]], 5)
        with self.assertRaisesRegex(TypeError, "^n: an integer"):
            norma.sample(CUBE, QUADS)


class HeightMaps(unittest.TestCase):
    def test_planes_and_parabolas(self):
        y, x = np.mgrid[0:20, 0:30] * 0.5
        for kind in np.float32, np.float64, np.int32:
            plane = np.array([-2, 4, 1]) / np.sqrt(21)
            normals = norma.heightmap_normals((4 * x - 8 * y).astype(kind), 1.0)  # slopes 2 and -4 a step
            self.assertLess(np.abs(normals - plane).max(), 1e-7)
        normals = norma.heightmap_normals(x * x + 3 * y * y, 0.5)[1:-1, 1:-1].astype(float)
        exact = np.stack([-2 * x, -6 * y, np.ones_like(x)], -1)[1:-1, 1:-1]  # a parabola's central difference is its slope
        self.assertLess(np.abs(normals - exact / np.linalg.norm(exact, axis=-1, keepdims=True)).max(), 1e-7)

    def test_numpys_gradient(self):
        rng = np.random.default_rng(8)
        for shape in (40, 50), (2, 2), (2, 7):
            z = rng.normal(size=shape)
            dy, dx = np.gradient(z, -0.25, 2.0)
            exact = np.stack([-dx, -dy, np.ones(shape)], -1)
            exact /= np.linalg.norm(exact, axis=-1, keepdims=True)
            self.assertLess(np.abs(norma.heightmap_normals(z, (2.0, -0.25)) - exact).max(), 2e-7)  # roundings of floats

    def test_steep_empty_and_missing(self):
        self.assertTrue(np.allclose(norma.heightmap_normals([[0, 1e300], [0, 1e300]])[0, 0], [-1, 0, 0]))
        self.assertEqual(norma.heightmap_normals(np.zeros((0, 5))).shape, (0, 5, 3))
        self.assertEqual(norma.heightmap_normals([[7.0]]).tolist(), [[[0, 0, 1]]])
        z = np.zeros((5, 5))
        z[2, 2] = np.nan
        normals, report = norma.heightmap_normals(z, report=True)
        self.assertEqual((report.non_finite, int((normals[..., 2] == 0).sum())), (4, 4))
        out = np.empty((5, 5, 3), np.float32)
        self.assertTrue(np.shares_memory(norma.heightmap_normals(np.ones((5, 5)), out=out), out))
        for words, arguments in (("^z: shape", (np.zeros(3),)), ("^spacing: finite", (z, 0)), ("^spacing: a number", (z, (1, 2, 3)))):
            with self.assertRaisesRegex(ValueError, words):
                norma.heightmap_normals(*arguments)


if __name__ == "__main__":
    unittest.main()
