"""Creases of a CAD part: splits vertices where faces bend by more than 30 degrees.

    python cad_creases.py part.obj
"""
import sys

import norma_mesh as norma

part = norma.open(sys.argv[1]).meshes[0]
faces, source_vertices, normals = norma.split(part.positions, part.faces, crease=30)
print(f"{len(part.positions)} positions become {len(normals)} vertices with one normal each")
positions = part.positions[source_vertices]
