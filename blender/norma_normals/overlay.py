"""Colours the faces of findings in the 3D views: errors red, warnings orange, information blue; the
finding that is chosen stands out."""
from __future__ import annotations

from typing import Any, List, Tuple

import bpy
import numpy as np

from . import state
from .findings import Row

COLOURS = {"error": (0.86, 0.16, 0.12), "warning": (0.95, 0.55, 0.08), "info": (0.20, 0.48, 0.86)}
_handle: Any = None


def layers(rows: List[Row], active: int) -> List[Tuple[Tuple[float, float, float, float], np.ndarray]]:
    """(colour, triangles in the world) for each finding with faces, the gravest on top."""
    found = []
    for number, row in reversed(list(enumerate(rows))):
        if len(row.triangles):
            found.append(((*COLOURS[row.severity], 0.7 if number == active else 0.3), _lifted(row.triangles)))
    return found


def _lifted(triangles: np.ndarray) -> np.ndarray:
    """Both sides of the triangles, a thousandth of their own extent off the surface."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    unit = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    offset = (unit * extent * 1e-3)[:, None]
    return np.concatenate([triangles + offset, triangles - offset]).astype(np.float32)


def _draw() -> None:
    own = state.settings(bpy.context)
    if not own.overlay or not state.rows:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    for colour, triangles in layers(state.rows, own.active):
        batch = batch_for_shader(shader, "TRIS", {"pos": triangles.reshape(-1, 3)})
        shader.uniform_float("color", colour)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def register() -> None:
    global _handle
    _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
    _handle = None
