"""The add-on in Blender without a window: made scenes and files against the command-line tool.

    blender -b --factory-startup --python tests/blender/test_addon.py -- ADD-ON.zip NORMA [FILE.obj...]
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import bmesh
import bpy
import numpy as np

ZIP, TOOL, *FILES = sys.argv[sys.argv.index("--") + 1 :]
NAME = "norma_normals"
bpy.ops.preferences.addon_install(filepath=os.path.abspath(ZIP), overwrite=True)
bpy.ops.preferences.addon_enable(module=NAME)
addon = sys.modules[NAME]
if not hasattr(np, "bool"):
    np.bool = bool  # Blender 3.4's importer of glTF uses the name, which numpy 1.24 dropped
PICTURES = ("N811", "N812")  # looked at when a file is exported
exchange, state = addon.exchange, addon.state
from norma_normals import exports, overlay, weighted  # noqa: E402


def clear():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    for mesh in list(bpy.data.meshes):
        bpy.data.meshes.remove(mesh)


def select(*objects):
    bpy.ops.object.mode_set(mode="OBJECT") if bpy.context.object and bpy.context.object.mode != "OBJECT" else None
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]
    bpy.context.view_layer.update()


def material(obj, double_sided=False, normal_map=False):
    made = bpy.data.materials.new("m")
    made.use_backface_culling = not double_sided
    if normal_map:
        made.use_nodes = True
        nodes, links = made.node_tree.nodes, made.node_tree.links
        turn, picture = nodes.new("ShaderNodeNormalMap"), nodes.new("ShaderNodeTexImage")
        picture.image = bpy.data.images.new("flat", 4, 4)
        picture.image.generated_color = (128 / 255, 128 / 255, 1, 1)
        links.new(picture.outputs["Color"], turn.inputs["Color"])
        links.new(turn.outputs["Normal"], nodes["Principled BSDF"].inputs["Normal"])
    obj.data.materials.append(made)
    return made


def sphere(smooth=True, scale=(1, 1, 1), **options):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16, **options)
    obj = bpy.context.object
    obj.scale = scale
    obj.data.polygons.foreach_set("use_smooth", [smooth] * len(obj.data.polygons))
    material(obj)
    return obj


def cube(scale=(1, 1, 1), **options):
    bpy.ops.mesh.primitive_cube_add(**options)
    bpy.context.object.scale = scale
    material(bpy.context.object)
    return bpy.context.object


def turn_faces(obj, faces):
    bm = bmesh.new()
    bm.from_mesh(obj.data)
    bm.faces.ensure_lookup_table()
    bmesh.ops.reverse_faces(bm, faces=[bm.faces[i] for i in faces])
    bm.to_mesh(obj.data)
    bm.free()


def volume(obj):
    bm = bmesh.new()
    bm.from_mesh(obj.data)
    found = bm.calc_volume(signed=True)
    bm.free()
    return found


def found(*objects, infos=True):
    """(rule, severity, object, count) of what the panel's button finds."""
    select(*objects)
    bpy.context.window_manager.norma.infos = infos
    bpy.ops.norma.check()
    return [(row.rule, row.severity, row.object, row.count) for row in state.rows]


def rules(rows):
    return {row[0] for row in rows}


def angles(a, b):
    """Between unit rows, exact for small angles too."""
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))


def write_obj(path, mesh):
    """Every number as it is: 9 digits hold a float."""
    with open(path, "w") as file:
        for vertex in mesh.vertices:
            file.write("v %.9g %.9g %.9g\n" % tuple(vertex.co))
        for face in mesh.polygons:
            file.write("f " + " ".join(str(v + 1) for v in face.vertices) + "\n")


