# SPDX-License-Identifier: Apache-2.0
"""Live mapping: a camera's or a replayed recording's frames become a map, or are found in one, while they come."""

from __future__ import annotations

import os
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any, Callable, cast

from . import _estancia
from ._common import Path
from .geometry import Pose
from .labelers import Labeler, load_model
from .labels import LabelProbability
from .maps import Map, read_map

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import LocalizerOptions, MapperOptions, ReplayOptions, SequenceOptions, WorldOptions

__all__ = ["LiveLoop", "LiveStatus"]


@dataclass(frozen=True)
class LiveStatus:
    """The newest frame and what it says."""

    state: str
    """"mapping", "localizing", "waiting" or "ended"."""
    frame: str
    timestamp: float | None
    pose: Pose | None
    words: list[LabelProbability]
    places: list[tuple[int, float]]
    """Where the robot is and how probably, most probable first."""
    area: int
    area_name: str
    unmapped: float | None
    decision: str
    """Why the frame went to this place."""
    frames: int
    dropped: int
    failed: int
    latency: float
    """From the frame's arrival to its place [ms]."""
    rate: float
    """Frames a second."""
    troubles: list[str]
    """What is wrong now."""


class LiveLoop:
    """Takes the newest frame, says where it is, then maps what it shows; a context manager.

    ``source``: "0", "/dev/video0", "rtsp://…": a camera; "ros2:/topic"; else the path of a recording, which is played.
    ``localize``: only finds the frames in the map. ``sequence`` and ``replay``: options of recordings; ``world``: of
    the layers above the places; ``localizer``: of localization. Options: :class:`estancia.options.MapperOptions`.

    >>> with estancia.LiveLoop("/dev/video0", "home.estancia") as live:
    ...     live.run(lambda now: print(now.frame, now.places[0]))
    """

    def __init__(
        self,
        source: Path,
        map: Path,
        labeler: Labeler | None = None,
        *,
        localize: bool = False,
        sequence: SequenceOptions | None = None,
        replay: ReplayOptions | None = None,
        world: WorldOptions | None = None,
        localizer: LocalizerOptions | None = None,
        **options: Unpack[MapperOptions],
    ) -> None:
        self._path = map
        self._core: Any = _estancia.LiveLoop(
            os.fspath(source),
            (labeler or load_model())._core,
            os.fspath(map),
            localize,
            dict(sequence or {}),
            dict(replay or {}),
            dict(options),
            dict(world or {}),
            dict(localizer or {}),
        )

    def __enter__(self) -> LiveLoop:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.stop()

    def run(self, each: Callable[[LiveStatus], None] | None = None) -> Map:
        """Until the source ends, :meth:`stop` is called, or Ctrl-C; then writes everything, and returns the map.
        ``each`` hears of every frame when its place is known: it must be quick."""
        self._core.run(each)
        return read_map(self._path)

    def stop(self) -> None:
        """From any thread, or from ``each``."""
        self._core.stop()

    def status(self) -> LiveStatus:
        """The newest frame; from any thread."""
        return cast(LiveStatus, self._core.status())
