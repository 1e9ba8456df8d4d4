"""Random arguments, right and wrong: whatever the shape, type, strides and size, a call returns or
raises a ValueError, TypeError or IndexError that begins with an argument's name, or a MemoryError;
it never crashes, and inputs stay as they were. `make python-fuzz` runs it with the address sanitizer.

    fuzz_arguments.py [SECONDS [SEED]]
"""
import random
import re
import sys
import time

import numpy as np

import norma_mesh as norma

KINDS = ["f4", "f8", "f2", ">f4", ">f8", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", ">i4", "c8", "?", "O", "S3", "M8[s]"]
FINE = (ValueError, TypeError, IndexError, MemoryError)
NAMES = "positions faces face_starts out weight weld fallback threads crease non_manifold per mode open smoothing_groups hard_edges " \
    "normals texcoords normal_faces texcoord_faces streams moved model models matrix encoding codes matrices joints weights " \
    "tangents skinned_normals blend"
NAMED = re.compile(rf"({NAMES.replace(' ', '|')})(\[[\d, ]+\])*(: .| is )")


def dressed(r, array):
    """The same numbers with other strides, alignment or rights."""
    way = r.randrange(8)
    if way == 0:
        return np.asfortranarray(array)
    if way == 1 and array.ndim == 2:
        wide = np.zeros((array.shape[0], array.shape[1] + r.randrange(4)), array.dtype)
        wide[:, : array.shape[1]] = array
        return wide[:, : array.shape[1]]
    if way == 2:
        return array[::-1]
    if way == 3:
        return np.repeat(array, 2, 0)[::2]
    if way == 4:
        array = array.copy()
        array.flags.writeable = False
        return array
    if way == 5 and array.dtype.kind in "fiu":
        raw = np.zeros(array.nbytes + 1, np.uint8)
        odd = raw[1:].view(array.dtype).reshape(array.shape) if array.size else array
        if array.size:
            odd[...] = array
        return odd
    if way == 6 and array.ndim == 2 and array.shape[0]:
        return np.broadcast_to(array[:1], array.shape)
    return array


def numbers(r, shape):
    kind = r.choice(KINDS if r.random() < 0.1 else KINDS[:5])
    values = np.random.RandomState(r.randrange(2**31)).randint(-4, 5, shape)
    with np.errstate(all="ignore"):
        array = values.astype(kind)
    if array.dtype.kind == "f" and array.size and r.random() < 0.3:
        array.flat[r.randrange(array.size)] = r.choice([np.nan, np.inf, -np.inf, 1e-40, 3e38])
    return dressed(r, array)


def vectors(r, rows, width):
    if r.random() < 0.1:
        return r.choice([None, [], 3, "text", [[1, 2]], np.zeros((2, 2, 3)), {}, [[0, 0, 0], [1]], object()])
    return numbers(r, (rows, width + (r.random() < 0.05)))


def some_faces(r, positions):
    way = r.randrange(12)
    count = r.randrange(9)
    high = positions + (1 if r.random() < 0.15 else 0)
    low = -1 if r.random() < 0.1 else 0
    draw = np.random.RandomState(r.randrange(2**31))
    if way == 0:
        return r.choice(["soup", None])
    if way == 1:
        return [draw.randint(low, max(high, low + 1), r.randrange(6)).tolist() for _ in range(count)]
    if way == 2:
        corners = draw.randint(low, max(high, low + 1), count)
        starts = np.sort(draw.randint(0, count + 1, r.randrange(5)))
        if r.random() < 0.7:
            starts = np.concatenate([[0], starts, [count]])
        return (corners, starts.astype(r.choice(["i8", "u4", "i4", "u2"])))
    if way == 3 and r.random() < 0.3:
        return r.choice([[], (), "faces", 5, [[0, 1, 2**40]], [[0.5, 1, 2]], np.zeros((2, 3)), (1, 2, 3), [None], [[None]]])
    kind = r.choice(["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", ">i4"])
    with np.errstate(all="ignore"):
        array = draw.randint(low, max(high, low + 1), (count, r.choice([3, 3, 3, 4, 1, 0, 6]))).astype(kind)
    return dressed(r, array)


def some_options(r, names):
    values = {
        "weight": ["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths", "x", None, 3, []],
        "weld": ["exact", "none", 0.5, 0, -1, float("nan"), "far", None, 10**400],
        "fallback": ["zero", "nearest", (0, 0, 1), [0, 1], "x", None, (float("inf"), 0, 0), ("a", 1, 2), [[1], [2, 3]]],
        "threads": [None, 1, 2, 3, 0, -5, 2**40, "two", 1.5],
        "crease": [60, 0, 180, -5, 181, float("nan"), float("inf"), -1e300, None, "a", 10**400],
        "non_manifold": ["hard", "smooth", "x", None, {}],
        "report": [True, False],
        "per": ["vertex", "corner", "face", []],
        "mode": ["mikk", "steady", "x", []],
        "open": ["kept", "rays", "x"],
    }
    good = {"weight": 7, "weld": 4, "fallback": 3, "threads": 4, "crease": 4, "non_manifold": 2, "per": 2, "mode": 2, "open": 2}
    pick = lambda name: r.choice(values[name][: None if r.random() < 0.05 else good.get(name)])
    return {name: pick(name) for name in names if r.random() < 0.4}


def some_out(r, rows, width):
    way = r.randrange(20)
    if way == 0:
        return np.empty((rows, width), np.float32)
    if way == 1:
        return np.empty((rows, width + 3), np.float32)[:, :width]
    if way == 2:
        return r.choice([np.empty((rows + 1, width), np.float32), np.empty((rows, width)), 3, [], np.empty((width, rows), np.float32).T])
    return None


def check_named(error):
    """That the message of a refusal begins with the argument's name."""
    assert isinstance(error, MemoryError) or NAMED.match(str(error)), f"unnamed: {error!r}"


def one(r):
    points = r.randrange(9)
    positions = vectors(r, points, 3)
    faces = some_faces(r, points)
    before = positions.tobytes() if isinstance(positions, np.ndarray) and positions.dtype != object else None
    call = r.randrange(10)
    creased = ["crease", "weight", "weld", "non_manifold", "fallback", "threads", "report"]
    if call == 0:
        norma.face_normals(positions, faces, out=some_out(r, points, 3), **some_options(r, ["weld", "fallback", "threads", "report"]))
    elif call == 1:
        norma.vertex_normals(positions, faces, out=some_out(r, points, 3), **some_options(r, ["weight", "weld", "fallback", "threads", "report"]))
    elif call == 2:
        groups = numbers(r, (r.randrange(9),)) if r.random() < 0.2 else None
        hard = numbers(r, (r.randrange(27),)) if r.random() < 0.2 else None
        norma.corner_normals(positions, faces, smoothing_groups=groups, hard_edges=hard, **some_options(r, creased))
    elif call == 3:
        norma.split(positions, faces, **some_options(r, creased))
    elif call == 4:
        own = {"normal_faces": some_faces(r, points), "texcoord_faces": some_faces(r, points)} if r.random() < 0.3 else {}
        norma.tangents(positions, vectors(r, points, 3), vectors(r, points, 2), faces, **own,
                       **some_options(r, ["mode", "weight", "threads", "report"]))
        norma.index_corners(vectors(r, points, 3), vectors(r, points, 2), **some_options(r, ["threads"]))
    elif call == 5:
        norma.orient(positions, faces, **some_options(r, ["open", "weld", "threads", "report"]))
        surface = (positions, faces, vectors(r, points, 3))
        norma.compare(surface, surface, **some_options(r, ["threads"]))
    elif call == 6:
        plan = norma.Plan(positions, faces, **some_options(r, ["per", "crease", "weld", "non_manifold", "threads"]))
        for _ in range(3):
            moved = numbers(r, (r.randrange(4),)) if r.random() < 0.5 else None
            try:
                plan.update(vectors(r, points, 3), moved, out=some_out(r, points, 3), **some_options(r, ["weight", "fallback", "threads", "report"]))
            except FINE as error:
                check_named(error)
    elif call == 7:
        many = numbers(r, (r.randrange(4), r.choice([3, 4]), r.choice([3, 4])))
        norma.normal_matrices(many)
        norma.normal_matrix(many[0] if len(many) else many)
        norma.matrix_info(many[0] if len(many) else many)
    elif call == 8:
        shape = (points, r.randrange(4))
        skin = norma.Skin(numbers(r, (r.randrange(4), 4, 4)), numbers(r, shape), numbers(r, shape), blend=r.choice(["linear", "dual-quaternion", "none"]))
        turned = skin.normals(positions, out=some_out(r, points, 3), **some_options(r, ["fallback", "threads"]))
        skin.positions(positions, out=some_out(r, points, 3))
        skin.tangents(vectors(r, points, 4), turned, out=some_out(r, points, 4))
    else:
        norma.transform_normals(numbers(r, (3, 3)), positions, out=some_out(r, points, 3))
        encoding = r.choice(["oct8", "oct12", "oct16", "10-10-10-2", "oct9", None])
        norma.decode_normals(norma.encode_normals(positions, encoding), encoding, out=some_out(r, points, 3))
        norma.decode_normals(numbers(r, (points,)), encoding)
    if before is not None:
        assert positions.tobytes() == before, "an input was changed"


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    end = time.monotonic() + seconds
    calls = refused = 0
    while time.monotonic() < end:
        r = random.Random(f"{seed}.{calls}")
        calls += 1
        try:
            one(r)
        except FINE as error:
            refused += 1
            check_named(error)
        except BaseException:
            print(f"call {calls - 1} of seed {seed}:", file=sys.stderr)
            raise
    print(f"{calls} calls, {refused} refused")
    assert calls > refused > 0


main()
