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
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Tuple

from . import _norma
from ._arguments import WEIGHTS, choice, count_of, given_degrees, thread_count
from ._files import Path, bytes_of, raise_document
from ._selection import PROFILES, Names, mask_of
from ._tool import tool_path

_PROFILE_NAMES = ("auto", "render", "print", "generated")
_SEVERITIES = ("none", "info", "warning", "error")
_SHADINGS = ("default", "crease", "smooth", "flat")
_FIXES = (None, "safe", "unsafe")


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
    """What `check` found in a file. Iterate over it, or look at `.errors`; in a notebook it is a
    table."""

    path: str
    profile: str  #: "render", "print" or "generated"
    status: str  #: "checked", "partly" or "unreadable"
    findings: Tuple[Finding, ...]
    _time: int = field(default=-1, repr=False, compare=False)

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
        summary = {
            "errors": len(self.errors),
            "warnings": len(self.warnings),
            "infos": len(self.infos),
            "files": 1,
            "not_checked": int(self.status != "checked"),
            "exit_status": 3 if self.status == "unreadable" else int(bool(self.errors)),
        }
        entry = {
            "path": self.path,
            "profile": self.profile,
            "status": self.status,
            "findings": [_finding_json(finding) for finding in self.findings],
        }
        report = {"schema": "norma-check/1", "files": [entry], "summary": summary}
        return json.dumps(report, indent=indent, ensure_ascii=False, allow_nan=False)

    def __str__(self) -> str:
        lines = [str(finding) for finding in self.findings if finding.severity != "info"]
        return "\n".join([*lines, self._verdict()])

    def _verdict(self) -> str:
        if self.status == "unreadable":
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
            if not self.findings or not os.path.isfile(tool) or os.stat(self.path).st_mtime_ns != self._time:
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
            f"<td>{html.escape(f.rule)} {html.escape(f.name)}</td><td>{html.escape(f.label)}</td>"
            f'<td style="text-align:right">{f.count}</td>'
            f'<td style="text-align:left">{html.escape(f.message)}</td></tr>'
            for f in self.findings
        )
        head = "<tr><th>severity</th><th>rule</th><th>where</th><th>count</th><th>what</th></tr>"
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


def _command(path: str, rule: str, fix: Optional[str], profile: str) -> Optional[str]:
    if fix is None:
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


def _finding(parts: Tuple[Any, ...], path: str, unreadable: bool, profile: str) -> Finding:
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
        _command(path, rule, _FIXES[fix], profile),
        _deviation(deviation),
        f"{mesh:016x}" if mesh else None,
        cause,
        impact,
    )


def check(
    path: Path,
    *,
    profile: str = "auto",
    select: Names = None,
    ignore: Names = None,
    strict: bool = False,
    samples: int = 10,
    threads: Optional[int] = None,
) -> Report:
    """Checks the normals of a file, as `norma check` does; configuration files are not read.

    profile: "render", "print", "generated" or "auto" (print for STL and 3MF).  select, ignore: rules by id, beginning of
    an id ("N3") or name, in a list or with commas.  strict: lengths within 1e-4 of 1.
    A file that is there and cannot be read gives a report with the status "unreadable".

    >>> import norma_mesh as norma
    >>> norma.check("assets/goathead.obj").ok
    True
    """
    encoded = bytes_of("path", path)
    shown = os.fsdecode(encoded)
    if not os.path.exists(encoded):
        raise FileNotFoundError(2, os.strerror(2), shown)
    kind = choice("profile", profile, PROFILES)
    time = os.stat(encoded).st_mtime_ns
    answer = _norma.check(encoded, kind, bool(strict), count_of("samples", samples, sys.maxsize), mask_of(select, ignore), thread_count(threads))
    if isinstance(answer[0], int):
        raise_document(answer)
    (applied, partly, findings), unreadable = answer
    status = "unreadable" if unreadable else "partly" if partly else "checked"
    found = tuple(_finding(f, shown, bool(unreadable), profile) for f in findings)
    return Report(shown, _PROFILE_NAMES[applied], status, found, time)


def rules() -> List[Rule]:
    """All rules, sorted by id."""
    return [
        Rule(id_, name, _SEVERITIES[render], _SEVERITIES[printed], _FIXES[fix], verb, what, cause, why, how)
        for id_, name, render, printed, fix, verb, what, cause, why, how in _norma.rules()
    ]
