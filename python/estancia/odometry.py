# SPDX-License-Identifier: Apache-2.0
"""RGB-D odometry: the camera's trajectory, of a recording or frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from . import _estancia
from ._common import Depth, Image, Progress, progress_callback
from .geometry import Camera, Pose
from .sequences import Sequence

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import RgbdOptions

__all__ = ["RgbdTracker", "RgbdTrajectory", "TrackedFrame", "track_rgbd"]


@dataclass(frozen=True)
class RgbdTrajectory:
    """The poses of a camera. The map's origin is the first tracked camera, which looks along x."""

    poses: list[Pose | None]
    """T_map_camera of every frame; None where the camera was lost."""
    lost: list[tuple[int, str]]
    """Frames without a pose, and why."""
    bridged: list[tuple[int, str]]
    """Frames that were not tracked, whose pose was made from those around."""
    keyframes: list[int]
    loops: list[tuple[int, int]]
    """Pairs of frames of the accepted loop closures."""
    notes: list[str]


def track_rgbd(sequence: Sequence, *, progress: Progress = False, **options: Unpack[RgbdOptions]) -> RgbdTrajectory:
    """Tracks the camera of a recording with depth; loops are closed. Options: :class:`estancia.options.RgbdOptions`.
    Raises InvalidInputError without depth or camera, Error ("missing-dependency") without the package
    estancia-odometry."""
    found = _estancia.track_rgbd(sequence._core, dict(options), progress_callback(progress))
    return cast(RgbdTrajectory, found)


@dataclass(frozen=True)
class TrackedFrame:
    """Where a frame was taken."""

    pose: Pose | None
    """T_map_camera; None when it is not placed (yet)."""
    why: str
    """Why it was not tracked; "" when it was."""


class RgbdTracker:
    """Tracks a camera one frame after the other; earlier poses may change when a loop is closed: ``revision`` tells.

    Options: :class:`estancia.options.RgbdOptions`. Raises Error as :func:`track_rgbd` does.
    """

    def __init__(self, camera: Camera, **options: Unpack[RgbdOptions]) -> None:
        self._core: Any = _estancia.RgbdTracker(camera, dict(options))

    def __len__(self) -> int:
        return len(self._core)

    def add(
        self, image: Image, depth: Depth, timestamp: float | None = None, prior: Pose | None = None
    ) -> TrackedFrame:
        """The next frame. ``prior``: the camera's pose as another sensor has it, in any fixed frame."""
        return cast(TrackedFrame, self._core.add(image, depth, timestamp, prior))

    def at(self, frame: int) -> TrackedFrame:
        """A frame as it is known now. Raises IndexError."""
        if not 0 <= frame < len(self):
            raise IndexError(f"frame {frame} of {len(self)}")
        return cast(TrackedFrame, self._core.at(frame))

    @property
    def revision(self) -> int:
        """Grows when earlier poses changed."""
        return cast(int, self._core.revision)

    def settle(self) -> None:
        """Applies smaller corrections, too."""
        self._core.settle()

    def trajectory(self) -> RgbdTrajectory:
        """All of it, as known now."""
        return cast(RgbdTrajectory, self._core.trajectory())
