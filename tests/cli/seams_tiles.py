"""Makes the tiles of seams.sh and of the farms' tests.

    tiles K SIZE FOLDER       a height field in K x K binary PLY files of SIZE x SIZE squares
"""
import math
import os
import struct
import sys


def height(x, y):
    """Of a multiple of 1/1024, so that both sides of a cut have it exactly."""
    return round(1024 * (3 * math.sin(x / 7) * math.cos(y / 5) + (x * 31 + y * 17) % 5 / 4)) / 1024


def write_tile(name, left, low, size):
    points = [(x, y, height(x, y)) for y in range(low, low + size + 1) for x in range(left, left + size + 1)]
    row, faces = size + 1, []
    for j in range(size):
        for i in range(size):
            a = j * row + i
            faces += [(a, a + 1, a + row + 1), (a, a + row + 1, a + row)]
    with open(name, "wb") as out:
        out.write(("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(points), len(faces))).encode())
        out.write(b"".join(struct.pack("<3f", *p) for p in points))
        out.write(b"".join(struct.pack("<B3i", 3, *f) for f in faces))


def tiles(k, size, folder):
    os.makedirs(folder, exist_ok=True)
    for j in range(int(k)):
        for i in range(int(k)):
            write_tile("%s/t%03d-%03d.ply" % (folder, i, j), i * int(size), j * int(size), int(size))


tiles(*sys.argv[2:])
