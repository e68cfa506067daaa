# SPDX-License-Identifier: Apache-2.0
"""Mapping: images or labels become a map file, all at once or frame by frame; and localization in it."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any, Mapping, cast

import numpy.typing as npt

from . import _estancia
from ._common import Image, Path, Progress, progress_callback
from .geometry import Pose
from .labelers import Labeler, load_model
from .labels import Labels
from .maps import Decision, Map, Merge, Transition, read_map
from .sequences import Frame, Sequence, open_sequence

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import LocalizerOptions, MapBudget, MapperOptions, WorldOptions

__all__ = [
    "CompactedMap",
    "Localization",
    "Localizer",
    "MapChanges",
    "Mapper",
    "MappingSession",
    "compact_map",
    "map_sequence",
]


def map_sequence(
    sequence: Sequence | Labels | Path,
    map: Path,
    labeler: Labeler | None = None,
    *,
    existing: str = "refuse",
    cache: bool | Path = True,
    progress: Progress = False,
    world: WorldOptions | None = None,
    budget: MapBudget | None = None,
    **options: Unpack[MapperOptions],
) -> Map:
    """Maps a drive into the file ``map`` as ``estancia map`` does: places, zones and, with depth, areas and objects;
    cameras without poses are tracked.

    ``labeler``: by default the default model; labels need none. ``existing``: "refuse", "replace" or "continue".
    ``world``: options of the layers above the places. ``budget``: how much memory and how large a file the map may
    take, which it keeps. Options: :class:`estancia.options.MapperOptions`. An interrupted
    run keeps what it has mapped, and goes on with ``existing="continue"``. Warns of images that were left out, and of
    options of the map that have gone. Raises ExistingFileError, FileError and
    InvalidInputError.
    """
    if isinstance(sequence, Labels):
        frames, labeling = _RecordedFrames(sequence), Labeler(_estancia.recorded_labeler(sequence._core), False)
        core = frames.sequence
    else:
        core = (sequence if isinstance(sequence, Sequence) else open_sequence(sequence))._core
        labeling = labeler or load_model(on_demand=True)
    *_, problems = _estancia.map_sequence(
        core,
        labeling._core,
        os.fspath(map),
        labeling._cache(cache),
        existing,
        dict(options),
        dict(world or {}),
        dict(budget or {}),
        progress_callback(progress),
    )
    for problem in problems:
        warnings.warn(problem, stacklevel=2)
    return read_map(map)


class _RecordedFrames:
    """The frames of labels as a sequence without images."""

    def __init__(self, labels: Labels) -> None:
        self.sequence = _estancia.frames_of_labels(labels._core)


@dataclass(frozen=True)
class CompactedMap:
    """What :func:`compact_map` did."""

    bytes_before: int
    bytes_after: int
    frames_before: int
    frames_after: int


def compact_map(map: Path, *, file_budget: int | None = None) -> CompactedMap:
    """Gives the unused space of a map file back and, with ``file_budget`` [MB], leaves out the frames that say least
    beside the others of their places until it fits. Raises FileError, and Error where what must stay does not fit."""
    return cast(CompactedMap, _estancia.compact_map(os.fspath(map), file_budget))


class MappingSession:
    """Maps frames into a file while they come, and goes on with it later; a context manager.

    Creates the map, or continues it with another drive where the file exists. What it holds is written once a second, and is whole after a
    crash. Options: :class:`estancia.options.MapperOptions`, for a new map. Raises InvalidInputError where they are not
    those of the map, and Error ("busy") where another process writes it.

    >>> with estancia.MappingSession("home.estancia", estancia.load_model()) as session:
    ...     for image in images:
    ...         place = session.add(image)
    """

    def __init__(self, map: Path, labeler: Labeler, **options: Unpack[MapperOptions]) -> None:
        self._path = map
        self._core: Any = _estancia.MappingSession(os.fspath(map), labeler._core, dict(options) if options else None)

    def __enter__(self) -> MappingSession:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    @property
    def frames(self) -> int:
        """How many frames the map has."""
        return cast(int, self._open().frames)

    def set_budget(self, **budget: Unpack[MapBudget]) -> None:
        """Bounds the memory and the file from now on, whatever is mapped: the file leaves out the frames that say
        least beside the others of their places. The map keeps it. Raises Error ("too large"), also later, where what
        must stay does not fit."""
        self._open().set_budget(dict(budget))

    def begin_drive(self, name: str = "", *, poses_in_map: bool = False) -> None:
        """The next frame is another drive's: the robot may be anywhere, and is localized in what earlier drives have
        mapped. ``poses_in_map``: its poses are in the map's frame, else in any fixed one."""
        self._open().begin_drive(name, poses_in_map)

    def add(self, image: Image, timestamp: float | None = None, pose: Pose | None = None) -> int:
        """Labels an image, (height, width, 3), uint8, BGR, maps it with a small copy of it, and returns its place."""
        return cast(int, self._open().add(image, timestamp, pose))

    def add_labels(self, frame: Frame | str, probabilities: npt.ArrayLike, image: Image | None = None) -> int:
        """Maps a frame that was labeled elsewhere, and returns its place."""
        named = Frame(frame) if isinstance(frame, str) else frame
        return cast(int, self._open().add_labels(named, probabilities, image))

    def finish(self) -> None:
        """Writes everything. More frames may follow."""
        self._open().finish()

    def map(self) -> Map:
        """The map as of now."""
        self.finish()
        return read_map(self._path)

    def close(self) -> None:
        """Writes everything and closes the file; at any time, also twice."""
        if self._core is not None:
            core, self._core = self._core, None
            core.finish()

    def _open(self) -> Any:
        if self._core is None:
            raise _estancia_closed("the mapping session is closed")
        return self._core


