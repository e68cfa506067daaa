# SPDX-License-Identifier: Apache-2.0
"""Poses and cameras: meters, radians, pixels; frames as in REP-103."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Camera", "Pose"]


@dataclass(frozen=True)
class Pose:
    """T_map_camera: position [m] and unit quaternion of a camera's optical frame (x right, y down, z forward) in the
    map."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @staticmethod
    def planar(x: float, y: float, theta: float) -> Pose:
        """A level camera at (x, y, 0) that looks along ``theta`` [rad], counter-clockwise from the map's x axis."""
        c, s = 0.5 * math.cos(theta / 2), 0.5 * math.sin(theta / 2)
        return Pose(x, y, 0.0, -c - s, c - s, -c + s, c + s)

    @staticmethod
    def from_matrix(matrix: npt.ArrayLike) -> Pose:
        """Of a rigid transform, 4×4. Raises InvalidInputError for other matrices."""
        from . import _estancia

        return _pose(_estancia.pose_of_matrix(np.asarray(matrix, dtype=np.float64)))

    def matrix(self) -> npt.NDArray[np.float64]:
        """The same as a 4×4 matrix: its product with a point in the camera is that point in the map."""
        x, y, z, w = self.qx, self.qy, self.qz, self.qw
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), self.x],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), self.y],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), self.z],
                [0, 0, 0, 1],
            ]
        )


@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion, of images of ``width`` × ``height``: u = fx X / Z + cx, v = fy Y / Z + cy
    [pixels]; the first pixel has its center at (0, 0)."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def scaled_to(self, width: int, height: int) -> Camera:
        """The same camera with images of another size."""
        sx, sy = width / self.width, height / self.height
        return Camera(
            width, height, self.fx * sx, self.fy * sy, (self.cx + 0.5) * sx - 0.5, (self.cy + 0.5) * sy - 0.5
        )


def _pose(value: Any) -> Pose:
    assert isinstance(value, Pose)
    return value
