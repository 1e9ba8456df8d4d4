"""Files that contain normals: their meshes as arrays, changing them, saving."""
from __future__ import annotations

import errno
import os
import threading
import warnings
from dataclasses import dataclass, field
from typing import Any, List, Literal, NoReturn, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _norma
from ._arguments import (
    NON_MANIFOLD,
    WEIGHTS,
    Array,
    Floats,
    NonManifold,
    Profile,
    TangentMode,
    Weight,
    Weld,
    as_array,
    choice,
    crease_radians,
    given_degrees,
    thread_count,
    vectors,
    weld_of,
)
from ._calls import MODES, compare, index_corners, matrix_columns, matrix_info, normal_matrix, split
from ._results import Comparison, NormalReport, Split, report_of
from ._selection import PROFILES, Names, mask_of

Path = Union[str, "os.PathLike[str]", "os.PathLike[bytes]"]
Contents = Union[bytes, bytearray, memoryview]
Format = Literal["obj", "ply", "stl", "gltf", "glb", "b3dm", "i3dm", "cmpt", "3mf"]
Only = Literal["all", "missing", "broken"]

FORMATS = {"": 0, "obj": 1, "ply": 2, "stl": 3, "gltf": 4, "glb": 5, "b3dm": 6, "i3dm": 7, "cmpt": 8, "3mf": 9}
_BEGINNINGS = ((b"glTF", "glb"), (b"ply", "ply"), (b"b3dm", "b3dm"), (b"i3dm", "i3dm"), (b"cmpt", "cmpt"), (b"PK\3\4", "3mf"))
_FORMATS = (np.float32, np.float64, np.int8, np.uint8, np.int16, np.uint16)
_SHADINGS = {"default": 0, "crease": 1, "smooth": 2, "flat": 3}
_ONLY = {"all": 0, "missing": 1, "broken": 2}
_GROUPS = {"auto": 0, "ignore": 1}
_STORED_TANGENTS = {"orthogonalise": 0, "keep": 1, "regenerate": 2}
_STORAGE = ("none", "vertex", "corner", "facet")
_NO_NORMAL = 0xFFFFFFFF


class FileError(OSError):
    """A file could not be read or written; the text says where in the file, and why."""


def raise_document(answer: Any) -> NoReturn:
    result, message = answer
    if result == -6:
        raise MemoryError(message)
    if result == -1:
        raise ValueError(message)
    raise FileError(message)


def bytes_of(name: str, path: object) -> bytes:
    """A path as the system's bytes."""
    try:
        encoded = os.fsencode(path)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name}: a path is needed, not {type(path).__name__}") from None
    if b"\0" in encoded:
        raise ValueError(f"{name}: a path holds no zero byte")
    return encoded


def is_tileset(path: Any) -> bool:
    """Whether a file is called as a tileset of 3D Tiles is."""
    return os.fsdecode(path).lower().endswith(".json") and os.path.isfile(path)


@dataclass(frozen=True)
class Source:
    """A file to be read: on the disk, or bytes with a name for messages."""

    shown: str
    path: Optional[bytes]
    contents: Optional[bytes]
    format: int


def source_of(argument: str, source: object, name: Optional[str] = None, format: Optional[str] = None) -> Source:
    """What a path or a file's bytes stand for; without a name and a format, bytes are known by their beginning."""
    kind = choice("format", format or "", FORMATS)
    if isinstance(source, (bytes, bytearray, memoryview)):
        contents = bytes(source)
        if not kind and not (name and os.path.splitext(name)[1]):
            found = [word for beginning, word in _BEGINNINGS if contents.startswith(beginning)]
            found += ["gltf"] * contents.lstrip().startswith(b"{")
            if not found:
                raise ValueError(f"format: {name or 'bytes'} that begin with {contents[:8]!r} may be of any format; "
                                 "name it (\"obj\", \"stl\"), or give the name of a file")
            kind = FORMATS[found[0]]
        return Source(name or "bytes", bytes_of("name", name) if name else None, contents, kind)
    encoded = bytes_of(argument, source)
    if not os.path.exists(encoded):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fsdecode(encoded))
    return Source(os.fsdecode(encoded), encoded, None, kind)


