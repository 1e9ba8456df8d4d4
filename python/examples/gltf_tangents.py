"""Tangents of a glTF's meshes with the bits of MikkTSpace, as a normal map needs them.

    python gltf_tangents.py model.glb
"""
import sys

import norma_mesh as norma

for mesh in norma.open(sys.argv[1]).meshes:
    if mesh.normals is None or mesh.texcoords is None:
        print(f"{mesh.where}: no normals or texture coordinates")
        continue
    tangents, report = norma.tangents(
        mesh.positions, mesh.normals, mesh.texcoords, mesh.faces,
        normal_faces=mesh.normal_faces, texcoord_faces=mesh.texcoord_faces, report=True,
    )
    tangents[:, 3] *= -1  # glTF: v runs downwards
    print(f"{mesh.where}: {len(tangents)} corners, {report.degenerate} without texture area")
