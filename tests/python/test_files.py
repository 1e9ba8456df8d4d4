"""Files and rules: what Python says is what the command-line tool says."""
import base64
import glob
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy as np

import norma_mesh as norma

DATA = os.environ.get("NORMA_DATA", "")


def files(limit):
    """The project's own meshes, and those of the data set that are small enough."""
    own = glob.glob("assets/*.obj") + glob.glob("assets/*.stl")
    shared = [
        path
        for ending in ("obj", "ply", "stl", "glb", "gltf")
        for path in glob.glob(os.path.join(DATA, "**", "*." + ending), recursive=True)
        if DATA and os.path.getsize(path) < limit
    ]
    return sorted(own) + sorted(shared)


def tool(*arguments):
    return subprocess.run([sys.executable, "-m", "norma_mesh", *arguments], capture_output=True, text=True)


class Rules(unittest.TestCase):
    def test_the_report_is_that_of_the_tool(self):
        paths = sorted(files(100000))  # as the tool reports them
        self.assertGreater(len(paths), 3)
        expected = json.loads(tool("check", "--format", "json", "--no-config", *paths).stdout)
        totals = dict.fromkeys(expected["summary"], 0)
        for path, theirs in zip(paths, expected["files"]):
            report = json.loads(norma.check(path).to_json())
            worst = max(totals["exit_status"], report["summary"].pop("exit_status"))
            for key, count in report["summary"].items():
                totals[key] += count
            totals["exit_status"] = worst
            ours = report["files"][0]
            for finding in ours["findings"] + theirs["findings"]:
                finding.pop("command", None)
            self.assertEqual(ours, theirs)
        self.assertEqual(totals, expected["summary"])

    def test_every_profile_is_that_of_the_tool(self):
        for profile in "render", "print", "generated":
            theirs = json.loads(tool("check", "--format", "json", "--no-config", "--profile", profile, "assets/spider.stl").stdout)["files"][0]
            ours = json.loads(norma.check("assets/spider.stl", profile=profile).to_json())["files"][0]
            self.assertEqual((ours["profile"], [f["severity"] for f in ours["findings"]]), (profile, [f["severity"] for f in theirs["findings"]]))
            self.assertTrue(all(f["cause"] and f["impact"] for f in ours["findings"]))

    def test_selecting(self):
        all_rules = norma.rules()
        self.assertIn("N501", [rule.id for rule in all_rules])
        goat = norma.check("assets/goathead.obj")
        self.assertTrue(goat.ok)
        self.assertEqual([f.rule for f in goat], ["N104"])
        self.assertEqual(len(norma.check("assets/goathead.obj", ignore="missing-normals")), 0)
        self.assertEqual(len(norma.check("assets/goathead.obj", select=["N3", "N104"])), 1)
        self.assertIn("no problems", str(norma.check("assets/goathead.obj", ignore="N1")))
        with self.assertRaisesRegex(ValueError, "select: no rule is called 'N999'"):
            norma.check("assets/goathead.obj", select="N999")
        with self.assertRaisesRegex(TypeError, "^select: names of rules"):
            norma.check("assets/goathead.obj", select=5)
        with self.assertRaisesRegex(ValueError, "profile"):
            norma.check("assets/goathead.obj", profile="paint")
        for kind, samples in ((ValueError, 10**5000), (ValueError, 0), (TypeError, "ten"), (TypeError, 1.5)):
            with self.assertRaisesRegex(kind, "^samples: "):
                norma.check("assets/goathead.obj", samples=samples)
        self.assertEqual(len(norma.check("assets/goathead.obj", samples=sys.maxsize).findings[0].samples), goat.findings[0].count)

    def test_the_command_of_a_finding_works_when_pasted(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "it's bad.obj")
            with open(path, "w") as file:
                file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n")
            report = norma.check(path)
            self.assertFalse(report.ok)
            fixable = [f for f in report.errors if f.rule == "N102"]
            self.assertEqual(len(fixable), 1)
            shell = os.path.join(os.path.dirname(sys.executable), "norma")
            done = subprocess.run(["sh", "-c", fixable[0].command.replace("norma", shell, 1)], capture_output=True, text=True)
            self.assertIn(done.returncode, (0, 1), done.stderr)
            self.assertEqual([f for f in norma.check(os.path.join(folder, "it's bad.fixed.obj")) if f.rule == "N102"], [])
            page = report._repr_html_()
            self.assertIn("N102", page)

    def test_a_tileset_stands_for_its_tiles(self):
        with tempfile.TemporaryDirectory() as folder:
            path, inner = os.path.join(folder, "tileset.json"), os.path.join(folder, "inner.json")
            data = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2], [0, 0, 2], [0, 0, 2]]).tobytes()
            accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
            tile = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 72, "uri": "data:;base64," + base64.b64encode(data).decode()}],
                    "bufferViews": [{"buffer": 0, "byteLength": 72}], "accessors": [accessor, {**accessor, "byteOffset": 36, "min": [0, 0, 2], "max": [0, 0, 2]}],
                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}]}
            for name in ("a.gltf", "b c.gltf"):
                with open(os.path.join(folder, name), "w") as file:
                    json.dump(tile, file)
            tiles = [{"content": {"uri": uri}, "geometricError": 0} for uri in ("b%20c.gltf", "inner.json", "b%20c.gltf")]
            for name, root in ((path, {"geometricError": 1, "children": tiles}), (inner, {"geometricError": 0, "content": {"uri": "a.gltf"}})):
                with open(name, "w") as file:
                    json.dump({"asset": {"version": "1.1"}, "geometricError": 1, "root": root}, file)
            report, expected = norma.check(path), json.loads(tool("check", path, "--json", "--no-config").stdout)["files"]
            self.assertEqual(sorted(part.path for part in report.files), sorted(file["path"] for file in expected))
            self.assertEqual(len(report.findings), sum(len(file["findings"]) for file in expected))
            self.assertGreater(len(report.findings), 0)
            self.assertEqual(norma.check([path]).findings, report.findings)
            os.remove(os.path.join(folder, "a.gltf"))
            report, expected = norma.check(path), json.loads(tool("check", path, "--json", "--no-config").stdout)["files"]
            seen = [(part.path, part.status, [f.rule for f in part.findings]) for part in report.files]
            self.assertEqual(sorted(seen), sorted((file["path"], file["status"], [f["rule"] for f in file["findings"]]) for file in expected))
            self.assertIn("N001", [f.rule for f in report.findings])
            with self.assertRaisesRegex(norma.FileError, "a tileset is no mesh"):
                norma.open(path)
            with open(inner, "w") as file:
                file.write("{}")
            with self.assertRaisesRegex(norma.FileError, "inner.json"):
                norma.check(path)

    def test_a_list_of_anything_is_one_report(self):
        path, points, faces = "assets/spider.stl", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
        with open(path, "rb") as file:
            data = file.read()
        written = io.BytesIO()
        norma.write(written, points, faces, normals=[[0, 0, 2]] * 3, format="glb")
        glb, document = written.getvalue(), norma.open("assets/goathead.obj")
        mesh = document.meshes[0]
        report = norma.check([path, glb, norma.open(glb), document, mesh])
        self.assertEqual([file.path for file in report.files], [path, "bytes 2", "bytes 3", "assets/goathead.obj", "arrays 5"])
        singly = [norma.check(each) for each in (path, glb, norma.open(glb), document, mesh)]
        self.assertEqual([[f.message for f in file] for file in report.files], [[f.message for f in one] for one in singly])
        self.assertTrue(all(f.path == file.path for file in report.files for f in file))
        self.assertEqual((report.path, norma.check([path]).path, norma.check([glb]).path), ("5 inputs", "1 path", "1 input"))
        for others in ([data], (data,), {data}, {"a": data}.values(), (each for each in [data])):
            self.assertEqual([f.message for f in norma.check(others, format="stl")], [f.message for f in norma.check(path)])
        for each in (points, np.array(points)):
            self.assertEqual(norma.check((each, faces)), norma.check(points, faces))
            self.assertEqual(norma.check((each, "soup", np.ones((3, 3)))), norma.check(points, "soup", normals=np.ones((3, 3))))
        for kind, words, wrong in ((ValueError, "^path: nothing was given to check", []), (ValueError, "^path: nothing was given", iter(())),
                                   (TypeError, r"^path\[1\]: a path, bytes, a document or a mesh is needed, not float", [path, 3.5]),
                                   (TypeError, r"^path\[0\]: .* not NoneType", [None]), (ValueError, "^format: bytes 1 that begin with", [b"v 0 0 0"]),
                                   (TypeError, "^faces: indices are needed", points)):
            with self.assertRaisesRegex(kind, words):
                norma.check(wrong)
        with self.assertRaisesRegex(TypeError, "^normals: only for positions"):
            norma.check([path], normals=points)

    def test_files_that_cannot_be_read(self):
        with self.assertRaises(FileNotFoundError):
            norma.check("no such file.obj")
        with self.assertRaises(FileNotFoundError):
            norma.open("no such file.obj")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "broken.ply")
            with open(path, "w") as file:
                file.write("ply\nformat ascii 1.0\nelement vertex 2\n")
            report = norma.check(path)
            self.assertEqual((report.status, [f.rule for f in report.errors], report.ok), ("unreadable", ["N001"], False))
            with self.assertRaises(norma.FileError):
                norma.open(path)
        with self.assertRaises(TypeError):
            norma.check(3.5)
        with self.assertRaises(ValueError):
            norma.check("a\0b.obj")


