"""The rules of `norma check` on files."""
from __future__ import annotations

import html
import json
import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator as AnyIterator, Set as AnySet, ValuesView
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

from . import _norma
from ._arguments import WEIGHTS, Faces, Profile, choice, count_of, given_degrees, mesh, options, parts_of, refuse, thread_count, unpacked
from ._calls import attribute
from ._files import FORMATS, Document, FileError, FileMesh, Format, Source, bytes_of, is_tileset, raise_document, source_of
from ._selection import PROFILES, Names, mask_of
from ._tool import tool_path

_PROFILE_NAMES = ("auto", "render", "print", "generated")
_SEVERITIES = ("none", "info", "warning", "error")
_SHADINGS = ("default", "crease", "smooth", "flat")
_FIXES = (None, "safe", "unsafe")
_PATHS = (str, os.PathLike)
_BYTES = (bytes, bytearray, memoryview)
_LISTS = (list, tuple, AnySet, ValuesView, AnyIterator)


@dataclass(frozen=True)
class Rule:
    """A rule. `norma explain ID` shows the same."""

    id: str
    name: str
    severity: str  #: the highest one, for rendering
    print_severity: str  #: the highest one, for printing
    fix: Optional[str]  #: "safe", "unsafe" or None
    fix_verb: str
    what: str
    cause: str
    why: str
    how: str


@dataclass(frozen=True)
class Sample:
    """A place; numbers are those of the file, from 0."""

    vertex: Optional[int]
    face: Optional[int]
    normal: Optional[int]
    position: Optional[Tuple[float, float, float]]


@dataclass(frozen=True)
class Deviation:
    """The weight and crease that explain stored normals best, and how well they do, in degrees."""

    shading: str  #: "crease", "smooth" or "flat"
    weight: Optional[str]  #: None: flat
    crease: Optional[float]
    mean: float
    p50: float
    p99: float
    max: float
    histogram: Tuple[Tuple[float, int], ...]  #: (bound, corners below it and not below the one before)


@dataclass(frozen=True)
class Finding:
    """What one rule found at one place."""

    rule: str  #: "N301"
    name: str  #: "inconsistent-winding"
    severity: str  #: "info", "warning" or "error"
    where: str  #: JSON pointer in a glTF; "" for a whole OBJ, PLY or STL
    label: str  #: a name for people
    count: int
    worst_value: Optional[float]
    unit: str
    worst: Sample
    samples: Tuple[Sample, ...]
    fix: Optional[str]  #: "safe", "unsafe" or None
    message: str
    command: Optional[str]  #: mends it, ready to paste
    deviation: Optional[Deviation] = None  #: of N204
    mesh: Optional[str] = None  #: the same for equal meshes, in whichever file; None: not about one
    cause: str = ""  #: how such a fault usually arises; the same for all findings of a rule
    impact: str = ""  #: what it does to pictures or programs; the same for all findings of a rule
    path: str = ""  #: of the file; "arrays": of arrays

    def __str__(self) -> str:
        place = f"{self.label}: " if self.label else ""
        return f"{self.severity} {self.rule} {self.name}: {place}{self.message}"


def _sample(parts: Tuple[Any, ...]) -> Sample:
    return Sample(*parts)


def _sample_json(sample: Sample) -> Dict[str, Any]:
    found = {"vertex": sample.vertex, "face": sample.face, "normal": sample.normal}
    result: Dict[str, Any] = {key: value for key, value in found.items() if value is not None}
    result["position"] = None if sample.position is None else list(sample.position)
    return result


def _deviation(parts: Optional[Tuple[Any, ...]]) -> Optional[Deviation]:
    if parts is None:
        return None
    shading, weight, crease, mean, p50, p99, largest, bins = parts
    name = _SHADINGS[shading]
    bounds = (given_degrees(bound) for bound in _norma.bounds())
    return Deviation(
        name,
        None if name == "flat" else tuple(WEIGHTS)[weight],
        given_degrees(crease) if math.isfinite(crease) else None,
        math.degrees(mean),
        math.degrees(p50),
        math.degrees(p99),
        math.degrees(largest),
        tuple(zip(bounds, bins)),
    )


