"""What calls return beside arrays."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Tuple, Union

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class NormalReport:
    """How many elements have no normal of their own, and why; and unusual edges.

    Edges are counted by the calls that use creases.
    """

    degenerate_faces: int  #: faces without a direction
    non_finite: int  #: elements at a position that is NaN or infinite
    unreferenced: int  #: elements that no face with a direction uses
    cancelled: int  #: elements where the normals of the faces cancel
    non_manifold_edges: int
    winding_conflicts: int


@dataclass(frozen=True)
class TangentReport:
    """How many corners have no tangent of their own, and why."""

    degenerate: int  #: no texture area
    non_finite: int
    cancelled: int


@dataclass(frozen=True)
class OrientReport:
    """What `orient` found. Parts are sets of faces connected by shared edges."""

    parts: int
    closed: int
    open: int
    one_sided: int  #: no winding is consistent; left as they are
    inward: int  #: closed parts that faced inward
    nested: int  #: solids directly inside a solid, left as they are
    by_rays: int  #: open parts that rays turned or confirmed
    undecided: int
    least_confidence: float
    reversed_faces: int
    winding_conflicts: int
    non_manifold_edges: int


@dataclass(frozen=True)
class Comparison:
    """By how much the normals of one surface differ from those of another. Angles are in degrees;
    percentiles and shares are of area. One value for each corner in the arrays."""

    same_faces: bool  #: corners were compared with corners, else with the nearest points
    corners: int  #: that were compared
    missing: int  #: without a normal
    area: float
    p50_deg: float
    p99_deg: float
    max_deg: float
    p50_distance: float
    p99_distance: float
    max_distance: float
    share_above: float  #: the part of the area above the largest angle allowed, or missing
    worst: int  #: the corner with the largest angle; -1: none
    angles: NDArray[np.float64]  #: NaN: not compared
    distances: NDArray[np.float64]  #: to the base; NaN: unknown
    areas: NDArray[np.float64]
    faces: NDArray[np.int64]  #: of the base; -1: none
    normals: NDArray[np.float32]  #: of the base there


class Split(NamedTuple):
    """An indexed mesh whose vertices have one normal each."""

    faces: Union[NDArray[np.uint32], Tuple[NDArray[np.uint32], NDArray[np.uint32]]]  #: (n, k), or (corners, face_starts)
    source_vertices: NDArray[np.uint32]  #: the old vertex of each new one
    normals: NDArray[np.float32]


class Indexed(NamedTuple):
    """Corners that share vertices."""

    indices: NDArray[np.uint32]  #: the vertex of each corner
    source_corners: NDArray[np.uint32]  #: of each vertex the first corner that uses it


@dataclass(frozen=True)
class MatrixInfo:
    """What kind of matrix a model is, and what it does to normals."""

    kind: str  #: identity, translation, rotation, uniform-scale, non-uniform-scale, shear, singular
    rank: int
    mirrored: bool
    determinant: float
    anisotropy: float  #: largest over smallest singular value
    worst_error_deg: float  #: between M n and the right normal
    worst_normal: Tuple[float, float, float]  #: a normal, before M, for which it occurs


def report_of(counts: Any) -> NormalReport:
    return NormalReport(*counts)
