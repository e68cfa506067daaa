# SPDX-License-Identifier: Apache-2.0
"""Object recognition: finds known objects and their 6-DoF poses in point clouds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, List, Mapping

import numpy as np
import numpy.typing as npt

from . import _estancia
from ._common import Progress, progress_callback
from .clouds import PointCloud

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import RecognitionOptions

__all__ = ["Detection", "Detections", "Recognizer", "recognition_presets"]


@dataclass(frozen=True, eq=False)
class Detection:
    """A known object in a pose."""

    model: str
    pose: npt.NDArray[np.float64]
    """T_scene_model, 4×4."""
    center: tuple[float, float, float]
    """Of the object, in the frame of the scene [m]."""
    inliers: int
    confidence: float
    false_alarm_rate: float
    """The probability that a model that is not in this scene has as much evidence; NaN where unknown."""


class Detections(List[Detection]):
    """What was found in a scene, most confident first, and beside that what is not sure."""

    maybe: list[Detection]
    """What has up to ten times the rate of false alarms that is allowed; it does not count as found."""

    def __init__(self, found: Iterable[Detection] = (), maybe: Iterable[Detection] = ()) -> None:
        super().__init__(found)
        self.maybe = list(maybe)


class Recognizer:
    """Looks for models in scenes: :meth:`add_model` once for each object, :meth:`detect` for each scene.

    ``preset``: one of :func:`recognition_presets`. Options: :class:`estancia.options.RecognitionOptions`.

    >>> recognizer = estancia.Recognizer()
    >>> recognizer.add_model("mug", estancia.read_cloud("mug.pcd"))
    >>> for found in recognizer.detect(estancia.read_cloud("table.pcd")):
    ...     print(found.model, found.center)
    """

    def __init__(
        self,
        models: Mapping[str, PointCloud] | None = None,
        *,
        preset: str | None = None,
        **options: Unpack[RecognitionOptions],
    ) -> None:
        self._core: Any = _estancia.Recognizer(preset, dict(options))
        for name, cloud in (models or {}).items():
            self.add_model(name, cloud)

    def add_model(self, name: str, cloud: PointCloud) -> None:
        """Prepares and keeps a model. Raises InvalidInputError on a cloud that is empty or too small to be
        described."""
        self._core.add_model(name, cloud._core)

    def detect(self, scene: PointCloud, *, progress: Progress = False) -> Detections:
        """The detections of all models in a scene, most confident first; ``.maybe``: what is not sure."""
        return Detections(*self._core.detect(scene._core, progress_callback(progress)))


def recognition_presets() -> dict[str, str]:
    """The names of the presets, with what each is for."""
    return dict(_estancia.recognition_presets())
