"""Surface normals of meshes: computed, carried through transforms, and checked in files.

    import norma_mesh as norma

    normals = norma.vertex_normals(positions, faces)
    report = norma.check("chair.glb")

Angles are in degrees. Arrays go in and out as numpy arrays; inputs are never written, and the
interpreter's lock is given up during a call, so they must not change meanwhile. Wrong shapes, types
and indices raise a ValueError, TypeError or IndexError that names the argument.
"""
from ._calls import (
    Plan,
    compare,
    corner_normals,
    decode_normals,
    encode_normals,
    encoding_error_deg,
    face_normals,
    index_corners,
    matrix_info,
    normal_matrices,
    normal_matrix,
    orient,
    split,
    tangents,
    transform_normals,
    vertex_normals,
)
from ._check import Deviation, Finding, Report, Rule, Sample, check, rules
from ._files import ComputeSummary, Document, FileError, FileMesh, FixSummary, TangentSummary, TransformSummary, open
from ._norma import version as _version
from ._results import Comparison, Indexed, MatrixInfo, NormalReport, OrientReport, Split, TangentReport
from ._skins import Skin
from ._surfaces import Closest, Samples, closest, heightmap_normals, sample
from ._write import write

__version__: str = _version()
__all__ = [
    "Closest",
    "Comparison",
    "ComputeSummary",
    "Deviation",
    "Document",
    "FileError",
    "FileMesh",
    "Finding",
    "FixSummary",
    "Indexed",
    "MatrixInfo",
    "NormalReport",
    "OrientReport",
    "Plan",
    "Report",
    "Rule",
    "Sample",
    "Samples",
    "Skin",
    "Split",
    "TangentReport",
    "TangentSummary",
    "TransformSummary",
    "check",
    "closest",
    "compare",
    "corner_normals",
    "decode_normals",
    "encode_normals",
    "encoding_error_deg",
    "face_normals",
    "heightmap_normals",
    "index_corners",
    "matrix_info",
    "normal_matrices",
    "normal_matrix",
    "open",
    "orient",
    "rules",
    "sample",
    "split",
    "tangents",
    "transform_normals",
    "vertex_normals",
    "write",
]