def tool_normals(mesh, weight, crease):
    """(corners, 3): what `norma compute` writes for the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = os.path.join(folder, "in.obj"), os.path.join(folder, "out.obj")
        write_obj(source, mesh)
        subprocess.run([TOOL, "compute", source, "-o", target, "--weight", weight, "--crease", str(crease), "--quiet"], check=True)
        with open(target) as file:
            lines = [line.split() for line in file]
    normals = np.array([[float(x) for x in line[1:]] for line in lines if line and line[0] == "vn"])
    corners = [int(corner.split("/")[2]) - 1 for line in lines if line and line[0] == "f" for corner in line[1:]]
    return normals[corners]


def tool_findings(path):
    done = subprocess.run([TOOL, "check", "--no-config", "--profile", "render", "--format", "json", path], capture_output=True, text=True)
    report = json.loads(done.stdout)["files"][0]
    return sorted((f["rule"], f["severity"], f["count"]) for f in report["findings"])


def shown(obj):
    """Normals of the corners as they are drawn, with modifiers."""
    bpy.context.view_layer.update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    normals = exchange.corner_normals(mesh)
    evaluated.to_mesh_clear()
    return normals


class Weighted(unittest.TestCase):
    def setUp(self):
        clear()

    def compare(self, obj, weight, crease):
        mesh = obj.data
        theirs = tool_normals(mesh, weight, crease)
        ours = weighted.corner_normals(exchange.read_mesh(mesh, "x"), weight, crease, keep_sharp=False)
        self.assertEqual(ours.shape, theirs.shape)
        self.assertLess(np.abs(ours - theirs).max(), 1e-6, (obj.name, weight, crease))
        select(obj)
        bpy.ops.norma.weighted_normals(weight=weight, crease=crease, keep_sharp=False)
        stored = exchange.corner_normals(mesh)
        self.assertTrue(mesh.has_custom_normals)
        own = mesh.copy()  # Blender's own normals, which the stored ones are relative to
        own.normals_split_custom_set([(0, 0, 0)] * len(own.loops))
        far = angles(exchange.corner_normals(own), ours)
        self.assertTrue((angles(stored, ours) <= exchange.storage_bound(far)).all(), (obj.name, weight, crease))
        return float(angles(stored, ours).max())

    def test_made_meshes_by_all_weights_and_creases(self):
        worst = 0
        makers = {
            "cube": lambda: bpy.ops.mesh.primitive_cube_add(),
            "torus": lambda: bpy.ops.mesh.primitive_torus_add(major_segments=20, minor_segments=9),
            "monkey": lambda: bpy.ops.mesh.primitive_monkey_add(),
            "cone": lambda: bpy.ops.mesh.primitive_cone_add(vertices=17),
        }
        for make in makers.values():
            make()
            for weight in [item[0] for item in weighted.WEIGHTS]:
                for crease in (0, 30, 60, 180):
                    worst = max(worst, self.compare(bpy.context.object, weight, crease))
        print(f"largest angle by storing: {worst:.2e} rad")

    def test_files_of_the_data_set(self):
        if not FILES:
            self.skipTest("no files are given")
        for path in [path for path in FILES if path.endswith(".obj")]:
            clear()
            bpy.ops.wm.obj_import(filepath=path)
            meshes = [obj for obj in bpy.context.selected_objects if obj.type == "MESH" and len(obj.data.polygons)]
            self.assertTrue(meshes, path)
            for obj in meshes[:3]:
                self.compare(obj, "angle", 60)
                self.compare(obj, "area", 30)

    def test_sharp_edges_and_flat_faces_stay_hard(self):
        obj = sphere()
        bpy.ops.norma.weighted_normals(weight="angle", crease=180)
        smooth = exchange.corner_normals(obj.data)
        around = len(np.unique(smooth.round(3), axis=0))
        obj.data.polygons[100].use_smooth = False
        bpy.ops.norma.weighted_normals(weight="angle", crease=180)
        kept = exchange.corner_normals(obj.data)
        face = obj.data.polygons[100]
        loops = list(face.loop_indices)
        self.assertLess(angles(kept[loops], np.array([face.normal] * len(loops))).max(), 2e-3)
        self.assertGreater(len(np.unique(kept.round(3), axis=0)), around)

    def test_modifiers_that_make_another_mesh_are_named(self):
        """Never a success that changes nothing: what is drawn is not the mesh that normals are written into."""
        clear()
        plain, bevelled, linked = cube(), cube(location=(3, 0, 0)), cube(location=(6, 0, 0))
        bevelled.modifiers.new("Rounding", "BEVEL")
        linked.modifiers.new("Bend", "SIMPLE_DEFORM")
        select(bevelled)
        with self.assertRaisesRegex(RuntimeError, "Cube.001 is left as it is: apply Rounding first, or hide it"):
            bpy.ops.norma.weighted_normals(crease=30)
        self.assertFalse(bevelled.data.has_custom_normals)
        select(plain, bevelled, linked)
        before = shown(linked)
        self.assertEqual(bpy.ops.norma.weighted_normals(crease=180, keep_sharp=False), {"FINISHED"})
        self.assertTrue(plain.data.has_custom_normals)
        self.assertFalse(bevelled.data.has_custom_normals)
        self.assertGreater(angles(shown(linked), before).min(), 0.3)  # flat before, smooth now, through the deforming modifier
        bevelled.modifiers["Rounding"].show_viewport = False
        select(bevelled)
        self.assertEqual(bpy.ops.norma.weighted_normals(crease=180), {"FINISHED"})

    def test_nothing_is_selected(self):
        clear()
        for operator in (bpy.ops.norma.check, bpy.ops.norma.weighted_normals):
            with self.assertRaisesRegex(RuntimeError, "Select a mesh object first"):
                operator()

    def test_undo(self):
        name = cube().name
        bpy.ops.ed.undo_push(message="a cube")
        bpy.ops.norma.weighted_normals("EXEC_DEFAULT", True, weight="angle", crease=180)
        self.assertTrue(bpy.context.object.data.has_custom_normals)
        bpy.ops.ed.undo()
        self.assertFalse(bpy.data.objects[name].data.has_custom_normals)


class Checks(unittest.TestCase):
    def setUp(self):
        clear()

    def test_a_clean_sphere(self):
        self.assertEqual(found(sphere(), infos=False), [])
        self.assertIn("No problems found", bpy.context.window_manager.norma.verdict)

    def test_a_turned_face_is_found_selected_and_fixed(self):
        obj = sphere()
        before = volume(obj)
        turn_faces(obj, [100])
        rows = found(obj, infos=False)
        self.assertIn("N301", rules(rows))
        at = [row[0] for row in rows].index("N301")
        self.assertIn(100, state.rows[at].faces.tolist())
        bpy.context.window_manager.norma.active = at  # a click in the list
        self.assertEqual(bpy.context.object.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual([p.index for p in obj.data.polygons if p.select], state.rows[at].faces.tolist())
        self.assertTrue(any(colour[0] > 0.8 and len(triangles) for colour, triangles in overlay.layers(state.rows, at)))
        bpy.ops.norma.fix(index=-1)
        self.assertEqual(state.rows, [])
        self.assertAlmostEqual(volume(obj), before, 5)

    def test_inside_out(self):
        obj = sphere()
        turn_faces(obj, range(len(obj.data.polygons)))
        self.assertLess(volume(obj), 0)
        self.assertIn("N302", rules(found(obj, infos=False)))
        bpy.ops.norma.fix(index=-1)
        self.assertGreater(volume(obj), 0)
        self.assertEqual(state.rows, [])

    def test_a_fix_is_undone(self):
        obj = sphere()
        name = obj.name
        turn_faces(obj, range(len(obj.data.polygons)))
        found(obj, infos=False)
        bpy.ops.ed.undo_push(message="inside out")
        bpy.ops.norma.fix("EXEC_DEFAULT", True, index=-1)
        self.assertGreater(volume(bpy.data.objects[name]), 0)
        bpy.ops.ed.undo()
        self.assertLess(volume(bpy.data.objects[name]), 0)

    def test_mirrored_scaled_and_sheared_objects(self):
        obj = cube(scale=(-1, 1, 1))
        obj.data.materials[0].use_backface_culling = False
        self.assertIn("N602", rules(found(obj)))
        plain = sphere(scale=(3, 1, 1), location=(5, 0, 0))
        self.assertIn("N601", rules(found(plain)))
        at = [row.rule for row in state.rows].index("N601")
        shape = np.array([plain.matrix_world @ v.co for v in plain.data.vertices])
        bpy.ops.norma.fix(index=at)
        self.assertNotIn("N601", {row.rule for row in state.rows})
        self.assertEqual(tuple(plain.scale), (1, 1, 1))
        moved = np.array([plain.matrix_world @ v.co for v in plain.data.vertices])
        self.assertLess(np.abs(moved - shape).max(), 1e-5)

    def test_baking_a_mirror_keeps_custom_normals(self):
        obj = sphere(scale=(-2, 1, 1))
        obj.data.materials[0].use_backface_culling = False
        bpy.ops.norma.weighted_normals(weight="area", crease=180)
        stored = exchange.corner_normals(obj.data)
        keys = [(f.index, obj.data.loops[i].vertex_index) for f in obj.data.polygons for i in f.loop_indices]
        right = dict(zip(keys, stored * [-0.5, 1, 1]))  # the inverse transpose of diag(-2, 1, 1)
        found(obj)
        bpy.ops.norma.fix(index=[row.rule for row in state.rows].index("N602"))
        self.assertGreater(volume(obj), 0)
        after = exchange.corner_normals(obj.data)
        keys = [(f.index, obj.data.loops[i].vertex_index) for f in obj.data.polygons for i in f.loop_indices]
        wanted = np.array([right[key] for key in keys])
        wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
        self.assertLess(angles(after, wanted).max(), 0.02)

    def test_opposed_custom_normals(self):
        obj = sphere()
        exchange.write_corner_normals(obj.data, -exchange.corner_normals(obj.data))
        self.assertTrue(rules(found(obj, infos=False)) & {"N201", "N206"})
        bpy.ops.norma.fix(index=-1)
        self.assertEqual(state.rows, [])
        outward = np.array([v.co for v in obj.data.vertices])[[loop.vertex_index for loop in obj.data.loops]]
        self.assertTrue(((exchange.corner_normals(obj.data) * outward).sum(1) > 0.9).all())

    def test_a_seam_of_texture_coordinates(self):
        obj = sphere()
        normals = exchange.corner_normals(obj.data).copy()
        layer = obj.data.uv_layers.active.data
        for polygon in obj.data.polygons:  # normals tilt on one side of the seam
            us = [layer[i].uv.x for i in polygon.loop_indices]
            if max(us) > 0.99:
                for i in polygon.loop_indices:
                    if layer[i].uv.x > 0.99:
                        normals[i] += (0.3, -0.2, 0.1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        exchange.write_corner_normals(obj.data, normals)
        self.assertIn("N501", rules(found(obj, infos=False)))

    def test_tangents(self):
        obj = sphere()
        obj.data.materials.clear()
        material(obj, normal_map=True)
        self.assertEqual(found(obj, infos=False), [])
        self.assertNotIn("N805", rules(found(obj)))
        bpy.context.window_manager.norma.tangents = False
        self.addCleanup(setattr, bpy.context.window_manager.norma, "tangents", True)
        self.assertIn("N805", rules(found(obj)))

    def test_modifiers_are_seen_and_not_overwritten(self):
        obj = sphere()
        turn_faces(obj, [100])
        modifier = obj.modifiers.new("Array", "ARRAY")
        modifier.count, modifier.relative_offset_displace = 2, (2, 0, 0)
        rows = found(obj, infos=False)
        edges = len(obj.data.polygons[100].vertices)
        self.assertEqual([row[3] for row in rows if row[0] == "N301"], [2 * edges])  # the face is there twice
        before = volume(obj)
        bpy.ops.norma.fix(index=-1)
        self.assertEqual(volume(obj), before)

    def test_duplicate_faces_are_deleted(self):
        obj = sphere()
        bm = bmesh.new()
        bm.from_mesh(obj.data)
        bm.faces.ensure_lookup_table()
        vertices = [bm.verts.new(v.co) for v in bm.faces[100].verts]
        bm.faces.new(vertices)
        bm.to_mesh(obj.data)
        bm.free()
        count = len(obj.data.polygons)
        rows = found(obj, infos=False)
        self.assertIn("N305", rules(rows))
        bpy.ops.norma.fix(index=-1)
        self.assertEqual(len(obj.data.polygons), count - 1)
        self.assertNotIn("N305", {row.rule for row in state.rows})


class Exports(unittest.TestCase):
    def test_what_is_checked_is_what_is_exported(self):
        clear()
        good, bad, turned = sphere(), sphere(location=(4, 0, 0)), cube(location=(8, 0, 0), scale=(1, 2, -3))
        turn_faces(bad, [100, 101, 200])
        exchange.write_corner_normals(turned.data, -exchange.corner_normals(turned.data))
        ours = sorted((rule, severity, count) for rule, severity, _, count in found(good, bad, turned))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.glb")
            bpy.ops.export_scene.gltf(filepath=path, export_tangents=True, export_yup=False)
            self.assertTrue(bpy.app.timers.is_registered(exports.check_pending))
            theirs = tool_findings(path)
            exports.check_pending()
            handled = sorted((row.rule, row.severity, row.count) for row in state.rows)
            exports.unregister()
        self.assertGreater(len(ours), 3)
        self.assertEqual(ours, theirs)
        self.assertEqual(handled, theirs)

    def test_files_of_the_data_set(self):
        """A file is imported, checked in Blender, exported, and checked by the tool: the same findings."""
        files = [path for path in FILES if path.endswith(".glb")]
        if not files:
            self.skipTest("no files are given")
        for path in files:
            clear()
            bpy.ops.import_scene.gltf(filepath=path)
            objects = [obj for obj in bpy.context.view_layer.objects if obj.type == "MESH"]
            for obj in [obj for obj in bpy.context.view_layer.objects if obj.type != "MESH"]:
                obj.select_set(False)
            ours = sorted((rule, severity, count) for rule, severity, _, count in found(*objects) if rule not in PICTURES)
            with tempfile.TemporaryDirectory() as folder:
                target = os.path.join(folder, "scene.glb")
                bpy.ops.export_scene.gltf(
                    filepath=target, export_tangents=True, export_yup=False, use_selection=True, export_animations=False,
                    export_morph=False, export_skins=False)
                theirs = [row for row in tool_findings(target) if row[0] not in PICTURES]
                exports.unregister()
            self.assertEqual(ours, theirs, path)

    def test_checking_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bad.obj")
            with open(path, "w") as file:
                file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n")
            bpy.ops.norma.check_file(filepath=path)
        self.assertIn("N102", {row.rule for row in state.rows})


class Registration(unittest.TestCase):
    def test_off_and_on_again(self):
        bpy.ops.preferences.addon_disable(module=NAME)
        self.assertFalse(hasattr(bpy.types.WindowManager, "norma"))
        bpy.ops.preferences.addon_enable(module=NAME)
        self.assertTrue(bpy.ops.norma.check.idname())


if __name__ == "__main__":
    done = unittest.main(argv=["test_addon", "-v"], exit=False)
    sys.stdout.flush()
    os._exit(0 if done.result.wasSuccessful() else 1)
