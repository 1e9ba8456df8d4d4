"""The findings of the last check, and the settings of the panel. They live in the window manager:
neither saved with the file nor undone."""
from __future__ import annotations

from typing import Any, List

import bpy

from .findings import Row
from .weighted import WEIGHTS

rows: List[Row] = []


class NormaFinding(bpy.types.PropertyGroup):
    """A line of the list; what it is about is in `rows` at the same number."""

    title: bpy.props.StringProperty()
    object: bpy.props.StringProperty()
    severity: bpy.props.StringProperty()
    message: bpy.props.StringProperty()


def _chosen(settings: Any, context: Any) -> None:
    if 0 <= settings.active < len(rows):
        bpy.ops.norma.show_finding("EXEC_DEFAULT", index=settings.active)


class NormaSettings(bpy.types.PropertyGroup):
    findings: bpy.props.CollectionProperty(type=NormaFinding)
    active: bpy.props.IntProperty(name="Finding", default=-1, update=_chosen)
    verdict: bpy.props.StringProperty()
    profile: bpy.props.EnumProperty(
        name="Profile",
        items=(
            ("render", "Rendering", "Severities for models that are drawn"),
            ("print", "Printing", "Severities for solids that are printed"),
            ("generated", "Acceptance", "Severities for models to be accepted or sent back"),
        ),
    )
    infos: bpy.props.BoolProperty(name="Information", description="List findings that inform, too", default=False)
    tangents: bpy.props.BoolProperty(
        name="Tangents", description="Check the tangents that an export with tangents would write", default=True
    )
    overlay: bpy.props.BoolProperty(name="Overlay", description="Colour the faces of findings in the viewport", default=True)
    check_exports: bpy.props.BoolProperty(
        name="Check exports", description="Check each glTF file that Blender exports", default=True
    )
    unsafe: bpy.props.BoolProperty(
        name="Include unsafe fixes",
        description="Fix All applies also fixes that may change what an artist meant, such as turning faces",
        default=True,
    )
    weight: bpy.props.EnumProperty(name="Weight", items=WEIGHTS)
    crease: bpy.props.FloatProperty(
        name="Crease (°)", description="Edges that bend by more degrees are hard", default=60, min=0, max=180
    )
    keep_sharp: bpy.props.BoolProperty(
        name="Keep sharp edges", description="Edges marked as sharp and edges of flat faces stay hard", default=True
    )
    weld: bpy.props.BoolProperty(
        name="Across split vertices", description="Vertices at the same place share their normals", default=True
    )


def settings(context: Any) -> NormaSettings:
    return context.window_manager.norma


def show(context: Any, found: List[Row], verdict: str) -> None:
    """Puts findings into the list."""
    own = settings(context)
    rows[:] = found
    own.findings.clear()
    for row in found:
        item = own.findings.add()
        item.name = row.rule
        item.title, item.object = row.name, row.object
        item.severity, item.message = row.severity, f"{row.object or 'The whole file'}: {row.message}"
    own.active = -1  # nothing is chosen yet
    own.verdict = verdict


classes = (NormaFinding, NormaSettings)
