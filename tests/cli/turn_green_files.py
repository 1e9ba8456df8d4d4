"""Squares whose normal maps are made for the other convention, and a judge of what norma check
--fix-unsafe makes of them: a PNG codec by the standard library alone.

    turn_green_files.py make          writes the scenes into the current folder
    turn_green_files.py judge OLD NEW every normal map's green channel inverted, nothing else changed
"""
import base64, json, math, os, struct, sys, urllib.parse, zlib

def chunk(name, data): return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

def hills(side):
    rows = []
    for y in range(side):
        row = []
        for x in range(side):
            u, v = (x + .5) / side, (y + .5) / side
            a, b = 18.85 * u + 9 * v, 31 * v
            dx = .5 * math.cos(a) * math.cos(b) + .3 * math.cos(70 * u + 55 * v)
            dy = .5 * (9 / 18.85) * math.cos(a) * math.cos(b) - .5 * (31 / 18.85) * math.sin(a) * math.sin(b) + .3 * (55 / 70) * math.cos(70 * u + 55 * v)
            n = (-dx, -dy, 1)  # green turned: down
            l = math.sqrt(sum(c * c for c in n))
            row.append([c / l for c in n])
        rows.append(row)
    return rows

def samples(normals, depth, alpha):
    top = (1 << depth) - 1
    return [[[round((c + 1) / 2 * top) for c in n] + ([(x * 7 + y) % (top + 1)] if alpha else []) for x, n in enumerate(row)] for y, row in enumerate(normals)]

ADAM7 = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
def pack(rows, depth):
    out = b""
    for row in rows:
        if depth == 16: line = b"".join(struct.pack(">H", s) for p in row for s in p)
        elif depth == 8: line = bytes(s for p in row for s in p)
        else:
            bits = "".join(format(p[0], "0%db" % depth) for p in row); bits += "0" * (-len(bits) % 8)
            line = bytes(int(bits[i:i + 8], 2) for i in range(0, len(bits), 8))
        out += b"\0" + line
    return out
def png(rows, depth, kind, interlaced=False, before=(), after=()):
    h, w = len(rows), len(rows[0])
    if interlaced:
        raw = b""
        for x0, y0, dx, dy in ADAM7:
            part = [row[x0::dx] for row in rows[y0::dy]]
            if part and part[0]: raw += pack(part, depth)
    else: raw = pack(rows, depth)
    z = zlib.compress(raw)
    idat = [chunk(b"IDAT", z[i:i + 3000]) for i in range(0, len(z), 3000)]
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, depth, kind, 0, 0, int(interlaced))) + b"".join(before) + b"".join(idat) + b"".join(after) + chunk(b"IEND", b"")

def chunks(data):
    at, out = 8, []
    while at < len(data):
        n = struct.unpack(">I", data[at:at + 4])[0]
        name, body = data[at + 4:at + 8], data[at + 8:at + 8 + n]
        assert struct.unpack(">I", data[at + 8 + n:at + 12 + n])[0] == zlib.crc32(name + body), name
        out.append((name, body)); at += 12 + n
    return out
def unfilter(raw, at, width, height, bpp, bits):
    stride = (width * bits + 7) // 8; prev = bytes(stride); rows = []
    for _ in range(height):
        f, line = raw[at], bytearray(raw[at + 1:at + 1 + stride]); at += 1 + stride
        for i in range(stride):
            a = line[i - bpp] if i >= bpp else 0; b = prev[i]; c = prev[i - bpp] if i >= bpp else 0
            if f == 1: p = a
            elif f == 2: p = b
            elif f == 3: p = (a + b) // 2
            elif f == 4:
                q = a + b - c; pa, pb, pc = abs(q - a), abs(q - b), abs(q - c)
                p = a if pa <= pb and pa <= pc else b if pb <= pc else c
            else: p = 0
            line[i] = (line[i] + p) & 255
        rows.append(bytes(line)); prev = bytes(line)
    return rows, at
