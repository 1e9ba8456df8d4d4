"""The Norma tab of the sidebar in the 3D view."""
from __future__ import annotations

import textwrap
from typing import Any

import bpy

from . import state

_ICONS = {"error": "CANCEL", "warning": "ERROR", "info": "INFO"}


class NORMA_UL_findings(bpy.types.UIList):
    def draw_item(self, context: Any, layout: Any, data: Any, item: Any, icon: Any, active_data: Any, active: Any, index: int = 0) -> None:
        row = layout.row(align=True)
        row.label(text=f"{item.name}  {item.title}", icon=_ICONS.get(item.severity, "DOT"))


class _Tab:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Norma"


class NORMA_PT_check(_Tab, bpy.types.Panel):
    bl_label = "Check Normals"
    bl_idname = "NORMA_PT_check"

    def draw(self, context: Any) -> None:
        layout, own = self.layout, state.settings(context)
        layout.operator("norma.check", icon="VIEWZOOM")
        layout.prop(own, "profile", text="")
        row = layout.row(align=True)
        row.prop(own, "infos", toggle=True)
        row.prop(own, "tangents", toggle=True)
        row.prop(own, "overlay", toggle=True)
        if own.verdict:
            layout.label(text=own.verdict)
        if own.findings:
            layout.template_list("NORMA_UL_findings", "", own, "findings", own, "active", rows=4)
            self._details(own)
        layout.separator()
        layout.prop(own, "check_exports")
        layout.operator("norma.check_file", icon="FILE")

    def _details(self, own: Any) -> None:
        layout = self.layout
        if 0 <= own.active < len(state.rows):
            finding = state.rows[own.active]
            column = layout.column(align=True)
            for line in textwrap.wrap(finding.message, 44):
                column.label(text=line)
            if finding.fix and finding.object:
                layout.operator("norma.fix", text=f"Fix {finding.rule}", icon="TOOL_SETTINGS").index = own.active
        row = layout.row(align=True)
        row.operator("norma.fix", text="Fix All").index = -1
        row.operator("norma.clear_findings", text="", icon="X")
        layout.prop(own, "unsafe")


class NORMA_PT_weighted(_Tab, bpy.types.Panel):
    bl_label = "Weighted Normals"
    bl_idname = "NORMA_PT_weighted"

    def draw(self, context: Any) -> None:
        layout, own = self.layout, state.settings(context)
        layout.use_property_split = True
        for name in ("weight", "crease", "keep_sharp", "weld"):
            layout.prop(own, name)
        button = layout.operator("norma.weighted_normals", icon="NORMALS_VERTEX_FACE")
        for name in ("weight", "crease", "keep_sharp", "weld"):
            setattr(button, name, getattr(own, name))


classes = (NORMA_UL_findings, NORMA_PT_check, NORMA_PT_weighted)
