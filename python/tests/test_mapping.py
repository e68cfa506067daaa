# SPDX-License-Identifier: Apache-2.0
"""Sequences, labelers, mapping, maps and localization, beside the command's answers."""

from __future__ import annotations

import pathlib
import pickle
import signal
import threading
import time
from typing import Any, Callable

import numpy as np
import pytest

import estancia


def gray(level: int) -> estancia._common.Image:
    return np.full((48, 64, 3), level, np.uint8)


def test_a_sequence_gives_frames_images_and_depth(data: Callable[[str], pathlib.Path]) -> None:
    drive = estancia.open_sequence(data("sevenscenes_redkitchen"))
    assert len(drive) == len(list(drive)) > 10
    assert drive.image(0).dtype == np.uint8 and drive.image(0).shape[2] == 3
    depth = drive.depth(-1)
    assert depth.dtype == np.float32 and 0.3 < np.median(depth[depth > 0]) < 10
    assert drive.camera is not None and drive[0].pose is not None
    with pytest.raises(IndexError):
        drive[len(drive)]


def test_an_unknown_path_and_an_unknown_option_are_said() -> None:
    with pytest.raises(FileNotFoundError) as missing:
        estancia.open_sequence("/nowhere/at/all")
    assert isinstance(missing.value, estancia.Error) and missing.value.code == "file-not-found"
    with pytest.raises(ValueError):
        estancia.open_sequence("/", views_per_place=3)  # type: ignore[call-arg]