def decode(data):
    cs = chunks(data); w, h, depth, kind, _, _, inter = struct.unpack(">IIBBBBB", cs[0][1])
    n = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[kind]; bits = n * depth; bpp = max(1, bits // 8)
    raw = zlib.decompress(b"".join(b for k, b in cs if k == b"IDAT"))
    def split(line, width):
        if depth == 16: s = struct.unpack(">%dH" % (width * n), line[:width * n * 2])
        elif depth == 8: s = line[:width * n]
        else:
            b = "".join(format(x, "08b") for x in line); s = [int(b[i * depth:(i + 1) * depth], 2) for i in range(width)]
        return [list(s[i * n:(i + 1) * n]) for i in range(width)]
    out = [[None] * w for _ in range(h)]
    at = 0
    for x0, y0, dx, dy in (ADAM7 if inter else [(0, 0, 1, 1)]):
        pw, ph = (w - x0 + dx - 1) // dx, (h - y0 + dy - 1) // dy
        if pw <= 0 or ph <= 0: continue
        rows, at = unfilter(raw, at, pw, ph, bpp, bits)
        for j, line in enumerate(rows):
            for i, p in enumerate(split(line, pw)): out[y0 + j * dy][x0 + i * dx] = p
    return (w, h, depth, kind, inter), out, cs

def square(images, textures, materials, glb=False, views=(), extra=None, name="scene"):
    """One square for each material; images: dicts; views: bytes that become bufferViews 4, 5, ..."""
    body = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0) + struct.pack("<12f", *([0, 0, 1] * 4)) + struct.pack("<8f", 0, 1, 1, 1, 1, 0, 0, 0) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    bv = [dict(buffer=0, byteOffset=0, byteLength=48), dict(buffer=0, byteOffset=48, byteLength=48), dict(buffer=0, byteOffset=96, byteLength=32), dict(buffer=0, byteOffset=128, byteLength=12)]
    for v in views:
        body += b"\0" * (-len(body) % 4); bv.append(dict(buffer=0, byteOffset=len(body), byteLength=len(v))); body += v
    j = dict(asset=dict(version="2.0"), scene=0, scenes=[dict(nodes=list(range(len(materials))))],
        nodes=[dict(mesh=i, translation=[1.5 * i, 0, 0]) for i in range(len(materials))],
        meshes=[dict(primitives=[dict(attributes=dict(POSITION=0, NORMAL=1, TEXCOORD_0=2), indices=3, material=i)]) for i in range(len(materials))],
        accessors=[dict(bufferView=0, componentType=5126, count=4, type="VEC3", min=[0, 0, 0], max=[1, 1, 0]), dict(bufferView=1, componentType=5126, count=4, type="VEC3"), dict(bufferView=2, componentType=5126, count=4, type="VEC2"), dict(bufferView=3, componentType=5123, count=6, type="SCALAR")],
        bufferViews=bv, buffers=[dict(byteLength=len(body))], images=images, textures=textures, materials=materials)
    if extra: j.update(extra)
    if glb:
        t = json.dumps(j).encode(); t += b" " * (-len(t) % 4); body += b"\0" * (-len(body) % 4)
        return b"glTF" + struct.pack("<II", 2, 28 + len(t) + len(body)) + struct.pack("<I", len(t)) + b"JSON" + t + struct.pack("<I", len(body)) + b"BIN\0" + body, None
    j["buffers"][0]["uri"] = name + ".bin"
    return json.dumps(j, indent=1).encode(), body
def write(name, made):
    with open(name, "wb") as file: file.write(made[0])
    if made[1] is not None:
        with open(name.rsplit(".", 1)[0] + ".bin", "wb") as file: file.write(made[1])


# ---- the scenes

N = hills(128)
USE = [dict(normalTexture=dict(index=0))]


def colours(depth=8, alpha=False, **more): return png(samples(N, depth, alpha), depth, 6 if alpha else 2, **more)


