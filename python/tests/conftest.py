# SPDX-License-Identifier: Apache-2.0
"""Real data, a made-up drive, and the command whose answers must be the same."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
from typing import Any, Callable

import numpy as np
import pytest

import estancia

LABELS = ["sofa", "television", "oven", "microwave", "bathtub", "lamp"]
ROOMS = {"living room": [0.55, 0.3, 0.02, 0.02, 0.01, 0.1], "kitchen": [0.02, 0.02, 0.5, 0.4, 0.01, 0.05]}


@pytest.fixture(scope="session")
def data() -> Callable[[str], pathlib.Path]:
    """Folders of real data; without them a test is skipped or, in CI, fails."""
    home = pathlib.Path(os.environ.get("ESTANCIA_DATA", pathlib.Path.home() / ".cache/estancia/data"))

    def folder(name: str) -> pathlib.Path:
        path = home / name
        if not path.exists():
            if os.environ.get("CI") == "true":
                pytest.fail(f"{path} is missing")
            pytest.skip(f"{path} is missing")
        return path

    return folder


@pytest.fixture(scope="session")
def panoramas() -> pathlib.Path:
    home = os.environ.get("ESTANCIA_HOME", pathlib.Path.home() / ".local/share/estancia")
    return pathlib.Path(home) / "panoramas"


@pytest.fixture(scope="session")
def command() -> Callable[..., Any]:
    """Runs the command and gives what it prints as JSON."""
    program = os.environ["ESTANCIA_COMMAND"]

    def run(*arguments: object) -> Any:
        words = [program, *map(str, arguments), "--json"]
        return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)

    return run


@pytest.fixture(scope="session")
def labels() -> estancia.Labels:
    """Twice through a living room and a kitchen, with noise."""
    random = np.random.default_rng(1)
    rows, frames = [], []
    for i in range(80):
        room = list(ROOMS)[i // 20 % 2]
        row = np.abs(np.array(ROOMS[room]) + random.normal(0, 0.01, len(LABELS)))
        rows.append(row / row.sum())
        pose = estancia.Pose.planar(0.1 * (i % 40), 5.0 * (i // 20 % 2), 0.0)
        frames.append(estancia.Frame(f"{i:04}.jpg", 0.1 * i, pose, room))
    return estancia.Labels(np.array(rows), LABELS, frames, "test labels")


@pytest.fixture(scope="session")
def home(labels: estancia.Labels, tmp_path_factory: pytest.TempPathFactory) -> estancia.Map:
    """The map of these labels."""
    path = tmp_path_factory.mktemp("map") / "home.estancia"
    return estancia.map_sequence(labels, path, distance="hellinger", tau_join=0.3, tau_revisit=0.3)


@pytest.fixture
def room_labeler() -> estancia.CallableLabeler:
    """Bright images are kitchens."""

    def look(image: np.ndarray[Any, Any]) -> dict[str, float]:
        light = float(image.mean()) / 255
        return {"oven": light, "sofa": 1 - light}

    return estancia.CallableLabeler(look, ["oven", "sofa"])
