"""Norma for Conan 2. It builds the tree that it lies in: conan create packaging/conan"""

import os

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, rmdir


class NormaConan(ConanFile):
    name = "norma"
    version = "0.1.0"
    license = "MIT"
    description = "Computes, transforms and checks surface normals in OBJ, PLY, STL and glTF files"
    topics = ("normals", "mesh", "gltf", "geometry")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    # files: libnorma, with files and rules; without it, libnorma-core alone.
    options = {"shared": [True, False], "fPIC": [True, False], "files": [True, False], "meshopt": [True, False]}
    default_options = {"shared": False, "fPIC": True, "files": True, "meshopt": True}
    languages = "C"

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "cmake/*", "include/*", "src/*", "web/page/model/*", "docs/man/*", "completions/*"):
            copy(self, pattern, src=root, dst=self.export_sources_folder)

    def config_options(self):
        if self.settings.os == "Windows":
            del self.options.fPIC

    def configure(self):
        if self.options.shared:
            self.options.rm_safe("fPIC")
        if not self.options.files:
            self.options.rm_safe("meshopt")

    def validate(self):
        if self.settings.compiler == "msvc":
            raise ConanInvalidConfiguration("Norma needs gcc or clang (on Windows: mingw-w64)")

    def requirements(self):
        if self.options.get_safe("meshopt"):
            self.requires("meshoptimizer/[>=0.18 <1]")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        variables = toolchain.cache_variables
        variables["NORMA_SHARED"] = bool(self.options.shared)
        variables["NORMA_FILES"] = bool(self.options.files)
        variables["NORMA_TOOL"] = False
        variables["NORMA_WITH_MESHOPTIMIZER"] = "ON" if self.options.get_safe("meshopt") else "OFF"
        variables["NORMA_MESHOPTIMIZER_PACKAGE"] = bool(self.options.get_safe("meshopt"))
        variables["NORMA_WITH_DRACO"] = "OFF"
        variables["NORMA_TESTS"] = "OFF"
        variables["NORMA_BITS"] = "OFF"
        variables["NORMA_EXAMPLES"] = "OFF"
        variables["NORMA_WEB"] = "OFF"
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        for folder in ("share", os.path.join("lib", "cmake"), os.path.join("lib", "pkgconfig")):
            rmdir(self, os.path.join(self.package_folder, folder))

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "norma")
        names = ["core", "norma"] if self.options.files else ["core"]
        for name in names:
            component = self.cpp_info.components[name]
            library = "norma" if name == "norma" else "norma-core"
            component.libs = [library]
            component.set_property("cmake_target_name", "norma::" + name)
            component.set_property("pkg_config_name", library)
            if self.settings.os in ("Linux", "FreeBSD"):
                component.system_libs = ["m", "pthread"]
        if self.options.get_safe("meshopt"):
            self.cpp_info.components["norma"].requires = ["meshoptimizer::meshoptimizer"]
