"""Checks each glTF file after Blender's exporter has written it.

The exporter calls add-ons just before it writes the file, so the check waits on a timer until the
exporter is done."""
from __future__ import annotations

import os
from typing import Any, Dict, List

import bpy

from . import state
from .findings import rows_of_file, verdict

_pending: List[str] = []


def after_export(export_settings: Dict[str, Any]) -> None:
    """The exporter's hook."""
    path = export_settings.get("gltf_filepath")
    if path and state.settings(bpy.context).check_exports:
        _pending.append(path)
        if not bpy.app.timers.is_registered(check_pending):
            bpy.app.timers.register(check_pending, first_interval=0.1)


def check_pending() -> None:
    """Checks what has been exported, shows the findings, and prints them to the console."""
    for path in _pending:
        if not os.path.exists(path):
            continue
        rows = rows_of_file(path)
        listed = [row for row in rows if row.severity != "info" or state.settings(bpy.context).infos]
        state.show(bpy.context, listed, verdict(rows, os.path.basename(path)))
        for row in listed:
            print(f"norma: {path}: {row.severity} {row.rule} {row.name}: {row.message}")
        print(f"norma: {path}: {verdict(rows)}")
    _pending.clear()


def unregister() -> None:
    _pending.clear()
    if bpy.app.timers.is_registered(check_pending):
        bpy.app.timers.unregister(check_pending)
