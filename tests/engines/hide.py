"""Copies a GLB without some nodes, for engines that do not survive them.   hide.py IN.glb OUT.glb NODE..."""
import json
import struct
import sys

source, target, *names = sys.argv[1:]
with open(source, "rb") as file:
    data = file.read()
length = struct.unpack_from("<I", data, 12)[0]
document, rest = json.loads(data[20:20 + length]), data[20 + length:]
hidden = {index for index, node in enumerate(document["nodes"]) if node.get("name") in names}
if len(hidden) != len(names):
    sys.exit(f"hide.py: {source} lacks one of {', '.join(names)}")
for scene in document["scenes"]:
    scene["nodes"] = [node for node in scene["nodes"] if node not in hidden]
for node in document["nodes"]:
    if "children" in node:
        node["children"] = [child for child in node["children"] if child not in hidden] or node.pop("children")[:0]
text = json.dumps(document, separators=(",", ":")).encode()
text += b" " * (-len(text) % 4)
with open(target, "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest)
