"""The Norma tab of the sidebar in the 3D view."""
from __future__ import annotations

from typing import Any, Callable, List

import blf
import bpy

from . import exchange, state

_ICONS = {"error": "CANCEL", "warning": "ERROR", "info": "INFO"}


def _fits(context: Any, beside: int = 0) -> Callable[[str], bool]:
    """Whether the panel shows a text whole on one line, by what its letters take; beside: pixels for an icon or a scroll bar."""
    system, style = context.preferences.system, context.preferences.ui_styles[0]
    size = style.widget.points * system.ui_scale
    if bpy.app.version >= (4, 0, 0):
        blf.size(0, size)
    else:
        blf.size(0, size, 72)
    room = max(context.region.width - (48 + beside) * system.ui_scale, 80)
    return lambda text: blf.dimensions(0, text)[0] <= room


def _lines(text: str, fits: Callable[[str], bool]) -> List[str]:
    lines: List[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and fits(longer):
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def _write(layout: Any, context: Any, text: str, icon: str = "NONE") -> None:
    """Text over as many lines as it needs; the icon before the first."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(_lines(text, _fits(context, 0 if icon == "NONE" else 20))):
        column.label(text=line, icon=icon if i == 0 else "NONE" if icon == "NONE" else "BLANK1")


class NORMA_UL_findings(bpy.types.UIList):
    """A finding over two lines: where it is, and what; its tooltip is the whole message."""

    def draw_item(self, context: Any, layout: Any, data: Any, item: Any, icon: Any, active_data: Any, active: Any, index: int = 0) -> None:
        column = layout.column(align=True)
        where = item.object or "whole file"
        whole = f"{item.name}  {where}"
        column.label(text=next(filter(_fits(context, 40), (whole, where)), whole), icon=_ICONS.get(item.severity, "DOT"))
        column.label(text=item.title.replace("-", " "))


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
        if not exchange.selected_meshes(context):
            _write(layout, context, "Nothing is selected: select the mesh objects to be checked.", "INFO")
        layout.prop(own, "profile", text="")
        row = layout.row(align=True)
        row.prop(own, "infos", text="Infos", toggle=True)
        row.prop(own, "tangents", toggle=True)
        row.prop(own, "overlay", toggle=True)
        if own.verdict:
            _write(layout, context, own.verdict)
        if own.findings:
            layout.template_list("NORMA_UL_findings", "", own, "findings", own, "active", item_dyntip_propname="message", rows=4)
            self._details(context, own)
        layout.separator()
        layout.prop(own, "check_exports")
        layout.operator("norma.check_file", icon="FILE")

    def _details(self, context: Any, own: Any) -> None:
        layout = self.layout
        if 0 <= own.active < len(state.rows):
            finding = state.rows[own.active]
            _write(layout, context, f"{finding.object}: {finding.message}" if finding.object else finding.message)
            row = layout.row(align=True)
            row.operator("norma.show_finding", text="Show", icon="VIEWZOOM").index = own.active
            if finding.fix and finding.object:
                row.operator("norma.fix", text=f"Fix {finding.rule}", icon="TOOL_SETTINGS").index = own.active
        row = layout.row(align=True)
        row.operator("norma.fix", text="Fix All").index = -1
        row.operator("norma.clear_findings", text="", icon="X")
        layout.prop(own, "unsafe")


class NORMA_PT_weighted(_Tab, bpy.types.Panel):
    bl_label = "Weighted Normals"
    bl_idname = "NORMA_PT_weighted"

    def draw(self, context: Any) -> None:
        layout, own = self.layout, state.settings(context)
        column = layout.column()
        column.use_property_split = True
        for name in ("weight", "crease"):
            column.prop(own, name)
        for name in ("keep_sharp", "weld"):
            layout.prop(own, name)
        for obj in exchange.selected_meshes(context):
            why = exchange.why_not_weighted(obj)
            if why:
                _write(layout, context, f"{obj.name}: {why}", "ERROR")
        button = layout.operator("norma.weighted_normals", icon="NORMALS_VERTEX_FACE")
        for name in ("weight", "crease", "keep_sharp", "weld"):
            setattr(button, name, getattr(own, name))


classes = (NORMA_UL_findings, NORMA_PT_check, NORMA_PT_weighted)
