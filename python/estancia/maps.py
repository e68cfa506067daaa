# SPDX-License-Identifier: Apache-2.0
"""Maps: a map file with its places, zones, areas and objects, asked, driven, edited and shown."""

from __future__ import annotations

import base64
import os
import pathlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Sequence as SequenceOf, cast

from . import _estancia
from ._common import FloatArray, Path
from .geometry import Pose
from .labels import LabelProbability, Labels
from .sequences import Frame

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .drives import Changes, Drive
    from .options import ExportOptions, RouteOptions

__all__ = [
    "Answers",
    "Area",
    "Decision",
    "LabelMatch",
    "Map",
    "MapObject",
    "MapZone",
    "MappedFrame",
    "Measure",
    "Merge",
    "ObjectAnswer",
    "Place",
    "PlaceAnswer",
    "RoomProbability",
    "Route",
    "Transition",
    "ViewPose",
    "read_map",
]


@dataclass(frozen=True)
class RoomProbability:
    """A room with its probability."""

    room: str
    probability: float


@dataclass(frozen=True)
class Place:
    """A node of the topological map."""

    id: int
    frames: int
    words: list[LabelProbability]
    """The ten most probable labels of its frames, in the mean."""
    position: tuple[float, float, float] | None
    """Mean of its posed frames [m]."""
    room: str
    """The true room of most of its frames; "" where none is known."""
    predicted_room: str
    """Its name by a room classifier, or by the rooms' names; "" where that is not sure."""
    predicted: list[RoomProbability]
    """Best first."""
    area: int
    """-1 where there are no areas."""


@dataclass(frozen=True)
class Transition:
    """The robot has driven from one place to another."""

    start: int
    end: int
    count: int
    first_frame: int


@dataclass(frozen=True)
class MappedFrame(Frame):
    """A frame of the map and its place."""

    node: int = 0


@dataclass(frozen=True)
class Decision:
    """Why a frame belongs to its place."""

    frame: int
    kind: str
    """"start", "join", "revisit" or "create-node"."""
    node: int
    current: int
    """The place where the robot was before; -1 at the start."""
    to_current: float
    other: int
    """The nearest other place; -1 where it was not searched."""
    to_other: float
    tau_join: float
    tau_revisit: float


@dataclass(frozen=True)
class Merge:
    """Two places turned out to be one."""

    frame: int
    kept: int
    absorbed: int
    distance: float
    threshold: float


@dataclass(frozen=True)
class Area:
    """A part of the floor that walls and doors enclose."""

    id: int
    name: str
    """For people: the given name, else the room, else the telling words."""
    words: str
    """The words that distinguish what is in it."""
    given_name: str
    room: str
    """The room that it surely is; "" for none."""
    predicted_room: str
    room_probability: float
    size: float
    """[m²]"""
    center: tuple[float, float]
    """On the floor [m]."""
    outline: list[tuple[float, float]]
    frames: int


@dataclass(frozen=True)
class MapObject:
    """A thing that was seen in several frames."""

    id: int
    name: str
    given_name: str
    probability: float
    words: list[LabelProbability]
    shape_classes: list[LabelProbability]
    center: tuple[float, float, float]
    """Middle of its upright box in the map [m]."""
    size: tuple[float, float, float]
    """Of the box before it is turned [m]."""
    yaw: float
    """Turn of the box about the floor's up [rad]."""
    color: list[int]
    """Red, green, blue."""
    flat: bool
    views: int
    best_frame: int
    support: str
    """What it stands on: "floor", "object", "surface", "wall" or "" for unknown."""
    on_object: int
    area: int
    known_name: str
    """The known object that was recognized; "" for none."""
    known_pose: Pose | None


@dataclass(frozen=True)
class MapZone:
    """Frames that look alike, wherever they are."""

    id: int
    name: str
    frames: int


@dataclass(frozen=True)
class LabelMatch:
    """A label that words mean."""

    label: str
    probability: float
    """That a person would take the label for an answer."""
    reason: str
    """Why; "" where the label has that name."""


@dataclass(frozen=True)
class PlaceAnswer:
    """A place that holds what was asked for."""

    node: int
    probability: float
    lift: float
    """How much more probable than in the mean of the map."""
    rank: int
    matched: str
    """The label, or room, that matched best."""
    likely: bool