def _deviation_json(d: Deviation) -> Dict[str, Any]:
    return {
        "shading": d.shading,
        "weight": d.weight,
        "crease_deg": d.crease,
        "mean_deg": d.mean,
        "p50_deg": d.p50,
        "p99_deg": d.p99,
        "max_deg": d.max,
        "histogram": [{"below_deg": bound, "corners": corners} for bound, corners in d.histogram],
    }


@dataclass(frozen=True)
class Report:
    """What `check` found. Iterate over it, or look at `.errors`; in a notebook it is a table. Of a
    folder or a list it holds the findings of all files, and `files` has a report of each."""

    path: str
    profile: str  #: "render", "print" or "generated"
    status: str  #: "checked", "partly" or "unreadable"
    findings: Tuple[Finding, ...]
    _time: int = field(default=-1, repr=False, compare=False)
    _parts: Optional[Tuple[Report, ...]] = field(default=None, repr=False)

    @property
    def files(self) -> Tuple[Report, ...]:
        """A report of each file: of one file, the report itself."""
        return (self,) if self._parts is None else self._parts

    def _of(self, severity: str) -> List[Finding]:
        return [finding for finding in self.findings if finding.severity == severity]

    @property
    def errors(self) -> List[Finding]:
        return self._of("error")

    @property
    def warnings(self) -> List[Finding]:
        return self._of("warning")

    @property
    def infos(self) -> List[Finding]:
        return self._of("info")

    @property
    def ok(self) -> bool:
        """Whether the file could be read and has no errors."""
        return self.status != "unreadable" and not self.errors

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.findings)

    def __len__(self) -> int:
        return len(self.findings)

    def to_json(self, indent: Optional[int] = None) -> str:
        """The report as `norma check --format json` writes it (schema norma-check/1)."""
        unreadable = any(file.status == "unreadable" for file in self.files)
        summary = {
            "errors": len(self.errors),
            "warnings": len(self.warnings),
            "infos": len(self.infos),
            "files": len(self.files),
            "not_checked": sum(file.status != "checked" for file in self.files),
            "exit_status": 3 if unreadable else int(bool(self.errors)),
        }
        entries = [
            {
                "path": file.path,
                "profile": file.profile,
                "status": file.status,
                "findings": [_finding_json(finding) for finding in file.findings],
            }
            for file in self.files
        ]
        report = {"schema": "norma-check/1", "files": entries, "summary": summary}
        return json.dumps(report, indent=indent, ensure_ascii=False, allow_nan=False)

    def to_pandas(self) -> Any:
        """The findings as a pandas DataFrame, a row for each; pandas has to be installed."""
        try:
            import pandas  # type: ignore[import]
        except ImportError:
            raise ImportError("to_pandas: pandas is not installed") from None
        columns = ("path", "rule", "name", "severity", "where", "label", "count", "worst_value", "unit", "fix", "message", "command", "mesh")
        return pandas.DataFrame([[getattr(f, column) for column in columns] for f in self.findings], columns=list(columns))

    def __str__(self) -> str:
        if self._parts is not None:
            return "\n".join([*map(str, self._parts), self._verdict()])
        lines = [str(finding) for finding in self.findings if finding.severity != "info"]
        return "\n".join([*lines, self._verdict()])

    def _verdict(self) -> str:
        if self.status == "unreadable" and self._parts is None:
            return f"{self.path}: could not be read"
        counts = [(len(self.errors), "error"), (len(self.warnings), "warning"), (len(self.infos), "info")]
        if not any(count for count, _ in counts):
            return f"{self.path}: no problems found"
        words = ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)
        return f"{self.path}: {words}"

    def _repr_html_(self) -> str:
        """The tool's own HTML report with its pictures, where the file is still as it was checked
        (by its time of change); otherwise a table."""
        page = self._page()
        if page is None:
            return self._table()
        frame = html.escape(page, quote=True)
        return f'<iframe srcdoc="{frame}" style="width:100%;height:36em;border:0" title="{html.escape(self._verdict())}"></iframe>'

    def _page(self) -> Optional[str]:
        tool = tool_path()
        try:
            if not self.findings or self._parts is not None or not os.path.isfile(tool) or os.stat(self.path).st_mtime_ns != self._time:
                return None
            done = subprocess.run(
                [tool, "check", "--no-config", "--info", "--format", "html", "--profile", self.profile, "--", self.path],
                capture_output=True,
                timeout=60,
            )
        except (OSError, subprocess.SubprocessError):
            return None
        return done.stdout.decode("utf-8", "replace") if done.returncode in (0, 1) else None

    def _table(self) -> str:
        colors = {"error": "#b3261e", "warning": "#8a5a00", "info": "#4a5568"}
        rows = "".join(
            f'<tr><td style="color:{colors[f.severity]}">{f.severity}</td>'
            f"<td>{html.escape(f.path)}</td>"
            f"<td>{html.escape(f.rule)} {html.escape(f.name)}</td><td>{html.escape(f.label)}</td>"
            f'<td style="text-align:right">{f.count}</td>'
            f'<td style="text-align:left">{html.escape(f.message)}</td></tr>'
            for f in self.findings
        )
        head = "<tr><th>severity</th><th>file</th><th>rule</th><th>where</th><th>count</th><th>what</th></tr>"
        table = f"<table>{head}{rows}</table>" if rows else ""
        return f"<p><b>{html.escape(self._verdict())}</b></p>{table}"


