"""Reads acid scenes by the glTF 2.0 specification and compares each subject with its references. It shares nothing with
the program that wrote them.

    acid_reader.py FOLDER            TAP: every cell of norma-acid.glb, and of cells/ID.glb
    acid_reader.py FOLDER --angles   mean angles between the references of each cell
"""
import base64
import json
import math
import os
import re
import struct
import sys
import zlib

COMPONENTS = {5120: ("b", 1), 5121: ("B", 1), 5123: ("H", 2), 5125: ("I", 4), 5126: ("f", 4)}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

# ---- vectors, and matrices as rows


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def linear(m, v):
    return [dot(m[i][:3], v) for i in range(3)]


def point(m, v):
    return [dot(m[i][:3], v) + m[i][3] for i in range(3)]


def cofactors(m):
    a = [row[:3] for row in m[:3]]
    return [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])]


def determinant(m):
    return dot(m[0][:3], cofactors(m)[0])


def degrees(a, b):
    return math.degrees(math.atan2(math.sqrt(dot(cross(a, b), cross(a, b))), dot(a, b)))


def placed(translation, rotation, scale):
    x, y, z, w = rotation
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [[turn[i][j] * scale[j] for j in range(3)] + [translation[i]] for i in range(3)] + [[0, 0, 0, 1]]


# ---- the file


def png_pixels(data):
    """Rows of RGB, eight bits each, not interlaced."""
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", data, at + 8)
            assert (depth, color) == (8, 2), "an 8-bit RGB image"
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw, stride, rows, last = zlib.decompress(packed), 3 * width, [], bytes(3 * width)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up, corner = (row[i - 3] if i > 2 else 0), last[i], (last[i - 3] if i > 2 else 0)
            nearest = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        rows.append(row)
        last = row
    return width, height, rows


class Scene:
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + size])
        self.binary = data[28 + size:]
        self.parents = {child: i for i, node in enumerate(self.json["nodes"]) for child in node.get("children", [])}
        self.names = {node.get("name"): i for i, node in enumerate(self.json["nodes"])}
        assert sorted(self.json["scenes"][0]["nodes"]) == [i for i in range(len(self.json["nodes"])) if i not in self.parents]

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        letter, size = COMPONENTS[accessor["componentType"]]
        width = WIDTHS[accessor["type"]]
        stride = view.get("byteStride", width * size)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        rows = [struct.unpack_from("<%d%s" % (width, letter), self.binary, start + i * stride) for i in range(accessor["count"])]
        if accessor.get("normalized"):
            most = {"b": 127, "B": 255}[letter]
            rows = [[max(x / most, -1) for x in row] for row in rows]
        return [row[0] for row in rows] if width == 1 else [list(row) for row in rows]

    def local(self, node):
        return placed(node.get("translation", [0, 0, 0]), node.get("rotation", [0, 0, 0, 1]), node.get("scale", [1, 1, 1]))

    def world(self, index):
        m = self.local(self.json["nodes"][index])
        return product(self.world(self.parents[index]), m) if index in self.parents else m

    def texture(self, index):
        view = self.json["bufferViews"][self.json["images"][self.json["textures"][index]["source"]]["bufferView"]]
        return png_pixels(self.binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]])

    def matrices(self, index, attributes, count):
        """Of each vertex; a list for each instance."""
        node = self.json["nodes"][index]
        if "skin" in node:
            skin = self.json["skins"][node["skin"]]
            binds = [[[b[4 * j + i] for j in range(4)] for i in range(4)] for b in self.accessor(skin["inverseBindMatrices"])]
            joints = [product(self.world(j), b) for j, b in zip(skin["joints"], binds)]
            weights, numbers = self.accessor(attributes["WEIGHTS_0"]), self.accessor(attributes["JOINTS_0"])
            return [[[[sum(w * joints[j][r][c] for w, j in zip(weights[v], numbers[v]) if w) for c in range(4)] for r in range(4)] for v in range(count)]]
        world = self.world(index)
        instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if instancing:
            parts = [self.accessor(instancing["attributes"][k]) for k in ("TRANSLATION", "ROTATION", "SCALE")]
            return [[product(world, placed(*part))] * count for part in zip(*parts)]
        return [[world] * count]


