# SPDX-License-Identifier: Apache-2.0
"""Objects that label themselves: samples from drives, shape classifiers trained on an image classifier's labels."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence as SequenceOf, cast

from . import _estancia
from ._common import Depth, FloatArray, Image, Path, Progress, progress_callback
from .geometry import Camera, Pose
from .labelers import Labeler
from .labels import Labels
from .sequences import Sequence

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import CollectOptions, PredictOptions, TrainingOptions

__all__ = [
    "Collected",
    "ObjectModel",
    "ObjectPredictor",
    "PredictedObject",
    "collect_objects",
    "read_object_model",
    "train_object_model",
]


@dataclass(frozen=True)
class Collected:
    """What :func:`collect_objects` did."""

    frames: int
    samples: int
    instances: int
    flat: int
    at_border: int
    problems: list[str]
    """Sentences about frames that were skipped."""


def collect_objects(
    sequence: Sequence,
    folder: Path,
    *,
    progress: Progress = False,
    **options: Unpack[CollectOptions],
) -> Collected:
    """Segments each frame of a sequence with depth into objects, tracks them, and writes images and clouds of them into
    a new folder. Options: :class:`estancia.options.CollectOptions`. Raises ExistingFileError unless ``replace``."""
    done = _estancia.collect_objects(sequence._core, os.fspath(folder), dict(options), progress_callback(progress))
    return cast(Collected, done)


class ObjectModel:
    """A classifier of 3-D shapes with its target classes. Made by :func:`train_object_model` and
    :func:`read_object_model`."""

    def __init__(self, core: Any, problems: SequenceOf[str] = ()) -> None:
        self._core = core
        self.problems = list(problems)
        """Sentences about views that were left out of the training."""

    def __repr__(self) -> str:
        return f"<estancia.ObjectModel: {', '.join(self.classes)}>"

    @property
    def classes(self) -> list[str]:
        """The target classes."""
        return cast("list[str]", self._core.classes)

    @property
    def labeler(self) -> str:
        """Identity of the labeler of the training data; "" for a person."""
        return cast(str, self._core.labeler)

    @property
    def choice(self) -> str:
        """Parameters and their cross-validation accuracy."""
        return cast(str, self._core.choice)

    @property
    def held_out_accuracy(self) -> FloatArray:
        """Of each predicted class on held-out instances; -1 where unknown."""
        return cast(FloatArray, self._core.held_out_accuracy)

    def write(self, file: Path) -> None:
        """Writes the model, whole or not at all."""
        self._core.write(os.fspath(file))


def read_object_model(file: Path) -> ObjectModel:
    """Reads what ``estancia objects train`` or :meth:`ObjectModel.write` wrote. Raises FileError."""
    return ObjectModel(_estancia.read_object_model(os.fspath(file)))


def train_object_model(
    folders: Path | SequenceOf[Path],
    labels: Labels | SequenceOf[Labels] = (),
    *,
    classes: Path | None = None,
    progress: Progress = False,
    **options: Unpack[TrainingOptions],
) -> ObjectModel:
    """Learns the shapes of views in folders (of :func:`collect_objects`, or a data set) from the labels of their
    images; without labels, from their true categories. ``classes``: a TOML file of target classes; by default the words
    that several objects surely have and their shapes confirm, or the categories. Options:
    :class:`estancia.options.TrainingOptions`."""
    paths = [folders] if isinstance(folders, (str, os.PathLike)) else list(folders)
    given = [labels] if isinstance(labels, Labels) else list(labels)
    core, problems = _estancia.train_object_model(
        [os.fspath(path) for path in paths],
        [each._core for each in given],
        None if classes is None else os.fspath(classes),
        dict(options),
        progress_callback(progress),
    )
    return ObjectModel(core, problems)


@dataclass(frozen=True, eq=False)
class PredictedObject:
    """One object in one frame."""

    instance: int
    """Number of the tracked object in the sequence."""
    views: int
    box: tuple[int, int, int, int]
    """x, y, width, height in the image [pixels]."""
    label: str
    """The class by image and shape, of all views so far; "" for none of them."""
    probability: float
    why: str
    image: FloatArray
    """Probabilities of the classes by this view's image; empty without an answer."""
    shape: FloatArray
    """The same by its shape."""
    problem: str


class ObjectPredictor:
    """Classifies the objects of each frame by image, by shape, and by their late fusion.

    Without a ``labeler`` only shapes are classified. Options: :class:`estancia.options.PredictOptions`.
    """

    def __init__(self, model: ObjectModel, labeler: Labeler | None = None, **options: Unpack[PredictOptions]) -> None:
        self._model = model
        self._core: Any = _estancia.ObjectPredictor(model._core, labeler and labeler._core, dict(options))

    def predict(self, image: Image, depth: Depth, camera: Camera, pose: Pose | None = None) -> list[PredictedObject]:
        """The objects of the next frame."""
        found = self._core.predict(self._model._core, image, depth, camera, pose)
        return cast("list[PredictedObject]", found)
