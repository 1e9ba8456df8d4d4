"""The README's code and the examples, run as they stand."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = os.getcwd()


class Examples(unittest.TestCase):
    def run_one(self, name, *arguments):
        script = os.path.join(ROOT, "python", "examples", name)
        done = subprocess.run([sys.executable, script, *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_the_readme(self):
        with open("python/README.md") as file:
            blocks = re.findall(r"```python\n(.*?)```", file.read(), re.S)
        self.assertEqual(len(blocks), 3)
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(os.path.join(ROOT, "assets"), os.path.join(folder, "assets"))
            done = subprocess.run([sys.executable, "-c", "\n".join(blocks)], cwd=folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("1 info", done.stdout)
            self.assertTrue(os.path.getsize(os.path.join(folder, "goathead-normals.obj")))

    def test_the_readme_on_normals_of_an_obj(self):
        import norma_mesh as norma
        with open("python/README.md") as file:
            readme = " ".join(file.read().split())
        document = norma.open("assets/goathead.obj")

        def refuses(**options):
            with self.assertRaises(ValueError) as caught:
                document.meshes[0].normals = norma.corner_normals(document.meshes[0], **options)
            words = str(caught.exception).partition(": ")[2].partition(";")[0]
            self.assertIn(f'"{words}"', readme)

        refuses()
        document.compute(smooth=True)
        lines = [line.split(b" ")[0] for line in document.to_bytes().splitlines()]
        for normals in norma.vertex_normals(document.meshes[0], weight="area"), document.meshes[0].normals[::-1]:
            document.meshes[0].normals = normals
        self.assertEqual([line.split(b" ")[0] for line in document.to_bytes().splitlines()], lines)
        refuses(crease=30)

    def test_a_scan(self):
        with tempfile.TemporaryDirectory() as folder:
            target = os.path.join(folder, "out.obj")
            self.assertIn("faces", self.run_one("scan_normals.py", "assets/goathead.obj", target))
            self.assertTrue(os.path.getsize(target))

    def test_a_part(self):
        self.assertRegex(self.run_one("cad_creases.py", "assets/dodecahedron.obj"), r"20 positions become 60 vertices")

    def test_tangents(self):
        import numpy as np
        import norma_mesh as norma
        with tempfile.TemporaryDirectory() as folder:
            path, target = os.path.join(folder, "square.glb"), os.path.join(folder, "out.glb")
            square = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
            norma.write(path, square, [[0, 1, 2], [0, 2, 3]], normals=[[0, 0, 1]] * 4, texcoords=square[:, :2])
            self.assertIn("1 primitive got tangents; 0 primitives have no normals", self.run_one("gltf_tangents.py", path, target))
            # v runs downwards in glTF: the bitangent of these coordinates points along -y of the picture
            self.assertEqual(norma.open(target).meshes[0].tangents.tolist(), [[1, 0, 0, -1]] * 4)

            norma.write(path, square, [[0, 1, 2], [0, 2, 3]])  # two triangles, one primitive
            self.assertIn("0 primitives got tangents; 1 primitive has no normals", self.run_one("gltf_tangents.py", path, os.path.join(folder, "bare.glb")))

    def test_a_folder_in_pytest(self):
        try:
            import pytest  # noqa: F401
        except ImportError:
            self.skipTest("pytest is not installed")
        with open(os.path.join(ROOT, "assets", "goathead.obj")) as file:
            right = file.read()
        wrong = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n"
        for text, status, words in ((right, 0, "1 passed"), (wrong, 1, "N102")):
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "part.obj"), "w") as file:
                    file.write(text)
                script = os.path.join(ROOT, "python", "examples", "test_assets.py")
                done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", script],
                                      env={**os.environ, "NORMA_ASSETS": folder}, capture_output=True, text=True)
                self.assertEqual(done.returncode, status, done.stdout)
                self.assertIn(words, done.stdout)


if __name__ == "__main__":
    unittest.main()
