"""Builds the extension against the libnorma.a that scripts/python.sh made (NORMA_LIBRARY, with what
it links in NORMA_LINKS). The wheel serves every Python from 3.9 on."""
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
            ["norma_mesh/_norma.c"],
            include_dirs=[str(root / "include")],
            extra_objects=[os.environ["NORMA_LIBRARY"]],
            extra_compile_args=["-std=c11", "-O2", "-Wall", "-Wextra", "-fvisibility=hidden"],
            extra_link_args=["-Wl,--exclude-libs,ALL", *os.environ.get("NORMA_LINKS", "").split()],
            py_limited_api=True,
        )
    ],
    cmdclass={"build_ext": WithoutSuffix},
    options={"bdist_wheel": {"py_limited_api": "cp39"}},
)
