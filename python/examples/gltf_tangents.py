"""Writes the tangents of a glTF's meshes into it, with the bits of MikkTSpace, as a normal map needs them.

    python gltf_tangents.py model.glb with-tangents.glb
"""
import sys

import norma_mesh as norma

source, target = sys.argv[1:3]
model = norma.open(source)
done = model.tangents(only="missing")
model.save(target)
print(f"{done.primitives} meshes got tangents; {done.left_out} triangles have no normals or texture coordinates")
print(f"{done.vertices_before} vertices became {done.vertices_after}; {done.degenerate} corners have no texture area")
