"""Blender's meshes into arrays and back. Everything that differs between Blender's versions is here.

Blender stores a custom normal as two 16-bit numbers, relative to the normal that it would compute
itself: an angle from it, and a direction around it. That direction is exact to 0.0142 rad only
(directions closer than that to the reference are taken for it), and two normals of one smooth fan
that differ by less are stored as one. So edges between different normals are marked as sharp
before normals are written, and what is read back differs from what was computed by at most
storage_bound(angle to Blender's own normal).
"""
from __future__ import annotations

import math
from typing import Any, List

import bmesh
import bpy
import numpy as np

from .fixing import Change
from .surface import Material, Surface
from .weighted import hard_edges


def storage_bound(angle: np.ndarray) -> np.ndarray:
    """Radians by which a stored normal may differ from the one that was given, where that is `angle`
    from Blender's own: 2 pi / 32767 for each of the two numbers, what the arc cosine of a float
    loses near 1 (2^-11), and the snap to the reference direction."""
    return 2 * (2 * math.pi / 32767) + 2.0**-11 + math.acos(0.9999) * np.sin(angle)


# ---- reading


def corner_normals(mesh: Any) -> np.ndarray:
    """(corners, 3) float32: what Blender shades with and exports."""
    values = np.empty(len(mesh.loops) * 3, np.float32)
    if hasattr(mesh, "corner_normals"):  # 4.1 and later
        mesh.corner_normals.foreach_get("vector", values)
    else:
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", values)
    return values.reshape(-1, 3)


def _read(collection: Any, name: str, kind: Any, width: int = 1) -> np.ndarray:
    values = np.empty(len(collection) * width, kind)
    collection.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def _starts(mesh: Any) -> np.ndarray:
    starts = np.zeros(len(mesh.polygons) + 1, np.uint32)
    starts[1:] = np.cumsum(_read(mesh.polygons, "loop_total", np.int32))
    if not np.array_equal(starts[:-1], _read(mesh.polygons, "loop_start", np.int32)):
        raise ValueError(f'mesh "{mesh.name}": its corners are out of order; use Mesh > Clean Up > Merge by Distance or save and reload')
    return starts


