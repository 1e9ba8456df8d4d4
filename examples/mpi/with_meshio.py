"""Normals for files that Norma does not read (VTK, VTU, XDMF, CGNS, MED, Gmsh, ...), by way of meshio.

    python3 with_meshio.py IN OUT [COMMAND...]    COMMAND: norma compute --smooth, or mpirun -n 16 norma-mpi compute

Triangles and quads of IN go into a PLY, the command writes its normals, and OUT is IN with them as point data "Normals", in any format that meshio writes. Points and cells stay as they are;
a point that only volume cells use gets (0, 0, 0).
"""
import os
import subprocess
import sys
import tempfile

import meshio
import numpy as np


def write_ply(path, points, blocks):
    """Points as doubles; each block: an array of faces with the same number of corners."""
    with open(path, "wb") as out:
        out.write(("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
                   "element face %d\nproperty list uchar uint vertex_indices\nend_header\n" % (len(points), sum(map(len, blocks)))).encode())
        out.write(points.astype("<f8").tobytes())
        for block in blocks:
            rows = np.empty(len(block), np.dtype([("count", "u1"), ("corners", "<u4", block.shape[1])]))
            rows["count"], rows["corners"] = block.shape[1], block
            out.write(rows.tobytes())


def read_normals(path, count):
    """Of the PLY that Norma wrote: three doubles, then three floats, for each vertex."""
    with open(path, "rb") as file:
        header = iter(file.readline, b"end_header\n")
        lines = [line.split() for line in header]
        names = [words[-1] for words in lines if words[0] == b"property"]
        found = next(int(words[2]) for words in lines if words[:2] == [b"element", b"vertex"])
        if found != count:
            raise SystemExit("%s: %d vertices, where the mesh has %d; creases split vertices, which a file of points cannot hold" % (path, found, count))
        if names[:6] != [b"x", b"y", b"z", b"nx", b"ny", b"nz"]:
            raise SystemExit("%s: expected positions, then normals" % path)
        rows = np.fromfile(file, np.dtype([("position", "<f8", 3), ("normal", "<f4", 3)]), count)
    return rows["normal"]


def main():
    if len(sys.argv) < 3:
        raise SystemExit(__doc__)
    source, target, command = sys.argv[1], sys.argv[2], sys.argv[3:] or ["norma", "compute", "--smooth"]
    mesh = meshio.read(source)
    points = np.zeros((len(mesh.points), 3))
    points[:, :mesh.points.shape[1]] = mesh.points  # 2D files have two coordinates
    blocks = [block.data for block in mesh.cells if block.type in ("triangle", "quad")]
    if not blocks:
        raise SystemExit("%s: has no triangles or quads; take the surface of volume cells first" % source)
    with tempfile.TemporaryDirectory() as folder:
        before, after = os.path.join(folder, "before.ply"), os.path.join(folder, "after.ply")
        write_ply(before, points, blocks)
        subprocess.run([*command, before, "-o", after, "--quiet"], check=True)
        normals = read_normals(after, len(points)).astype(float)
    used = np.zeros(len(points), bool)
    for block in blocks:
        used[block] = True
    normals[~used] = 0
    mesh.point_data["Normals"] = normals
    mesh.write(target)


main()
