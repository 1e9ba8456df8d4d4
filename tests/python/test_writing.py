"""New files from arrays, documents that are changed, bytes in and out, checks of what is in memory. The judges
are meshio (another reader), the tool itself, and the arrays that were given."""
import io
import os
import subprocess
import sys
import tempfile
import types
import unittest

import numpy as np

import norma_mesh as norma

QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64) / 3
TRIANGLES = np.concatenate([QUADS[:, :3], QUADS[:, [0, 2, 3]]])
DART = np.array([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], np.float64)[[1, 2, 3, 0]]
MIXED = [[0, 1, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def tool(*arguments):
    return subprocess.run([sys.executable, "-m", "norma_mesh", *arguments], capture_output=True, text=True)


def written(format, *arguments, **named):
    file = io.BytesIO()
    norma.write(file, *arguments, format=format, **named)
    return norma.open(file.getvalue(), format=format)


def corners_of(faces):
    return np.concatenate([np.asarray(face) for face in faces])


class Writing(unittest.TestCase):
    def test_what_is_written_is_read_back(self):
        rng = np.random.default_rng(1)
        normals = rng.normal(size=(8, 3)).astype(np.float32)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        uv = rng.random((8, 2), np.float32)
        for format, faces in (("obj", TRIANGLES), ("obj", MIXED), ("ply", QUADS), ("ply", MIXED), ("glb", TRIANGLES)):
            for points in (CUBE, CUBE.astype(np.float32)):
                mesh = written(format, points, faces, normals=normals, texcoords=uv).meshes[0]
                held = np.float32 if format == "glb" else points.dtype
                self.assertTrue(np.array_equal(mesh.positions.astype(held), points.astype(held)), format)
                corners = mesh.faces[0] if isinstance(mesh.faces, tuple) else mesh.faces.ravel()
                self.assertTrue(np.array_equal(corners, corners_of(faces)))
                self.assertTrue(np.array_equal(mesh.corner_normals, normals[corners]), format)
                if mesh.texcoords is not None:
                    own = corners if mesh.texcoord_faces is None else mesh.texcoord_faces
                    self.assertTrue(np.array_equal(mesh.texcoords[own], uv[corners]))
                else:
                    self.assertEqual(format, "ply")

    def test_normals_of_corners_split_vertices_only_where_they_differ(self):
        normals = norma.corner_normals(CUBE, TRIANGLES, crease=30)
        for format, vertices in (("glb", 24), ("ply", 24), ("obj", 8)):
            mesh = written(format, CUBE, TRIANGLES, normals=normals).meshes[0]
            self.assertEqual(len(mesh.positions), vertices)
            self.assertTrue(np.array_equal(mesh.corner_normals, normals))
            self.assertTrue(np.allclose(mesh.positions[mesh.faces], CUBE[TRIANGLES], atol=1e-7))

    def test_facets_of_an_stl(self):
        mesh = written("stl", CUBE, TRIANGLES).meshes[0]
        expected = np.cross(CUBE[TRIANGLES[:, 1]] - CUBE[TRIANGLES[:, 0]], CUBE[TRIANGLES[:, 2]] - CUBE[TRIANGLES[:, 0]]) * 9
        self.assertTrue(np.allclose(mesh.normals, expected, atol=1e-6))

    def test_polygons_become_triangles(self):
        corners = norma.corner_normals(CUBE, MIXED, crease=30)
        facets = norma.face_normals(CUBE, MIXED)
        sizes = [len(face) - 2 for face in MIXED]
        for mesh in (written("glb", CUBE, MIXED, normals=corners).meshes[0], written("stl", CUBE, MIXED).meshes[0],
                     written("stl", CUBE, MIXED, normals=facets).meshes[0]):
            self.assertEqual(mesh.faces.shape, (12, 3))
            self.assertTrue(np.allclose(norma.face_normals(mesh.positions, mesh.faces), np.repeat(facets, sizes, 0), atol=1e-6))
            self.assertTrue(np.allclose(mesh.corner_normals.reshape(12, 3, 3), np.repeat(facets, sizes, 0)[:, None], atol=1e-6))
            sides = mesh.positions[mesh.faces].astype(np.float64)
            self.assertAlmostEqual(np.einsum("ij,ij->", sides[:, 0], np.cross(sides[:, 1], sides[:, 2])) / 6, np.linalg.det(np.eye(3) / 3), 6)

    def test_tangents_in_a_glb(self):
        uv = CUBE[:, :2].astype(np.float32)
        corners = norma.corner_normals(CUBE, TRIANGLES, crease=0)
        tangents = norma.tangents(CUBE, corners, uv, TRIANGLES) * np.float32([1, 1, 1, -1])
        mesh = written("glb", CUBE, TRIANGLES, normals=corners, texcoords=uv, tangents=tangents).meshes[0]
        self.assertTrue(np.array_equal(mesh.tangents[mesh.faces.ravel()], tangents))
        document = written("glb", CUBE, TRIANGLES, normals=corners, texcoords=uv)
        self.assertEqual(document.tangents().primitives, 1)
        mesh = document.meshes[0]
        self.assertLess(np.abs(mesh.tangents[mesh.faces.ravel()] - tangents).max(), 1e-6)

    def test_other_readers_and_the_rules_agree(self):
        with tempfile.TemporaryDirectory() as folder:
            for format, faces in (("ply", QUADS), ("stl", TRIANGLES), ("obj", TRIANGLES), ("glb", TRIANGLES)):
                path = os.path.join(folder, "cube." + format)
                normals = None if format == "stl" else norma.corner_normals(CUBE, faces, crease=30)
                norma.write(path, CUBE, faces, normals=normals)
                self.assertEqual([str(f) for f in norma.check(path).findings if f.severity != "info"], [], format)
                try:
                    import meshio
                except ImportError:
                    self.skipTest("meshio is not installed")
                if format == "glb":
                    continue
                if format == "obj":  # meshio wants a vn for each v
                    norma.write(path, CUBE, faces, normals=norma.vertex_normals(CUBE, faces))
                mesh = meshio.read(path)
                self.assertTrue(np.allclose(mesh.points[mesh.cells[0].data], CUBE[faces], atol=1e-6), format)

    def test_refusals_name_the_argument_and_leave_the_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "kept.stl")
            norma.write(path, CUBE, TRIANGLES)
            with open(path, "rb") as file:
                before = file.read()
            for error, words, arguments, named in (
                (ValueError, r"^faces\[1\]: convex polygons are needed", (DART, [[0, 1, 2], [0, 1, 2, 3]]), {}),
                (ValueError, r"^normals: stl holds one for each of 12", (CUBE, TRIANGLES), {"normals": CUBE}),
                (ValueError, r"^texcoords: stl holds none", (CUBE, TRIANGLES), {"texcoords": CUBE[:, :2]}),
                (IndexError, r"^faces: index 9 of corner 2", (CUBE, [[0, 1, 9]]), {}),
                (ValueError, r"^positions\[0\]: finite", (CUBE * np.nan, TRIANGLES), {}),
                (ValueError, r"^normals\[0\]: stl holds floats.* finite", (CUBE, TRIANGLES), {"normals": np.full((12, 3), np.nan)}),
            ):
                with self.assertRaisesRegex(error, words):
                    norma.write(path, *arguments, **named)
            with open(path, "rb") as file:
                self.assertEqual(file.read(), before)
            self.assertEqual(os.listdir(folder), ["kept.stl"])
            with self.assertRaisesRegex(norma.FileError, "nowhere"):
                norma.write(os.path.join(folder, "nowhere", "a.ply"), CUBE, QUADS)
            with self.assertRaisesRegex(ValueError, "^format: one of .* not 'off'"):
                norma.write(os.path.join(folder, "a.off"), CUBE, QUADS)
        with self.assertRaisesRegex(ValueError, r"^tangents: ply holds none"):
            norma.write(io.BytesIO(), CUBE, QUADS, tangents=np.zeros((8, 4)), format="ply")
        with self.assertRaisesRegex(ValueError, r"^normals: one for each of 8 positions or 24 corners is needed, not 5"):
            norma.write(io.BytesIO(), CUBE, QUADS, normals=np.ones((5, 3)), format="ply")


    def test_numbers_beyond_floats_are_refused_where_floats_are_held(self):
        rows, most = CUBE + 1, float(np.finfo(np.float32).max)
        for number in 1e39, -1e300, most * (1 + 2**-24):
            for format, names in (("stl", ("positions", "normals")), ("glb", ("positions", "normals", "texcoords", "tangents")), ("ply", ("normals", "texcoords"))):
                for name in names:
                    given = {"positions": CUBE.copy(), name: np.ones((12 if (format, name) == ("stl", "normals") else 8, {"texcoords": 2, "tangents": 4}.get(name, 3)))}
                    given[name][5, 1] = number
                    with self.assertRaisesRegex(ValueError, rf"^{name}\[5\]: {format} holds floats of 32 bits here"):
                        norma.write(io.BytesIO(), given.pop("positions"), TRIANGLES, format=format, **given)
        rows[5, 1] = 1e39
        for format in "ply", "obj":  # hold doubles
            self.assertEqual(written(format, rows, TRIANGLES).meshes[0].positions[5, 1], 1e39, format)
        rows[5, 1] = most
        for format in "ply", "glb":
            self.assertEqual(written(format, CUBE, TRIANGLES, normals=rows).meshes[0].normals[5, 1], most, format)


class Documents(unittest.TestCase):
    def test_normals_are_set(self):
        sphere = CUBE / np.linalg.norm(CUBE + 1, axis=1, keepdims=True) + 1
        unit = (sphere / np.linalg.norm(sphere, axis=1, keepdims=True)).astype(np.float32)
        for format in "glb", "ply":
            for normals in (None, -unit):
                document = written(format, CUBE, TRIANGLES, normals=normals)
                mesh = document.meshes[0]
                mesh.normals = unit * 7
                self.assertTrue(np.allclose(mesh.normals, unit, atol=1e-6))
                self.assertTrue(np.allclose(norma.open(document.to_bytes()).meshes[0].normals, unit, atol=1e-6))
                corners = norma.corner_normals(CUBE, TRIANGLES, crease=30)
                again = document.set_normals(0, corners)
                self.assertTrue(np.allclose(again.corner_normals, corners, atol=1e-6))
                self.assertEqual(len(again.positions), 24)
                self.assertTrue(np.allclose(again.positions[again.faces], CUBE[TRIANGLES], atol=1e-7))
        facets = np.tile(np.float32([0, 0, -1]), (12, 1))
        stl = written("stl", CUBE, TRIANGLES)
        self.assertTrue(np.array_equal(stl.set_normals(0, facets).normals, facets))
        obj = written("obj", CUBE, TRIANGLES, normals=unit)
        self.assertTrue(np.allclose(obj.set_normals(0, -unit).normals, -unit, atol=1e-6))
        with self.assertRaisesRegex(ValueError, "^normals: corners that share normal"):
            obj.set_normals(0, norma.corner_normals(CUBE, TRIANGLES, crease=30))
        with self.assertRaisesRegex(ValueError, r"^normals\[2\]: a vector with a length"):
            obj.set_normals(0, unit * (np.arange(8) != 2)[:, None])
        with self.assertRaisesRegex(ValueError, "^normals: this obj file stores none yet"):
            written("obj", CUBE, TRIANGLES).set_normals(0, unit)
        with self.assertRaisesRegex(IndexError, "^mesh: 3 is not"):
            obj.set_normals(3, unit)
        with self.assertRaisesRegex(AttributeError, "^positions: of a file's mesh, only normals"):
            obj.meshes[0].positions = CUBE

    def test_normals_that_are_refused_change_nothing(self):
        for format, named in (("glb", {}), ("ply", {}), ("obj", {}), ("glb", {"normals": CUBE + 1}), ("ply", {"normals": CUBE + 1}),
                              ("obj", {"normals": CUBE + 1}), ("stl", {})):
            document = written(format, CUBE, TRIANGLES, **named)
            before = document.to_bytes()
            for wrong in (np.ones((5, 3)), np.zeros((8, 3)), np.full((36, 3), np.nan), np.ones((8, 2)), "no numbers"):
                with self.assertRaisesRegex(ValueError, "^normals"):
                    document.set_normals(0, wrong)
                self.assertEqual(document.to_bytes(), before, format)

    def test_one_primitive_of_a_gltf_without_normals_gets_them(self):
        file = io.BytesIO()
        norma.write(file, CUBE, TRIANGLES, format="glb")
        document = norma.open(file.getvalue(), name="cube.glb")
        document.set_normals(0, CUBE + 1)
        self.assertEqual(document.meshes[0].stored, "vertex")

    def test_transforming_writes_what_the_tool_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            theirs, ours = os.path.join(folder, "theirs.obj"), os.path.join(folder, "ours.obj")
            self.assertEqual(tool("transform", "--scale", "-1,2,3", "assets/goathead.obj", "-o", theirs).returncode, 0)
            goat = norma.open("assets/goathead.obj")
            self.assertTrue(goat.transform(np.diag([-1, 2, 3])).mirrored)
            goat.save(ours)
            with open(theirs, "rb") as a, open(ours, "rb") as b:
                self.assertEqual(a.read(), b.read())
        with self.assertRaisesRegex(ValueError, "matrix"):
            goat.transform(np.eye(5))

    def test_comparing(self):
        flat, smooth = norma.open("assets/goathead.obj"), norma.open("assets/goathead.obj")
        flat.compute(crease=0)
        smooth.compute(smooth=True)
        found = smooth.compare(flat, max_deg=10)
        self.assertEqual(len(found), 1)
        a, b = flat.meshes[0], smooth.meshes[0]
        cosine = (a.corner_normals * b.corner_normals).sum(1) / np.linalg.norm(a.corner_normals, axis=1) / np.linalg.norm(b.corner_normals, axis=1)
        self.assertAlmostEqual(found[0].max_deg, np.degrees(np.arccos(cosine.min())), 2)
        self.assertEqual(smooth.compare(smooth)[0].max_deg, 0)

    def test_a_document_prints_itself(self):
        self.assertRegex(str(written("glb", CUBE, TRIANGLES, normals=CUBE + 1)), r"^bytes: glb, 1 mesh\n    /meshes/0/primitives/0: 8 positions, 12 faces, a normal for each vertex \(float\)$")
        self.assertIn("spider.stl", repr(norma.open("assets/spider.stl")))

    def test_bytes(self):
        with open("assets/goathead.obj", "rb") as file:
            contents = file.read()
        for kind in bytes, bytearray, memoryview:
            document = norma.open(kind(contents), format="obj")
            self.assertEqual(document.to_bytes(), contents)
        with self.assertRaisesRegex(ValueError, "^format: bytes that begin with"):
            norma.open(contents)
        with self.assertRaisesRegex(norma.FileError, "part.ply"):
            norma.open(b"ply\nnothing", name="part.ply")


class Checking(unittest.TestCase):
    def test_arrays(self):
        normals = norma.corner_normals(CUBE, QUADS, crease=30)
        report = norma.check(CUBE, QUADS, normals=normals)
        self.assertEqual(([f.rule for f in report if f.severity != "info"], report.path, report.status), ([], "arrays", "checked"))
        turned = QUADS.copy()
        turned[2] = turned[2, ::-1]
        report = norma.check(CUBE, turned, normals=normals)
        self.assertIn("N301", [f.rule for f in report.errors])
        self.assertEqual({(f.path, f.command) for f in report}, {("arrays", None)})
        file = io.BytesIO()
        norma.write(file, CUBE, turned, normals=normals, format="obj")
        same = norma.check(file.getvalue(), format="obj")
        self.assertEqual([(f.rule, f.severity, f.count) for f in same], [(f.rule, f.severity, f.count) for f in report])
        with self.assertRaisesRegex(IndexError, r"^faces\[0, 2\] is 8"):
            norma.check(CUBE, [[0, 1, 8]])
        with self.assertRaisesRegex(TypeError, "^faces: "):
            norma.check(CUBE)

    def test_bytes_and_documents(self):
        with open("assets/spider.stl", "rb") as file:
            contents = file.read()
        on_disk, in_memory = norma.check("assets/spider.stl"), norma.check(contents, name="assets/spider.stl")
        self.assertEqual([(f.rule, f.count, f.message) for f in on_disk], [(f.rule, f.count, f.message) for f in in_memory])
        self.assertEqual({f.command for f in in_memory}, {None})
        self.assertEqual(norma.check(b"ply\nno", name="x.ply").status, "unreadable")
        goat = norma.open("assets/goathead.obj")
        self.assertEqual([f.rule for f in norma.check(goat)], ["N104"])
        goat.compute()
        self.assertNotIn("N104", [f.rule for f in norma.check(goat)])
        self.assertEqual(norma.check(goat).path, "assets/goathead.obj")

    def test_folders_and_lists(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(norma.FileError, "holds no OBJ"):
                norma.check(folder)
            os.mkdir(os.path.join(folder, "below"))
            for name, faces in (("a.ply", QUADS), (os.path.join("below", "b.stl"), TRIANGLES[:, ::-1])):
                norma.write(os.path.join(folder, name), CUBE, faces)
            with open(os.path.join(folder, "notes.txt"), "w") as file:
                file.write("no mesh")
            report = norma.check(folder)
            self.assertEqual([os.path.relpath(file.path, folder) for file in report.files], ["a.ply", "below/b.stl"])
            self.assertEqual({os.path.basename(f.path) for f in report.errors}, {"b.stl"})
            self.assertIn(folder, str(report).splitlines()[-1])
            theirs = tool("check", "--no-config", "--format", "json", folder)
            import json
            self.assertEqual(json.loads(theirs.stdout)["summary"], json.loads(report.to_json())["summary"])
            listed = norma.check([os.path.join(folder, "a.ply"), folder])
            self.assertEqual(len(listed.files), 3)
            self.assertEqual(len(norma.check("assets/goathead.obj").files), 1)

    def test_pandas(self):
        report = norma.check("assets/goathead.obj")
        try:
            frame = report.to_pandas()
        except ImportError as error:
            self.assertIn("pandas is not installed", str(error))
            stand_in = types.ModuleType("pandas")
            stand_in.DataFrame = lambda rows, columns: dict(zip(columns, zip(*rows)))
            sys.modules["pandas"] = stand_in
            try:
                frame = report.to_pandas()
            finally:
                del sys.modules["pandas"]
        self.assertEqual((list(frame["rule"]), list(frame["path"])), (["N104"], ["assets/goathead.obj"]))


if __name__ == "__main__":
    unittest.main()
