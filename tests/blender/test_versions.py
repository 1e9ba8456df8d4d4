"""The calls that differ between Blender's versions, from the zip, with stand-ins for what Blender 3.4 and
later versions have: each stand-in has just the names of its version, and any other is an AttributeError.

    test_versions.py ADD-ON.zip [-v]
"""
import os
import sys
import tempfile
import types
import unittest
import zipfile
from unittest import mock

import numpy as np

ZIP = sys.argv.pop(1)
folder = tempfile.TemporaryDirectory()
with zipfile.ZipFile(ZIP) as archive:
    archive.extractall(folder.name)
package = types.ModuleType("norma_normals")
package.__path__ = [os.path.join(folder.name, "norma_normals")]
bpy, gpu, blf = mock.MagicMock(), mock.MagicMock(), mock.MagicMock()
bpy.types.PropertyGroup = bpy.types.Panel = bpy.types.UIList = object
bpy.app.version = (3, 4, 1)
sys.modules.update(norma_normals=package, bpy=bpy, bmesh=mock.MagicMock(), blf=blf, gpu=gpu, gpu_extras=mock.MagicMock())
sys.modules["gpu_extras.batch"] = mock.MagicMock()
from norma_normals import exchange, overlay, panel  # noqa: E402

NORMALS = np.float32([[0, 0, 1], [0, 1, 0], [1, 0, 0]])


class Collection:
    """What Blender keeps of each element, by name."""

    def __init__(self, count, **values):
        self.count, self.values = count, values

    def __len__(self):
        return self.count

    def foreach_get(self, name, into):
        into[:] = np.asarray(self.values[name]).reshape(-1)

    def foreach_set(self, name, values):
        self.values[name] = np.array(values)


class Mesh:
    """A triangle of either version."""

    def __init__(self):
        self.name = "Triangle"
        self.loops = Collection(3, vertex_index=[0, 1, 2], edge_index=[0, 1, 2])
        self.polygons = Collection(1, loop_start=[0], loop_total=[3], use_smooth=[False])
        self.edges = Collection(3, use_edge_sharp=[False] * 3)
        self.custom = None

    def normals_split_custom_set(self, normals):
        self.custom = normals

    def update(self):
        pass


class Mesh34(Mesh):
    def __init__(self):
        super().__init__()
        self.use_auto_smooth = False

    def calc_normals_split(self):
        self.loops.values["normal"] = NORMALS


class Mesh41(Mesh):
    def __init__(self):
        super().__init__()
        self.corner_normals = Collection(3, vector=NORMALS)


class Mesh45(Mesh41):
    """With free normals, which have the name that others need."""

    def __init__(self, data_type):
        super().__init__()
        self.attributes = {"custom_normal": types.SimpleNamespace(data_type=data_type)}
        self.removed = []
        self.attributes = types.SimpleNamespace(get=self.attributes.get, remove=self.removed.append)


def material(version, method="OPAQUE", value=1.0, source=None):
    links = [types.SimpleNamespace(from_node=source)] if source else []
    alpha = types.SimpleNamespace(is_linked=bool(links), links=links, default_value=value)
    shader = types.SimpleNamespace(type="BSDF_PRINCIPLED", inputs={"Alpha": alpha})
    made = types.SimpleNamespace(
        name="m", use_nodes=True, use_backface_culling=False, blend_method=method, node_tree=types.SimpleNamespace(nodes=[shader])
    )
    if version >= (4, 2):
        made.surface_render_method = "BLENDED" if method == "BLEND" else "DITHERED"
        made.blend_method = "BLEND" if method == "BLEND" else "HASHED"
    return made


