"""Checks a folder in pytest: one test for each file.

    NORMA_ASSETS=assets pytest test_assets.py
"""
import os
from pathlib import Path

import pytest

import norma_mesh as norma

ENDINGS = {".obj", ".ply", ".stl", ".gltf", ".glb"}
FILES = sorted(path for path in Path(os.environ.get("NORMA_ASSETS", "assets")).rglob("*") if path.suffix in ENDINGS)


@pytest.mark.parametrize("path", FILES, ids=str)
def test_normals(path):
    report = norma.check(path)
    assert report.ok, str(report)