def _finding_json(finding: Finding) -> Dict[str, Any]:
    worst = {
        "value": finding.worst_value,
        "unit": finding.unit,
        "vertex": finding.worst.vertex,
        "face": finding.worst.face,
        "position": None if finding.worst.position is None else list(finding.worst.position),
    }
    result = {
        "rule": finding.rule,
        "name": finding.name,
        "severity": finding.severity,
        "where": finding.where,
        "count": finding.count,
        "worst": worst,
        "samples": [_sample_json(sample) for sample in finding.samples],
        "fix": finding.fix,
        "command": finding.command,
        "message": finding.message,
        "cause": finding.cause,
        "impact": finding.impact,
    }
    if finding.mesh is not None and finding.severity != "info":
        result["mesh"] = finding.mesh
    if finding.deviation is not None:
        result["deviation"] = _deviation_json(finding.deviation)
    return result


def _command(path: Optional[str], rule: str, fix: Optional[str], profile: str) -> Optional[str]:
    if fix is None or path is None:
        return None
    stem, ending = os.path.splitext(path)
    flag = "--fix" if fix == "safe" else "--fix-unsafe"
    output = shlex.quote(f"{stem}.fixed{ending}")
    alike = "" if profile == "auto" else f" --profile {profile}"
    return f"norma check {shlex.quote(path)} {flag} --select {rule}{alike} -o {output}"


def _without_path(message: str, path: str) -> str:
    """The report names the file already: "PATH:12: " becomes "line 12: "."""
    if not message.startswith(path + ":"):
        return message
    rest = message[len(path) + 1 :]
    line = re.match(r"\d+:", rest)
    return "line " + rest if line else rest.lstrip()


def _finding(parts: Tuple[Any, ...], path: str, unreadable: bool, profile: str, on_disk: bool) -> Finding:
    rule, name, severity, where, label, count, value, unit, worst, samples, fix, message, deviation, mesh, cause, impact = parts
    if unreadable:
        message = _without_path(message, path)
    return Finding(
        rule,
        name,
        _SEVERITIES[severity],
        where,
        label,
        count,
        value if math.isfinite(value) else None,
        unit,
        _sample(worst),
        tuple(_sample(sample) for sample in samples),
        _FIXES[fix],
        message,
        _command(path if on_disk else None, rule, _FIXES[fix], profile),
        _deviation(deviation),
        f"{mesh:016x}" if mesh else None,
        cause,
        impact,
        path,
    )


