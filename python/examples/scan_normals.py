"""Normals of a scan: reads a mesh, computes smooth normals by angle, says what had none.

    python scan_normals.py scan.ply out.ply
"""
import sys

import norma_mesh as norma

source, target = sys.argv[1:3]
scan = norma.open(source)
summary = scan.compute(smooth=True)
scan.save(target)
print(f"{summary.faces} faces, {summary.vertices_after} vertices")
print(f"{summary.report.degenerate_faces} faces have no direction, {summary.filled} normals were taken from the nearest vertex")
