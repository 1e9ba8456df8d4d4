"""`python -m norma_mesh` is the command-line tool itself, which the wheel carries."""
from __future__ import annotations

import os
import subprocess
import sys

from ._tool import tool_path


def main() -> int:
    tool = tool_path()
    if not os.path.isfile(tool):
        print(f"norma_mesh: the command-line tool is not in this installation ({tool} is missing)", file=sys.stderr)
        return 3
    if os.name == "nt":
        return subprocess.call([tool, *sys.argv[1:]])
    os.execv(tool, ["norma", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
