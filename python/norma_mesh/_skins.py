"""Positions, normals and tangents of vertices that several joints move."""
from __future__ import annotations

from typing import Any, Literal, Optional, Tuple, Union, overload

import numpy as np
from numpy.typing import ArrayLike

from . import _norma
from ._arguments import (
    Array, Fallback, Floats, choice, indices, integers, options, output, raise_index, refuse, stride, vectors,
)
from ._calls import _address, _models
from ._results import NormalReport, report_of

_BLENDS = {"linear": 0, "dual-quaternion": 1}
_POSITIONS, _NORMALS, _TANGENTS = 0, 1, 2
_NO_NORMALS = (0, 0, 0, 0)


class Skin:
    """The joints of each vertex, and how much each of them weighs.

    matrices: (j, 4, 4) as mathematics writes them, the translation in the last column: a joint's
        world matrix times its inverse bind matrix.
    joints: (n, k) integers, the joints of each vertex.  weights: (n, k) numbers, taken as they are.
    blend: "linear", as glTF and engines do, or "dual-quaternion" (Kavan et al. 2008).

    >>> import norma_mesh as norma, numpy as np
    >>> skin = norma.Skin([np.eye(4), np.diag([4, 1, 1, 1])], [[0, 1]], [[0.5, 0.5]])
    >>> skin.normals([[0.6, 0.8, 0]]).round(3)
    array([[0.287, 0.958, 0.   ]], dtype=float32)
    """

    def __init__(
        self, matrices: ArrayLike, joints: ArrayLike, weights: ArrayLike, *, blend: str = "linear"
    ) -> None:
        columns = _models("matrices", matrices, True).transpose(0, 2, 1)
        self._matrices = np.ascontiguousarray(columns, np.float32)
        given = integers("joints", joints)
        shares: Array = np.asarray(weights)
        if shares.dtype.kind not in "fiu":
            raise TypeError(f"weights: numbers are needed, not {shares.dtype}")
        if given.ndim != 2 or not 1 <= given.shape[1] <= 64:
            raise ValueError(f"joints: shape (n, k) with k from 1 to 64 is needed, not {given.shape}")
        if shares.shape != given.shape:
            raise ValueError(f"weights: the shape of joints, {given.shape}, is needed, not {shares.shape}")
        self._joints = indices("joints", given)
        self._weights = np.ascontiguousarray(shares, np.float32)
        self._blend = choice("blend", blend, _BLENDS)

    @property
    def vertex_count(self) -> int:
        return int(self._joints.shape[0])

    def _run(
        self, of: int, name: str, values: ArrayLike, width: int, out: Optional[Floats],
        normals: Tuple[Any, ...], kept: Tuple[Array, ...], fallback: Fallback, threads: Optional[int],
    ) -> Tuple[Floats, NormalReport]:
        array, kind = vectors(name, values, width)
        count = self.vertex_count
        if array.shape[0] != count:
            raise ValueError(f"{name}: shape ({count}, {width}) is needed, not {array.shape}")
        if of == _TANGENTS:
            array, kind = np.ascontiguousarray(array, np.float32), 0
        result = output("out", out, count, width, *(() if out is array else (array,)), *kept)
        call = (_address(self._matrices), self._matrices.shape[0], _address(self._joints), self._joints.itemsize,
                _address(self._weights), self._joints.shape[1], count, self._blend)
        settings = options(fallback=fallback, threads=threads, normal_stride=stride(result))
        answer = _norma.skin(of, call, (_address(array), count, stride(array), kind), normals,
                             (*settings[4:9], settings[10]), _address(result))
        if len(answer) != 6:
            result_code, argument, index, expected = answer
            if argument == "skin->joints" and result_code == -3:
                raise_index("joints", self._joints, index, self._matrices.shape[0])
            if argument == "skin->weights":
                index //= self._joints.shape[1]  # a row: weights[index] in Python
            refuse((result_code, argument.replace("skin->", ""), index, expected))
        return result, report_of(answer)

    def positions(
        self, positions: ArrayLike, *, threads: Optional[int] = None, out: Optional[Floats] = None
    ) -> Floats:
        """Moves positions, (n, 3) float32. out: an array to write to; may be `positions` itself."""
        return self._run(_POSITIONS, "positions", positions, 3, out, _NO_NORMALS, (), "zero", threads)[0]

    @overload
    def normals(
        self, normals: ArrayLike, *, fallback: Fallback = ..., threads: Optional[int] = ...,
        out: Optional[Floats] = ..., report: Literal[False] = ...,
    ) -> Floats: ...
    @overload
    def normals(
        self, normals: ArrayLike, *, fallback: Fallback = ..., threads: Optional[int] = ...,
        out: Optional[Floats] = ..., report: Literal[True],
    ) -> Tuple[Floats, NormalReport]: ...
    def normals(
        self, normals: ArrayLike, *, fallback: Fallback = "zero", threads: Optional[int] = None,
        out: Optional[Floats] = None, report: bool = False,
    ) -> Union[Floats, Tuple[Floats, NormalReport]]:
        """Turns normals by the normal matrix of each vertex's blended matrix, and makes them unit:
        (n, 3) float32. Zero stays zero, or becomes the fallback, three numbers; the report counts it.
        """
        if fallback == "nearest":
            raise ValueError("fallback: 'zero' or three numbers are needed, not 'nearest'")
        result, counts = self._run(_NORMALS, "normals", normals, 3, out, _NO_NORMALS, (), fallback, threads)
        return (result, counts) if report else result

    def tangents(
        self, tangents: ArrayLike, skinned_normals: ArrayLike, *, threads: Optional[int] = None,
        out: Optional[Floats] = None,
    ) -> Floats:
        """Turns tangents by each vertex's blended matrix and makes them perpendicular to the normals
        that `normals` gave: (n, 4) float32, the sign negated where a matrix mirrors.
        """
        array, kind = vectors("skinned_normals", skinned_normals)
        if array.shape[0] != self.vertex_count:
            raise ValueError(f"skinned_normals: shape ({self.vertex_count}, 3) is needed, not {array.shape}")
        view = (_address(array), array.shape[0], stride(array), kind)
        return self._run(_TANGENTS, "tangents", tangents, 4, out, view, (array,), "zero", threads)[0]
