"""Writes the tangents of a glTF's meshes into it, with the bits of MikkTSpace, as a normal map needs them.

    python gltf_tangents.py model.glb with-tangents.glb
"""
import sys

import norma_mesh as norma

def counted(count: int, one: str, more: str) -> str:
    return f"{count} {one if count == 1 else more}"


source, target = sys.argv[1:3]
model = norma.open(source)
done = model.tangents(only="missing")
model.save(target)
print(f"{counted(done.primitives, 'primitive', 'primitives')} got tangents; "
      f"{counted(done.left_out, 'primitive has', 'primitives have')} no normals or no texture coordinates")
print(f"{counted(done.vertices_before, 'vertex', 'vertices')} became {done.vertices_after}; "
      f"{counted(done.degenerate, 'corner has', 'corners have')} no texture area")
