"""Writes a PLY or STL for tests/mpi: a bumpy grid with repeated positions, vertices of no face and
degenerate faces.  make_file.py PATH SIDE WORD...: big, double, shuffled, polygons, normals, codes
(normals as chars), before (an element before the vertices), number (a property before the list),
tail (an element with lists behind), nan, stl, flat (faces without area, which borrow a direction),
fins (edges of three faces, faces turned round), short (corners of 16 bits), ridges (even slopes
that meet at 36 degrees, each position once)."""

import math
import random
import struct
import sys

path, side, words = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
random.seed(side)
order = ">" if "big" in words else "<"
count = side * side + 3
points = [[v % side + 0.3 * random.random(), v // side + 0.3 * random.random(), random.random()] for v in range(count)]
if "ridges" in words:
    points = [[v % side, v // side, 8 * abs(math.sin(v % side / 25))] for v in range(count)]
for _ in range(count // 10 if "ridges" not in words else 0):
    points[random.randrange(count)] = list(points[random.randrange(count)])
faces = []
for y in range(side - 1):
    for x in range(side - 1):
        a = y * side + x
        faces += [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]]
if "ridges" not in words:
    faces += [[1, 1, 2]] * 5
if "flat" in words:
    points = [[round(c * 256) / 256 for c in point] for point in points]  # exact midpoints
    for a in random.sample(range(side, side * side - 1), side * 2):
        b = a - side + 1
        points[a - 1] = [(p + q) / 2 for p, q in zip(points[a], points[b])]
        faces.append([b, a, a - 1] if a % 2 else [a, b, a - 1])
if "nan" in words:
    points[5][1] = float("nan")
if "fins" in words:
    for face in random.sample(faces, len(faces) // 8):
        faces.append([face[1], face[0], random.randrange(count)])
        random.choice(faces).reverse()
if "shuffled" in words:
    random.shuffle(faces)
if "polygons" in words:
    faces = [f + [random.randrange(count) for _ in range(random.randrange(4))] if random.random() < 0.4 else f for f in faces]

with open(path, "wb") as out:
    if "stl" in words:
        out.write(b"made".ljust(80) + struct.pack("<I", len(faces)))
        for face in faces:
            out.write(struct.pack("<12f", 0, 0, -0.0, *[c for v in face for c in points[v]]) + b"ab")
        sys.exit()
    kind = "double" if "double" in words else "float"
    header = "ply\nformat binary_%s_endian 1.0\ncomment made\n" % ("big" if order == ">" else "little")
    if "before" in words:
        header += "element camera 2\nproperty float q\n"
    header += "element vertex %d\n" % count + "".join("property %s %s\n" % (kind, axis) for axis in "xyz")
    if "normals" in words or "codes" in words:
        header += "".join("property %s n%s\n" % ("char" if "codes" in words else "float", axis) for axis in "xyz")
    header += "property uchar red\nelement face %d\n" % len(faces)
    if "number" in words:
        header += "property int id\n"
    header += "property list uchar %s vertex_indices\n" % ("ushort" if "short" in words else "int")
    if "tail" in words:
        header += "element edge 2\nproperty int a\nproperty list uchar float b\n"
    out.write((header + "end_header\n").encode())
    if "before" in words:
        out.write(struct.pack(order + "2f", 1, 2))
    for number, point in enumerate(points):
        out.write(struct.pack(order + ("3d" if kind == "double" else "3f"), *point))
        if "codes" in words:
            out.write(struct.pack("3b", 1, 2, 3))
        elif "normals" in words:
            out.write(struct.pack(order + "3f", 0, 0, -0.0))
        out.write(bytes([number % 256]))
    for number, face in enumerate(faces):
        if "number" in words:
            out.write(struct.pack(order + "i", number))
        out.write(struct.pack(order + "B%d%s" % (len(face), "H" if "short" in words else "i"), len(face), *face))
    if "tail" in words:
        for number in range(2):
            out.write(struct.pack(order + "iB2f", number, 2, 1.5, 2.5))
