"""Texts of XML, most of them broken a little, as models of 3MFs: those that norma check calls no XML must be those that expat refuses. TAP.
   judge_xml.py NORMA FOLDER"""
import json
import os
import random
import subprocess
import sys
import xml.parsers.expat
import zipfile

norma, folder = sys.argv[1], os.path.join(sys.argv[2], "xml")
random.seed(1)
COUNT, LEAST = 3000, 500
RELS = '<R><Relationship Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/m"/></R>'
HEAD = b"<?xml version='1.0' encoding=\"UTF-8\" standalone='no'?>\n<!-- kept --><?a b?>"
MODEL = b'<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><metadata>%s</metadata><resources/><build/></model>\n<!---->'
SEEDS = [b"<a b='1' c=\"&lt;&#65;x\">t&amp;<d/><![CDATA[x]]]>]]><?pi x?></a>", b"<b:c k=' 1\r\n2\t3'>\xc3\xa9</b:c >&#x20AC;", b"]]&gt; ]] > <e f='>' g=\"'\"/><e></e>"]
BITS = ["<", ">", "/", "?", "!", "--", "]]>", "<![CDATA[", "<!--", "-->", "&", "&lt;", "&#0;", "&#x110000;", "&#55296;", "'", '"', "=", " a='1'", " ", "\r", "\n", "<?xml", "?>", "</a>", "<a>", "<?xml version='1.0'?>", "xml", ":", "-", "1", ".", "\x01", "\uffff"]
BYTES = [bit.encode() for bit in BITS] + [b"\xc3", b"\xa9", b"\xed\xa0\x80", b"\xf5\x80\x80\x80", b"\xc0\x80", b"\xe2\x82"]


def break_a_little(text):
    for _ in range(random.randrange(4)):
        at, to = random.randrange(len(text) + 1), random.randrange(len(text) + 1)
        text = random.choice([text[:at] + text[at + 1 :], text[:at] + random.choice(BYTES) + text[at:], text[:to] + text[at : at + 8] + text[to:]])
    return text


def is_read_by_expat(text):
    try:
        xml.parsers.expat.ParserCreate().Parse(text, True)
        return True
    except xml.parsers.expat.ExpatError:
        return False


os.mkdir(folder)
texts = {}
for number in range(COUNT):
    inner = random.choice(SEEDS)
    text = HEAD + MODEL % break_a_little(inner) if number % 4 else HEAD + break_a_little(MODEL % inner)
    texts[f"{number}.3mf"] = text
    with zipfile.ZipFile(os.path.join(folder, f"{number}.3mf"), "w") as package:
        package.writestr("_rels/.rels", RELS)
        package.writestr("m", text)
said = json.loads(subprocess.run([norma, "check", "--no-config", "--format", "json", folder], capture_output=True, check=False).stdout)
messages = {os.path.basename(file["path"]): " ".join(finding["message"] for finding in file["findings"] if finding["rule"] == "N001") for file in said["files"]}
counts, wrong = {True: 0, False: 0}, []
for name, text in texts.items():
    is_read, message = is_read_by_expat(text), messages[name]
    if message and "is not XML" not in message:  # another fault came first
        continue
    counts[is_read] += 1
    if is_read == bool(message):
        wrong.append((text, message))
print(f"# {counts[True]} texts that expat reads, {counts[False]} that it refuses")
print(f"{'not ok' if wrong else 'ok'} 1 - expat reads the same texts")
for text, message in wrong[:5]:
    print(f"# {text!r}: {message}")
print(f"{'ok' if min(counts.values()) >= LEAST else 'not ok'} 2 - enough of them were judged")
print("1..2")
sys.exit(bool(wrong) or min(counts.values()) < LEAST)