def test_the_default_network_labels_as_the_command_does(
    panoramas: pathlib.Path, command: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    tour = estancia.open_sequence(panoramas, views=1)
    labeler = estancia.load_model()
    labels = labeler.label_sequence(tour, cache=False)
    command("label", panoramas, "--views", 1, "-o", tmp_path / "tour.labels", "--no-cache")
    stored = estancia.read_labels(tmp_path / "tour.labels")
    assert stored.labels == labels.labels and [f.name for f in stored.frames] == [f.name for f in labels.frames]
    np.testing.assert_array_equal(stored.probabilities, labels.probabilities)
    np.testing.assert_allclose(labeler.label(tour.image(3)), labels.probabilities[3], atol=1e-5)
    best = labeler.best(tour.image(3), 2)
    assert best[0].label == labels.labels[int(np.argmax(labels.probabilities[3]))]


def test_a_callable_labels_and_its_exception_comes_through(room_labeler: estancia.CallableLabeler) -> None:
    assert room_labeler.label(gray(255)).tolist() == [1.0, 0.0]
    vector = estancia.CallableLabeler(lambda image: [0.25, 0.75], ["a", "b"])
    assert vector.best(gray(1))[0] == estancia.LabelProbability("b", 0.75)

    def fails(image: Any) -> list[float]:
        raise KeyError("the camera is upside down")

    with pytest.raises(KeyError, match="upside down"):
        estancia.CallableLabeler(fails, ["a"]).label(gray(0))
    for answer in ([0.5], [0.5, float("nan")], [2.0, 0.0], {"c": 1.0}, "words"):
        with pytest.raises(estancia.Error):
            estancia.CallableLabeler(lambda image: answer, ["a", "b"]).label(gray(0))


@pytest.mark.parametrize("array", [np.zeros((4, 4, 2), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8), 7])
def test_what_is_no_image_is_refused(array: Any, room_labeler: estancia.CallableLabeler) -> None:
    with pytest.raises(estancia.InvalidInputError):
        room_labeler.label(array)


def test_slices_are_understood_and_kept_images_stay() -> None:
    seen: list[Any] = []
    labeler = estancia.CallableLabeler(lambda image: (seen.append(image), [1.0])[1], ["a"])
    image = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
    parts = [image[10:20], image[:, 5:9], image[::2], image[:, :, ::-1], np.asfortranarray(image), image[:, ::-1]]
    for part in parts:
        labeler.label(part)
    for part, kept in zip(parts, seen):
        np.testing.assert_array_equal(kept, part)


def test_a_session_maps_frame_by_frame_and_goes_on(
    tmp_path: pathlib.Path, room_labeler: estancia.CallableLabeler
) -> None:
    path = tmp_path / "home.estancia"
    with estancia.MappingSession(path, room_labeler, distance="hellinger", tau_join=0.3, tau_revisit=0.3) as session:
        places = [session.add(gray(level), 0.1 * i) for i, level in enumerate([20] * 6 + [240] * 6 + [20] * 6)]
        assert places[0] == places[-1] != places[6]
    with pytest.raises(estancia.Error):
        session.add(gray(0))
    with estancia.MappingSession(path, room_labeler) as session:
        assert session.frames == 18
        session.add(gray(240))
        assert len(session.map().frames) == 19
    answers = estancia.read_map(path).ask("oven")
    assert answers.places[0].node == places[6] and answers.places[0].matched == "oven"


def test_a_map_of_labels_is_that_of_the_command(
    labels: estancia.Labels, home: estancia.Map, command: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    labels.write(tmp_path / "home.labels")
    out = tmp_path / "home.estancia"
    options = ["--distance", "hellinger", "--tau-join", 0.3, "--tau-revisit", 0.3]
    printed = command("map", tmp_path / "home.labels", "-o", out, *options)
    assert (printed["frames"], printed["nodes"]) == (len(home.frames), len(home.places)) == (80, 2)
    other = estancia.read_map(out)
    assert home.places == other.places and home.frames == other.frames and home.transitions == other.transitions
    np.testing.assert_array_equal(home.means, other.means)
    asked = command("ask", out, "oven")
    best = home.ask("oven").places[0]
    assert best.node == asked["places"][0]["node"] and best.likely
    assert best.probability == pytest.approx(asked["places"][0]["probability"])
    assert home.route("oven").nodes == command("route", out, "--to", "oven", "--from", 0)["nodes"]


def test_a_map_answers_explains_and_shows_itself(home: estancia.Map, tmp_path: pathlib.Path) -> None:
    assert "2 places" in repr(home)
    assert home.places[0].room == "living room" and home.places[0].position is not None
    assert any("place" in sentence or "node" in sentence for sentence in home.explain(0))
    assert {measure.key for measure in home.measures()} >= {"nodes"} or home.measures()
    assert "graphml" in home.export("graphml")
    assert home._repr_html_().startswith("<iframe")
    home.write_page(tmp_path / "home.html")
    assert "</html>" in (tmp_path / "home.html").read_text()
    assert [path.name for path in tmp_path.iterdir()] == ["home.html"]
    with pytest.raises(estancia.NoAnswerError):
        home.ask("zzyzx")
    with pytest.raises(LookupError):
        home.route("zzyzx")
    with pytest.raises(estancia.InvalidInputError):
        home.route(99)


def test_existing_maps_are_refused_replaced_or_continued(labels: estancia.Labels, tmp_path: pathlib.Path) -> None:
    path = tmp_path / "home.estancia"
    estancia.map_sequence(labels, path)
    with pytest.raises(FileExistsError):
        estancia.map_sequence(labels, path)
    assert len(estancia.map_sequence(labels, path, existing="continue").frames) == 80
    assert len(estancia.map_sequence(labels, path, existing="replace").frames) == 80
    with pytest.raises(estancia.InvalidInputError):
        estancia.map_sequence(labels, path, existing="overwrite")


def test_the_localizer_finds_the_mapped_frames(home: estancia.Map, labels: estancia.Labels) -> None:
    localizer = estancia.Localizer(home.path)
    found = [localizer.add(row)[0] for row in labels.probabilities[:30]]
    assert [at.node for at in found] == [frame.node for frame in home.frames[:30]]
    assert all(0 < at.confidence <= 1 for at in found) and found[-1].nearest_image == 29


def test_the_mapper_says_what_it_decided(labels: estancia.Labels) -> None:
    mapper = estancia.Mapper(len(labels.labels), distance="hellinger", tau_join=0.3, tau_revisit=0.3)
    places = [mapper.add(row) for row in labels.probabilities]
    mapper.finish()
    changes = mapper.take_changes()
    assert [d.kind for d in changes.decisions if d.kind != "join"] == ["start", "create-node", "revisit", "revisit"]
    assert len(set(places)) == mapper.places == 2 and mapper.transitions[0].count == 2
    with pytest.raises(estancia.InvalidInputError):
        mapper.add([0.5])


def test_progress_is_told_and_may_stop_the_work(panoramas: pathlib.Path) -> None:
    tour = estancia.open_sequence(panoramas)
    labeler = estancia.CallableLabeler(lambda image: [1.0], ["a"])
    told: list[tuple[str, int, int]] = []
    labeler.label_sequence(tour, progress=lambda *now: told.append(now))
    assert told[0][1:] == (0, len(tour)) and told[-1][1:] == (len(tour), len(tour))

    def stop(what: str, done: int, total: int) -> None:
        raise TimeoutError("no patience")

    with pytest.raises(TimeoutError, match="no patience"):
        labeler.label_sequence(tour, progress=stop)


def test_ctrl_c_is_heard_in_long_work_and_work_goes_on_later(panoramas: pathlib.Path, tmp_path: pathlib.Path) -> None:
    tour = estancia.open_sequence(panoramas, rounds=50)
    timer = threading.Timer(1.0, signal.raise_signal, [signal.SIGINT])
    labeler = estancia.CallableLabeler(lambda image: [float(image[0, 0, 0]) / 255, 0.1], ["a", "b"])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        estancia.map_sequence(tour, tmp_path / "tour.estancia", labeler)
    before = len(estancia.read_map(tmp_path / "tour.estancia").frames)
    assert 0 < before < len(tour)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    few = estancia.open_sequence(panoramas)
    assert len(labeler.label_sequence(few)) == len(few)  # nothing is left of the interrupt


def test_other_threads_run_meanwhile(panoramas: pathlib.Path) -> None:
    count = 0
    done = threading.Event()

    def work() -> None:
        estancia.load_model().label_sequence(estancia.open_sequence(panoramas, views=2), cache=False)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0.001)
    thread.join()
    assert count > 100


def test_small_results_are_pickled(home: estancia.Map, labels: estancia.Labels) -> None:
    for value in (home.places, home.ask("oven"), home.route("oven"), labels.frames, home.decisions[0].kind, home.areas):
        assert pickle.loads(pickle.dumps(value)) == value
    error = pickle.loads(pickle.dumps(estancia.NoAnswerError("none", "no-answer")))
    assert (str(error), error.code) == ("none", "no-answer")


def test_a_replayed_recording_is_mapped_live(panoramas: pathlib.Path, tmp_path: pathlib.Path) -> None:
    labeler = estancia.CallableLabeler(lambda image: [float(image.mean()) / 255, 0.1], ["a", "b"])
    heard: list[estancia.LiveStatus] = []
    loop = estancia.LiveLoop(panoramas, tmp_path / "live.estancia", labeler, replay={"rate": 0}, sequence={"views": 2})
    with loop as live:
        result = live.run(heard.append)
    assert len(result.frames) == len(heard) and heard[-1].places[0][0] == result.frames[-1].node


def test_areas_and_objects_of_a_home(data: Callable[[str], pathlib.Path], tmp_path: pathlib.Path) -> None:
    drive = estancia.open_sequence(data("home_a") / "day")
    labeler = estancia.CallableLabeler(lambda image: [0.9, 0.1], ["a", "b"])
    result = estancia.map_sequence(drive, tmp_path / "day.estancia", labeler)
    assert len(result.areas) >= 3 and len(result.objects) >= 5
    result.name_area(result.areas[0].id, "Emma's room")
    assert estancia.read_map(result.path).areas[0].name == "Emma's room" == result.areas[0].name
    assert result.route("Emma's room", result.frames[-1].node).areas[-1] == 0


def test_a_live_loop_ends_by_what_its_listener_raises_or_says(panoramas: pathlib.Path, tmp_path: pathlib.Path) -> None:
    labeler = estancia.CallableLabeler(lambda image: [float(image.mean()) / 255, 0.1], ["a", "b"])

    def fails(now: estancia.LiveStatus) -> None:
        raise BufferError(now.frame)

    with estancia.LiveLoop(panoramas, tmp_path / "one.estancia", labeler, replay={"rate": 0}) as live:
        with pytest.raises(BufferError):
            live.run(fails)
    with estancia.LiveLoop(panoramas, tmp_path / "two.estancia", labeler, replay={"rate": 0}) as live:
        stopped = live.run(lambda now: live.stop() if now.frames >= 3 else None)
    assert 3 <= len(stopped.frames) < 216


def test_several_drives_are_one_map(tmp_path: pathlib.Path) -> None:
    rng = np.random.default_rng(3)
    looks = np.exp(1.5 * rng.normal(size=(8, 40)))

    def image(place: int) -> list[float]:
        row = looks[place] * np.exp(0.4 * rng.normal(size=40))
        return [float(p) for p in row / row.sum()]

    labeler = estancia.CallableLabeler(lambda pixels: image(0), [f"word {i}" for i in range(40)])

    def drive(file: pathlib.Path, name: str, steps: range) -> None:
        with estancia.MappingSession(file, labeler) as session:
            session.begin_drive(name)
            for step in steps:
                session.add_labels(f"{name} {step}", image(step // 4 % 8))

    one, other = tmp_path / "one.estancia", tmp_path / "other.estancia"
    drive(one, "first", range(80))
    drive(one, "second", range(10, 60))
    drive(other, "third", range(20, 70))
    drives = estancia.read_map(one).drives
    assert [d.name for d in drives] == ["first", "second"]
    assert drives[1].first_frame == 80 and drives[1].frames == 50
    assert drives[1].recognized_after is not None
    assert estancia.read_map(one).changes().since == 1
    merged = estancia.merge_maps([one, other], tmp_path / "all.estancia")
    assert merged.drives == 3 and merged.frames == 180 and merged.recognized == [True]
    with pytest.raises(estancia.InvalidInputError):
        estancia.merge_maps([one, one], tmp_path / "twice.estancia")
    estancia.undo_drive(one, 0)
    assert [d.name for d in estancia.read_map(one).drives] == ["second"]
