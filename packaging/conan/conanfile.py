"""Conan 2: `conan create packaging/conan`."""

import re
from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Rivid(ConanFile):
    name = "rivid"
    description = "Identifies the dynamic parameters of robot arms from logs of their motion"
    license = "BSD-3-Clause"
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False]}
    default_options = {"shared": True, "fPIC": True}
    implements = ["auto_shared_fpic"]

    def _project(self) -> Path:
        return Path(self.recipe_folder).resolve().parents[1]

    def set_version(self) -> None:
        text = (self._project() / "CMakeLists.txt").read_text()
        self.version = re.search(r"project\(rivid VERSION ([0-9.]+)", text).group(1)

    def export_sources(self) -> None:
        folders = ("apps", "cmake", "data", "docs", "include", "src", "third_party")
        for pattern in ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "package.xml", *(f"{folder}/*" for folder in folders)):
            copy(self, pattern, self._project(), self.export_sources_folder)

    def requirements(self) -> None:
        self.requires("eigen/[>=3.4 <4]", transitive_headers=True)
        self.requires("libmd/[>=1.0 <2]")
        self.requires("nlopt/[>=2.7 <3]")
        self.requires("orocos-kdl/[>=1.5 <2]")
        self.requires("pugixml/[>=1.13 <2]")
        self.requires("sundials/[>=6.4 <8]")
        self.requires("urdfdom/[>=3.0 <5]")
        for build_only in ("cli11/[>=2.1 <3]", "nlohmann_json/[>=3.11 <4]", "tomlplusplus/[>=3.3 <4]"):
            self.requires(build_only, visible=False)

    def layout(self) -> None:
        cmake_layout(self)

    def generate(self) -> None:
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self, generator="Ninja")
        toolchain.cache_variables["CMAKE_UNITY_BUILD"] = "ON"
        for part in ("TESTS", "EXAMPLES", "BENCHMARKS"):
            toolchain.cache_variables[f"RIVID_BUILD_{part}"] = "OFF"
        toolchain.generate()

    def build(self) -> None:
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self) -> None:
        CMake(self).install()

    def package_info(self) -> None:
        self.cpp_info.libs = ["rivid"]
        self.cpp_info.defines = ["RIVID_LIBRARY"]
        self.cpp_info.set_property("cmake_target_name", "rivid::rivid")
