"""Fixes surfaces as `norma check --fix` fixes files, and finds what that changed, face by face.

The surfaces are written as a file, the library fixes it, and what it wrote is compared with what
was there: triangles that are gone or turned, corners with another normal, vertices that moved.
Needs no Blender.
"""
from __future__ import annotations

import itertools
import os
import tempfile
from dataclasses import dataclass
from typing import Any, List, Optional, Tuple

import numpy as np

from . import norma_mesh as norma
from .findings import exported
from .surface import Primitive, Surface

PLACED = ("N601", "N602", "N604")  # what is wrong with these is the object's matrix
_ORDERS = np.array(list(itertools.permutations(range(3))))
_REVERSED = np.array([sum(a > b for a, b in itertools.combinations(order, 2)) % 2 == 1 for order in _ORDERS])


@dataclass
class Change:
    """What a fix changes in a surface."""

    turned: np.ndarray  # (faces,) bool
    gone: np.ndarray  # (faces,) bool
    normals: Optional[np.ndarray]  # (corners, 3); None: none changed
    positions: Optional[np.ndarray]  # (vertices, 3); None: none moved

    @property
    def empty(self) -> bool:
        return not (self.turned.any() or self.gone.any()) and self.normals is None and self.positions is None


def fix(surfaces: List[Surface], unsafe: bool, select: Any, profile: str = "render") -> Tuple[List[Change], Tuple[str, ...]]:
    """The change of each surface (all have faces), and why fixes were left out."""
    placed = [rule.id for rule in norma.rules() if rule.id in PLACED]
    with tempfile.TemporaryDirectory() as folder:
        path, parts = exported(surfaces, folder)
        document = norma.open(path)
        summary = document.fix(unsafe=unsafe, select=select, ignore=placed, profile=profile)
        target = os.path.join(folder, "fixed.glb")
        document.save(target)
        fixed = {mesh.where: mesh for mesh in norma.open(target).meshes}
    changes = []
    for i, surface in enumerate(surfaces):
        after = [fixed.get(f"/meshes/{i}/primitives/{j}") for j in range(len(parts[i]))]
        changes.append(_change(surface, parts[i], after))
    return changes, summary.notes


def _change(surface: Surface, before: List[Primitive], after: List[Any]) -> Change:
    kept = np.zeros(surface.face_count, np.int64)
    turned = np.zeros(surface.face_count, np.int64)
    normals, positions = surface.normals.copy(), surface.positions.copy()
    for old, new in zip(before, after):
        if new is None or new.normals is None:
            kept[surface.triangle_faces[old.triangles]] += 1  # not read: left as it is
            continue
        points = np.asarray(new.positions, np.float32)
        source, order = _matched(old.positions[old.indices], points[new.faces])
        triangles = old.triangles[source]
        faces = surface.triangle_faces[triangles]
        np.add.at(kept, faces, 1)
        np.add.at(turned, faces, _REVERSED[order])
        corners = np.take_along_axis(surface.triangles[triangles], _ORDERS[order], 1)
        normals[corners] = np.asarray(new.normals, np.float32)[new.faces]
        positions[surface.corners[corners]] = points[new.faces]
    same_normals = np.array_equal(_kept(normals), _kept(surface.normals))
    return Change(
        (turned * 2 > kept) & (kept > 0),
        kept == 0,
        None if same_normals else normals,
        None if np.array_equal(_kept(positions), _kept(surface.positions)) else positions,
    )


def _kept(values: np.ndarray) -> np.ndarray:
    """Bits, as NaN differs from itself; the two zeros are one."""
    return (values + np.float32(0)).view(np.uint32)


def _matched(before: np.ndarray, after: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """For each triangle after a fix: which it was, and in which order its corners are now.

    Fixes keep the order of triangles and drop some, so each is looked for from where the one
    before it was found. If as many are left, they are the same ones, some perhaps with moved corners.
    """
    if len(before) == len(after):
        source = np.arange(len(before))
    else:
        source = _subsequence(_keys(before), _keys(after))
    orders = np.stack([(_kept(after) == _kept(before[source][:, order])).all((1, 2)) for order in _ORDERS], 1)
    return source, orders.argmax(1)


def _keys(triangles: np.ndarray) -> List[bytes]:
    """The same for a triangle however its corners are turned."""
    return [b"".join(sorted(corner.tobytes() for corner in triangle)) for triangle in _kept(triangles)]


def _subsequence(before: List[bytes], after: List[bytes]) -> np.ndarray:
    found, at = [], 0
    for key in after:
        while before[at] != key:
            at += 1
        found.append(at)
        at += 1
    return np.array(found, np.int64)