def _sharp(mesh: Any, edges: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """(corners,) bool: the edge is marked as sharp, or belongs to a flat face."""
    flat = ~_read(mesh.polygons, "use_smooth", bool)
    of_face = np.repeat(flat, np.diff(starts.astype(np.int64)))
    sharp = _read(mesh.edges, "use_edge_sharp", bool)
    np.logical_or.at(sharp, edges, of_face)
    return sharp[edges]


def _material(material: Any) -> Material:
    """As the glTF exporter reads it: back faces are hidden only where that is asked for."""
    if material is None:
        return Material("", True)
    normal_map = material.use_nodes and any(
        node.type == "NORMAL_MAP" and node.outputs[0].is_linked and node.inputs["Color"].is_linked
        for node in material.node_tree.nodes
    )
    return Material(material.name, not material.use_backface_culling, _alpha_mode(material), bool(normal_map))


def _alpha_mode(material: Any) -> str:
    """From 4.2 on the exporter reads it from the nodes; blend_method then says HASHED of every
    material that is not blended, opaque ones too."""
    if not hasattr(material, "surface_render_method"):
        return {"CLIP": "MASK", "HASHED": "BLEND", "BLEND": "BLEND"}.get(material.blend_method, "OPAQUE")
    nodes = material.node_tree.nodes if material.use_nodes else []
    alpha = next((node.inputs["Alpha"] for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    if alpha is None or (not alpha.is_linked and alpha.default_value == 1):
        return "OPAQUE"
    if not alpha.is_linked:
        return "MASK" if alpha.default_value == 0 else "BLEND"
    source = alpha.links[0].from_node
    clips = source.type == "MATH" and source.operation in ("ROUND", "SUBTRACT", "GREATER_THAN", "LESS_THAN")
    return "MASK" if clips else "BLEND"


def _texcoords(mesh: Any, layer: str) -> np.ndarray:
    """(corners, 2), by name: what holds a layer does not survive calls that compute something."""
    found = mesh.uv_layers[layer]
    if hasattr(found, "uv"):  # 3.5 and later
        return _read(found.uv, "vector", np.float32, 2)
    return _read(found.data, "uv", np.float32, 2)


def _tangents(mesh: Any, layer: str) -> Any:
    """(corners, 4) as the exporter writes them, or None where Blender has none: faces of five corners."""
    try:
        mesh.calc_tangents(uvmap=layer)
    except RuntimeError:
        return None
    signs = _read(mesh.loops, "bitangent_sign", np.float32)
    return np.column_stack([_read(mesh.loops, "tangent", np.float32, 3), signs])


def is_linked(block: Any) -> bool:
    """Whether an object or mesh belongs to another file, and so cannot be changed here."""
    return getattr(block, "library", None) is not None


def _not_editable(obj: Any) -> str:
    if is_linked(obj) or is_linked(obj.data):
        return "it is linked from another file"
    shown = [modifier.name for modifier in obj.modifiers if modifier.show_viewport]
    if shown:
        return "its modifiers change the mesh; apply or hide them first: " + ", ".join(shown)
    if obj.data.shape_keys:
        return "it has shape keys"
    return ""


# Modifiers that move vertices and make none: custom normals follow them.
_DEFORMING = frozenset(
    "ARMATURE CAST CORRECTIVE_SMOOTH CURVE DISPLACE HOOK LAPLACIANDEFORM LAPLACIANSMOOTH LATTICE MESH_DEFORM SHRINKWRAP"
    " SIMPLE_DEFORM SMOOTH SURFACE_DEFORM WARP WAVE".split()
)


def why_not_weighted(obj: Any) -> str:
    """Why normals that are written into an object's mesh would not be the ones it is drawn with, or ""."""
    if is_linked(obj.data):
        return "it is linked from another file"
    others = [modifier.name for modifier in obj.modifiers if modifier.show_viewport and modifier.type not in _DEFORMING]
    if others:
        them = "them" if len(others) > 1 else "it"
        return f"apply {', '.join(others)} first, or hide {them}: the mesh that is drawn is another one"
    return ""


def read_mesh(mesh: Any, name: str, tangents: bool = False) -> Surface:
    """The arrays of a mesh; the mesh itself is not changed."""
    starts = _starts(mesh)
    edges = _read(mesh.loops, "edge_index", np.int32)
    mesh.calc_loop_triangles()
    layer = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
    surface = Surface(
        name,
        _read(mesh.vertices, "co", np.float32, 3),
        _read(mesh.loops, "vertex_index", np.int32).astype(np.uint32),
        starts,
        corner_normals(mesh),
        _read(mesh.loop_triangles, "loops", np.int32, 3).astype(np.uint32),
        _read(mesh.loop_triangles, "polygon_index", np.int32).astype(np.uint32),
        None if layer is None else _texcoords(mesh, layer),
        face_materials=_read(mesh.polygons, "material_index", np.int32),
        hard_edges=_sharp(mesh, edges, starts),
        materials=[_material(material) for material in mesh.materials],
    )
    if tangents and layer is not None:
        surface.tangents = _tangents(mesh, layer)
    return surface


def read_object(obj: Any, depsgraph: Any, tangents: bool = True) -> Surface:
    """An object as it would be exported: with its modifiers, at its place."""
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        surface = read_mesh(mesh, obj.name, tangents)
    finally:
        evaluated.to_mesh_clear()
    surface.matrix = np.array(evaluated.matrix_world, np.float64)
    surface.not_editable = _not_editable(obj)
    return surface


# ---- writing


def write_corner_normals(mesh: Any, normals: np.ndarray) -> None:
    """Stores normals as custom split normals: faces become smooth, edges between different normals sharp."""
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    corners = _read(mesh.loops, "vertex_index", np.int32)
    edges = _read(mesh.loops, "edge_index", np.int32)
    sharp = hard_edges(corners, _starts(mesh), edges, normals, len(mesh.edges))
    mesh.edges.foreach_set("use_edge_sharp", sharp)
    if hasattr(mesh, "use_auto_smooth"):  # before 4.1 custom normals are shown only with it
        mesh.use_auto_smooth = True
    _drop_free_normals(mesh)
    mesh.normals_split_custom_set(normals.tolist())
    mesh.update()


def _drop_free_normals(mesh: Any) -> None:
    """From 4.5 on a mesh may have free normals, plain vectors that do not follow when it is deformed.
    They have the name that others need, which cannot be written while they are there."""
    free = mesh.attributes.get("custom_normal") if bpy.app.version >= (4, 5, 0) else None
    if free is not None and free.data_type == "FLOAT_VECTOR":
        mesh.attributes.remove(free)


def apply_change(mesh: Any, surface: Surface, change: Change) -> None:
    """Does to the mesh what a fix did to the surface that was read from it."""
    wanted = _by_corner(surface, surface.normals if change.normals is None else change.normals)
    if change.positions is not None:
        mesh.vertices.foreach_set("co", change.positions.reshape(-1))
    custom = mesh.has_custom_normals
    if change.turned.any() or change.gone.any():
        _edit_faces(mesh, np.flatnonzero(change.turned), np.flatnonzero(change.gone))
    mesh.update()
    left = np.flatnonzero(~change.gone)
    target = _in_order(mesh, left, wanted)
    if custom or differ(corner_normals(mesh), target):
        write_corner_normals(mesh, target)


def _edit_faces(mesh: Any, turned: np.ndarray, gone: np.ndarray) -> None:
    bm = bmesh.new()
    bm.from_mesh(mesh)
    faces = bm.faces[:]
    bmesh.ops.reverse_faces(bm, faces=[faces[i] for i in turned])
    bmesh.ops.delete(bm, geom=[faces[i] for i in gone], context="FACES")
    bm.to_mesh(mesh)
    bm.free()


def _by_corner(surface: Surface, normals: np.ndarray) -> dict:
    """Normals by face and vertex, which stay the same where a face is turned."""
    keys = zip(surface.corner_faces().tolist(), surface.corners.tolist())
    return dict(zip(keys, normals.tolist()))


def _in_order(mesh: Any, left: np.ndarray, wanted: dict) -> np.ndarray:
    """The wanted normals in the order of the mesh's corners; left: the old number of each face."""
    faces = np.repeat(left, _read(mesh.polygons, "loop_total", np.int32)).tolist()
    corners = _read(mesh.loops, "vertex_index", np.int32).tolist()
    return np.array([wanted[key] for key in zip(faces, corners)], np.float32).reshape(-1, 3)


def differ(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(len(a)) and float(np.linalg.norm(a - b, axis=1).max()) > 1e-3


def bake_matrix(obj: Any, surface: Surface, normals: np.ndarray) -> str:
    """Applies rotation, scale, shear and mirror of the object's place to its mesh, and keeps its
    location and what hangs on it; normals: those of the surface, already turned. Why not, or ""."""
    world = obj.matrix_world.copy()
    children = [(child, child.matrix_world.copy()) for child in obj.children]
    place = world.Translation(world.to_translation())
    obj.matrix_world = place
    bpy.context.view_layer.update()
    if not np.allclose(np.array(obj.matrix_world), np.array(place), atol=1e-5):
        obj.matrix_world = world
        return "its parent's scale cannot be undone; clear the parent first (Alt P)"
    linear = world.to_3x3().to_4x4()
    custom = obj.data.has_custom_normals
    obj.data.transform(linear)
    if linear.determinant() < 0:
        obj.data.flip_normals()
    obj.data.update()
    if custom:
        wanted = _by_corner(surface, normals)
        write_corner_normals(obj.data, _in_order(obj.data, np.arange(surface.face_count), wanted))
    bpy.context.view_layer.update()
    for child, matrix in children:
        child.matrix_world = matrix
    return ""


def selected_meshes(context: Any) -> List[Any]:
    """The selected mesh objects, by name."""
    found = [obj for obj in context.selected_objects if obj.type == "MESH"]
    return sorted(found, key=lambda obj: obj.name)