def palette(interlaced):
    """Every sixteenth of red and green, blue by the unit length: 256 colours; some half transparent."""
    entries = []
    for i in range(256):
        x, y = (i % 16 - 7.5) / 12, (i // 16 - 7.5) / 12
        l = math.sqrt(x * x + y * y + 1)
        entries.append([round((c / l + 1) * 127.5) for c in (x, y, 1)])
    index = lambda p: [max(0, min(15, round(p[0] / p[2] * 12 + 7.5))) + 16 * max(0, min(15, round(p[1] / p[2] * 12 + 7.5)))]
    plte, trns = chunk(b"PLTE", bytes(c for e in entries for c in e)), chunk(b"tRNS", bytes(range(0, 200)))
    return png([[index(p) for p in row] for row in N], 8, 3, interlaced, [plte, trns])


def make():
    pictures = dict(rgb8=colours(), rgba8=colours(alpha=True), rgb16=colours(16), rgba16=colours(16, True), interlaced=colours(interlaced=True),
        interlaced16=colours(16, True, interlaced=True), palette=palette(False), palette_interlaced=palette(True))
    first = samples(N, 8, False)[40][40]
    pictures["key8"] = colours(before=[chunk(b"tRNS", struct.pack(">3H", *first))])
    pictures["key16"] = colours(16, before=[chunk(b"tRNS", struct.pack(">3H", *samples(N, 16, False)[40][40]))])
    pictures["chunks"] = colours(before=[chunk(b"gAMA", struct.pack(">I", 100000)), chunk(b"sBIT", bytes([8, 8, 8])), chunk(b"pHYs", struct.pack(">IIB", 3, 4, 0)),
        chunk(b"tEXt", b"Comment\0made by hand"), chunk(b"prVt", b"safe to copy"), chunk(b"prVT", b"not safe to copy"), chunk(b"acTL", struct.pack(">II", 1, 0))],
        after=[chunk(b"iTXt", b"Title\0\0\0\0\0hills"), chunk(b"tIME", struct.pack(">HBBBBB", 2020, 1, 2, 3, 4, 5))])
    pictures["no_end"] = colours()[:-12]
    for name, picture in pictures.items():
        with open(name + ".png", "wb") as file: file.write(picture)
        write("file_" + name + ".gltf", square([dict(uri=name + ".png", name=name)], [dict(source=0)], USE, name="file_" + name))
    plain = pictures["rgb8"]
    in_view = dict(bufferView=4, mimeType="image/png")
    write("view.glb", square([in_view], [dict(source=0)], USE, True, [plain]))
    write("view.gltf", square([in_view], [dict(source=0)], USE, views=[plain], name="view"))
    write("data.gltf", square([dict(uri="data:image/png;base64," + base64.b64encode(plain).decode())], [dict(source=0)], USE, name="data"))
    # What else shows it keeps it.
    colour = dict(pbrMetallicRoughness=dict(baseColorTexture=dict(index=0)))
    two = [dict(normalTexture=dict(index=0, scale=1, texCoord=0)), colour]
    for kind, image, views in (("file", dict(uri="rgb8.png"), []), ("view", in_view, [plain])):
        write("texture_shared_" + kind + ".glb", square([image], [dict(source=0, name="n")], two, True, views))
        write("image_shared_" + kind + ".glb", square([image], [dict(source=0), dict(source=0)], [USE[0], dict(emissiveTexture=dict(index=1))], True, views))
    write("both_turned.glb", square([in_view], [dict(source=0)], USE + USE, True, [plain]))
    write("view_shared.glb", square([in_view, dict(in_view)], [dict(source=0), dict(source=1)], [USE[0], dict(occlusionTexture=dict(index=1))], True, [plain]))
    write("own_use.glb", square([in_view], [dict(source=0)], [dict(normalTexture=dict(index=0), occlusionTexture=dict(index=0))], True, [plain]))
    write("other_format.glb", square([in_view, in_view], [dict(source=0, extensions=dict(KHR_texture_basisu=dict(source=1)))], USE, True, [plain], dict(extensionsUsed=["KHR_texture_basisu"])))
    write("dangling.glb", square([in_view], [dict(source=0), dict(source=3)], two, True, [plain]))
    # The name that the new image would get is another's.
    with open("out_normal_0.png", "wb") as file: file.write(pictures["rgba8"])
    write("name_taken.gltf", square([dict(uri="rgb8.png"), dict(uri="out_normal_0.png")], [dict(source=0), dict(source=1)], [USE[0], dict(pbrMetallicRoughness=dict(baseColorTexture=dict(index=1)))], name="name_taken"))
    # Two meshes show the two halves of one map, made for two conventions.
    halves = samples(N, 8, False)
    for row in halves[64:]:
        for p in row: p[1] = 255 - p[1]
    write("halves.gltf", square([dict(uri="halves.png")], [dict(source=0)], [
        dict(normalTexture=dict(index=0, extensions=dict(KHR_texture_transform=dict(offset=[0, .5 * i], scale=[1, .5])))) for i in range(2)],
        extra=dict(extensionsUsed=["KHR_texture_transform"]), name="halves"))
    with open("halves.png", "wb") as file: file.write(png(halves, 8, 2))
    # Two meshes with one material do: there the map cannot become right for both.
    text, body = square([dict(uri="halves.png")], [dict(source=0)], USE + USE, views=[struct.pack("<16f", 0, .5, 1, .5, 1, 0, 0, 0, 0, 1, 1, 1, 1, .5, 0, .5)], name="one_material")
    j = json.loads(text)
    for i, mesh in enumerate(j["meshes"]):
        mesh["primitives"][0].update(material=0, attributes=dict(POSITION=0, NORMAL=1, TEXCOORD_0=4 + i))
        j["accessors"].append(dict(bufferView=4, byteOffset=32 * i, componentType=5126, count=4, type="VEC2"))
    j["materials"].pop()
    write("one_material.gltf", (json.dumps(j).encode(), body))
    write("cut.gltf", square([dict(uri="cut.png")], [dict(source=0)], USE, name="cut"))
    with open("cut.png", "wb") as file: file.write(plain[:len(plain) // 2])


# ---- the judge

def parse(name):
    with open(name, "rb") as file: data = file.read()
    if data[:4] != b"glTF": return json.loads(data), None
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + size]), data[28 + size:]


def bytes_of(j, binary, folder, image):
    def load(uri):
        if uri.startswith("data:"): return base64.b64decode(uri.split(",", 1)[1])
        with open(os.path.join(folder, urllib.parse.unquote(uri)), "rb") as file: return file.read()
    image = j["images"][image]
    if "bufferView" not in image: return load(image["uri"])
    view = j["bufferViews"][image["bufferView"]]
    buffer = j["buffers"][view["buffer"]]
    whole = load(buffer["uri"]) if "uri" in buffer else binary
    start = view.get("byteOffset", 0)
    return whole[start:start + view["byteLength"]]


def seen(data):
    """Each pixel as it is seen: red, green, blue, alpha; and what it is of."""
    header, rows, cs = decode(data)
    parts, top = dict(cs), (1 << header[2]) - 1
    plte, trns = parts.get(b"PLTE"), parts.get(b"tRNS")
    key = list(struct.unpack(">3H", trns)) if trns and header[3] == 2 else None
    def colour(p):
        if header[3] == 3: return tuple(plte[3 * p[0]:3 * p[0] + 3]) + (trns[p[0]] if trns and p[0] < len(trns) else 255,)
        return tuple(p) if len(p) == 4 else tuple(p) + (0 if p == key else top,)
    return header, [[colour(p) for p in row] for row in rows], cs


def judge_image(old, new, turned):
    if not turned:
        assert old == new, "an image that something else shows has changed"
        return
    (h, was, before), (k, now, after) = seen(old), seen(new)
    top = 255 if h[3] == 3 else (1 << h[2]) - 1
    assert h == k, "the kind of the picture: %s, %s" % (h, k)
    assert now == [[(r, top - g, b, a) for r, g, b, a in row] for row in was], "the pixels"
    assert any(g != top - g for row in was for r, g, b, a in row)
    others = lambda cs: [c for c in cs if c[0] not in (b"IDAT", b"PLTE", b"tRNS", b"prVT", b"acTL")]
    if before[-1][0] == b"IEND": assert others(before) == others(after), "the other chunks"
    assert after[-1][0] == b"IEND" and not {b"prVT", b"acTL"} & {c[0] for c in after}


def judge(old, new):
    a, b = parse(old), parse(new)
    count = 0
    def shown(asset, folder, material, path):
        info = material
        for part in path: info = info.get(part, {})
        if "index" not in info: return None
        return bytes_of(*asset, folder, asset[0]["textures"][info["index"]]["source"])
    for before, after in zip(a[0]["materials"], b[0]["materials"]):
        for path in (["normalTexture"], ["pbrMetallicRoughness", "baseColorTexture"], ["emissiveTexture"], ["occlusionTexture"]):
            one, other = shown(a, os.path.dirname(old), before, path), shown(b, os.path.dirname(new), after, path)
            assert (one is None) == (other is None)
            if one is not None:
                judge_image(one, other, path == ["normalTexture"])
                count += 1
    assert count
    used = {t["source"] for t in b[0]["textures"]}
    assert used == set(range(len(b[0]["images"]))), "images that nothing shows"
    for key in a[0]:
        if key not in ("images", "textures", "materials", "buffers", "bufferViews"): assert a[0][key] == b[0][key], key


if __name__ == "__main__":
    if sys.argv[1] == "make": make()
    else: judge(sys.argv[2], sys.argv[3])
