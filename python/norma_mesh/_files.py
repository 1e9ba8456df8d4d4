"""Files that contain normals: their meshes as arrays, computing, saving."""
from __future__ import annotations

import errno
import os
import threading
from dataclasses import dataclass
from typing import Any, List, NoReturn, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _norma
from ._arguments import (
    NON_MANIFOLD,
    WEIGHTS,
    Array,
    Weld,
    choice,
    crease_radians,
    given_degrees,
    thread_count,
    weld_of,
)
from ._results import NormalReport, report_of
from ._selection import PROFILES, Names, mask_of

Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]

_FORMATS = (np.float32, np.float64, np.int8, np.uint8, np.int16, np.uint16)
_SHADINGS = {"default": 0, "crease": 1, "smooth": 2, "flat": 3}
_ONLY = {"all": 0, "missing": 1, "broken": 2}
_GROUPS = {"auto": 0, "ignore": 1}
_STORED_TANGENTS = {"orthogonalise": 0, "keep": 1, "regenerate": 2}
_STORAGE = ("none", "vertex", "corner", "facet")


class FileError(OSError):
    """A file could not be read or written; the text says where in the file, and why."""


def raise_document(answer: Any) -> NoReturn:
    result, message = answer
    if result == -6:
        raise MemoryError(message)
    if result == -1:
        raise ValueError(message)
    raise FileError(message)


def bytes_of(name: str, path: Path) -> bytes:
    """A path as the system's bytes."""
    try:
        encoded = os.fsencode(path)
    except TypeError:
        raise TypeError(f"{name}: a path is needed, not {type(path).__name__}") from None
    if b"\0" in encoded:
        raise ValueError(f"{name}: a path holds no zero byte")
    return encoded


@dataclass(frozen=True)
class FileMesh:
    """A mesh of a file (a glTF primitive, or a whole OBJ, PLY or STL), in arrays of its own."""

    name: str
    where: str  #: JSON pointer of a glTF primitive
    encoding: str  #: of the normals in the file: "float", "text", "snorm8", ...
    positions: NDArray[Any]  #: (n, 3)
    faces: Union[NDArray[np.uint32], Tuple[NDArray[np.uint32], NDArray[np.uint32]]]  #: (n, 3), or (corners, face_starts)
    stored: str  #: how the file stores normals: "none", "vertex", "corner" or "facet"
    normals: Optional[NDArray[Any]]  #: (n, 3), as stored
    normal_faces: Optional[NDArray[np.uint32]]  #: for each corner its normal, 2**32 - 1: none
    texcoords: Optional[NDArray[np.float32]]  #: (n, 2)
    texcoord_faces: Optional[NDArray[np.uint32]]  #: for each corner, where not that of its position
    tangents: Optional[NDArray[np.float32]]  #: (n, 4)


@dataclass(frozen=True)
class ComputeSummary:
    """What `Document.compute` did."""

    changed: bool
    faces: int
    vertices_before: int
    vertices_after: int
    shading: str  #: "crease", "smooth" or "flat"
    crease: Optional[float]  #: degrees
    hard_edges: Optional[int]  #: None: edges were not looked at
    filled: int  #: elements without a normal of their own, which got the nearest one
    report: NormalReport


@dataclass(frozen=True)
class FixSummary:
    """What `Document.fix` did."""

    changed: bool
    left_out: int  #: fixes that would have done harm; `notes` say why
    notes: Tuple[str, ...]


