"""Normals of corners by one of Norma's weights and a crease, and where they are hard. Needs no Blender."""
from __future__ import annotations

from typing import Optional

import numpy as np

from . import norma_mesh as norma
from .surface import Surface

# What norma.corner_normals takes, with what people read.
WEIGHTS = (
    ("angle", "Angle", "Each face counts by its angle at the vertex; independent of how faces are cut"),
    ("area", "Area", "Each face counts by its area: large flat faces stay flat"),
    ("angle-area", "Angle and area", "Angle times area, as Blender's Weighted Normal modifier offers it"),
    ("uniform", "Uniform", "Each face counts alike"),
    ("max", "Max (1999)", "Exact on spheres: sine of the angle over the lengths of both edges"),
    ("angle-lengths", "Angle and lengths", "Angle times the lengths of both edges"),
    ("visible", "Most visible", "The direction that is closest to all faces"),
)


def corner_normals(
    surface: Surface, weight: str = "angle", crease: float = 60.0, keep_sharp: bool = True, weld: str = "exact"
) -> np.ndarray:
    """(corners, 3) float32: what `norma compute --weight WEIGHT --crease CREASE` computes; keep_sharp:
    edges that are marked as sharp, and those of flat faces, stay hard."""
    hard: Optional[np.ndarray] = surface.hard_edges if keep_sharp else None
    return norma.corner_normals(
        surface.positions,
        (surface.corners, surface.starts),
        crease=crease,
        weight=weight,
        weld=weld,
        hard_edges=hard,
        fallback="nearest",
    )


def hard_edges(corners: np.ndarray, starts: np.ndarray, edges: np.ndarray, normals: np.ndarray, edge_count: int) -> np.ndarray:
    """(edges,) bool: whether the two faces of an edge have different normals there.

    edges: for each corner the number of the edge to the next corner.
    """
    following = np.arange(1, len(corners) + 1)
    sizes = np.diff(starts.astype(np.int64))
    following[starts[1:][sizes > 0].astype(np.int64) - 1] = starts[:-1][sizes > 0]
    users = np.bincount(edges, minlength=edge_count)
    order = np.argsort(edges, kind="stable")
    first = np.cumsum(users) - users
    shared = np.flatnonzero(users == 2)
    one, two = order[first[shared]], order[first[shared] + 1]
    along = corners[one] == corners[two]  # both run the same way
    start_of_two = np.where(along, two, following[two])
    end_of_two = np.where(along, following[two], two)
    differs = (normals[one] != normals[start_of_two]).any(1) | (normals[following[one]] != normals[end_of_two]).any(1)
    result = np.zeros(edge_count, bool)
    result[shared] = differs
    return result
