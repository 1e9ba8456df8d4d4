"""Makes the meshes of together.sh, and compares normals by position.

    cut K SEED PREFIX         an ellipsoid, its faces dealt at random into K PLY files, in any order
    halves PREFIX             the same in one glTF of two nodes, one mirrored and stretched, and as PLY
    twice PREFIX              a glTF whose two nodes draw one mesh, side by side, and touch
    levels PREFIX             a glTF with MSFT_lod, one without, and the finer level as PLY
    skin PREFIX               a glTF whose second half has a skin, and the whole as PLY
    locks PREFIX              a glTF whose second half has normals; locked FILE: what it becomes
    steps PREFIX              the same, and they share an edge that bends by 45 degrees
    grid PREFIX               a large height field in two PLY files
    same LIMIT A... -- B...   one normal at each position of A, and of B, at most LIMIT apart
    subset LIMIT A... -- B... the same for the positions that both have
    corners LIMIT A... -- B... the normals of all corners of all faces
    obj A.ply B.obj           as OBJ, without normals
"""
import json
import math
import random
import struct
import sys

ROWS, COLUMNS = 16, 24


def single(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def ellipsoid():
    """Multiples of 1/1024, so that turning and scaling them by powers of two is exact."""
    points, faces, numbers = [], [], {}

    def vertex(i, j):
        at = (0 if i in (0, ROWS) else j % COLUMNS)
        t, p = math.pi * i / ROWS, 2 * math.pi * at / COLUMNS
        place = tuple(round(1024 * x) / 1024 for x in (3 * math.sin(t) * math.cos(p), 2 * math.sin(t) * math.sin(p), math.cos(t)))
        if place not in numbers:
            numbers[place] = len(points)
            points.append(place)
        return numbers[place]

    for i in range(ROWS):
        for j in range(COLUMNS):
            a, b, c, d = vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)
            if 0 < i < ROWS - 1 and (i + j) % 3 == 0:
                faces.append((a, b, c, d))
                continue
            if i < ROWS - 1:
                faces.append((a, b, c))
            if i > 0:
                faces.append((a, c, d))
    return points, faces


def write_ply(name, points, faces, shuffle):
    faces = list(faces)
    shuffle.shuffle(faces)
    used = sorted({v for f in faces for v in f})
    shuffle.shuffle(used)
    number = {v: i for i, v in enumerate(used)}
    with open(name, "wb") as out:
        out.write(("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(used), len(faces))).encode())
        for v in used:
            out.write(struct.pack("<3f", *points[v]))
        for f in faces:
            turn = shuffle.randrange(len(f))
            f = f[turn:] + f[:turn]
            out.write(struct.pack("<B%di" % len(f), len(f), *[number[v] for v in f]))


def cut(k, seed, prefix):
    points, faces = ellipsoid()
    dealer = random.Random(int(seed))
    parts = [[] for _ in range(int(k))]
    for f in faces:
        parts[dealer.randrange(len(parts))].append(f)
    for i, part in enumerate(parts):
        write_ply("%s%d.ply" % (prefix, i), points, part, dealer)


def write_gltf(name, meshes, nodes):
    data, views, accessors, made = b"", [], [], []

    def add(kind, code, rows):
        nonlocal data
        numbers = [x for row in rows for x in row]
        part = struct.pack("<%d%s" % (len(numbers), code), *numbers)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        accessors.append({"bufferView": len(views) - 1, "componentType": {"f": 5126, "I": 5125, "B": 5121}[code], "count": len(rows), "type": kind})
        data += part
        return len(accessors) - 1

    for points, triangles, *more in meshes:
        attributes = {"POSITION": add("VEC3", "f", points)}
        accessors[-1]["min"] = [min(p[k] for p in points) for k in range(3)]
        accessors[-1]["max"] = [max(p[k] for p in points) for k in range(3)]
        if more:
            attributes["NORMAL"] = add("VEC3", "f", more[0])
        if any(node.get("mesh") == len(made) and "skin" in node for node in nodes):
            attributes["JOINTS_0"] = add("VEC4", "B", [(0, 0, 0, 0)] * len(points))
            attributes["WEIGHTS_0"] = add("VEC4", "f", [(1, 0, 0, 0)] * len(points))
        indices = add("SCALAR", "I", [(v,) for t in triangles for v in t])
        made.append({"name": "part%d" % len(made), "primitives": [{"attributes": attributes, "indices": indices}]})
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
            "meshes": made, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data)}]}
    if any("skin" in node for node in nodes):
        tree["skins"] = [{"joints": [len(nodes) - 1]}]
    if any("extensions" in node for node in nodes):
        tree["extensionsUsed"] = ["MSFT_lod"]
        tree["scenes"][0]["nodes"] = [0]
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    with open(name, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


# x' = -2 y + 5, y' = x / 2, z' = -z: turned, stretched and mirrored.
WORLD = [0, 0.5, 0, 0, -2, 0, 0, 0, 0, 0, -1, 0, 5, 0, 0, 1]


def into_node(p):
    return (2 * p[1], (5 - p[0]) / 2, -p[2])


def triangles_of(faces):
    return [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]


def orientation(m):
    return (m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]))


