# SPDX-License-Identifier: Apache-2.0
"""Point clouds: files, filters, Growing Neural Gas, normals, noise, object segmentation and rendering."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence as SequenceOf, cast

import numpy as np
import numpy.typing as npt

from . import _estancia
from ._common import Depth, FloatArray, Image, Path, Progress, progress_callback
from .geometry import Camera, Pose

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import CloudFileOptions, ClusterOptions, FilterOptions, GngOptions, NormalOptions

__all__ = [
    "Cluster",
    "Clusters",
    "NeuralGas",
    "Plane",
    "PointCloud",
    "draw_clouds",
    "estimate_normals",
    "filter_cloud",
    "find_clusters",
    "grow_neural_gas",
    "read_cloud",
]


class PointCloud:
    """Points [m] with colors and normals. Arrays are views that cannot be written; make another cloud to change it.

    ``points``: (N, 3), or (height, width, 3) of an organized cloud, NaN where it has a hole; ``colors``: uint8, BGR;
    ``normals``: unit vectors. ``viewpoint``: the sensor's pose in the frame of the points.
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        colors: npt.ArrayLike | None = None,
        normals: npt.ArrayLike | None = None,
        viewpoint: Pose | None = None,
    ) -> None:
        self._core = _estancia.PointCloud(np.asarray(points, dtype=np.float32), colors, normals, viewpoint)

    @classmethod
    def _of(cls, core: Any) -> PointCloud:
        cloud = cls.__new__(cls)
        cloud._core = core
        return cloud

    @staticmethod
    def from_depth(depth: Depth, camera: Camera) -> PointCloud:
        """The organized cloud of a depth image [m], in the optical frame of ``camera``."""
        return PointCloud._of(_estancia.back_project(depth, camera))

    def __len__(self) -> int:
        return len(self._core)

    def __repr__(self) -> str:
        shape = f"{self.height}×{self.width}" if self.height > 1 else str(len(self))
        more = [name for name in ("colors", "normals") if getattr(self, name) is not None]
        return f"<estancia.PointCloud: {shape} points{''.join(', ' + name for name in more)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        shape = (self.height, self.width, 3) if self.height > 1 else (len(self), 3)
        return PointCloud, (np.array(self.points).reshape(shape), self.colors, self.normals, self.viewpoint)

    @property
    def points(self) -> FloatArray:
        """(N, 3) [m]."""
        return cast(FloatArray, self._core.points)

    @property
    def colors(self) -> npt.NDArray[np.uint8] | None:
        """(N, 3), BGR; None without colors."""
        return cast("npt.NDArray[np.uint8] | None", self._core.colors)

    @property
    def normals(self) -> FloatArray | None:
        """(N, 3), NaN where unknown; None without normals."""
        return cast("FloatArray | None", self._core.normals)

    @property
    def width(self) -> int:
        """Of the image behind an organized cloud; else the number of points."""
        return cast(int, self._core.width)

    @property
    def height(self) -> int:
        """1 for a cloud that is not organized."""
        return cast(int, self._core.height)

    @property
    def viewpoint(self) -> Pose | None:
        """The sensor's pose in the frame of the points; None: at the origin."""
        return cast("Pose | None", self._core.viewpoint)

    def write(self, file: Path) -> None:
        """Writes a binary .pcd or .ply."""
        _estancia.write_cloud(self._core, os.fspath(file))

    def select(self, indices: npt.ArrayLike) -> PointCloud:
        """These points with their colors and normals, not organized."""
        return PointCloud._of(_estancia.points_of(self._core, np.asarray(indices).tolist()))

    def with_noise(self, sigma: float, seed: int) -> PointCloud:
        """With independent Gaussian noise of ``sigma`` [m] added to x, y and z."""
        return PointCloud._of(_estancia.with_gaussian_noise(self._core, sigma, seed))

    def resolution(self) -> float:
        """The median distance from a point to its nearest neighbor [m]."""
        return cast(float, _estancia.cloud_resolution(self._core))

    def noise(self) -> float:
        """The standard deviation of the sensor's noise across the surface [m], estimated."""
        return cast(float, _estancia.cloud_noise(self._core))


def read_cloud(file: Path, *, unit: str = "m", **options: Unpack[CloudFileOptions]) -> PointCloud:
    """Reads a .pcd, a .ply, or a depth image with its camera. Raises FileError.

    ``unit``: "m", "cm" or "mm", of the coordinates in the file; the cloud is in meters. Options:
    :class:`estancia.options.CloudFileOptions`."""
    return PointCloud._of(_estancia.read_cloud(os.fspath(file), unit, dict(options)))