@dataclass(frozen=True)
class _Settings:
    """The arguments of a check, looked at."""

    profile: str
    kind: int
    strict: bool
    samples: int
    mask: Optional[bytes]
    threads: Optional[int]

    def report(self, path: str, answer: Tuple[Any, ...], unreadable: bool = False, on_disk: bool = True, time: int = -1) -> Report:
        applied, partly, findings = answer
        status = "unreadable" if unreadable else "partly" if partly else "checked"
        found = tuple(_finding(f, path, unreadable, self.profile, on_disk) for f in findings)
        return Report(path, _PROFILE_NAMES[applied], status, found, time)


def check(
    source: Any,
    faces: Faces = None,
    *,
    normals: Optional[ArrayLike] = None,
    name: Optional[str] = None,
    format: Optional[Format] = None,
    profile: Profile = "auto",
    select: Names = None,
    ignore: Names = None,
    strict: bool = False,
    samples: int = 10,
    threads: Optional[int] = None,
) -> Report:
    """Checks the normals of a file, as `norma check` does; configuration files are not read.

    source: a path; a folder, whose files are checked, those in folders below too; a tileset.json, whose
        tiles are; a file's contents as bytes; a document of `norma.open`, as it is now; a mesh as
        `norma.vertex_normals` takes it; a list or another iterable of such, for one report; or positions
        (with `faces`), also as (positions, faces) or (positions, faces, normals).
    faces, normals: of positions; normals are one for each position or for each corner.
    name, format: of bytes, as in `norma.open`. In a list, `format` is that of all bytes, which are
        called by their place: "bytes 2" are the second of the list.
    profile: "render", "print", "generated" or "auto" (print for STL and 3MF).  select, ignore: rules by
        id, beginning of an id ("N3") or name, in a list or with commas.  strict: lengths within 1e-4 of 1.
    A file that is there and cannot be read gives a report with the status "unreadable", and so does one
    of several that is not there.

    >>> import norma_mesh as norma
    >>> norma.check("assets/goathead.obj").ok
    True
    >>> [f.rule for f in norma.check([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals=[[0, 0, 2]] * 3)]
    ['N103', 'N204', 'N304']
    """
    settings = _Settings(profile, choice("profile", profile, PROFILES), bool(strict), count_of("samples", samples, sys.maxsize),
                         mask_of(select, ignore), threads)
    source, faces, normals = unpacked(source, faces, normals)
    if faces is None and isinstance(source, _LISTS):
        source = list(source)
        if not source or not all(isinstance(item, (list, tuple, np.ndarray)) for item in source):
            _refuse_arrays(faces, normals)
            return _check_list(source, format, settings)
    if isinstance(source, (*_PATHS, *_BYTES, Document)):
        _refuse_arrays(faces, normals)
        return _check_named(source, name, format, settings)
    if faces is None and not isinstance(source, (list, np.ndarray)) and not _is_mesh(source):
        raise TypeError(f"path: a path, bytes, or positions and faces are needed, not {type(source).__name__}")
    return _check_arrays(source, faces, normals, settings)


def _is_mesh(source: Any) -> bool:
    return not isinstance(source, (*_PATHS, *_BYTES, Document)) and parts_of(source)[0] is not source


def _refuse_arrays(faces: Faces, normals: Optional[ArrayLike]) -> None:
    if faces is not None or normals is not None:
        raise TypeError(f"{'faces' if faces is not None else 'normals'}: only for positions, not for a file")


def _check_named(source: Any, name: Optional[str], format: Optional[Format], settings: _Settings) -> Report:
    """A path, with all that it stands for, bytes or a document."""
    if isinstance(source, Document):
        return _check_file(source.to_bytes(), settings, name or source.path, source.format)
    if isinstance(source, _PATHS) and not format and (os.path.isdir(bytes_of("path", source)) or is_tileset(source)):
        return _joined(_check_paths(source, settings), os.fsdecode(source), settings)
    return _check_file(source, settings, name, format)


def _check_list(items: List[Any], format: Optional[Format], settings: _Settings) -> Report:
    if not items:
        raise ValueError("path: nothing was given to check, the list is empty")
    parts = [part for place, item in enumerate(items) for part in _check_item(item, place, format, settings)]
    word = "path" if all(isinstance(item, _PATHS) for item in items) else "input"
    return _joined(parts, f"{len(items)} {word}{'' if len(items) == 1 else 's'}", settings)