class Documents(unittest.TestCase):
    def test_computing_writes_what_the_tool_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            for path in files(20000):
                ending = os.path.splitext(path)[1]
                theirs, ours = os.path.join(folder, "theirs" + ending), os.path.join(folder, "ours" + ending)
                for leftover in glob.glob(os.path.join(folder, "*")):
                    (shutil.rmtree if os.path.isdir(leftover) else os.remove)(leftover)  # folders of images
                if ending == ".gltf":
                    continue  # its buffers are named after the output
                done = tool("compute", path, "-o", theirs)
                try:
                    document = norma.open(path)
                    document.compute()
                    document.save(ours)
                except (norma.FileError, ValueError):
                    self.assertNotEqual(done.returncode, 0, path)
                    continue
                if done.returncode != 0:
                    continue  # the tool refuses more: files without a surface
                with open(theirs, "rb") as a, open(ours, "rb") as b:
                    self.assertEqual(a.read(), b.read(), path)

    def test_meshes_are_arrays(self):
        goat = norma.open("assets/goathead.obj")
        self.assertEqual((goat.format, goat.mesh_count), ("obj", 1))
        mesh = goat.meshes[0]
        self.assertEqual(mesh.positions.shape[1], 3)
        self.assertEqual((mesh.stored, mesh.normals), ("none", None))
        normals = norma.corner_normals(mesh.positions, mesh.faces)
        summary = goat.compute()
        self.assertTrue(summary.changed)
        self.assertEqual(summary.shading, "crease")
        after = goat.meshes[0]
        stored = after.normals[after.normal_faces]
        self.assertEqual(stored.shape, normals.shape)
        box = norma.open("assets/box-rotated.obj")
        normals = norma.corner_normals(box.meshes[0].positions, box.meshes[0].faces, crease=30)
        self.assertEqual(box.compute(crease=30).crease, 30.0)
        after = box.meshes[0]
        self.assertLess(np.abs(after.normals[after.normal_faces] - normals).max(), 1e-5)

    def test_a_matrix_that_flattens_is_warned_of_as_by_the_tool(self):
        flat, thin = np.diag([1.0, 1, 0]), np.diag([1.0, 1, 1e-9])
        with tempfile.TemporaryDirectory() as folder:
            glb = os.path.join(folder, "a.glb")
            norma.write(glb, np.eye(3), [[0, 1, 2]], normals=np.ones((3, 3)))
            for path, matrix, bake in (("assets/spider.stl", flat, False), ("assets/spider.stl", thin, False), ("assets/spider.stl", np.zeros((3, 3)), False),
                                       ("assets/spider.stl", np.diag([1.0, 0, 0]), False), (glb, flat, False), (glb, flat, True)):
                whole = np.eye(4)
                whole[:3, :3] = matrix
                out = os.path.join(folder, "out" + os.path.splitext(path)[1])
                said = tool("transform", path, "-o", out, "--matrix", " ".join(map(str, whole.ravel())), *["--bake"] * bake).stdout
                with self.assertWarns(UserWarning) as caught:
                    norma.open(path).transform(matrix, bake=bake)
                words = str(caught.warning).replace("bake=True", "--bake")
                self.assertRegex(words, "^matrix: singular; .*flat")
                self.assertIn(words, said.replace(", 1 node baked", ""))
                self.assertEqual(caught.filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            norma.open("assets/spider.stl").transform(np.diag([1.0, -1, 0.1]))

    def test_saving_keeps_the_source(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.obj")
            with open("assets/goathead.obj", "rb") as source, open(path, "wb") as target:
                target.write(source.read())
            document = norma.open(path)
            document.compute(smooth=True)
            with self.assertRaisesRegex(ValueError, "is the input itself; give another name, or in_place=True$"):
                document.save(path)
            document.save(path, in_place=True)
            self.assertEqual(norma.open(path).meshes[0].stored, "corner")
        with self.assertRaisesRegex(ValueError, "only one of"):
            norma.open("assets/goathead.obj").compute(smooth=True, crease=3)

    def test_fixing_writes_what_the_tool_writes(self):
        changed = 0
        with tempfile.TemporaryDirectory() as folder:
            for path in files(20000):
                ending = os.path.splitext(path)[1]
                if ending == ".gltf":
                    continue  # its buffers are named after the output
                theirs, ours = os.path.join(folder, "theirs" + ending), os.path.join(folder, "ours" + ending)
                if tool("check", "--no-config", "--fix-unsafe", path, "-o", theirs).returncode not in (0, 1):
                    continue
                document = norma.open(path)
                changed += document.fix(unsafe=True).changed
                document.save(ours)
                with open(theirs, "rb") as a, open(ours, "rb") as b:
                    self.assertEqual(a.read(), b.read(), path)
        self.assertGreater(changed, 0)

    def test_fixing_selected_rules(self):
        goat = norma.open("assets/goathead.obj")
        self.assertFalse(goat.fix(unsafe=True, ignore="N104").changed)
        self.assertTrue(goat.fix(unsafe=True, select=["missing-normals"]).changed)
        self.assertEqual(goat.meshes[0].stored, "corner")
        with self.assertRaisesRegex(ValueError, "select: no rule is called 'N999'"):
            goat.fix(select="N999")

    def test_the_module_is_the_tool(self):
        self.assertIn(norma.__version__, tool("--version").stdout)
        self.assertEqual(tool("check", "assets/goathead.obj").returncode, 0)
        self.assertEqual(tool("chekc").returncode, 2)


if __name__ == "__main__":
    unittest.main()
