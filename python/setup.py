"""Builds the extension against the shared libnorma that scripts/python.sh made (NORMA_LIBRARY), which
lies in lib/ of the package. The wheel serves every Python from 3.9 on."""
import os
import re
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

root = Path(os.environ.get("NORMA_SOURCE", Path(__file__).resolve().parent.parent))
header = (root / "include/norma/norma.h").read_text()
version = ".".join(re.findall(r"define NORMA_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", header))


class WithoutSuffix(build_ext):
    """_norma.abi3.so"""

    def get_ext_filename(self, name):  # type: ignore[no-untyped-def]
        return name.replace(".", os.sep) + ".abi3.so" if os.name != "nt" else super().get_ext_filename(name)


setup(
    version=version,
    ext_modules=[
        Extension(
            "norma_mesh._norma",
            sorted(str(path) for path in Path("norma_mesh").glob("*.c")),
            include_dirs=[str(root / "include")],
            extra_objects=[os.environ["NORMA_LIBRARY"]],
            extra_compile_args=["-std=c11", "-O3", "-fno-math-errno", "-Wall", "-Wextra", "-fvisibility=hidden"],
            extra_link_args=["-Wl,-rpath,$ORIGIN/lib"],
            py_limited_api=True,
        )
    ],
    cmdclass={"build_ext": WithoutSuffix},
    options={"bdist_wheel": {"py_limited_api": "cp39"}},
)
