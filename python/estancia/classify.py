# SPDX-License-Identifier: Apache-2.0
"""Classifiers: of rooms by images or labels, and of any numbers, in the manners of scikit-learn."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Sequence as SequenceOf, cast

import numpy as np
import numpy.typing as npt

from . import _estancia
from ._common import Depth, FloatArray, Image, Path, Progress, progress_callback
from .errors import Error
from .geometry import Camera
from .labels import Labels
from .maps import RoomProbability
from .sequences import Frame, Sequence

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import ClassifierOptions

__all__ = [
    "Classifier",
    "Features",
    "RoomClassifier",
    "describe_image",
    "describe_sequence",
    "read_room_classifier",
    "rooms_by_name",
    "train_room_classifier",
]


class Features:
    """Frames with their descriptors. Made by :func:`describe_sequence` or of :class:`Labels`."""

    def __init__(self, labels: Labels) -> None:
        self._core = _estancia.features_of_labels(labels._core)

    @classmethod
    def _of(cls, core: Any) -> Features:
        features = cls.__new__(cls)
        features._core = core
        return features

    def __len__(self) -> int:
        return len(self._core)

    def __repr__(self) -> str:
        return f"<estancia.Features {self.name!r}: {len(self)} × {self.values.shape[1]}>"

    @property
    def name(self) -> str:
        """ "inception-v3+gist"."""
        return cast(str, self._core.name)

    @property
    def values(self) -> FloatArray:
        """N×D, float32; a view that cannot be written."""
        return cast(FloatArray, self._core.values)

    @property
    def columns(self) -> list[str]:
        """What the columns are: labels, "gist 0" …"""
        return cast("list[str]", self._core.columns)

    @property
    def frames(self) -> list[Frame]:
        """In the order of the rows."""
        return cast("list[Frame]", self._core.frames)

    @property
    def rooms(self) -> list[str]:
        """The true room of each frame, "" where unknown."""
        return [frame.room for frame in self.frames]

    @property
    def problems(self) -> list[str]:
        """Sentences about frames that were left out."""
        return cast("list[str]", self._core.problems)


def describe_sequence(
    sequence: Sequence, descriptors: str = "inception-v3", *, cache: bool | Path = True, progress: Progress = False
) -> Features:
    """Describes the frames of a sequence by models, "phog", "gist" or "esf"; "A+B" by both. Raises InvalidInputError
    for unknown names."""
    store = None if cache is False else _estancia.LabelCache(None if cache is True else os.fspath(cast(Path, cache)))
    described = _estancia.describe_sequence(sequence._core, descriptors, store, progress_callback(progress))
    return Features._of(described)


def describe_image(
    image: Image | None, descriptor: str, *, depth: Depth | None = None, camera: Camera | None = None
) -> FloatArray:
    """The descriptor of one view; "esf" needs depth and camera."""
    return cast(FloatArray, _estancia.describe_image(image, descriptor, depth, camera))


class Classifier:
    """A classifier of numbers: SVM, logistic regression, random forest or k nearest neighbors, in the manners of
    scikit-learn: ``fit``, ``predict``, ``predict_proba``, ``score``, ``get_params`` and ``set_params``.

    Parameters that are not given are found by cross-validation. Options: :class:`estancia.options.ClassifierOptions`.

    >>> rooms = estancia.Classifier(type="svm-rbf").fit(x, y)
    >>> rooms.predict_proba(x).shape
    (120, 5)
    """

    def __init__(self, **options: Unpack[ClassifierOptions]) -> None:
        self._options = dict(options)
        self._core: Any = None
        self.classes_: npt.NDArray[Any] = np.array([])

    def fit(
        self, x: npt.ArrayLike, y: npt.ArrayLike, groups: npt.ArrayLike | None = None, *, progress: Progress = False
    ) -> Classifier:
        """Learns from N×D numbers and N classes. Rows of one of ``groups`` are never split in cross-validation. Raises
        InvalidInputError."""
        self.classes_, classes = np.unique(np.asarray(y), return_inverse=True)
        if groups is None:
            members = np.arange(len(classes))
        else:
            members = np.unique(np.asarray(groups), return_inverse=True)[1]
        self._core = _estancia.train_classifier(
            x, classes.tolist(), members.tolist(), len(self.classes_), dict(self._options), progress_callback(progress)
        )
        return self

    def predict_proba(self, x: npt.ArrayLike) -> FloatArray:
        """N×classes, in the order of ``classes_``; rows add up to 1. Raises Error before :meth:`fit`."""
        if self._core is None:
            raise Error("the classifier was not trained; call fit() first", "invalid-state")
        return cast(FloatArray, self._core.predict(x))

    def predict(self, x: npt.ArrayLike) -> npt.NDArray[Any]:
        """The most probable class of each row."""
        return cast("npt.NDArray[Any]", self.classes_[np.argmax(self.predict_proba(x), axis=1)])

    def score(self, x: npt.ArrayLike, y: npt.ArrayLike) -> float:
        """The share of rows whose class is predicted."""
        return float(np.mean(self.predict(x) == np.asarray(y)))

    @property
    def choice(self) -> str:
        """Parameters and their cross-validation accuracy, in words."""
        return "" if self._core is None else cast(str, self._core.choice)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The options that were given, for scikit-learn."""
        return dict(self._options)

    def set_params(self, **options: Unpack[ClassifierOptions]) -> Classifier:
        """Changes options, for scikit-learn; takes effect at the next :meth:`fit`."""
        self._options.update(options)
        return self


