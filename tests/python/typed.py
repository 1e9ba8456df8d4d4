"""For mypy in strict mode: what calls return, as a user's editor shows it; wheel.sh runs mypy, nothing runs this."""
from typing import Tuple, Union

import numpy as np
from numpy.typing import NDArray
from typing_extensions import assert_type

import norma_mesh as norma

Floats = NDArray[np.float32]


def calls(points: NDArray[np.float64], faces: NDArray[np.uint32], wanted: bool) -> None:
    assert_type(norma.vertex_normals(points, faces), Floats)
    assert_type(norma.vertex_normals(points, faces, report=True), Tuple[Floats, norma.NormalReport])
    assert_type(norma.vertex_normals(points, faces, report=wanted), Union[Floats, Tuple[Floats, norma.NormalReport]])
    assert_type(norma.corner_normals(points, faces, report=wanted), Union[Floats, Tuple[Floats, norma.NormalReport]])
    assert_type(norma.face_normals(points, faces, report=wanted), Union[Floats, Tuple[Floats, norma.NormalReport]])
    assert_type(norma.split(points, faces, report=wanted), Union[norma.Split, Tuple[norma.Split, norma.NormalReport]])
    assert_type(norma.tangents(points, points, points[:, :2], faces, report=wanted), Union[Floats, Tuple[Floats, norma.TangentReport]])
    assert_type(norma.heightmap_normals(points, report=wanted), Union[Floats, Tuple[Floats, norma.NormalReport]])
    assert_type(norma.encode_normals(points, report=wanted), Union[NDArray[np.uint32], Tuple[NDArray[np.uint32], norma.NormalReport]])
    norma.orient(points, faces, report=wanted)
    norma.vertex_normals(points, faces, weight="areas")  # type: ignore[call-overload]  # no such weight
    norma.check("a.obj", profile="paint")  # type: ignore[arg-type]  # no such profile
    norma.corner_normals(points, faces, weld="near")  # type: ignore[call-overload]  # no such weld
    assert_type(norma.closest(points, points, faces).distances, NDArray[np.float64])
    assert_type(norma.open("a.glb").meshes[0].normals is None, bool)