class Document:
    """An open file. `meshes` are its meshes; `compute` and `fix` change it; `save` writes it, and every byte
    that has nothing to do with normals is kept."""

    def __init__(self, path: Path, *, threads: Optional[int] = None) -> None:
        encoded = bytes_of("path", path)
        self.path = os.fsdecode(encoded)
        self._lock = threading.Lock()
        if not os.path.exists(encoded):
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), self.path)
        answer = _norma.open_document(encoded, thread_count(threads))
        if isinstance(answer, tuple):
            raise_document(answer)
        self._document: Any = answer
        self.format: str = _norma.document_meshes(answer)[0]

    @property
    def meshes(self) -> List[FileMesh]:
        """The meshes as arrays. A mesh that cannot be read (points, an unknown compression) is a
        FileError; `mesh_count` counts it."""
        with self._lock:
            infos = _norma.document_meshes(self._document)[1]
            return [self._mesh(i, info) for i, info in enumerate(infos)]

    @property
    def mesh_count(self) -> int:
        with self._lock:
            return len(_norma.document_meshes(self._document)[1])

    def _mesh(self, index: int, info: Tuple[Any, ...]) -> FileMesh:
        name, where, _, _, storage, encoding, _, not_read = info
        if not_read is not None:
            raise FileError(f"{self.path}: {where or 'the file'}: {not_read}")
        answer = _norma.document_arrays(self._document, index)
        if len(answer) == 2:
            raise_document(answer)
        points, corners, starts, normals, normal_corners, texcoords, texcoord_corners, tangents = answer
        flat = _corners(corners, points[1])
        offsets = _rows(starts[0], starts[1] + 1, np.uint32) if starts[0] else None
        faces: Any = flat.reshape(-1, 3) if offsets is None else (flat, offsets)
        return FileMesh(
            name,
            where,
            encoding,
            _view(points),
            faces,
            _STORAGE[storage],
            _view(normals) if normals[1] else None,
            _rows(normal_corners, corners[1], np.uint32) if normal_corners else None,
            _table(texcoords, 2),
            _rows(texcoord_corners, corners[1], np.uint32) if texcoord_corners else None,
            _table(tangents, 4),
        )

    def compute(
        self,
        *,
        crease: Optional[float] = None,
        smooth: bool = False,
        flat: bool = False,
        weight: str = "angle",
        weld: Weld = "exact",
        non_manifold: str = "hard",
        groups: str = "auto",
        only: str = "all",
        morphs: bool = False,
        tangents: str = "orthogonalise",
        threads: Optional[int] = None,
    ) -> ComputeSummary:
        """Computes normals into the document, as `norma compute` does: creases at 60 degrees unless
        `crease`, `smooth` or `flat` say otherwise (PLY: smooth; STL: flat). Stored tangents are
        made perpendicular to new normals; `tangents` may also be "keep" or "regenerate"."""
        if (crease is not None) + bool(smooth) + bool(flat) > 1:
            raise ValueError("crease: only one of crease, smooth and flat can be given")
        shading = 1 if crease is not None else 2 if smooth else 3 if flat else 0
        mode, distance = weld_of(weld)
        settings = (
            shading,
            crease_radians(crease) if crease is not None else 0.0,
            choice("weight", weight, WEIGHTS),
            mode,
            distance,
            choice("non_manifold", non_manifold, NON_MANIFOLD),
            choice("groups", groups, _GROUPS),
            choice("only", only, _ONLY),
            bool(morphs),
            thread_count(threads),
            choice("tangents", tangents, _STORED_TANGENTS),
        )
        with self._lock:
            answer = _norma.document_compute(self._document, settings)
        if len(answer) == 2:
            raise_document(answer)
        changed, faces, before, after, shade, angle, hard, filled, counts = answer
        words = {number_: word for word, number_ in _SHADINGS.items()}
        return ComputeSummary(
            bool(changed), faces, before, after, words[shade],
            given_degrees(angle) if shade == 1 else None,
            None if hard < 0 else hard, filled, report_of(counts),
        )

    def fix(
        self,
        *,
        unsafe: bool = False,
        select: Names = None,
        ignore: Names = None,
        profile: str = "auto",
        open_by_rays: bool = False,
        threads: Optional[int] = None,
    ) -> FixSummary:
        """Fixes what `check` finds, as `norma check --fix` does; `unsafe` as `--fix-unsafe` does:
        informations are left as they are unless `select` names their rules. A fix after which some
        rule would find more is left out. The other arguments are those of
        `check`; open_by_rays turns open surfaces (N304) as most rays suggest.

        >>> import norma_mesh as norma
        >>> norma.open("assets/goathead.obj").fix().changed
        False
        """
        kind = choice("profile", profile, PROFILES)
        mask = mask_of(select, ignore)
        with self._lock:
            answer = _norma.document_fix(self._document, kind, mask, (2 if select is not None else 1) if unsafe else 0, bool(open_by_rays), thread_count(threads))
        if len(answer) == 2:
            raise_document(answer)
        changed, left_out, notes = answer
        return FixSummary(bool(changed), left_out, tuple(notes))

    def save(self, path: Path, *, in_place: bool = False) -> None:
        """Writes the document, whole or not at all. `in_place` allows the source as `path`."""
        with self._lock:
            answer = _norma.document_save(self._document, bytes_of("path", path), in_place)
        if answer is not None:
            raise_document(answer)


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def _rows(address: int, count: int, kind: Any, width: int = 0, stride: int = 0) -> NDArray[Any]:
    result = np.empty((count, width) if width else count, kind)
    if count:
        _norma.copy(address, count, max(width, 1) * result.itemsize, stride, _address(result))
    return result


def _view(view: Tuple[int, int, int, int]) -> NDArray[Any]:
    address, count, stride, kind = view
    return _rows(address, count, _FORMATS[kind], 3, stride)


def _table(table: Tuple[int, int], width: int) -> Optional[NDArray[np.float32]]:
    return _rows(table[0], table[1], np.float32, width) if table[0] else None


def _corners(corners: Tuple[int, int, int], positions: int) -> NDArray[np.uint32]:
    address, count, size = corners
    if not address:
        return np.arange(count, dtype=np.uint32)
    return _rows(address, count, {4: np.uint32, 2: np.uint16, 1: np.uint8}[size]).astype(np.uint32, copy=False)


def open(path: Path, *, threads: Optional[int] = None) -> Document:
    """Opens an OBJ, PLY, STL, glTF or GLB file.

    >>> import norma_mesh as norma
    >>> goat = norma.open("assets/goathead.obj")
    >>> goat.compute(crease=30).hard_edges
    659
    """
    return Document(path, threads=threads)