@dataclass
class FileMesh:
    """A mesh of a file (a glTF primitive, or a whole OBJ, PLY or STL), in arrays of its own.

    `mesh.normals = array` writes normals into the document, one for each position or for each corner;
    the other arrays are copies. After another change of the document, take `document.meshes` again.
    """

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
    _document: Optional[Document] = field(default=None, repr=False, compare=False)
    _index: int = field(default=0, repr=False, compare=False)

    def __setattr__(self, name: str, value: Any) -> None:
        if "_index" not in self.__dict__:  # not made yet
            object.__setattr__(self, name, value)
        elif name != "normals":
            raise AttributeError(f"{name}: of a file's mesh, only normals can be set")
        else:
            assert self._document is not None
            self.__dict__.update(self._document.set_normals(self._index, value).__dict__)

    def split(self, *, crease: float = 60.0, weight: Weight = "angle", weld: Weld = "exact",
              threads: Optional[int] = None) -> Split:
        """`norma.split` of this mesh."""
        return split(self.positions, self.faces, crease=crease, weight=weight, weld=weld, threads=threads)

    @property
    def corner_normals(self) -> Optional[NDArray[Any]]:
        """The stored normal of each corner, (corners, 3); NaN: none. None if the file has no normals."""
        if self.normals is None:
            return None
        corners = _corner_list(self)
        if self.stored == "facet":
            return np.repeat(self.normals, 3, axis=0)
        own = corners if self.normal_faces is None else self.normal_faces
        padded = np.concatenate([self.normals, np.full((1, 3), np.nan, self.normals.dtype)])
        found: NDArray[Any] = padded[np.minimum(own, len(self.normals))]
        return found

    def __str__(self) -> str:
        count = len(self.faces[1]) - 1 if isinstance(self.faces, tuple) else len(self.faces)
        return _described(self.where, self.name, len(self.positions), count, self.stored, self.encoding, None)


def _described(where: str, name: str, positions: int, faces: int, stored: str, encoding: str, why: Optional[str]) -> str:
    head = " ".join(part for part in (where, repr(name) if name else "") if part)
    words = f"{positions} positions, {faces} faces, " if why is None else f"not read: {why}"
    if why is None:
        words += "no normals" if stored == "none" else f"a normal for each {stored} ({encoding})"
    return f"{head}: {words}" if head else words


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


@dataclass(frozen=True)
class TransformSummary:
    """What `Document.transform` did."""

    changed: bool
    vertices: int
    meshes: int
    nodes_baked: int
    mirrored: bool  #: by the matrix, or by a node that was baked


@dataclass(frozen=True)
class TangentSummary:
    """What `Document.tangents` did."""

    changed: bool
    primitives: int  #: that got tangents
    left_out: int  #: primitives of triangles without normals or texture coordinates
    vertices_before: int
    vertices_after: int
    degenerate: int  #: corners without texture area
    non_finite: int
    cancelled: int


