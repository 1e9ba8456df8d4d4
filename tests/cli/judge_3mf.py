"""Turns a tenth of the triangles of each 3MF that it is given, has norma check turn them back, and compares the package with the one before. TAP.
   judge_3mf.py NORMA FOLDER FILE..."""
import ctypes
import os
import random
import re
import struct
import subprocess
import sys
import zipfile

norma, folder, files = sys.argv[1], sys.argv[2], sys.argv[3:]
random.seed(1)
number = failed = 0


def check(name, fine, why=""):
    global number, failed
    number += 1
    failed += not fine
    print(f"{'ok' if fine else 'not ok'} {number} - {name}")
    if not fine:
        print(f"# {why}")


def swapped(tag, one, other):
    first, second = (re.search(rb'\b%s="([^"]*)"' % name, tag) for name in (one, other))
    if not first or not second:
        return tag
    tag = re.sub(rb'\b%s="[^"]*"' % one, b'%s="@"' % one, tag)
    tag = re.sub(rb'\b%s="[^"]*"' % other, b'%s="%s"' % (other, first[1]), tag)
    return tag.replace(b'"@"', b'"%s"' % second[1])


def damage(path, to):
    """The same package with some triangles turned; how many."""
    turned = 0

    def turn(match):
        nonlocal turned
        if random.random() > 0.1:
            return match[0]
        turned += 1
        return swapped(swapped(match[0], b"v2", b"v3"), b"p2", b"p3")

    with zipfile.ZipFile(path) as before, zipfile.ZipFile(to, "w") as after:
        for entry in before.infolist():
            content = before.read(entry)
            if entry.filename.endswith(".model") and entry.filename.startswith("3D/"):
                content = re.sub(rb"<triangle\b[^>]*>", turn, content)
            after.writestr(entry, content, compress_type=entry.compress_type)
    return turned


def listed(path):
    """What unzip lists of the members that hold no model: sizes, method, date, sum."""
    lines = subprocess.run(["unzip", "-v", path], capture_output=True, text=True).stdout.splitlines()
    return [line for line in lines[3:-2] if not line.endswith(".model")]


def packed(path):
    """The bytes of each member as they lie in the archive."""
    with open(path, "rb") as file:
        content = file.read()
    members = {}
    for entry in zipfile.ZipFile(path).infolist():
        name, extra = struct.unpack_from("<HH", content, entry.header_offset + 26)
        begin = entry.header_offset + 30 + name + extra
        members[entry.filename] = content[begin : begin + entry.compress_size]
    return members


try:
    lib3mf = ctypes.CDLL("lib3MF.so.1")
except OSError:
    lib3mf = None


def oriented(path):
    """What lib3mf says of each mesh: vertices, triangles, whether it is manifold and oriented. None: it does not read the file."""
    model, reader, meshes, mesh = (ctypes.c_void_p() for _ in range(4))
    lib3mf.lib3mf_createmodel(ctypes.byref(model))
    lib3mf.lib3mf_model_queryreader(model, b"3mf", ctypes.byref(reader))
    if lib3mf.lib3mf_reader_readfromfileutf8(reader, path.encode()):
        return None
    lib3mf.lib3mf_model_getmeshobjects(model, ctypes.byref(meshes))
    found, more = [], ctypes.c_uint32()
    while lib3mf.lib3mf_resourceiterator_movenext(meshes, ctypes.byref(more)) == 0 and more.value & 255:
        lib3mf.lib3mf_resourceiterator_getcurrent(meshes, ctypes.byref(mesh))
        counts = [ctypes.c_uint32() for _ in range(3)]
        for call, count in zip(("getvertexcount", "gettrianglecount", "ismanifoldandoriented"), counts):
            getattr(lib3mf, f"lib3mf_meshobject_{call}")(mesh, ctypes.byref(count))
        found.append((counts[0].value, counts[1].value, counts[2].value & 255))
    return found


total = 0
for path in files:
    name = os.path.basename(path)
    harmed, fixed = os.path.join(folder, "harmed.3mf"), os.path.join(folder, "fixed.3mf")
    if os.path.exists(fixed):
        os.remove(fixed)
    turned = damage(path, harmed)
    if not turned:
        continue
    total += turned
    run = subprocess.run([norma, "check", harmed, "--fix-unsafe", "--select", "N3", "-o", fixed], capture_output=True, text=True)
    if not os.path.exists(fixed):
        check(f"{name}: {turned} turned triangles are turned back", False, run.stdout + run.stderr)
        continue
    with zipfile.ZipFile(path) as before, zipfile.ZipFile(fixed) as after:
        differ = [entry for entry in before.namelist() if before.read(entry) != after.read(entry)]
        check(f"{name}: {turned} turned triangles are turned back, and its text is what it was", not differ and before.namelist() == after.namelist(), differ)
    old, new = packed(harmed), packed(fixed)
    others = [member for member in old if not member.endswith(".model") and old[member] != new[member]]
    check(f"{name}: other members are packed as they were", not others, others)
    others = listed(harmed)
    check(f"{name}: unzip lists the other members as before", len(others) > 1 and listed(fixed) == others, others)
    test = subprocess.run(["unzip", "-tq", fixed], capture_output=True, text=True)
    check(f"{name}: unzip finds no fault", test.returncode == 0, test.stdout)
    if lib3mf:
        said = oriented(fixed)
        check(f"{name}: lib3mf finds each mesh as it was before", said == oriented(path), said)
print(f"# {total} triangles; lib3mf {'judged' if lib3mf else 'is not there'}")
check("triangles were turned", total > 1000)
print(f"1..{number}")
sys.exit(failed > 0)