@dataclass(frozen=True)
class ObjectAnswer:
    """An object that is what was asked for."""

    object: int
    probability: float
    lift: float
    rank: int
    matched: str
    likely: bool


@dataclass(frozen=True)
class Answers:
    """What words mean in a map."""

    question: str
    places: list[PlaceAnswer]
    """Most probable first."""
    objects: list[ObjectAnswer]
    areas: list[int]
    """Of this name."""
    rooms: list[str]
    matches: list[LabelMatch]
    corrected: str
    """The words that were looked for, where some were misspelled."""


@dataclass(frozen=True)
class ViewPose:
    """Where to stand to look at an object, on the floor [m, rad]."""

    x: float
    y: float
    yaw: float
    distance: float


@dataclass(frozen=True)
class Route:
    """The cheapest way."""

    nodes: list[int]
    """The places along it."""
    cost: float
    """[m] where ``metric``, else transitions."""
    metric: bool
    areas: list[int]
    path: list[tuple[float, float]] | None
    """On the floor [m]; None without poses."""
    place: PlaceAnswer | None
    """The goal, where words were asked for and a place holds them."""
    object: ObjectAnswer | None
    area: int
    pose: ViewPose | None
    crossed: list[str]
    """What was to be avoided and is crossed all the same."""


@dataclass(frozen=True)
class Measure:
    """One measure of quality."""

    key: str
    name: str
    value: float | None
    """None where it cannot be known."""
    explanation: str


