"""A mesh as it would be exported, in arrays: what Blender's mesh is read into, and what is checked.

Nothing here needs Blender. Corners are Blender's loops, faces its polygons.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Optional, Tuple

import numpy as np


@dataclass
class Material:
    """What of a material matters to normals, by the rules of Blender's glTF exporter."""

    name: str = ""
    double_sided: bool = False
    alpha_mode: str = "OPAQUE"
    normal_map: bool = False


@dataclass
class Surface:
    """An object: its evaluated mesh in its own space, and where it stands."""

    name: str
    positions: np.ndarray  # (vertices, 3) float32
    corners: np.ndarray  # (corners,) uint32: the vertex of each corner
    starts: np.ndarray  # (faces + 1,) uint32: the first corner of each face
    normals: np.ndarray  # (corners, 3) float32, as Blender shades and exports them
    triangles: np.ndarray  # (triangles, 3) uint32: corners
    triangle_faces: np.ndarray  # (triangles,) uint32
    texcoords: Optional[np.ndarray] = None  # (corners, 2) float32
    tangents: Optional[np.ndarray] = None  # (corners, 4) float32
    face_materials: Optional[np.ndarray] = None  # (faces,) slots
    hard_edges: Optional[np.ndarray] = None  # (corners,) bool: the edge to the next corner is sharp
    materials: List[Material] = field(default_factory=list)
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))
    not_editable: str = ""  # why what is computed here cannot be written back

    @property
    def face_count(self) -> int:
        return len(self.starts) - 1

    def corner_faces(self) -> np.ndarray:
        """The face of each corner."""
        return np.repeat(np.arange(self.face_count), np.diff(self.starts.astype(np.int64)))

    def world_positions(self) -> np.ndarray:
        return self.positions @ self.matrix[:3, :3].T.astype(np.float32) + self.matrix[:3, 3].astype(np.float32)


@dataclass
class Primitive:
    """The faces of one material as glTF has them: indexed triangles, one normal for each vertex."""

    material: int
    positions: np.ndarray
    normals: np.ndarray
    texcoords: Optional[np.ndarray]
    tangents: Optional[np.ndarray]
    indices: np.ndarray  # (triangles, 3) uint32
    triangles: np.ndarray  # the triangles of the surface, by number


def primitives(surface: Surface) -> List[Primitive]:
    """A primitive for each material that faces use, in the order of the slots."""
    slots = surface.face_materials
    if slots is None:
        slots = np.zeros(surface.face_count, np.int64)
    of_triangles = slots[surface.triangle_faces]
    return [_primitive(surface, int(slot), np.flatnonzero(of_triangles == slot)) for slot in np.unique(of_triangles)]


def _primitive(surface: Surface, slot: int, triangles: np.ndarray) -> Primitive:
    """Corners with the same position, normal, texture coordinates and tangent share a vertex."""
    corners = surface.triangles[triangles].reshape(-1)
    columns = [surface.corners[corners]]
    for attribute in (surface.normals, surface.texcoords, surface.tangents):
        if attribute is not None:
            columns.extend(np.ascontiguousarray(_bits(attribute[corners]).T))
    first, indices = _distinct(columns)
    kept = corners[first]
    return Primitive(
        slot,
        surface.positions[surface.corners[kept]],
        surface.normals[kept],
        None if surface.texcoords is None else surface.texcoords[kept],
        None if surface.tangents is None else surface.tangents[kept],
        indices.reshape(-1, 3).astype(np.uint32),
        triangles,
    )


_ROUNDS = 16


def _distinct(columns: List[np.ndarray]) -> Tuple[np.ndarray, np.ndarray]:
    """The first of each of the rows that differ, in order, and which of these each row is.

    Rows that differ in the first column, a vertex, are not compared: each round takes one row of each
    vertex, and all rows that are like it. Most vertices have few. What is left of those with many is sorted.
    """
    vertices = columns[0]
    own, left = np.arange(len(vertices)), np.arange(len(vertices))
    first_at = np.empty(int(vertices.max(initial=0)) + 1, np.int64)
    for _ in range(_ROUNDS):
        if not left.size:
            break
        first_at[vertices[left[::-1]]] = left[::-1]
        first = first_at[vertices[left]]
        alike = np.ones(len(left), bool)
        for column in columns[1:]:
            alike &= column[left] == column[first]
        own[left[alike]] = first[alike]
        left = left[~alike]
    if left.size:
        rows = np.ascontiguousarray(np.stack([column[left] for column in columns], 1).astype(np.uint32))
        _, first, of = np.unique(rows.view(f"V{rows.shape[1] * 4}").reshape(-1), return_index=True, return_inverse=True)
        own[left] = left[first[of.reshape(-1)]]
    is_first = own == np.arange(len(own))
    return np.flatnonzero(is_first), (np.cumsum(is_first) - 1)[own]


def _bits(values: np.ndarray) -> np.ndarray:
    """Floats as bits; the two zeros are one."""
    return (np.ascontiguousarray(values, np.float32) + np.float32(0)).view(np.uint32)