class Patch:
    """positions, normals, triangles (by position) in the world, front faces counterclockwise; one for each instance."""

    def __init__(self, scene, name, fault=None):
        """fault: the mistake that a renderer makes."""
        index = scene.names[name]
        self.fault = fault
        node = scene.json["nodes"][index]
        mesh = scene.json["meshes"][node["mesh"]]
        primitive = mesh["primitives"][0]
        attributes = primitive["attributes"]
        self.material = scene.json["materials"][primitive["material"]]
        self.indices = scene.accessor(primitive["indices"])
        positions = scene.accessor(attributes["POSITION"])
        normals = scene.accessor(attributes["NORMAL"]) if "NORMAL" in attributes else None
        for target, weight in zip(primitive.get("targets", []), node.get("weights", mesh.get("weights", []))):
            for base, key in ((positions, "POSITION"), (normals, "NORMAL"))[:1 if fault == "normals-not-morphed" else 2]:
                for row, delta in zip(base, scene.accessor(target[key])):
                    row[:] = [a + weight * d for a, d in zip(row, delta)]
        self.colors = scene.accessor(attributes["COLOR_0"]) if "COLOR_0" in attributes else None
        self.positions, self.normals, self.fronts = [], [], []
        for matrices in scene.matrices(index, attributes, len(positions)):
            posed = [point(m, p) for m, p in zip(matrices, positions)]
            mirrored = determinant(scene.world(index) if "skin" in node else matrices[0]) < 0
            order = self.indices if not mirrored else [self.indices[i + k] for i in range(0, len(self.indices), 3) for k in (0, 2, 1)]
            self.positions.append(posed)
            self.fronts.append([unit(cross([b - a for a, b in zip(posed[order[i]], posed[order[i + 1]])],
                                           [b - a for a, b in zip(posed[order[i]], posed[order[i + 2]])])) for i in range(0, len(order), 3)])
            self.normals.append(self.shaded(scene, node, attributes, matrices, normals) if normals else self.smoothed(len(positions)) if fault == "smoothed" else None)

    def smoothed(self, count):
        """Sums of the triangles' area vectors."""
        sums = [[0, 0, 0] for _ in range(count)]
        for i in range(0, len(self.indices), 3):
            a, b, c = (self.positions[-1][v] for v in self.indices[i:i + 3])
            area = cross([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)])
            for v in self.indices[i:i + 3]:
                sums[v] = [x + y for x, y in zip(sums[v], area)]
        return [unit(x) for x in sums]

    def transformed(self, scene, node, m, n, strongest):
        """sign(det) cof(M) n, or what a mistake makes of it."""
        by_normal_matrix = lambda a, v: [(-1 if determinant(a) < 0 else 1) * dot(row, v) for row in cofactors(a)]
        own = scene.local(node)
        if self.fault in ("object-space", "instance-ignored"):
            return n
        if self.fault == "model-matrix":
            return linear(m, n)
        if self.fault == "separate-scale":
            return linear(m, [n[k] / sum(m[i][k] ** 2 for i in range(3)) for k in range(3)])
        if self.fault == "strongest-joint":
            return by_normal_matrix(strongest, n)
        right = by_normal_matrix(m, n)
        if self.fault == "not-normalized":
            return [x / abs(determinant(m)) for x in right]
        if self.fault == "node-applied":
            return by_normal_matrix(own, right)
        if self.fault == "node-not-cancelled":
            back = [dot(column, linear(m, n)) / determinant(own) for column in zip(*cofactors(own))]
            return by_normal_matrix(own, back)
        return [-x for x in right] if self.fault == "reversed" else right

    def shaded(self, scene, node, attributes, matrices, normals):
        """Normals with their map; a mistake is made where it is one."""
        strongest = matrices
        if self.fault == "strongest-joint":
            joints = [scene.world(j) for j in scene.json["skins"][node["skin"]]["joints"]]
            strongest = [joints[max(range(4), key=lambda k: w[k])] for w in scene.accessor(attributes["WEIGHTS_0"])]
        raw = [self.transformed(scene, node, m, n, s) for m, n, s in zip(matrices, normals, strongest)]
        self.lengths = [math.sqrt(dot(n, n)) for n in raw]
        result = [unit(n) for n in raw]
        if "normalTexture" in self.material:
            result = self.mapped(scene, attributes, matrices, result)
        if self.material.get("doubleSided") and self.fronts[-1][0][2] < 0 and self.fault != "not-flipped":
            result = [[-x for x in n] for n in result]
        return result

    def mapped(self, scene, attributes, matrices, normals):
        width, height, rows = scene.texture(self.material["normalTexture"]["index"])
        scale = self.material["normalTexture"].get("scale", 1)
        coordinates = scene.accessor(attributes["TEXCOORD_0"])
        if "TANGENT" in attributes:
            tangents = scene.accessor(attributes["TANGENT"])
        else:
            tangents = self.generated_tangents(scene.accessor(attributes["POSITION"]), coordinates, normals)
        result = []
        for m, n, uv, t in zip(matrices, normals, coordinates, tangents):
            column, row = uv[0] * width - 0.5, uv[1] * height - 0.5
            assert abs(column - round(column)) < 1e-3 and abs(row - round(row)) < 1e-3, "each vertex has a texel"
            texel = [rows[round(row)][3 * round(column) + k] / 255 * 2 - 1 for k in range(3)]
            flip = -1 if determinant(m) < 0 else 1
            tangent = linear(m, t[:3])
            if self.fault == "tangent-by-normal-matrix":
                tangent = [flip * dot(row, t[:3]) for row in cofactors(m)]
            sign = (1 if self.fault == "sign-lost" else t[3]) * (1 if self.fault == "sign-kept" else flip)
            tangent, across = unit(tangent), [x * sign for x in cross(n, unit(tangent))]
            strength = [1, 1, scale] if self.fault == "scale-on-z" else [1, 1, 1] if self.fault == "scale-ignored" else [scale, scale, 1]
            if self.fault == "green-flipped":
                strength[1] = -strength[1]
            texel = [x * y for x, y in zip(texel, strength)]
            result.append(unit([texel[0] * a + texel[1] * b + texel[2] * c for a, b, c in zip(tangent, across, n)]))
        return result

    def generated_tangents(self, positions, coordinates, normals):
        """As MikkTSpace: of each triangle, where u grows, projected to the vertex's plane and weighted by its angle there;
        the sign is that of the texture's area, v running downwards."""
        sums, signs = [[0, 0, 0] for _ in positions], [0] * len(positions)
        for i in range(0, len(self.indices), 3):
            corner = self.indices[i:i + 3]
            for k in range(3):
                a, b, c = corner[k], corner[(k + 1) % 3], corner[(k + 2) % 3]
                e1, e2 = [[q - p for p, q in zip(positions[a], positions[o])] for o in (b, c)]
                (u1, v1), (u2, v2) = [[q - p for p, q in zip(coordinates[a], coordinates[o])] for o in (b, c)]
                area = u1 * -v2 + u2 * v1
                n = normals[a]
                flat = lambda v: [x - dot(n, v) * y for x, y in zip(v, n)]
                along = unit(flat([(x * -v2 + y * v1) * (1 if area > 0 else -1) for x, y in zip(e1, e2)]))
                f1, f2 = unit(flat(e1)), unit(flat(e2))
                angle = math.acos(max(-1, min(1, dot(f1, f2))))
                sums[a] = [s + angle * x for s, x in zip(sums[a], along)]
                signs[a] = 1 if area > 0 else -1
        return [unit(s) + [sign] for s, sign in zip(sums, signs)]