def _check_item(item: Any, place: int, format: Optional[Format], settings: _Settings) -> List[Report]:
    """The reports of one of a list; a nameless one is called by its place, from 1."""
    if isinstance(item, _PATHS):
        return _check_paths(item, settings)
    if isinstance(item, _BYTES) or (isinstance(item, Document) and item.path == "bytes"):
        return [_check_named(item, f"bytes {place + 1}", format, settings)]
    if isinstance(item, Document):
        return [_check_named(item, None, None, settings)]
    if not _is_mesh(item):
        raise TypeError(f"path[{place}]: a path, bytes, a document or a mesh is needed, not {type(item).__name__}")
    return [_check_arrays(item, None, None, settings, f"arrays {place + 1}")]


def _within(path: Any) -> List[str]:
    """The files of a folder that can be checked, those of a tileset, or the path itself."""
    if is_tileset(bytes_of("path", path)):
        tiles = _norma.tileset_tiles(os.fsencode(path))
        if not isinstance(tiles, list):
            raise_document(tiles)
        return list(dict.fromkeys(map(os.fsdecode, tiles)))
    if not os.path.isdir(bytes_of("path", path)):
        return [os.fsdecode(path)]
    endings = {"." + word for word in FORMATS if word} | {".vrm"}
    found = [os.path.join(folder, file) for folder, _, files in os.walk(os.fsdecode(path)) for file in files]
    return sorted(file for file in found if os.path.splitext(file)[1].lower() in endings)


def _check_paths(path: Any, settings: _Settings) -> List[Report]:
    return [_check_source(Source(file, bytes_of("path", file), None, 0), settings) for file in _within(path)]


def _joined(parts: List[Report], shown: str, settings: _Settings) -> Report:
    if not parts:
        raise FileError(f"{shown}: holds no OBJ, PLY, STL, glTF or 3MF file, nor a tile")
    worst = max((part.status for part in parts), key=("checked", "partly", "unreadable").index)
    profiles = {part.profile for part in parts}
    return Report(shown, profiles.pop() if len(profiles) == 1 else settings.profile, worst,
                  tuple(finding for part in parts for finding in part.findings), -1, tuple(parts))


def _check_file(given: object, settings: _Settings, name: Optional[str] = None, format: Optional[str] = None) -> Report:
    return _check_source(source_of("path", given, name, format), settings)


def _check_source(source: Source, settings: _Settings) -> Report:
    on_disk = source.contents is None and os.path.exists(source.shown)
    time = os.stat(source.shown).st_mtime_ns if on_disk else -1
    answer = _norma.check(source.path, source.contents, source.format, settings.kind, settings.strict, settings.samples,
                          settings.mask, thread_count(settings.threads))
    if isinstance(answer[0], int):
        raise_document(answer)
    return settings.report(source.shown, answer[0], bool(answer[1]), on_disk, time)


def _check_arrays(positions: Any, faces: Faces, normals: Optional[ArrayLike], settings: _Settings, shown: str = "arrays") -> Report:
    if normals is None and isinstance(positions, FileMesh):
        normals = positions.corner_normals
    m = mesh(positions, faces)
    parts: Any = None
    if normals is not None:
        each = np.arange(m.corner_count, dtype=np.uint32)
        rows = np.shape(normals)[:1]
        own = each if rows == (m.corner_count,) and rows != m.positions.shape[:1] else None
        held = attribute("normals", normals, 3, m, own)
        parts = held[2]
    answer = _norma.check_arrays(m.call, options(threads=settings.threads), parts, settings.kind, settings.strict,
                                 settings.samples, settings.mask)
    if len(answer) == 4:
        refuse(answer, m)
    return settings.report(shown, answer, on_disk=False)


def rules() -> List[Rule]:
    """All rules, sorted by id."""
    return [
        Rule(id_, name, _SEVERITIES[render], _SEVERITIES[printed], _FIXES[fix], verb, what, cause, why, how)
        for id_, name, render, printed, fix, verb, what, cause, why, how in _norma.rules()
    ]
