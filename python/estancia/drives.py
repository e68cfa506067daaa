# SPDX-License-Identifier: Apache-2.0
"""Several drives in one map: which there are, what changed between them, maps merged, a drive undone."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from typing import Sequence as SequenceOf, cast

from . import _estancia
from ._common import Path, Progress, progress_callback
from .geometry import Pose

__all__ = ["Changes", "Drive", "MergedMaps", "ObjectChange", "PlaceChange", "merge_maps", "undo_drive"]


@dataclass(frozen=True)
class Drive:
    """One run of a robot. Between two drives it may have been carried."""

    name: str
    first_frame: int
    frames: int
    begins: float | None
    """First and last time stamp [s], where the frames have any."""
    ends: float | None
    places: int
    """That it was in, and those of them that no earlier drive was in."""
    new_places: int
    posed_frames: int
    """Frames with a pose in the map."""
    aligned: bool
    """Whether its poses are known in the map's frame."""
    alignment: Pose | None
    """T_map_drive where that was found by recognized places."""
    recognized_after: int | None
    """The first frame in a place of an earlier drive, counted from the drive's first, and that place."""
    recognized_in: int | None


@dataclass(frozen=True)
class ObjectChange:
    """Something whose place was looked at before and after, and is empty in one of them."""

    kind: str
    """"moved", "gone" or "new"."""
    before: int | None
    """The object that it is, or was a part of, where it was, and where it is; None where that is none."""
    now: int | None
    whole: bool
    """Whether it is most of that object."""
    start: tuple[float, float, float] | None
    """Its middle where it was, and where it is [m]."""
    end: tuple[float, float, float] | None
    area: float
    """Its surface that was seen empty there [m²]."""
    last_before: int | None
    """The last frame that shows it where it was, and the first that shows it where it is."""
    first_now: int | None


@dataclass(frozen=True)
class PlaceChange:
    """A place that looks different."""

    node: int
    distance: float
    """Between the mean images before and since, in units of τ_join."""
    words: list[tuple[str, float, float]]
    """The labels whose probability changed most: label, before, now."""


@dataclass(frozen=True)
class Changes:
    """What drives from ``since`` on saw otherwise than those before."""

    since: int
    objects: list[ObjectChange]
    places: list[PlaceChange]


@dataclass(frozen=True)
class MergedMaps:
    """What :func:`merge_maps` did."""

    drives: int
    frames: int
    places: int
    recognized: list[bool]
    """Of the maps but the first: whether a place of the maps before was recognized in it."""
    aligned: list[bool]
    """And whether its poses are known in the merged map."""
    conflicts: list[str]
    """Sentences: options of the first map that have gone; names that people gave to one area in two maps, of which the
    first map's is kept."""


def merge_maps(
    maps: SequenceOf[Path], output: Path, *, existing: str = "refuse", progress: Progress = False
) -> MergedMaps:
    """Makes the map ``output`` of all drives of the maps. Places of two maps that are recognized as one become one; the
    rest is kept apart.

    ``existing``: "refuse" or "replace". Raises InvalidInputError for maps of different labels, models or distances, or
    that have a drive in common; ExistingFileError, MissingFileError and FileError.
    """
    files = [os.fspath(map) for map in maps]
    return cast(
        MergedMaps, _estancia.merge_maps(files, os.fspath(output), existing, progress_callback(progress))
    )


def undo_drive(map: Path, drive: int, *, progress: Progress = False) -> None:
    """Takes a drive out of the map, as if it had never been. Raises InvalidInputError where the map has no such drive,
    or no other; MissingFileError and FileError. Warns of options of the map that have gone."""
    for gone in _estancia.undo_drive(os.fspath(map), drive, progress_callback(progress)):
        warnings.warn(gone, stacklevel=2)