# ---- what is compared

# The lights of the scene, each 30 degrees off +z.
LIGHTS = [[0.5 * math.cos(a), 0.5 * math.sin(a), math.sqrt(0.75)] for a in (0, 2 * math.pi / 3, 4 * math.pi / 3)]


def lit(patch, normal, vertex):
    """What a matt surface shows in the scene's lights."""
    if "KHR_materials_unlit" in patch.material.get("extensions", {}):
        return [0, 0, 0]
    white = patch.material["pbrMetallicRoughness"]["baseColorFactor"]
    color = patch.colors[vertex] if patch.colors else [1, 1, 1]
    return [w * c * min(1, max(0, dot(l, normal))) for w, c, l in zip(white, color, LIGHTS)]


def corner_normals(patch, instance):
    """A row for each corner of a triangle: what flat and smooth patches have in common."""
    normals, fronts = patch.normals[instance], patch.fronts[instance]
    return [normals[v] if normals else fronts[i // 3] for i, v in enumerate(patch.indices)]


def corner_positions(patch, instance):
    return [patch.positions[instance][v] for v in patch.indices]


def compare_with_right(subject, instance, right, center):
    """Largest distance in shares of the patch's side, largest angle, whether fronts are seen."""
    def canonical(patch, which, origin):
        rows = {}
        for i, (p, n) in enumerate(zip(corner_positions(patch, which), corner_normals(patch, which))):
            p = [a - b for a, b in zip(p, origin)]
            triangle = i // 3
            rows.setdefault(triangle, []).append((p, n))
        keyed = {}
        for triangle in rows.values():
            middle = tuple(round(sum(p[k] for p, _ in triangle) / 3 * 1000) for k in range(2))
            keyed[middle] = triangle
        return keyed
    ours, theirs = canonical(subject, instance, center[0]), canonical(right, 0, center[1])
    assert len(ours) == len(theirs) >= 1900, "triangles"
    side = max(abs(p[k]) for t in theirs.values() for p, _ in t for k in range(2)) * 2
    distance = angle = 0
    for key, triangle in theirs.items():
        x, y = key
        other = next((ours[(x + i, y + j)] for i in (0, -1, 1) for j in (0, -1, 1) if (x + i, y + j) in ours), None)
        if other is None:
            return math.inf, math.inf
        for p, n in triangle:
            q, m = min(other, key=lambda corner: sum((a - b) ** 2 for a, b in zip(p[:2], corner[0][:2])))
            distance = max(distance, math.sqrt(sum((a - b) ** 2 for a, b in zip(p, q))) / side)
            angle = max(angle, degrees(n, m))
    return distance, angle


def brightness_differs(wrong, reference):
    """How far the lights' colours on the reference of not-normalized are from those of normals of the wrong length."""
    white, most = wrong.material["pbrMetallicRoughness"]["baseColorFactor"][0], 0
    for v, (n, length) in enumerate(zip(wrong.normals[0], wrong.lengths)):
        for l, shown in zip(LIGHTS, lit(reference, n, v)):
            most = max(most, abs(shown - white * min(1, length * max(0, dot(l, n)))))
    return most


def faces_viewer(patch, instance):
    return all(f[2] > 0 for f in patch.fronts[instance]) or (
        patch.material.get("doubleSided", False) and all(f[2] < 0 for f in patch.fronts[instance]))


def difference(a, b):
    """Mean angle between two references, of their corners or over what is seen of them, whichever is less, and the mean
    difference of what they show, 0 to 1 (0.06: as 15 degrees)."""
    na, nb = corner_normals(a, 0), corner_normals(b, 0)
    angle = sum(degrees(x, y) for x, y in zip(na, nb)) / len(na)
    seen = whole = 0
    p = corner_positions(a, 0)
    for i in range(0, len(p), 3):
        area = abs(cross([q - o for o, q in zip(p[i], p[i + 1])], [q - o for o, q in zip(p[i], p[i + 2])])[2])
        middle = [[sum(x) for x in zip(*n[i:i + 3])] for n in (na, nb)]
        seen, whole = seen + area * degrees(*middle), whole + area
    angle = min(angle, seen / whole)
    shown = sum(abs(p - q) for x, y, v, w in zip(na, nb, a.indices, b.indices) for p, q in zip(lit(a, x, v), lit(b, y, w))) / len(na) / 3
    white = a.material["pbrMetallicRoughness"]["baseColorFactor"][0]
    return angle, shown / (white or 1)


def painted(patch, picture):
    """By how many levels a picture of the page is off what the lights show in the middle of each triangle, on average."""
    width, height, rows = png_pixels(base64.b64decode(picture))
    white, off = patch.material["pbrMetallicRoughness"]["baseColorFactor"][0], []
    low, high = [[f(p[k] for p in patch.positions[0]) for k in range(2)] for f in (min, max)]
    positions, normals = corner_positions(patch, 0), corner_normals(patch, 0)
    for i in range(0, len(positions), 3):
        x, y = [(sum(p[k] for p in positions[i:i + 3]) / 3 - low[k]) / (high[k] - low[k]) for k in range(2)]
        row, column, n = rows[int((1 - y) * height)], int(x * width), unit([sum(x) for x in zip(*normals[i:i + 3])])
        colors = zip(*(patch.colors[v] for v in patch.indices[i:i + 3])) if patch.colors else [[3 * white]] * 3
        off += [abs(row[3 * column + k] - 255 * math.sqrt(sum(c) / 3 * max(0, dot(l, n)))) for k, (l, c) in enumerate(zip(LIGHTS, colors))]
    return sum(off) / len(off)


def center_of(place, half):
    return [(place["center"][0] - 0.5) * 2 * half[0], (0.5 - place["center"][1]) * 2 * half[1], 0]


def main():
    folder, angles_only = sys.argv[1], "--angles" in sys.argv
    layout = json.load(open(os.path.join(folder, "acid.json")))
    tests = 0

    def report(passed, name, detail=""):
        nonlocal tests
        tests += 1
        print("%s %d - %s" % ("ok" if passed else "not ok", tests, name))
        if not passed or detail:
            print("# " + detail)

    whole = Scene(os.path.join(folder, layout["scene"]))
    first = layout["cells"][0]
    page = open(os.path.join(folder, "index.html")).read()
    plain = Patch(whole, first["id"] + " right")
    bent = [degrees(n, plain.fronts[0][i // 3]) for i, n in enumerate(corner_normals(plain, 0))]
    report(max(bent) < 12 and sum(bent) / len(bent) < 3, "normals are those of the surface", "%.1f degrees from its faces at most" % max(bent))
    steepest = max(degrees(n, [0, 0, 1]) for n in plain.normals[0])
    report(45 < steepest <= 60, "normals are up to 60 degrees from +z", "%.1f" % steepest)
    for cell in layout["cells"]:
        name = cell["id"]
        scenes = [(whole, cell, "")] if angles_only else [(whole, cell, ""), (Scene(os.path.join(folder, cell["file"])), cell["alone"], ", alone")]
        for scene, places, which in scenes:
            camera = next(c for c in scene.json["cameras"] if c["type"] == "orthographic")["orthographic"]
            half = (camera["xmag"], camera["ymag"])
            subject = Patch(scene, name + " subject")
            right = Patch(scene, name + " right")
            instance = len(subject.positions) - 1
            centers = center_of(places["subject"], half), center_of(places["references"][0], half)
            if not angles_only:
                distance, angle = compare_with_right(subject, instance, right, centers)
                report(distance < 1e-3 and angle < 0.05 and faces_viewer(subject, instance),
                       "%s%s: the subject is the right reference" % (name, which), "%.2g of its size, %.4f degrees" % (distance, angle))
            if which:
                continue
            if not angles_only and name not in ("flat", "flattened"):
                distance, angle = compare_with_right(right, 0, plain, (centers[1], center_of(first["references"][0], half)))
                coarse = name == "quantized"
                mapped = "normalTexture" in subject.material
                report((mapped or distance < 1e-3) and (name == "normal-scale" or angle < (1 if coarse or mapped else 0.05)),
                       "%s: the surface is every cell's" % name, "%.2g of its size, %.4f degrees" % (distance, angle))
            for place in places["references"][1:]:
                reference = Patch(scene, name + " " + place["id"])
                if place["id"] == "lost":
                    continue
                wrong = Patch(scene, name + " subject", place["id"])
                distance, angle = compare_with_right(wrong, instance, reference, (centers[0], center_of(place, half)))
                shown = brightness_differs(wrong, reference) if place["id"] == "not-normalized" else 0
                if not angles_only:
                    report(distance < 1e-3 and angle < 0.05 and shown < 1e-3, "%s: %s is what that mistake makes of the subject" % (name, place["id"]),
                           "%.2g of its size, %.4f degrees" % (distance, angle))
            pictures = re.findall('<img alt="" src="data:image/png;base64,([^"]*)"><figcaption>([a-z-]*)<', page.split('<h2 id="%s">' % name)[1].split("<h2")[0])
            report([place["id"] for place in places["references"]] == [of for _, of in pictures], name + ": the page has a picture of each reference")
            for picture, of in pictures:
                off = painted(Patch(scene, name + " " + of), picture)
                report(off < 12, "%s: the page's picture of %s" % (name, of), "%.1f of 255 levels" % off)
            references = [right] + [Patch(scene, name + " " + r["id"]) for r in places["references"][1:]]
            for i, a in enumerate(references):
                for j in range(i):
                    angle, shown = difference(references[j], a)
                    report(angle >= 15 or shown >= 0.15, "%s: %s and %s can be told apart" % (name, places["references"][j]["id"], places["references"][i]["id"]),
                           "%.1f degrees, %.2f of what white shows" % (angle, shown))
    print("1..%d" % tests)


main()