class RoomClassifier:
    """Names the room of an image or of described frames. Made by :func:`train_room_classifier` and
    :func:`read_room_classifier`; may be used in several threads."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __repr__(self) -> str:
        return f"<estancia.RoomClassifier: {', '.join(self.rooms)}>"

    @property
    def rooms(self) -> list[str]:
        """Sorted."""
        return cast("list[str]", self._core.rooms)

    @property
    def choice(self) -> str:
        """Parameters and their cross-validation accuracy, in words."""
        return cast(str, self._core.choice)

    @property
    def training_images(self) -> int:
        """Of all rooms together."""
        return cast(int, self._core.training_images)

    def predict_image(self, image: Image) -> list[RoomProbability]:
        """The rooms of an image, best first."""
        return cast("list[RoomProbability]", self._core.predict_image(image))

    def predict_proba(self, features: Features) -> FloatArray:
        """N×rooms, in the order of ``rooms``. Raises InvalidInputError where the features lack a part."""
        return cast(FloatArray, self._core.predict(features._core))

    def predict(self, features: Features) -> list[str]:
        """The most probable room of each frame."""
        return [self.rooms[i] for i in np.argmax(self.predict_proba(features), axis=1)]

    def write(self, file: Path) -> None:
        """Writes the classifier, whole or not at all."""
        self._core.write(os.fspath(file))


def train_room_classifier(
    features: Features | Labels, *, progress: Progress = False, **options: Unpack[ClassifierOptions]
) -> RoomClassifier:
    """Learns the rooms of frames whose room is known. Options: :class:`estancia.options.ClassifierOptions`. Raises
    InvalidInputError for fewer than two rooms."""
    known = Features(features) if isinstance(features, Labels) else features
    return RoomClassifier(_estancia.train_room_classifier(known._core, dict(options), progress_callback(progress)))


def read_room_classifier(file: Path) -> RoomClassifier:
    """Reads what ``estancia classify train`` or :meth:`RoomClassifier.write` wrote. Raises FileError."""
    return RoomClassifier(_estancia.read_room_classifier(os.fspath(file)))


def rooms_by_name(labels: Labels, rooms: SequenceOf[str] = ()) -> list[list[RoomProbability]]:
    """The rooms of the images of a run by the rooms' names alone, without an example, best first. By default common
    rooms are tried. Needs WordNet."""
    return cast("list[list[RoomProbability]]", _estancia.rooms_by_name(labels._core, list(rooms)))