def halves(prefix):
    points, faces = ellipsoid()
    triangles = triangles_of(faces)
    left = [t for t in triangles if sum(points[v][0] for v in t) < 0]
    right = [t for t in triangles if sum(points[v][0] for v in t) >= 0]
    write_ply(prefix + ".ply", points, triangles, random.Random(1))
    meshes = []
    for part, moved in ((left, 0), (right, 1)):
        used = sorted({v for t in part for v in t})
        number = {v: i for i, v in enumerate(used)}
        turned = moved and orientation(WORLD) < 0
        meshes.append(([into_node(points[v]) if moved else points[v] for v in used],
                       [tuple(number[v] for v in (t[::-1] if turned else t)) for t in part]))
    write_gltf(prefix + ".glb", meshes, [{"mesh": 0}, {"mesh": 1, "matrix": WORLD}])


def twice(prefix):
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0)]
    write_gltf(prefix + ".glb", [(points, [(0, 1, 2), (0, 2, 3)])], [{"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}])


def part_of(points, triangles):
    used = sorted({v for t in triangles for v in t})
    number = {v: i for i, v in enumerate(used)}
    return [points[v] for v in used], [tuple(number[v] for v in t) for t in triangles]


def levels(prefix):
    """The second node draws some of the triangles of the first: as its coarser level, or not."""
    points, faces = ellipsoid()
    triangles = triangles_of(faces)
    meshes = [part_of(points, triangles), part_of(points, random.Random(5).sample(triangles, 300))]
    write_ply(prefix + ".ply", points, triangles, random.Random(1))
    write_gltf(prefix + "-two.glb", meshes, [{"mesh": 0}, {"mesh": 1}])
    write_gltf(prefix + ".glb", meshes, [{"mesh": 0, "extensions": {"MSFT_lod": {"ids": [1]}}}, {"mesh": 1}])


def skin(prefix):
    """Two halves; the second has a skin, and its node is elsewhere."""
    points, faces = ellipsoid()
    triangles = triangles_of(faces)
    halves = [[t for t in triangles if (sum(points[v][0] for v in t) < 0) == side] for side in (True, False)]
    write_ply(prefix + ".ply", points, triangles, random.Random(1))
    write_gltf(prefix + ".glb", [part_of(points, half) for half in halves],
               [{"mesh": 0}, {"mesh": 1, "skin": 0, "translation": [100, 0, 0]}, {"name": "joint"}])


LOCKED = (0.6000000238418579, 0, 0.800000011920929)


def locks(prefix):
    points, faces = ellipsoid()
    triangles = triangles_of(faces)
    halves = [[t for t in triangles if (sum(points[v][0] for v in t) < 0) == side] for side in (True, False)]
    first, second = (part_of(points, half) for half in halves)
    write_gltf(prefix + ".glb", [first, second + ([LOCKED] * len(second[0]),)], [{"mesh": 0}, {"mesh": 1}])


def locked(name):
    """Where part1 is, its normals; elsewhere others."""
    normals, meeting = [dict(part) for part in read_glb_nodes(name)], 0
    for at, normal in normals[0].items():
        meeting += at in normals[1]
        if (normal == LOCKED) != (at in normals[1]):
            sys.exit("%s has %s" % (at, normal))
    if meeting < 10 or any(normal != LOCKED for normal in normals[1].values()):
        sys.exit("%d positions meet" % meeting)


def steps(prefix):
    points = [(x, y, min(x, 1)) for x in range(3) for y in range(2)]
    triangles = [t for x in range(2) for t in ((2 * x, 2 * x + 2, 2 * x + 3), (2 * x, 2 * x + 3, 2 * x + 1))]
    write_gltf(prefix + ".glb", [(points, triangles)], [{"mesh": 0}, {"mesh": 0, "translation": [2, 0, 1]}])


def grid(prefix):
    size = 260
    points = [(x / 8, y / 8, math.sin(x * .3) * math.cos(y * .2)) for y in range(size) for x in range(size)]
    faces = [(a, a + 1, a + size + 1, a + size) for y in range(size - 1) for x in range(size - 1) for a in (y * size + x,)]
    write_ply(prefix + ".ply", points, faces, random.Random(3))
    dealer = random.Random(4)
    parts = [[], []]
    for f in faces:
        parts[dealer.randrange(2)].append(f)
    for i in range(2):
        write_ply("%s%d.ply" % (prefix, i), points, parts[i], dealer)


def read_faces(name):
    """The corners of each face: positions with their normals, from the least on."""
    if name.endswith(".obj"):
        points, normals = [], []
        for words in (line.split() for line in open(name)):
            if words[:1] == ["v"]:
                points.append(tuple(single(float(x)) for x in words[1:4]))
            elif words[:1] == ["vn"]:
                normals.append(tuple(float(x) for x in words[1:4]))
            elif words[:1] == ["f"]:
                yield [(points[int(w.split("/")[0]) - 1], normals[int(w.split("/")[2]) - 1]) for w in words[1:]]
        return
    if name.endswith(".glb"):
        yield from read_glb_faces(name)
        return
    vertices = list(read_ply(name))
    body = open(name, "rb").read()
    count = int(body.split(b"element face ")[1].split()[0])
    at = body.index(b"end_header\n") + 11 + 24 * len(vertices)
    for _ in range(count):
        size = body[at]
        yield [vertices[v] for v in struct.unpack_from("<%di" % size, body, at + 1)]
        at += 1 + 4 * size


def read_glb_faces(name):
    raw = open(name, "rb").read()
    length = struct.unpack_from("<I", raw, 12)[0]
    tree, data = json.loads(raw[20:20 + length]), raw[28 + length:]
    vertices = list(read_glb(name))
    base = 0
    for node in tree["nodes"]:
        for primitive in tree["meshes"][node["mesh"]]["primitives"]:
            a = tree["accessors"][primitive["indices"]]
            view = tree["bufferViews"][a["bufferView"]]
            kind = {5121: "B", 5123: "H", 5125: "I"}[a["componentType"]]
            indices = struct.unpack_from("<%d%s" % (a["count"], kind), data, view.get("byteOffset", 0) + a.get("byteOffset", 0))
            turned = orientation(node.get("matrix", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])) < 0
            for i in range(0, a["count"], 3):
                face = [vertices[base + v] for v in indices[i:i + 3]]
                yield face[::-1] if turned else face
            base += tree["accessors"][primitive["attributes"]["POSITION"]]["count"]


def gather_corners(names):
    faces = {}
    for name in names:
        for face in read_faces(name):
            first = face.index(min(face, key=lambda corner: corner[0]))
            face = face[first:] + face[:first]
            faces[tuple(at for at, _ in face)] = [normal for _, normal in face]
    return faces


def corners(*words):
    limit, middle = float(words[0]), words.index("--")
    a, b = gather_corners(words[1:middle]), gather_corners(words[middle + 1:])
    if not a or a.keys() != b.keys():
        sys.exit("the faces are not the same: %d and %d" % (len(a), len(b)))
    worst = max(apart(p, q) for face in a for p, q in zip(a[face], b[face]))
    if worst > limit:
        sys.exit("normals differ by %g" % worst)
    cut = {}
    for face, normals in a.items():
        for at, normal in zip(face, normals):
            cut.setdefault(at, set()).add(normal)
    several = sum(len(normals) > 1 for normals in cut.values())
    if not 0 < several < len(cut):
        sys.exit("%d of %d positions have several normals" % (several, len(cut)))


def obj(source, target):
    body = open(source, "rb").read()
    count = int(body.split(b"element vertex ")[1].split()[0])
    faces = int(body.split(b"element face ")[1].split()[0])
    at = body.index(b"end_header\n") + 11
    with open(target, "w") as out:
        for i in range(count):
            out.write("v %r %r %r\n" % struct.unpack_from("<3f", body, at + 12 * i))
        at += 12 * count
        for _ in range(faces):
            out.write("f %s\n" % " ".join(str(v + 1) for v in struct.unpack_from("<%di" % body[at], body, at + 1)))
            at += 1 + 4 * body[at]


def read_ply(name):
    head, body = open(name, "rb").read().split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    count = [int(line.split()[-1]) for line in lines if line.startswith("element vertex")][0]
    keys = [line.split()[-1] for line in lines if line.startswith("property float")]
    for row in struct.iter_unpack("<%df" % len(keys), body[:4 * len(keys) * count]):
        at = dict(zip(keys, row))
        yield tuple(at[k] for k in ("x", "y", "z")), tuple(at[k] for k in ("nx", "ny", "nz"))


def read_glb(name):
    raw = open(name, "rb").read()
    length = struct.unpack_from("<I", raw, 12)[0]
    tree, data = json.loads(raw[20:20 + length]), raw[28 + length:]

    def numbers(accessor):
        a = tree["accessors"][accessor]
        view = tree["bufferViews"][a["bufferView"]]
        begin = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", 12)
        return [struct.unpack_from("<3f", data, begin + i * stride) for i in range(a["count"])]

    for node in tree["nodes"]:
        if "mesh" not in node:
            continue
        m = node.get("matrix", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        columns = [m[0:3], m[4:7], m[8:11]]
        cofactors = [cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])]
        sign = -1 if orientation(m) < 0 else 1
        for primitive in tree["meshes"][node["mesh"]]["primitives"]:
            for p, n in zip(numbers(primitive["attributes"]["POSITION"]), numbers(primitive["attributes"]["NORMAL"])):
                world = [sum(columns[k][axis] * p[k] for k in range(3)) + m[12 + axis] for axis in range(3)]
                normal = [sign * sum(cofactors[k][axis] * n[k] for k in range(3)) for axis in range(3)]
                length = math.sqrt(sum(x * x for x in normal))
                yield tuple(single(x) for x in world), tuple(x / length for x in normal)


def read_glb_nodes(name):
    """The same for each node that has no matrix, normals as they are stored."""
    vertices = list(read_glb(name))
    raw = open(name, "rb").read()
    tree = json.loads(raw[20:20 + struct.unpack_from("<I", raw, 12)[0]])
    for node in tree["nodes"]:
        count = tree["accessors"][tree["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"]]["count"]
        yield [(at, tuple(single(x) for x in normal)) for at, normal in vertices[:count]]
        vertices = vertices[count:]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def gather(names, limit):
    normals = {}
    for name in names:
        for at, normal in read_glb(name) if name.endswith(".glb") else read_ply(name):
            known = normals.setdefault(at, normal)
            if apart(known, normal) > limit:
                sys.exit("%s: two normals at %s: %s and %s" % (name, at, known, normal))
    return normals


def apart(a, b):
    return max(abs(x - y) for x, y in zip(a, b))


def compare(words, subset):
    limit, words = float(words[0]), words[1:]
    middle = words.index("--")
    within = 1e-6 if any(w.endswith(".glb") for w in words) else 0
    a, b = gather(words[:middle], within), gather(words[middle + 1:], within)
    if not a or (not subset and a.keys() != b.keys()):
        sys.exit("the positions are not the same: %d and %d" % (len(a), len(b)))
    common = a.keys() & b.keys()
    worst = max(apart(a[at], b[at]) for at in common)
    if worst > limit:
        sys.exit("normals differ by %g" % worst)


if __name__ == "__main__":
    verb, rest = sys.argv[1], sys.argv[2:]
    if verb in ("same", "subset"):
        compare(rest, verb == "subset")
    else:
        {"cut": cut, "halves": halves, "twice": twice, "grid": grid, "steps": steps, "levels": levels, "skin": skin, "locks": locks, "locked": locked, "corners": corners, "obj": obj}[verb](*rest)
