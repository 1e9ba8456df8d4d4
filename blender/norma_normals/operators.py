"""What the buttons do."""
from __future__ import annotations

from typing import Any, Dict, List, Tuple

import bpy
import numpy as np

from . import norma_mesh as norma
from . import exchange, state
from .findings import Row, check, rows_of_file, verdict
from .fixing import PLACED, Change, fix
from .surface import Surface
from .weighted import WEIGHTS, corner_normals


def _has_selected(operator: Any, context: Any) -> bool:
    """Whether a mesh is selected; else the button's tooltip says what to do."""
    if exchange.selected_meshes(context):
        return True
    operator.poll_message_set("Select a mesh object first")
    return False


def _surfaces(context: Any, objects: List[Any], tangents: bool) -> List[Surface]:
    depsgraph = context.evaluated_depsgraph_get()
    found = [exchange.read_object(obj, depsgraph, tangents) for obj in objects]
    return [surface for surface in found if len(surface.triangles)]


def _check(context: Any, objects: List[Any]) -> List[Row]:
    settings = state.settings(context)
    rows = check(_surfaces(context, objects, settings.tangents), settings.profile, settings.infos)
    count = len(objects)
    state.show(context, rows, verdict(rows, f"{count} object{'' if count == 1 else 's'}"))
    return rows


class NORMA_OT_check(bpy.types.Operator):
    """Check the normals of the selected objects as they would be exported"""

    bl_idname = "norma.check"
    bl_label = "Check Selected"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return _has_selected(cls, context)

    def execute(self, context: Any) -> Any:
        try:
            _check(context, exchange.selected_meshes(context))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, state.settings(context).verdict)
        return {"FINISHED"}


class NORMA_OT_check_file(bpy.types.Operator):
    """Check a glTF, OBJ, PLY or STL file that lies on the disk"""

    bl_idname = "norma.check_file"
    bl_label = "Check File"
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.glb;*.gltf;*.obj;*.ply;*.stl", options={"HIDDEN"})

    def invoke(self, context: Any, event: Any) -> Any:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> Any:
        path = bpy.path.abspath(self.filepath)
        try:
            rows = rows_of_file(path)
        except OSError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        state.show(context, rows, verdict(rows, bpy.path.basename(path)))
        self.report({"INFO"}, state.settings(context).verdict)
        return {"FINISHED"}


class NORMA_OT_show_finding(bpy.types.Operator):
    """Select the faces of a finding and frame them"""

    bl_idname = "norma.show_finding"
    bl_label = "Show Finding"
    bl_options = {"REGISTER", "UNDO"}
    index: bpy.props.IntProperty(default=-1)

    def execute(self, context: Any) -> Any:
        if not 0 <= self.index < len(state.rows):
            return {"CANCELLED"}
        row = state.rows[self.index]
        obj = context.view_layer.objects.get(row.object)
        if obj is None:
            self.report({"INFO"}, row.message)
            return {"CANCELLED"}
        _only(context, obj)
        if len(row.faces) and _select_faces(obj, row.faces):
            bpy.ops.object.mode_set(mode="EDIT")
            context.tool_settings.mesh_select_mode = (False, False, True)
        _frame(context)
        return {"FINISHED"}


def _only(context: Any, obj: Any) -> None:
    """Object mode, with this object selected and active."""
    if context.object is not None and context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def _select_faces(obj: Any, faces: np.ndarray) -> bool:
    """Selects these faces alone; not where modifiers made the faces that were checked."""
    mesh = obj.data
    if obj.type != "MESH" or any(modifier.show_viewport for modifier in obj.modifiers) or faces[-1] >= len(mesh.polygons):
        return False
    chosen = np.zeros(len(mesh.polygons), bool)
    chosen[faces] = True
    vertices = {v for i in faces.tolist() for v in mesh.polygons[i].vertices}
    mesh.vertices.foreach_set("select", [v in vertices for v in range(len(mesh.vertices))])
    edges = {key for i in faces.tolist() for key in mesh.polygons[i].edge_keys}
    mesh.edges.foreach_set("select", [edge.key in edges for edge in mesh.edges])
    mesh.polygons.foreach_set("select", chosen)
    return True


def _frame(context: Any) -> None:
    """Frames what is selected in each 3D view of the window."""
    for area in context.screen.areas if context.screen else ():
        region = next((region for region in area.regions if region.type == "WINDOW"), None)
        if area.type != "VIEW_3D" or region is None:
            continue
        with context.temp_override(area=area, region=region):
            if bpy.ops.view3d.view_selected.poll():
                bpy.ops.view3d.view_selected()


class NORMA_OT_fix(bpy.types.Operator):
    """Fix the chosen finding, or all"""

    bl_idname = "norma.fix"
    bl_label = "Fix"
    bl_options = {"REGISTER", "UNDO"}
    index: bpy.props.IntProperty(default=-1, description="Number of the finding; -1: all that can be fixed")

    @classmethod
    def poll(cls, context: Any) -> bool:
        return any(row.fix and row.object for row in state.rows)

    def execute(self, context: Any) -> Any:
        if context.object is not None and context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        wanted = _fixable(context, self.index)
        if not wanted:
            self.report({"INFO"}, "Nothing to fix")
            return {"CANCELLED"}
        objects = [o for o in (context.view_layer.objects.get(n) for n in _checked()) if o is not None and o.type == "MESH"]
        changed, notes = _fix(context, objects, wanted)
        for note in notes:
            self.report({"WARNING"}, note)
        _check(context, objects)
        self.report({"INFO"}, f"{changed} object{'' if changed == 1 else 's'} changed. {state.settings(context).verdict}")
        return {"FINISHED"}