class Map:
    """A map file as of one moment. Made by :func:`read_map`; a notebook shows its page."""

    def __init__(self, core: Any, path: pathlib.Path) -> None:
        self._core = core
        self.path = path
        """The file, an absolute path."""

    def __repr__(self) -> str:
        frames, places, areas, objects = self._core.counts
        return f"<estancia.Map {self.path.name!r}: {frames} frames, {places} places, {areas} areas, {objects} objects>"

    def _repr_html_(self) -> str:
        page = base64.b64encode(self.page().encode()).decode()
        return (
            f'<iframe src="data:text/html;base64,{page}" title="{self.path.stem}" sandbox="allow-scripts"'
            ' style="width:100%;height:640px;border:1px solid #ccc"></iframe>'
        )

    @property
    def labels(self) -> list[str]:
        """The labels that its places are described by."""
        return cast("list[str]", self._core.labels)

    @property
    def model(self) -> str:
        """Identity of the labeler."""
        return cast(str, self._core.model)

    @property
    def distance(self) -> str:
        """Name of the distance that places are told apart by."""
        return cast(str, self._core.distance)

    @property
    def places(self) -> list[Place]:
        """By their ids."""
        return cast("list[Place]", self._core.places)

    @property
    def means(self) -> FloatArray:
        """The mean descriptor of each place: places × labels."""
        return cast(FloatArray, self._core.means)

    @property
    def transitions(self) -> list[Transition]:
        """Between places, as driven."""
        return cast("list[Transition]", self._core.transitions)

    @property
    def frames(self) -> list[MappedFrame]:
        """In driving order."""
        return cast("list[MappedFrame]", self._core.frames)

    @property
    def drives(self) -> list[Drive]:
        """In order of frames."""
        return cast("list[Drive]", _estancia.drives_of(self._core))

    def changes(self, since: int | None = None) -> Changes:
        """What drives from ``since`` on (the last one) saw otherwise than those before. Raises InvalidInputError where
        the map has one drive, or not that one."""
        return cast("Changes", _estancia.changes(self.path, since))

    @property
    def decisions(self) -> list[Decision]:
        """One a frame."""
        return cast("list[Decision]", self._core.decisions)

    @property
    def areas(self) -> list[Area]:
        """Empty without poses and depth."""
        return cast("list[Area]", self._core.areas)

    @property
    def objects(self) -> list[MapObject]:
        """Empty without depth."""
        return cast("list[MapObject]", self._core.objects)

    @property
    def zones(self) -> list[MapZone]:
        """By falling number of frames."""
        return cast("list[MapZone]", self._core.zones)

    @property
    def zone_of_frame(self) -> list[int]:
        """-1 where there are no zones."""
        return cast("list[int]", self._core.zone_of_frame)

    @property
    def area_of_frame(self) -> list[int]:
        """-1 where there are no areas."""
        return cast("list[int]", self._core.area_of_frame)

    def descriptors(self) -> Labels:
        """The label probabilities of its frames, read from the file."""
        return Labels._of(_estancia.read_map_labels(os.fspath(self.path)))

    def ask(self, words: str, count: int = 10, *, understand: bool = True) -> Answers:
        """Where is it? Places, objects and areas that hold what the words mean.

        ``understand``: words that no label has are understood by WordNet, where it is installed. Raises NoAnswerError
        when nothing matches, with near spellings.
        """
        return cast(Answers, self._core.ask(words, count, understand))

    def route(
        self,
        to: str | int,
        start: int = 0,
        *,
        avoid: SequenceOf[str] = (),
        prefer: SequenceOf[str] = (),
        understand: bool = True,
        **options: Unpack[RouteOptions],
    ) -> Route:
        """The cheapest way from the place ``start`` to a place, or to the area, object or place that the words mean.

        ``avoid``, ``prefer``: areas, rooms or words. Options: :class:`estancia.options.RouteOptions`. Raises
        NoAnswerError when nothing matches or no way leads there.
        """
        return cast(Route, self._core.route(to, start, list(avoid), list(prefer), dict(options), understand))

    def explain(self, frame: int | str) -> list[str]:
        """Sentences: why a frame, by its number or name, belongs to its place."""
        return cast("list[str]", self._core.explain(str(frame)))

    def measures(self) -> list[Measure]:
        """Quality against true rooms and poses, as far as these are known."""
        return cast("list[Measure]", self._core.measures())

    def export(self, format: str = "json", **options: Unpack[ExportOptions]) -> str:
        """The map as "graphml", "json", "nav2" (GeoJSON of Nav2's route server) or another of the formats of
        ``estancia export``. Options: :class:`estancia.options.ExportOptions`."""
        return cast(str, self._core.export(format, dict(options)))

    def page(self, title: str = "", image_bytes: int = 1_200_000) -> str:
        """The map as one HTML page that needs nothing else, with at most so many bytes of images."""
        return cast(str, _estancia.map_page(os.fspath(self.path), title, image_bytes))

    def write_page(self, file: Path, title: str = "") -> None:
        """Writes that page."""
        _write_whole(file, self.page(title))

    def object_image(self, object: int) -> bytes:
        """The best image of an object, a JPEG; empty where there is none."""
        return cast(bytes, _estancia.object_image(os.fspath(self.path), object))

    def name_area(self, area: int | str, name: str) -> None:
        """Gives an area a name, in the file, too; "" takes it away. Raises InvalidInputError when there is no such
        area."""
        self._edit("name_area", str(area), name)

    def merge_areas(self, area: int | str, other: int | str) -> None:
        """Makes two areas one, in the file, too."""
        self._edit("merge_areas", str(area), str(other))

    def split_area(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Cuts the area along the line between two points of the floor [m], in the file, too."""
        self._edit("split_area", start, end)

    def name_object(self, object: int | str, name: str) -> None:
        """Gives an object a name, in the file, too; "" takes it away."""
        self._edit("name_object", str(object), name)

    def delete_object(self, object: int | str) -> None:
        """Removes an object, in the file, too."""
        self._edit("delete_object", str(object))

    def name_rooms(self, rooms: SequenceOf[str] = ()) -> None:
        """Names places and areas by the rooms' names alone, in the file, too; by default common rooms are tried. Needs
        WordNet."""
        self._edit("name_rooms", list(rooms))

    def _edit(self, function: str, *arguments: Any) -> None:
        getattr(_estancia, function)(os.fspath(self.path), *arguments)
        self._core = _estancia.read_map(os.fspath(self.path))


def read_map(file: Path) -> Map:
    """Reads a map file as of its last second, also while it is being written. Raises MissingFileError and
    FileError."""
    return Map(_estancia.read_map(os.fspath(file)), pathlib.Path(file).absolute())


def _write_whole(file: Path, text: str) -> None:
    """Writes beside, then renames: a reader never sees half of it."""
    target = pathlib.Path(file)
    beside = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, target)
    finally:
        beside.unlink(missing_ok=True)
