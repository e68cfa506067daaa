# SPDX-License-Identifier: Apache-2.0
"""Labels: the probabilities of a sequence's frames, from a labeler, a file or NumPy."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence as SequenceOf, cast

import numpy.typing as npt

from . import _estancia
from ._common import FloatArray, Path
from .sequences import Frame

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import LabelFileOptions

__all__ = ["LabelProbability", "Labels", "read_labels"]


@dataclass(frozen=True)
class LabelProbability:
    """A label with its probability, in [0, 1]."""

    label: str
    probability: float


class Labels:
    """Frames with a probability for each label.

    ``probabilities``: N×L, in [0, 1]; ``labels``: L names; ``frames``: N frames, or their names; ``model`` identifies
    what gave the labels. Raises InvalidInputError when they do not fit.
    """

    def __init__(
        self,
        probabilities: npt.ArrayLike,
        labels: SequenceOf[str],
        frames: SequenceOf[Frame | str] | None = None,
        model: str = "python",
    ) -> None:
        if frames is None:
            frames = [f"frame {i:06}" for i in range(len(cast("SequenceOf[Any]", probabilities)))]
        named = [Frame(frame) if isinstance(frame, str) else frame for frame in frames]
        self._core = _estancia.Labels(probabilities, list(labels), named, model)

    @classmethod
    def _of(cls, core: Any) -> Labels:
        labels = cls.__new__(cls)
        labels._core = core
        return labels

    def __len__(self) -> int:
        return len(self._core)

    def __repr__(self) -> str:
        return f"<estancia.Labels: {len(self)} frames, {len(self.labels)} labels of {self.model!r}>"

    @property
    def labels(self) -> list[str]:
        """The names, in the order of the columns."""
        return cast("list[str]", self._core.labels)

    @property
    def model(self) -> str:
        """Identity of the labeler."""
        return cast(str, self._core.model)

    @property
    def frames(self) -> list[Frame]:
        """In the order of the rows."""
        return cast("list[Frame]", self._core.frames)

    @property
    def probabilities(self) -> FloatArray:
        """N×L, float32; a view that cannot be written."""
        return cast(FloatArray, self._core.probabilities)

    @property
    def problems(self) -> list[str]:
        """Sentences about frames that were left out, as they cannot be read or labeled."""
        return cast("list[str]", self._core.problems)

    def write(self, file: Path) -> None:
        """Writes .labels (everything, exact), .csv or .npy, by the extension. Raises FileError."""
        _estancia.write_labels(self._core, os.fspath(file))


def read_labels(file: Path, **options: Unpack[LabelFileOptions]) -> Labels:
    """Reads a label file: .labels, .csv, .jsonl or .npy. Raises FileError with file and line. Options:
    :class:`estancia.options.LabelFileOptions`."""
    return Labels._of(_estancia.read_labels(os.fspath(file), dict(options)))
