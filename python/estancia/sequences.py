# SPDX-License-Identifier: Apache-2.0
"""Sequences: frames in driving order from image folders, videos, bags of ROS 1 and 2, and robotics data sets."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, Sequence as SequenceOf, cast

from . import _estancia
from ._common import Depth, Image, Path, Progress, progress_callback
from .geometry import Camera, Pose

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import CheckOptions, SequenceOptions

__all__ = [
    "CheckItem",
    "Frame",
    "Sequence",
    "check_sequence",
    "open_images",
    "open_sequence",
    "read_image",
    "read_trajectory",
    "write_trajectory",
]


@dataclass(frozen=True)
class Frame:
    """What is known of an image of a sequence without its pixels."""

    name: str
    """Unique in its sequence: the file name, or "frame 000123" in a video."""
    timestamp: float | None = None
    """[s]; None where the source has none."""
    pose: Pose | None = None
    """T_map_camera; None where unknown."""
    room: str = ""
    """The true room, "" where unknown: for evaluation, never for mapping."""


class Sequence:
    """Frames in driving order; pixels are read on request. Made by :func:`open_sequence`; may be used in several
    threads."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self._core)

    def __getitem__(self, i: int) -> Frame:
        return cast(Frame, self._core.frame(self._index(i)))

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<estancia.Sequence {self.name!r}: {len(self)} frames{', depth' if self.has_depth else ''}>"

    @property
    def name(self) -> str:
        """The folder or file name."""
        return cast(str, self._core.name)

    @property
    def has_depth(self) -> bool:
        """Whether there are depth images; single frames may still lack theirs."""
        return cast(bool, self._core.has_depth)

    @property
    def camera(self) -> Camera | None:
        """Of images and depth; None where unknown."""
        return cast("Camera | None", self._core.camera)

    @property
    def warnings(self) -> list[str]:
        """Sentences about problems of the whole sequence."""
        return cast("list[str]", self._core.warnings)

    def image(self, i: int) -> Image:
        """The image of frame ``i``: (height, width, 3), uint8, BGR. Raises Error when it cannot be read."""
        return cast(Image, self._core.image(self._index(i)))

    def depth(self, i: int) -> Depth:
        """The depth of frame ``i`` along the optical axis [m], float32, 0 where unknown. Raises Error when the frame
        has none."""
        return cast(Depth, self._core.depth(self._index(i)))

    def images(self) -> Iterator[Image]:
        """All images, one after the other."""
        return (self.image(i) for i in range(len(self)))

    def _index(self, i: int) -> int:
        size = len(self)
        if not -size <= i < size:
            raise IndexError(f"frame {i} of {size}")
        return i % size


def open_sequence(path: Path, **options: Unpack[SequenceOptions]) -> Sequence:
    """Opens a folder of images, a video, a bag, a label file, a folder of panoramas, or a data set; the format is
    detected.

    Raises MissingFileError, FileError and InvalidInputError. Options: :class:`estancia.options.SequenceOptions`.

    >>> drive = estancia.open_sequence("drive.bag", image_topic="/camera/color/image_raw")
    """
    return Sequence(_estancia.open_sequence(os.fspath(path), dict(options)))


def open_images(files: SequenceOf[Path]) -> Sequence:
    """Single image files in this order; frames are named by their paths. Raises MissingFileError."""
    return Sequence(_estancia.open_images([os.fspath(file) for file in files]))


def read_image(file: Path) -> Image:
    """Reads an image of any common format: (height, width, 3), uint8, BGR. Raises FileError."""
    return cast(Image, _estancia.read_image(os.fspath(file)))


@dataclass(frozen=True)
class CheckItem:
    """One finding of :func:`check_sequence`."""

    severity: str
    """"fine", "warning" or "problem"."""
    name: str
    """Stable, for programs: "pose-inverted"; docs/how-to/depth.md lists all."""
    what: str
    evidence: str
    fix: str
    """What to do; "" when fine."""


def check_sequence(
    sequence: Sequence, *, progress: Progress = False, **options: Unpack[CheckOptions]
) -> list[CheckItem]:
    """Finds faults of a recording that would spoil a map, and says how to repair them: images, depth, camera, time
    stamps and poses. Options: :class:`estancia.options.CheckOptions`."""
    found = _estancia.check_sequence(sequence._core, dict(options), progress_callback(progress))
    return cast("list[CheckItem]", found)


def read_trajectory(file: Path) -> list[tuple[float | None, Pose | None]]:
    """Time stamps [s] and poses of a trajectory in the format of TUM or KITTI; None where a line has none. Raises
    FileError with file and line."""
    return cast("list[tuple[float | None, Pose | None]]", _estancia.read_trajectory(os.fspath(file)))


def write_trajectory(points: SequenceOf[tuple[float, Pose]], file: Path) -> None:
    """Writes time stamps [s] and poses in the format of TUM, with all digits."""
    _estancia.write_trajectory(list(points), os.fspath(file))
