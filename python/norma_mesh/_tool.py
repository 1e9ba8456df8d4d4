"""Where the command-line tool lies that the wheel carries."""
import os


def tool_path() -> str:
    name = "norma.exe" if os.name == "nt" else "norma"
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", name)
