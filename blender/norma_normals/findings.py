"""Findings of the rules, led back from the exported file to objects and faces. Needs no Blender."""
from __future__ import annotations

import os
import re
import tempfile
from dataclasses import dataclass, field
from typing import Any, List, Optional, Tuple

import numpy as np

from . import norma_mesh as norma
from .gltf import glb
from .surface import Primitive, Surface, primitives

SAMPLES = 1000000  # for each finding: all faces are wanted, not ten


@dataclass
class Row:
    """A finding as the list shows it."""

    rule: str
    name: str
    severity: str  # "error", "warning" or "info"
    object: str  # the object's name; "": the whole file
    message: str
    count: int
    fix: str  # "safe", "unsafe" or ""
    faces: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))  # Blender's polygons
    triangles: np.ndarray = field(default_factory=lambda: np.empty((0, 3, 3), np.float32))  # in the world


def exported(surfaces: List[Surface], folder: str) -> Tuple[str, List[List[Primitive]]]:
    """Writes the surfaces into a folder; the path, and the primitives of each surface."""
    parts = [primitives(surface) for surface in surfaces]
    path = os.path.join(folder, "scene.glb")
    with open(path, "wb") as file:
        file.write(glb(surfaces, parts))
    return path, parts


def check(surfaces: List[Surface], profile: str = "render", infos: bool = True) -> List[Row]:
    """What the rules find in the surfaces, the gravest first. Surfaces without faces are left out."""
    surfaces = [surface for surface in surfaces if len(surface.triangles)]
    if not surfaces:
        return []
    with tempfile.TemporaryDirectory() as folder:
        path, parts = exported(surfaces, folder)
        report = norma.check(path, profile=profile, samples=SAMPLES)
    found = [_row(finding, surfaces, parts) for finding in report if infos or finding.severity != "info"]
    return sorted(found, key=lambda row: ("error", "warning", "info").index(row.severity))


def rows_of_file(path: str, profile: str = "auto") -> List[Row]:
    """What the rules find in a file; objects are named as its nodes and meshes are."""
    order = ("error", "warning", "info")
    rows = []
    for finding in norma.check(path, profile=profile):
        named = re.search(r'"([^"]+)"', finding.label)
        rows.append(_plain_row(finding, named.group(1) if named else ""))
    return sorted(rows, key=lambda row: order.index(row.severity))


def _plain_row(finding: Any, name: str) -> Row:
    return Row(finding.rule, finding.name, finding.severity, name, finding.message, finding.count, finding.fix or "")


def _row(finding: Any, surfaces: List[Surface], parts: List[List[Primitive]]) -> Row:
    place = re.match(r"/(meshes|nodes)/(\d+)(?:/primitives/(\d+))?", finding.where)
    if not place:
        return _plain_row(finding, "")
    number = int(place.group(2))
    surface = surfaces[number]
    row = _plain_row(finding, surface.name)
    if place.group(3) is not None:
        triangles = _named_triangles(finding, parts[number][int(place.group(3))])
        row.faces = np.unique(surface.triangle_faces[triangles]).astype(np.int64)
        row.triangles = _triangles_of(surface, row.faces)
    return row


def _named_triangles(finding: Any, part: Primitive) -> np.ndarray:
    """The triangles that samples name, by face, by vertex, or by position alone."""
    chosen = np.zeros(len(part.indices), bool)
    vertices = np.zeros(len(part.positions), bool)
    places: List[Tuple[float, float, float]] = []
    for sample in (*finding.samples, finding.worst):
        if sample.face is not None:
            chosen[sample.face] = True
        elif sample.vertex is not None:
            vertices[sample.vertex] = True
        elif sample.position is not None:
            places.append(sample.position)
    if places:
        rows = np.unique(np.asarray(places, np.float32), axis=0)
        vertices |= (part.positions[:, None] == rows[None]).all(2).any(1) if len(rows) < 64 else _among(part.positions, rows)
    chosen |= vertices[part.indices].any(1)
    return part.triangles[chosen]


def _among(points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    known = {row.tobytes() for row in rows}
    return np.array([point.tobytes() in known for point in np.ascontiguousarray(points, np.float32)], bool)


def _triangles_of(surface: Surface, faces: np.ndarray) -> np.ndarray:
    wanted = np.zeros(surface.face_count, bool)
    wanted[faces] = True
    chosen = surface.triangles[wanted[surface.triangle_faces]]
    return surface.world_positions()[surface.corners[chosen]].astype(np.float32)


def verdict(rows: List[Row], what: Optional[str] = None) -> str:
    """One line: "2 errors, 1 warning in 3 objects"."""
    counts = [(sum(row.severity == severity for row in rows), severity) for severity in ("error", "warning", "info")]
    words = ", ".join(f"{n} {word}{'' if n == 1 else 's'}" for n, word in counts if n)
    return (words or "No problems found") + (f" in {what}" if what else "")