def _estancia_closed(sentence: str) -> Exception:
    from .errors import Error

    return Error(sentence, "invalid-state")


@dataclass(frozen=True)
class MapChanges:
    """What changed in a map since it was asked last."""

    restarted: bool
    """All earlier decisions are void: the frames have been mapped again."""
    decisions: list[Decision]
    merges: list[Merge]


class Mapper:
    """Topological mapping in memory, from descriptors of ``labels`` probabilities (LexToMap). Deterministic.

    Options: :class:`estancia.options.MapperOptions`.
    """

    def __init__(self, labels: int, **options: Unpack[MapperOptions]) -> None:
        self._core: Any = _estancia.Mapper(labels, dict(options))

    def add(self, probabilities: npt.ArrayLike, pose: Pose | None = None) -> int:
        """Maps the next frame and returns its place. Raises InvalidInputError when it is no descriptor."""
        return cast(int, self._core.add(probabilities, pose))

    def finish(self) -> None:
        """The run is over (for now): a run that is still warming up is mapped a last time."""
        self._core.finish()

    def take_changes(self) -> MapChanges:
        """What changed since the last call."""
        changes = self._core.take_changes()
        return MapChanges(changes["restarted"], changes["decisions"], changes["merges"])

    @property
    def frames(self) -> int:
        """How many were added."""
        return cast(int, self._core.frames)

    @property
    def places(self) -> int:
        """How many there are."""
        return cast(int, self._core.nodes)

    @property
    def current_place(self) -> int:
        """-1 before the first frame."""
        return cast(int, self._core.current_node)

    @property
    def thresholds(self) -> Mapping[str, float]:
        """join, revisit, merge, view and sequence, as they are now."""
        return cast("Mapping[str, float]", self._core.thresholds)

    @property
    def transitions(self) -> list[Transition]:
        """Ordered by the places that they join."""
        return cast("list[Transition]", self._core.transitions)


@dataclass(frozen=True)
class Localization:
    """Where a frame was taken."""

    node: int
    """The nearest place by this frame alone."""
    nearest_image: int
    """The nearest frame of the map, by this frame alone."""
    distance: float
    """To that frame."""
    belief_node: int
    """The most probable place by all frames: where the robot is."""
    belief_image: int
    confidence: float
    """Probability of ``belief_node``."""
    unmapped: float | None
    """Probability that no mapped frame was taken near; None where the map has no poses."""
    unvisited: float | None
    """The same of frames that look anywhere."""
    belief_zone: int | None
    zone_confidence: float


class Localizer:
    """Finds frames in a map, each alone and by a Bayes filter over the drive.

    Options: :class:`estancia.options.LocalizerOptions`. Raises as :func:`read_map`.
    """

    def __init__(self, map: Path, **options: Unpack[LocalizerOptions]) -> None:
        self._core: Any = _estancia.Localizer(os.fspath(map), dict(options))

    @property
    def labels(self) -> list[str]:
        """What the columns of a descriptor are."""
        return cast("list[str]", self._core.labels)

    def set_zones(self, zone_of_frame: list[int]) -> None:
        """The zone (or area) of each frame of the map, which answers then tell, too; -1: none."""
        self._core.set_zones(zone_of_frame)

    def add(self, probabilities: npt.ArrayLike, odometry: Pose | None = None) -> list[Localization]:
        """Takes the next frame; gives the answers that are final now, in order: its own without ``lookahead``, none or
        several with it. ``odometry``: the camera's pose in any fixed frame."""
        return cast("list[Localization]", self._core.add(probabilities, odometry))

    def finish(self) -> list[Localization]:
        """The answers that still wait for later frames."""
        return cast("list[Localization]", self._core.finish())
