# SPDX-License-Identifier: Apache-2.0
"""Builds the extension of the Python package by CMake; see pyproject.toml.

$ESTANCIA_BUILD_DIR keeps CMake's build folder from one run to the next, CMAKE_ARGS adds options of CMake.
"""

import os
import pathlib
import re
import shlex
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).resolve().parent


class BuildByCMake(build_ext):
    def build_extension(self, ext: Extension) -> None:
        build = pathlib.Path(os.environ.get("ESTANCIA_BUILD_DIR") or self.build_temp).resolve()
        package = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve().parent
        configure = [
            *("cmake", "-S", str(SOURCE), "-B", str(build), "-G", "Ninja"),
            *("-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DESTANCIA_BUILD_PYTHON=ON"),
            *("-DESTANCIA_BUILD_TESTS=OFF", "-DESTANCIA_BUILD_BENCH=OFF", "-DESTANCIA_BUILD_EXAMPLES=OFF"),
            f"-DPython_EXECUTABLE={sys.executable}",
            *shlex.split(os.environ.get("CMAKE_ARGS", "")),
        ]
        subprocess.run(configure, check=True)
        subprocess.run(["cmake", "--build", str(build), "--target", "_estancia"], check=True)
        install = ["cmake", "--install", str(build), "--component", "wheel", "--prefix", str(package)]
        subprocess.run(install, check=True)


numbers = re.findall(r"define ESTANCIA_VERSION_\w+ (\d+)", (SOURCE / "estancia/version.hpp").read_text())
setup(version=".".join(numbers), ext_modules=[Extension("estancia._estancia", [])], cmdclass={"build_ext": BuildByCMake})
