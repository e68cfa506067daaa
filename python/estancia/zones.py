# SPDX-License-Identifier: Apache-2.0
"""Semantic zones: the areas of a run, clustered and named by their labels alone."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, Sequence as SequenceOf, cast

import numpy.typing as npt

from . import _estancia
from ._common import FloatArray, Path, Progress, progress_callback
from .labels import LabelProbability, Labels
from .maps import Measure, RoomProbability, _write_whole
from .sequences import Frame

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import ZoneOptions, ZoneStreamOptions

__all__ = ["Zone", "ZoneStream", "Zones", "find_zones", "read_zones"]


@dataclass(frozen=True, eq=False)
class Zone:
    """A cluster of images."""

    id: int
    """0 for the largest."""
    name: str
    """Its most telling words."""
    images: list[int]
    """Frame numbers, ascending."""
    words: list[LabelProbability]
    """The ten most probable labels, in the mean."""
    room: str
    """The true room of most of its images, or ""."""
    room_share: float
    predicted: list[RoomProbability]
    mean: FloatArray
    """Of each label's probability."""
    sigma: FloatArray


class Zones:
    """A run and its zones; iterates over them. Made by :func:`find_zones` and :func:`read_zones`."""

    def __init__(self, core: Any) -> None:
        self._core = core
        self._zones: list[Zone] = core.zones

    def __len__(self) -> int:
        return len(self._zones)

    def __getitem__(self, i: int) -> Zone:
        return self._zones[i]

    def __iter__(self) -> Iterator[Zone]:
        return iter(self._zones)

    def __repr__(self) -> str:
        return f"<estancia.Zones: {len(self)} zones of {len(self.zone_of)} images, {self.cut_reason}>"

    @property
    def labels(self) -> list[str]:
        """What the columns of ``mean`` are."""
        return cast("list[str]", self._core.labels)

    @property
    def frames(self) -> list[Frame]:
        """Of the run."""
        return cast("list[Frame]", self._core.frames)

    @property
    def zone_of(self) -> list[int]:
        """The zone of each frame."""
        return cast("list[int]", self._core.zone_of)

    @property
    def cut(self) -> float:
        """The distance up to which zones were merged."""
        return cast(float, self._core.cut)

    @property
    def cut_reason(self) -> str:
        """Where the cut comes from, one sentence."""
        return cast(str, self._core.cut_reason)

    @property
    def run_mean(self) -> FloatArray:
        """The mean probability of each label over the whole run."""
        return cast(FloatArray, self._core.run_mean)

    def measures(self) -> list[Measure]:
        """Quality against true rooms, as far as these are known."""
        return cast("list[Measure]", self._core.measures())

    def page(self, title: str = "") -> str:
        """The zones as one HTML page that needs nothing else."""
        return cast(str, self._core.page(title))

    def write_page(self, file: Path, title: str = "") -> None:
        """Writes that page."""
        _write_whole(file, self.page(title))

    def write(self, file: Path) -> None:
        """Writes FILE.zones (JSON), whole or not at all."""
        self._core.write(os.fspath(file))


def find_zones(labels: Labels, *, progress: Progress = False, **options: Unpack[ZoneOptions]) -> Zones:
    """Clusters the images of a run into zones. Options: :class:`estancia.options.ZoneOptions`.

    >>> for zone in estancia.find_zones(labels, count=6):
    ...     print(zone.name, len(zone.images))
    """
    return Zones(_estancia.find_zones(labels._core, dict(options), progress_callback(progress)))


def read_zones(file: Path) -> Zones:
    """Reads a zone file. Raises FileError."""
    return Zones(_estancia.read_zones(os.fspath(file)))


class ZoneStream:
    """Zones that are kept up to date while a robot drives, in bounded memory and time.

    ``stream``: options of the stream itself, :class:`estancia.options.ZoneStreamOptions`; the others are
    :class:`estancia.options.ZoneOptions`.
    """

    def __init__(
        self, labels: SequenceOf[str], *, stream: ZoneStreamOptions | None = None, **options: Unpack[ZoneOptions]
    ) -> None:
        self._core: Any = _estancia.ZoneStream(list(labels), dict(options), dict(stream or {}))

    def add(self, probabilities: npt.ArrayLike) -> int:
        """The next image's zone as of now."""
        return cast(int, self._core.add(probabilities))

    def update(self) -> None:
        """Links and cuts again by all images so far."""
        self._core.update()

    def finish(self, labels: Labels) -> Zones:
        """The zones of all images so far; ``labels`` are those of these images."""
        return Zones(self._core.finish(labels._core))

    def name_of(self, zone: int) -> str:
        """The most distinctive labels of a zone. Raises InvalidInputError when there is none of that number."""
        return cast(str, self._core.name_of(zone))

    @property
    def zone_of(self) -> list[int]:
        """Of every image so far."""
        return cast("list[int]", self._core.zone_of)

    @property
    def zone_count(self) -> int:
        """How many there are."""
        return cast(int, self._core.zone_count)
