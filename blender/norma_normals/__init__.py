"""Norma in Blender: checks normals as they would be exported, fixes them, and writes weighted ones.

The add-on needs nothing that is not in its folder: `norma_mesh` is its own copy of the Python package.
"""
from __future__ import annotations

import bpy

from . import exports, operators, overlay, panel, state

bl_info = {
    "name": "Norma",
    "author": "The Norma authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Norma",
    "description": "Checks, fixes and computes surface normals as they would be exported",
    "category": "Mesh",
}

_classes = (*state.classes, *operators.classes, *panel.classes)


def glTF2_post_export_callback(export_settings: dict) -> None:  # the name that the exporter looks for
    exports.after_export(export_settings)


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    """Another file was opened: the findings were about the one before."""
    state.rows.clear()


def register() -> None:
    for cls in _classes:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.norma = bpy.props.PointerProperty(type=state.NormaSettings)
    bpy.app.handlers.load_pre.append(_forget)
    overlay.register()


def unregister() -> None:
    overlay.unregister()
    exports.unregister()
    bpy.app.handlers.load_pre.remove(_forget)
    del bpy.types.WindowManager.norma
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
    state.rows.clear()