class Document:
    """An open file. `meshes` are its meshes as arrays; `compute`, `tangents`, `transform`, `fix` and
    `set_normals` change it; `save` and `to_bytes` write it. Every byte that has nothing to do with
    normals is kept. `print(document)` lists its meshes."""

    def __init__(self, source: Union[Path, Contents], *, name: Optional[str] = None,
                 format: Optional[Format] = None, threads: Optional[int] = None) -> None:
        found = source_of("path", source, name, format)
        self.path = found.shown
        self._lock = threading.Lock()
        answer = _norma.open_document(found.path, found.contents, found.format, thread_count(threads))
        if isinstance(answer, tuple):
            raise_document(answer)
        self._document: Any = answer
        self.format: str = _norma.document_meshes(answer)[0]

    def __str__(self) -> str:
        infos = self._infos()
        lines = [f"{self.path}: {self.format}, {len(infos)} mesh{'' if len(infos) == 1 else 'es'}"]
        for name, where, positions, faces, storage, encoding, _, why in infos:
            lines.append("    " + _described(where, name, positions, faces, _STORAGE[storage], encoding, why))
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<norma_mesh.Document {self.path!r}: {self.format}, {self.mesh_count} meshes>"

    def _infos(self) -> List[Tuple[Any, ...]]:
        with self._lock:
            return _norma.document_meshes(self._document)[1]

    @property
    def meshes(self) -> List[FileMesh]:
        """The meshes as arrays. A mesh that cannot be read (points, an unknown compression) is a
        FileError; `mesh_count` counts it."""
        with self._lock:
            infos = _norma.document_meshes(self._document)[1]
            return [self._mesh(i, info) for i, info in enumerate(infos)]

    @property
    def mesh_count(self) -> int:
        return len(self._infos())

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
            self,
            index,
        )

    def compute(
        self,
        *,
        crease: Optional[float] = None,
        smooth: bool = False,
        flat: bool = False,
        weight: Weight = "angle",
        weld: Weld = "exact",
        non_manifold: NonManifold = "hard",
        groups: Literal["auto", "ignore"] = "auto",
        only: Only = "all",
        morphs: bool = False,
        tangents: Literal["orthogonalise", "keep", "regenerate"] = "orthogonalise",
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
            0,
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
        profile: Profile = "auto",
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

    def tangents(
        self,
        *,
        mode: TangentMode = "mikk",
        weight: Weight = "angle",
        texcoord: Optional[int] = None,
        only: Only = "all",
        threads: Optional[int] = None,
    ) -> TangentSummary:
        """Computes the tangents of a glTF, as `norma tangents` does: of all triangles with normals and
        texture coordinates, split where corners of a vertex have different ones.

        mode: "mikk" gives the bits of MikkTSpace, "steady" does not depend on the order of faces.
        texcoord: the set of coordinates (TEXCOORD_n); None: that of the material's normal map, else 0.
        only: "missing" leaves primitives with tangents alone, "broken" those with usable ones.
        """
        if texcoord is not None and not 0 <= texcoord < 2**31:
            raise ValueError(f"texcoord: the number of a set is needed, not {texcoord!r}")
        settings = (choice("mode", mode, MODES), choice("weight", weight, WEIGHTS),
                    -1 if texcoord is None else texcoord, choice("only", only, _ONLY), thread_count(threads))
        with self._lock:
            answer = _norma.document_tangents(self._document, settings)
        if len(answer) == 2:
            raise_document(answer)
        return TangentSummary(bool(answer[0]), *answer[1:])

    def transform(self, matrix: Optional[ArrayLike] = None, *, bake: bool = False,
                  threads: Optional[int] = None) -> TransformSummary:
        """Transforms positions, normals and tangents, as `norma transform` does; a mirror reverses the
        winding.

        matrix: (4, 4) or (3, 3) as mathematics writes it: the translation is the last column.
        bake: the transforms of glTF nodes are applied to their meshes as well.
        A matrix that flattens gives a warning that says what becomes of the normals.

        >>> import norma_mesh as norma
        >>> norma.open("assets/goathead.obj").transform([[-1, 0, 0], [0, 1, 0], [0, 0, 1]]).mirrored
        True
        """
        columns = matrix_columns("matrix", np.eye(4) if matrix is None else matrix)
        with self._lock:
            answer = _norma.document_transform(self._document, _address(columns), bool(bake), thread_count(threads))
        if len(answer) == 2:
            raise_document(answer)
        changed, vertices, meshes, baked, mirrored = answer
        words = None if matrix is None else _flattening(matrix, self.format not in ("obj", "ply", "stl") and not bake)
        if changed and words:
            warnings.warn(f"matrix: singular; {words}", stacklevel=2)
        return TransformSummary(bool(changed), vertices, meshes, baked, bool(mirrored))

    def set_normals(self, mesh: int, normals: ArrayLike) -> FileMesh:
        """Writes normals into one mesh and returns it as it is then.

        mesh: its number in `meshes`.
        normals: (n, 3) numbers of any length above 0: one for each position or for each corner, or
            as many as the file stores (each facet of an STL, each vn of an OBJ). For corners that
            differ, vertices of a glTF or PLY are split; in an OBJ, faces that share a vn cannot get
            different normals.
        """
        with self._lock:
            infos = _norma.document_meshes(self._document)[1]
            if not 0 <= mesh < len(infos):
                raise IndexError(f"mesh: {mesh} is not the number of a mesh; there are {len(infos)}")
            found = self._mesh(mesh, infos[mesh])
            bare = found.stored == "none" and self.format not in ("obj", "stl")
            unit = _unit(found, normals, "vertex" if bare else found.stored, self.format)
            if bare:
                chosen = np.arange(len(infos)) == mesh
                settings = (2, 0.0, 0, 1, 0.0, 0, 0, 0, False, thread_count(None), 1, _address(chosen) if self.format != "ply" else 0)
                answer = _norma.document_compute(self._document, settings)
                if len(answer) == 2:
                    raise_document(answer)
                found = self._mesh(mesh, _norma.document_meshes(self._document)[1][mesh])
            given, marks, sources, corners = _placed(found, unit, self.format)
            answer = _norma.document_set_normals(
                self._document, mesh, _address(given), _address(marks), 0 if sources is None else _address(sources),
                0 if sources is None else len(sources), 0 if corners is None else _address(corners))
            if answer is not None:
                raise_document(answer)
            return self._mesh(mesh, _norma.document_meshes(self._document)[1][mesh])

    def compare(self, base: Union[Document, Path, Contents], *, max_deg: float = 0.0,
                threads: Optional[int] = None) -> List[Comparison]:
        """By how much the normals of each mesh differ from those of the same mesh of another file, as
        `norma.compare` measures it.

        base: a document, or what `norma.open` takes.
        """
        other = base if isinstance(base, Document) else Document(base, threads=threads)
        pairs = list(zip(other.meshes, self.meshes))
        if len(other.meshes) != len(self.meshes):
            raise ValueError(f"base: {len(self.meshes)} meshes are needed, as in {self.path}, not {len(other.meshes)}")
        return [compare(theirs, ours, max_deg=max_deg, threads=threads) for theirs, ours in pairs]

    def to_bytes(self) -> bytes:
        """The file as bytes; a .gltf has its buffers as data URIs."""
        with self._lock:
            answer = _norma.document_bytes(self._document)
        if isinstance(answer, tuple):
            raise_document(answer)
        return bytes(answer)

    def save(self, path: Path, *, in_place: bool = False) -> None:
        """Writes the document, whole or not at all. `in_place` allows the source as `path`."""
        with self._lock:
            answer = _norma.document_save(self._document, bytes_of("path", path), in_place)
        if answer is not None:
            raise_document((answer[0], answer[1].replace("or work in place", "or in_place=True")))


def _flattening(matrix: ArrayLike, on_a_node: bool) -> Optional[str]:
    """What a matrix that flattens does to normals, in the words of `norma transform`; None: it does not."""
    info = matrix_info(matrix)
    if info.rank == 3:
        return None
    if on_a_node:
        return (f"flattened (rank {info.rank}) by a new node: the normals then depend on the renderer; "
                "bake=True writes them into the file")
    if info.determinant != 0:
        return "nearly flat (within 1e-6 of its largest stretch): each face keeps its normal"
    if normal_matrix(matrix).any():
        return "flattened to a plane (rank 2): faces get the plane's normal, which is right; collapsed faces have none"
    shape = "line (rank 1)" if info.rank == 1 else "point (rank 0)"
    return f"flattened to a {shape}: no face keeps a direction, so no normal is right"


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def _corner_list(m: FileMesh) -> Array:
    return m.faces[0] if isinstance(m.faces, tuple) else m.faces.ravel()


def _unit(m: FileMesh, values: ArrayLike, stored: str, format: str) -> Floats:
    """Unit vectors in a number that a mesh with normals stored like this takes; nothing is changed before."""
    given = np.array(vectors("normals", values)[0], np.float64)
    length = np.sqrt((given * given).sum(1))
    wrong = np.flatnonzero(~((length > 0) & np.isfinite(length)))
    if wrong.size:
        raise ValueError(f"normals[{wrong[0]}]: a vector with a length is needed, not {tuple(given[wrong[0]].tolist())}")
    if m.normals is None and stored != "vertex":
        raise ValueError(f"normals: this {format} file stores none yet; compute() makes places for them, norma.write() new files")
    own = 0 if m.normals is None else len(m.normals)
    points, corners = len(m.positions), len(_corner_list(m))
    if len(given) not in {"facet": (own,), "corner": (own, points, corners)}.get(stored, (points, corners)):
        counts = f"{own} normals" if stored == "facet" else f"one for each of {points} positions or {corners} corners"
        raise ValueError(f"normals: {counts} are needed, not {len(given)}")
    unit: Floats = (given / length[:, None]).astype(np.float32)
    return unit


def _placed(m: FileMesh, unit: Floats, format: str) -> Tuple[Array, Array, Optional[Array], Optional[Array]]:
    """Unit vectors as the file stores them: (normals, marks, source vertices, corners)."""
    corners = _corner_list(m)
    stored = 0 if m.normals is None else len(m.normals)
    if len(unit) == (len(m.positions) if m.stored == "vertex" else stored):
        return unit, np.ones(len(unit), np.uint8), None, None
    if m.stored == "vertex":
        indices, first = index_corners(corners, unit)
        return unit[first], np.ones(len(first), np.uint8), corners[first], indices
    place = m.normal_faces
    assert place is not None
    unit = unit if len(unit) == len(corners) else unit[corners]
    result, marks = np.zeros((stored, 3), np.float32), np.zeros(stored, np.uint8)
    used = place != _NO_NORMAL
    result[place[used]], marks[place[used]] = unit[used], 1
    torn = np.flatnonzero((result[place[used]] != unit[used]).any(1))
    if torn.size:
        raise ValueError(f"normals: corners that share normal {place[used][torn[0]]} of the {format} file cannot get different ones; "
                         "norma.write() makes a new file")
    return result, marks, None, None


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


def open(source: Union[Path, Contents], *, name: Optional[str] = None, format: Optional[Format] = None,
         threads: Optional[int] = None) -> Document:
    """Opens an OBJ, PLY, STL, glTF, GLB or 3MF file, or a tile of 3D Tiles.

    source: a path, or the file's contents as bytes.
    name: of bytes: what messages call them; its folder is that of a glTF's buffers.
    format: "obj", "ply", "stl", "gltf", "glb", ...; otherwise it is known by the ending of the name, or
        by the first bytes.

    >>> import norma_mesh as norma
    >>> goat = norma.open("assets/goathead.obj")
    >>> print(goat)
    assets/goathead.obj: obj, 1 mesh
        2763 positions, 5522 faces, no normals
    >>> goat.compute(crease=30).hard_edges
    659
    """
    if isinstance(source, (str, os.PathLike)) and not format and is_tileset(bytes_of("path", source)):
        raise FileError(f"{os.fsdecode(source)}: a tileset is no mesh; open its tiles, or give it to norma.check")
    return Document(source, name=name, format=format, threads=threads)
