# SPDX-License-Identifier: Apache-2.0
"""The package itself: types, docstrings, options, examples and the tutorial."""

from __future__ import annotations

import inspect
import os
import pathlib
import re
import subprocess
import sys
import typing

import numpy as np
import pytest

import estancia
import estancia.options

SOURCE = pathlib.Path(os.environ["ESTANCIA_SOURCE"])
PUBLIC = [getattr(estancia, name) for name in estancia.__all__ if callable(getattr(estancia, name))]


def members() -> list[tuple[str, object]]:
    found = []
    for public in PUBLIC:
        found.append((public.__name__, public))
        if inspect.isclass(public):
            for name, member in vars(public).items():
                if not name.startswith("_") and (callable(member) or isinstance(member, (property, staticmethod))):
                    found.append((f"{public.__name__}.{name}", member))
    return found


@pytest.mark.parametrize(("name", "member"), members(), ids=lambda value: value if isinstance(value, str) else "")
def test_everything_public_has_types_and_a_docstring(name: str, member: object) -> None:
    function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
    assert inspect.getdoc(member), f"{name} has no docstring"
    if inspect.isclass(function):
        return
    signature = inspect.signature(typing.cast("typing.Callable[..., object]", function))
    assert signature.return_annotation is not inspect.Signature.empty, f"{name} does not say what it returns"
    for parameter in signature.parameters.values():
        assert parameter.name == "self" or parameter.annotation is not inspect.Parameter.empty, f"{name}: {parameter}"


def test_all_of_the_surface_is_listed_once() -> None:
    assert len(estancia.__all__) == len(set(estancia.__all__)) > 100
    assert (pathlib.Path(estancia.__file__).parent / "py.typed").exists()


def test_type_checkers_agree() -> None:
    pytest.importorskip("mypy")
    checked = [SOURCE / "python/estancia", *sorted((SOURCE / "python/examples").glob("*.py"))]
    for paths in ([checked[0]], *[[example] for example in checked[1:]]):
        done = subprocess.run(
            [sys.executable, "-m", "mypy", "--strict", "--enable-incomplete-feature=Unpack", *map(str, paths)],
            capture_output=True,
            text=True,
            env={**os.environ, "MYPYPATH": str(SOURCE / "python")},
            cwd=os.environ.get("TMPDIR", "/tmp"),
        )
        assert done.returncode == 0, done.stdout


def test_the_options_are_those_that_are_declared() -> None:
    done = subprocess.run(
        [sys.executable, str(SOURCE / "python/generate_options.py")], capture_output=True, text=True, check=True
    )
    written = (SOURCE / "python/estancia/options.py").read_text()
    assert written == done.stdout, "python/estancia/options.py is not up to date; run python/generate_options.py"


def test_every_option_that_a_docstring_names_exists() -> None:
    for public in PUBLIC:
        for name in re.findall(r"estancia\.options\.(\w+)", inspect.getdoc(public) or ""):
            assert hasattr(estancia.options, name), f"{public.__name__} names estancia.options.{name}"


def test_the_version_is_that_of_the_library() -> None:
    header = (SOURCE / "estancia/version.hpp").read_text()
    assert estancia.__version__ == ".".join(re.findall(r"define ESTANCIA_VERSION_\w+ (\d+)", header))


def run(*arguments: object, folder: pathlib.Path) -> str:
    done = subprocess.run(
        [sys.executable, "-P", *map(str, arguments)], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_code_of_the_guide_runs(tmp_path: pathlib.Path) -> None:
    guide = (SOURCE / "docs/how-to/python.md").read_text()
    code = "\n".join(re.findall(r"```python\n(.*?)```", guide, re.DOTALL))
    (tmp_path / "guide.py").write_text(code)
    printed = run("guide.py", folder=tmp_path)
    assert "window" in printed and "2 places" in printed


def test_the_examples_run(panoramas: pathlib.Path, tmp_path: pathlib.Path) -> None:
    examples = SOURCE / "python/examples"
    estancia.PointCloud(np.random.default_rng(1).normal(size=(4000, 3))).write(tmp_path / "in.ply")
    assert "place" in run(examples / "01_first_map.py", panoramas, "home.estancia", "sofa", folder=tmp_path)
    assert "</html>" in (tmp_path / "home.html").read_text()
    assert "place" in run(examples / "06_localize.py", "home.estancia", panoramas, folder=tmp_path)
    assert "places" in run(examples / "03_your_own_labeler.py", panoramas, "own.estancia", folder=tmp_path)
    assert "zone 0" in run(examples / "04_zones.py", panoramas, folder=tmp_path)
    assert "neurons" in run(examples / "08_denoise_a_cloud.py", "in.ply", "out.ply", folder=tmp_path)
    assert "Friedman" in run(examples / "10_compare_methods.py", folder=tmp_path)


def test_the_examples_of_real_data_run(
    data: typing.Callable[[str], pathlib.Path], panoramas: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    examples = SOURCE / "python/examples"
    kinect = data("shot_kinect")
    found = run(
        examples / "07_find_objects.py", kinect / "meshes/Frog012_0.ply", kinect / "scenes/scene039.pcd", folder=tmp_path
    )
    assert "confidence" in found
    assert "things" in run(examples / "09_segment_and_track.py", data("sevenscenes_redkitchen"), 3, folder=tmp_path)
    image = sorted(data("nyuv2_half").rglob("*.jpg"))[0]
    assert "%" in run(examples / "02_label_an_image.py", image, folder=tmp_path)
    assert "%" in run(examples / "05_name_rooms.py", panoramas, image, folder=tmp_path)
