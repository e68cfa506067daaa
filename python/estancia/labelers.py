# SPDX-License-Identifier: Apache-2.0
"""Labelers: everything that turns an image into label probabilities: networks, several of them, services, and any
callable of Python."""

from __future__ import annotations

import os
import pathlib
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping, Sequence as SequenceOf, Union, cast

import numpy.typing as npt

from . import _estancia
from ._common import FloatArray, Image, Path, Progress, progress_callback
from .labels import LabelProbability, Labels
from .sequences import Sequence

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import LabelerOptions, LabelStreamOptions

__all__ = [
    "CallableLabeler",
    "DEFAULT_MODEL",
    "InstalledModel",
    "LabelStream",
    "LabeledFrame",
    "Labeler",
    "ModelCheck",
    "check_model",
    "installed_models",
    "load_model",
    "model_home",
]

DEFAULT_MODEL = "inception-v3"
"""What is used where no model is named."""

Probabilities = Union[npt.ArrayLike, Mapping[str, float]]


class Labeler:
    """Turns images into label probabilities. Made by :func:`load_model`; for one thread at a time."""

    def __init__(self, core: Any, caches: bool = True) -> None:
        self._core = core
        self._caches = caches

    def __repr__(self) -> str:
        return f"<estancia.{type(self).__name__} {self.identity!r}: {len(self.labels)} labels>"

    @property
    def labels(self) -> list[str]:
        """The names of the labels, in the order of the probabilities."""
        return cast("list[str]", self._core.labels)

    @property
    def identity(self) -> str:
        """Identifies the labeler in maps: name and digest of its files."""
        return cast(str, self._core.identity)

    def label(self, image: Image, frame: str = "") -> FloatArray:
        """The probability of each label in an image: (height, width, 3), uint8, BGR, of any size. Raises
        InvalidInputError on other arrays."""
        return cast(FloatArray, self._core.label(image, frame))

    def best(self, image: Image, count: int = 5) -> list[LabelProbability]:
        """The most probable labels of an image, best first."""
        return cast("list[LabelProbability]", self._core.best(image, count))

    def label_sequence(
        self,
        sequence: Sequence,
        *,
        cache: bool | Path = True,
        progress: Progress = False,
        **options: Unpack[LabelStreamOptions],
    ) -> Labels:
        """Labels all frames; those without labels are left out and told in ``problems``.

        ``cache``: labels of earlier runs are used, and kept, in the user's cache or this folder. Options:
        :class:`estancia.options.LabelStreamOptions`.
        """
        return Labels._of(
            _estancia.label_sequence(
                sequence._core, self._core, self._cache(cache), dict(options), progress_callback(progress)
            )
        )

    def stream(
        self, sequence: Sequence, *, cache: bool | Path = True, **options: Unpack[LabelStreamOptions]
    ) -> LabelStream:
        """The labeled frames of a sequence, one after the other; decoding runs ahead in threads of its own."""
        return LabelStream(_estancia.LabelStream(sequence._core, self._core, self._cache(cache), dict(options)))

    def _cache(self, cache: bool | Path) -> Any:
        if cache is False or (cache is True and not self._caches):
            return None
        return _estancia.LabelCache(None if cache is True else os.fspath(cast(Path, cache)))


class CallableLabeler(Labeler):
    """A labeler that asks a function.

    ``function`` takes an image, (height, width, 3), uint8, BGR, and returns one probability for each of ``labels``, or
    a dict of label → probability, where labels that are left out have none. What it raises comes through. ``identity``
    names it in maps and, where given, in the label cache; say another one when its answers change.

    >>> labeler = estancia.CallableLabeler(lambda image: my_network(image), ["kitchen", "office"])
    """

    def __init__(
        self, function: Callable[[Image], Probabilities], labels: SequenceOf[str], identity: str | None = None
    ) -> None:
        name = getattr(function, "__name__", type(function).__name__)
        super().__init__(
            _estancia.callable_labeler(function, list(labels), identity or f"python {name}"), identity is not None
        )


@dataclass(frozen=True, eq=False)
class LabeledFrame:
    """A frame of a sequence with its labels, or why it has none."""

    index: int
    """In the sequence."""
    probabilities: FloatArray
    """Empty where there is a problem."""
    image: Image | None
    """None where it was not needed: its labels were in the cache."""
    problem: str
    """Why it has no labels; "" when all is well."""


class LabelStream:
    """Iterates over :class:`LabeledFrame`; a context manager that stops the threads which decode ahead."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __iter__(self) -> Iterator[LabeledFrame]:
        return self

    def __next__(self) -> LabeledFrame:
        if self._core is None:
            raise StopIteration
        return cast(LabeledFrame, self._core.next())

    def __enter__(self) -> LabelStream:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stops the work; there are no more frames."""
        self._core = None


def load_model(model: Path = DEFAULT_MODEL, **options: Unpack[LabelerOptions]) -> Labeler:
    """Loads an installed model by its name, or the folder of one; "A+B" loads several, in conjunction.

    Raises InvalidInputError that lists the known names. Options: :class:`estancia.options.LabelerOptions`.
    """
    return Labeler(_estancia.load_model(os.fspath(model), dict(options)))


@dataclass(frozen=True)
class InstalledModel:
    """A model of this machine."""

    name: str
    folder: pathlib.Path
    type: str
    license: str
    problem: str
    """Why it cannot be used; "" when all is well."""


def installed_models() -> list[InstalledModel]:
    """The models in :func:`model_home`, by name."""
    return cast("list[InstalledModel]", _estancia.installed_models())


def model_home() -> pathlib.Path:
    """Where models live: $ESTANCIA_HOME/models, else ~/.local/share/estancia/models."""
    return cast(pathlib.Path, _estancia.model_home())


@dataclass(frozen=True)
class ModelCheck:
    """What :func:`check_model` found out about a model that works."""

    name: str
    identity: str
    labels: int
    milliseconds_per_image: float
    """Median of inference alone, on this machine now."""
    best: str
    """The first label of a test image of noise."""
    best_probability: float


def check_model(model: Path = DEFAULT_MODEL, **options: Unpack[LabelerOptions]) -> ModelCheck:
    """Opens a model, labels two test images and takes the time. Raises Error saying what is wrong with it."""
    return cast(ModelCheck, _estancia.check_model(os.fspath(model), dict(options)))