def _checked() -> List[str]:
    """The objects that findings name."""
    return sorted({row.object for row in state.rows if row.object})


def _fixable(context: Any, index: int) -> List[Row]:
    unsafe = state.settings(context).unsafe
    if index >= 0:
        return [row for row in state.rows[index : index + 1] if row.fix and row.object]
    return [row for row in state.rows if row.object and (row.fix == "safe" or (row.fix and unsafe))]


def _fix(context: Any, objects: List[Any], wanted: List[Row]) -> Tuple[int, List[str]]:
    """Fixes these findings; the number of objects that changed, and what could not be done."""
    notes: List[str] = []
    rules = sorted({row.rule for row in wanted if row.rule not in PLACED})
    changed = _fix_meshes(context, objects, wanted, rules, notes) if rules else 0
    for name in sorted({row.object for row in wanted if row.rule in PLACED}):
        changed += _bake(context, context.view_layer.objects[name], notes)
    return changed, notes


def _fix_meshes(context: Any, objects: List[Any], wanted: List[Row], rules: List[str], notes: List[str]) -> int:
    surfaces = _surfaces(context, objects, state.settings(context).tangents)
    unsafe = any(row.fix == "unsafe" for row in wanted)
    changes, left_out = fix(surfaces, unsafe, rules, state.settings(context).profile)
    notes += left_out
    meant = {row.object for row in wanted}
    done: Dict[str, bool] = {}
    for surface, change in zip(surfaces, changes):
        mesh = context.view_layer.objects[surface.name].data
        if surface.name not in meant or change.empty or mesh.name in done:
            continue
        if _refused(surface, notes):
            continue
        exchange.apply_change(mesh, surface, change)
        done[mesh.name] = True
    if not done and not notes:
        notes.append("nothing that Blender stores is changed by this fix")
    return len(done)


def _refused(surface: Surface, notes: List[str]) -> bool:
    if surface.not_editable:
        notes.append(f"{surface.name} is left as it is: {surface.not_editable}")
    return bool(surface.not_editable)


def _bake(context: Any, obj: Any, notes: List[str]) -> int:
    surface = exchange.read_object(obj, context.evaluated_depsgraph_get(), False)
    if _refused(surface, notes):
        return 0
    if obj.data.users > 1:
        obj.data = obj.data.copy()
    turned = norma.transform_normals(norma.normal_matrix(surface.matrix), surface.normals)
    why = exchange.bake_matrix(obj, surface, turned)
    if why:
        notes.append(f"{obj.name} is left as it is: {why}")
    return int(not why)


class NORMA_OT_weighted_normals(bpy.types.Operator):
    """Write weighted normals with creases into the selected objects, as custom split normals"""

    bl_idname = "norma.weighted_normals"
    bl_label = "Weighted Normals"
    bl_options = {"REGISTER", "UNDO"}
    weight: bpy.props.EnumProperty(name="Weight", items=WEIGHTS)
    crease: bpy.props.FloatProperty(name="Crease (°)", description="Edges that bend by more degrees are hard", default=60, min=0, max=180)
    keep_sharp: bpy.props.BoolProperty(name="Keep sharp edges", default=True)
    weld: bpy.props.BoolProperty(name="Across split vertices", default=True)

    @classmethod
    def poll(cls, context: Any) -> bool:
        return _has_selected(cls, context)

    def execute(self, context: Any) -> Any:
        if context.object is not None and context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        objects = exchange.selected_meshes(context)
        why = {obj.data.name: (obj.name, reason) for obj in objects for reason in [exchange.why_not_weighted(obj)] if reason}
        meshes = {obj.data.name: obj.data for obj in objects if obj.data.name not in why}
        left: List[str] = []
        for obj in objects:
            if obj.data.name in why:
                name, reason = why[obj.data.name]
                shared = "" if name == obj.name else f"it shares the mesh of {name}: "
                left.append(f"{obj.name} is left as it is: {shared}{reason}")
        changed = 0
        for name, mesh in meshes.items():
            surface = exchange.read_mesh(mesh, name)
            normals = corner_normals(surface, self.weight, self.crease, self.keep_sharp, "exact" if self.weld else "none")
            changed += exchange.differ(surface.normals, normals)
            exchange.write_corner_normals(mesh, normals)
        for note in left:
            self.report({"WARNING" if meshes else "ERROR"}, note)
        if not meshes:
            return {"CANCELLED"}
        said = f"Normals of {len(meshes)} mesh{'' if len(meshes) == 1 else 'es'} written"
        if changed < len(meshes):
            said += f"; {len(meshes) - changed} had them already" + (" (flat faces stay flat)" if self.keep_sharp else "")
        if left:
            said += f"; {len(left)} object{'' if len(left) == 1 else 's'} left as they are"
        self.report({"INFO"}, said)
        return {"FINISHED"}


class NORMA_OT_clear_findings(bpy.types.Operator):
    """Forget the findings"""

    bl_idname = "norma.clear_findings"
    bl_label = "Clear"

    def execute(self, context: Any) -> Any:
        state.show(context, [], "")
        return {"FINISHED"}


classes = (
    NORMA_OT_check,
    NORMA_OT_check_file,
    NORMA_OT_show_finding,
    NORMA_OT_fix,
    NORMA_OT_weighted_normals,
    NORMA_OT_clear_findings,
)