class Versions(unittest.TestCase):
    def test_normals_are_read(self):
        for mesh in (Mesh34(), Mesh41()):
            np.testing.assert_array_equal(exchange.corner_normals(mesh), NORMALS)

    def test_normals_are_written(self):
        for mesh in (Mesh34(), Mesh41()):
            exchange.write_corner_normals(mesh, NORMALS)
            self.assertEqual(mesh.custom, NORMALS.tolist())
            self.assertTrue(mesh.polygons.values["use_smooth"].all())
            self.assertEqual(len(mesh.edges.values["use_edge_sharp"]), 3)
            self.assertEqual(getattr(mesh, "use_auto_smooth", None), True if isinstance(mesh, Mesh34) else None)

    def test_free_normals_make_room(self):
        for data_type, count in (("FLOAT_VECTOR", 1), ("INT16_2D", 0)):
            mesh = Mesh45(data_type)
            with mock.patch.object(bpy.app, "version", (4, 5, 0)):
                exchange.write_corner_normals(mesh, NORMALS)
            self.assertEqual(mesh.custom, NORMALS.tolist())
            self.assertEqual(len(mesh.removed), count)
        mesh = Mesh45("FLOAT_VECTOR")  # before 4.5 the name is any attribute's
        with mock.patch.object(bpy.app, "version", (4, 4, 0)):
            exchange.write_corner_normals(mesh, NORMALS)
        self.assertEqual(mesh.removed, [])

    def test_messages_are_whole(self):
        """Each letter 7 pixels wide, an icon 20: no line is wider than the panel, no word is lost."""
        blf.dimensions.side_effect = lambda font, text: (7 * len(text), 11)
        system = types.SimpleNamespace(ui_scale=1)
        style = types.SimpleNamespace(widget=types.SimpleNamespace(points=11))
        text = "neighbouring faces are wound against each other at 12 edges: 6 faces to turn"
        for version in ((3, 4, 1), (4, 2, 0)):
            for width in (160, 220, 400):
                bpy.app.version = version
                context = types.SimpleNamespace(
                    preferences=types.SimpleNamespace(system=system, ui_styles=[style]), region=types.SimpleNamespace(width=width)
                )
                blf.size.reset_mock()
                for icon, room in (("NONE", width - 48), ("INFO", width - 68)):
                    layout = mock.MagicMock()
                    panel._write(layout, context, text, icon)
                    lines = [call.kwargs["text"] for call in layout.column.return_value.label.call_args_list]
                    self.assertEqual(" ".join(lines), text)
                    self.assertLessEqual(max(7 * len(line) for line in lines), room)
                self.assertEqual(len(blf.size.call_args.args), 3 if version < (4, 0, 0) else 2)
        bpy.app.version = (3, 4, 1)

    def test_a_finding_s_object_is_whole(self):
        """The rule's number gives way to a long name."""
        blf.dimensions.side_effect = lambda font, text: (6 * len(text), 11)
        preferences = types.SimpleNamespace(
            system=types.SimpleNamespace(ui_scale=1), ui_styles=[types.SimpleNamespace(widget=types.SimpleNamespace(points=11))]
        )
        context = types.SimpleNamespace(preferences=preferences, region=types.SimpleNamespace(width=229))
        for name, first in (("Chassis", "N301  Chassis"), ("SM_Rock_Large_Weath_01", "SM_Rock_Large_Weath_01"), ("", "N301  whole file")):
            layout = mock.MagicMock()
            item = types.SimpleNamespace(name="N301", object=name, title="inconsistent-winding", severity="error")
            panel.NORMA_UL_findings().draw_item(context, layout, None, item, 0, None, "active", 0)
            labels = [call.kwargs["text"] for call in layout.column.return_value.label.call_args_list]
            self.assertEqual(labels, [first, "inconsistent winding"])

    def test_texture_coordinates_are_read(self):
        expected = np.float32([[0, 0], [1, 0], [1, 1]])
        old = types.SimpleNamespace(data=Collection(3, uv=expected))
        new = types.SimpleNamespace(uv=Collection(3, vector=expected))
        for layer in (old, new):
            mesh = types.SimpleNamespace(uv_layers={"UVMap": layer})
            np.testing.assert_array_equal(exchange._texcoords(mesh, "UVMap"), expected)

    def test_alpha_modes_before_the_nodes_said_so(self):
        for method, mode in (("OPAQUE", "OPAQUE"), ("CLIP", "MASK"), ("HASHED", "BLEND"), ("BLEND", "BLEND")):
            self.assertEqual(exchange._material(material((3, 4), method)).alpha_mode, mode)

    def test_alpha_modes_since_the_nodes_say_so(self):
        node = types.SimpleNamespace
        cases = [
            (material((4, 2)), "OPAQUE"),
            (material((4, 2), "BLEND"), "OPAQUE"),
            (material((4, 2), value=0.5), "BLEND"),
            (material((4, 2), value=0.0), "MASK"),
            (material((4, 2), source=node(type="TEX_IMAGE")), "BLEND"),
            (material((4, 2), source=node(type="MATH", operation="ROUND")), "MASK"),
            (material((4, 2), source=node(type="MATH", operation="MULTIPLY")), "BLEND"),
        ]
        for given, mode in cases:
            self.assertEqual(exchange._material(given).alpha_mode, mode)

    def test_the_overlay_draws_with_the_shader_of_the_version(self):
        overlay.state.rows[:] = [types.SimpleNamespace(triangles=np.zeros((1, 3, 3), np.float32), severity="error")]
        for version, name in (((3, 4, 1), "3D_UNIFORM_COLOR"), ((3, 6, 0), "3D_UNIFORM_COLOR"), ((4, 0, 0), "UNIFORM_COLOR"), ((5, 0, 0), "UNIFORM_COLOR")):
            bpy.app.version = version
            gpu.shader.from_builtin.reset_mock()
            with mock.patch.object(overlay.state, "settings", return_value=types.SimpleNamespace(overlay=True, active=0)):
                overlay._draw()
            gpu.shader.from_builtin.assert_called_once_with(name)


if __name__ == "__main__":
    unittest.main()