def filter_cloud(cloud: PointCloud, *, progress: Progress = False, **options: Unpack[FilterOptions]) -> PointCloud:
    """Fewer points by a voxel grid, or a denoised surface by Growing Neural Gas.

    Options: :class:`estancia.options.FilterOptions`.

    >>> clean = estancia.filter_cloud(cloud, method="gng", points=20000)
    """
    return PointCloud._of(_estancia.filter_cloud(cloud._core, dict(options), progress_callback(progress)))


@dataclass(frozen=True, eq=False)
class NeuralGas:
    """A graph of neurons on the surface of a cloud."""

    cloud: PointCloud
    """The neurons."""
    edges: npt.NDArray[np.uint32]
    """(E, 2): pairs of neurons."""
    signals: int
    """How many were shown."""
    quantization_error: float
    """Root mean square distance of the points to their nearest neurons."""
    stop: str
    """Why growth ended: "neurons", "quantization-error", "seconds", "points" or "stalled"."""

    def __post_init__(self) -> None:
        if not isinstance(self.cloud, PointCloud):
            object.__setattr__(self, "cloud", PointCloud._of(self.cloud))


def grow_neural_gas(cloud: PointCloud, *, progress: Progress = False, **options: Unpack[GngOptions]) -> NeuralGas:
    """Growing Neural Gas (Fritzke 1995). The same options and cloud give the same graph. Options:
    :class:`estancia.options.GngOptions`."""
    return cast(NeuralGas, _estancia.grow_neural_gas(cloud._core, dict(options), progress_callback(progress)))


def estimate_normals(cloud: PointCloud, **options: Unpack[NormalOptions]) -> PointCloud:
    """The cloud with surface normals, by ``radius`` [m] or by the number of ``neighbors``. Options:
    :class:`estancia.options.NormalOptions`."""
    return PointCloud._of(_estancia.with_normals(cloud._core, dict(options)))


@dataclass(frozen=True)
class Plane:
    """normal · X = offset [m]; the normal has unit length and points to the camera."""

    normal: tuple[float, float, float]
    offset: float
    area: float
    """The visible part [m²]."""
    structural: bool
    """Bounds the room (floor, wall, ceiling); else it is a face of a thing."""


@dataclass(frozen=True, eq=False)
class Cluster:
    """What may be one object."""

    points: npt.NDArray[np.uint32]
    """Indices of the cloud's points, or of the depth image's pixels row by row; ascending."""
    box: tuple[int, int, int, int]
    """x, y, width, height [pixels]."""
    center: tuple[float, float, float]
    """Mean of the points [m]."""
    at_border: bool
    flat: bool


@dataclass(frozen=True, eq=False)
class Clusters:
    """Segments of a depth image or cloud."""

    clusters: list[Cluster]
    """Largest first."""
    planes: list[Plane]
    up: tuple[float, float, float]
    """In the camera's frame."""


def find_clusters(
    scene: Depth | PointCloud,
    camera: Camera | None = None,
    image: Image | None = None,
    **options: Unpack[ClusterOptions],
) -> Clusters:
    """Segments a depth image with its ``camera``, or a cloud, into objects: planes are removed, the rest is split at
    depth edges and creases and, with the ``image``, where colors differ. Options:
    :class:`estancia.options.ClusterOptions`. Raises InvalidInputError."""
    if isinstance(scene, PointCloud):
        return cast(Clusters, _estancia.find_clusters_of_cloud(scene._core, dict(options)))
    return cast(Clusters, _estancia.find_clusters(scene, camera, image, dict(options)))


def draw_clouds(
    clouds: PointCloud | SequenceOf[PointCloud],
    poses: SequenceOf[npt.ArrayLike | None] = (),
    *,
    width: int = 1280,
    height: int = 960,
    azimuth: float = 0.0,
    elevation: float = 0.0,
) -> Image:
    """Clouds as an image that shows their shape, seen as the sensor did, or from beside [degrees]. ``poses``: a 4×4
    matrix a cloud."""
    layers = [clouds] if isinstance(clouds, PointCloud) else list(clouds)
    cores = [cloud._core for cloud in layers]
    return cast(Image, _estancia.draw_clouds(cores, list(poses), width, height, azimuth, elevation))
