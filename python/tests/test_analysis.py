# SPDX-License-Identifier: Apache-2.0
"""Zones, classifiers, statistics and words, beside SciPy, scikit-learn and the command."""

from __future__ import annotations

import math
import pathlib
from typing import Any, Callable

import numpy as np
import pytest

import estancia


def test_zones_are_those_of_the_command(
    labels: estancia.Labels, command: Callable[..., Any], tmp_path: pathlib.Path
) -> None:
    zones = estancia.find_zones(labels, count=2)
    assert sorted(len(zone.images) for zone in zones) == [40, 40]
    assert {zone.room for zone in zones} == {"living room", "kitchen"}
    labels.write(tmp_path / "run.labels")
    command("zones", "find", tmp_path / "run.labels", "-o", tmp_path / "run.zones", "--count", 2)
    stored = estancia.read_zones(tmp_path / "run.zones")
    assert stored.zone_of == zones.zone_of and [zone.name for zone in stored] == [zone.name for zone in zones]
    zones.write(tmp_path / "mine.zones")
    np.testing.assert_array_equal(estancia.read_zones(tmp_path / "mine.zones")[0].mean, zones[0].mean)
    zones.write_page(tmp_path / "zones.html")
    assert "</html>" in (tmp_path / "zones.html").read_text()
    with pytest.raises(estancia.InvalidInputError):
        estancia.find_zones(labels, count=2, cut=0.5)


def test_a_zone_stream_agrees_with_all_at_once(labels: estancia.Labels) -> None:
    stream = estancia.ZoneStream(labels.labels, count=2)
    for row in labels.probabilities:
        stream.add(row)
    zones = stream.finish(labels)
    agreement = estancia.measure_agreement(estancia.find_zones(labels, count=2).zone_of, zones.zone_of)
    assert agreement.adjusted_rand_index == pytest.approx(1)


def test_linkage_is_that_of_scipy(labels: estancia.Labels) -> None:
    hierarchy = pytest.importorskip("scipy.cluster.hierarchy")
    distance = pytest.importorskip("scipy.spatial.distance")
    p = labels.probabilities.astype(np.float64)
    ours = estancia.pairwise_distances(labels.probabilities, "hellinger")
    theirs = distance.pdist(np.sqrt(p))
    assert np.corrcoef(ours, theirs)[0, 1] > 1 - 1e-6
    z = estancia.linkage(theirs, len(p), "average")
    np.testing.assert_allclose(z, hierarchy.linkage(theirs, "average"), rtol=1e-12)
    with pytest.raises(estancia.InvalidInputError):
        estancia.linkage(theirs[:-1], len(p))
    assert "hellinger" in estancia.distances() and "ward" in estancia.linkages()


def test_rank_tests_are_those_of_scipy() -> None:
    stats = pytest.importorskip("scipy.stats")
    scores = np.random.default_rng(3).normal(size=(25, 4)) + [0, 0.2, 0.5, 1.5]
    ours, theirs = estancia.friedman_test(scores), stats.friedmanchisquare(*scores.T)
    assert ours.chi_squared == pytest.approx(theirs.statistic) and ours.p == pytest.approx(theirs.pvalue)
    test = estancia.wilcoxon_test(scores[:, 0], scores[:, 3])
    assert test.p == pytest.approx(stats.wilcoxon(scores[:, 0], scores[:, 3]).pvalue)
    found = estancia.compare_methods({f"m{i}": scores[:, i] for i in range(4)}, post_hoc="holm")
    assert found.methods[0].method == found.control == "m3" and found.differ
    assert found.methods[-1].p is not None and found.methods[-1].p < 0.05
    assert estancia.holm_adjusted([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    with pytest.raises(estancia.InvalidInputError):
        estancia.friedman_test([[1.0, math.nan]])


def test_a_classifier_has_the_manners_of_scikit_learn(labels: estancia.Labels) -> None:
    x, y = labels.probabilities, np.array([frame.room for frame in labels.frames])
    classifier = estancia.Classifier(type="svm-linear").fit(x[::2], y[::2])
    assert list(classifier.classes_) == ["kitchen", "living room"]
    p = classifier.predict_proba(x)
    assert p.shape == (80, 2) and np.allclose(p.sum(axis=1), 1, atol=1e-5)
    assert classifier.score(x[1::2], y[1::2]) == 1
    model_selection = pytest.importorskip("sklearn.model_selection")
    base = pytest.importorskip("sklearn.base")
    assert base.clone(classifier).get_params() == {"type": "svm-linear"}
    assert model_selection.cross_val_score(classifier, x, y, cv=4).min() == 1
    with pytest.raises(estancia.Error):
        estancia.Classifier().predict(x)
    with pytest.raises(estancia.InvalidInputError):
        estancia.Classifier(type="perceptron").fit(x, y)  # type: ignore[arg-type]


def test_a_room_classifier_learns_from_labels(labels: estancia.Labels, tmp_path: pathlib.Path) -> None:
    rooms = estancia.train_room_classifier(labels, type="linear")
    assert rooms.rooms == ["kitchen", "living room"] and rooms.training_images == 80
    features = estancia.Features(labels)
    assert rooms.predict(features) == features.rooms
    rooms.write(tmp_path / "rooms.classifier")
    again = estancia.read_room_classifier(tmp_path / "rooms.classifier")
    np.testing.assert_array_equal(again.predict_proba(features), rooms.predict_proba(features))


def test_images_are_described(panoramas: pathlib.Path) -> None:
    tour = estancia.open_sequence(panoramas, views=1)
    features = estancia.describe_sequence(tour, "gist+phog")
    assert features.name == "gist+phog" and len(features.columns) == features.values.shape[1]
    gist = estancia.describe_image(tour.image(0), "gist")
    np.testing.assert_array_equal(gist, features.values[0, : len(gist)])
    with pytest.raises(estancia.InvalidInputError):
        estancia.describe_sequence(tour, "gits")


def test_words_are_understood() -> None:
    names = ["espresso maker", "studio couch, day bed", "desk", "Labrador retriever", "beagle"]
    if estancia.wordnet_hint():
        pytest.skip(estancia.wordnet_hint())
    assert estancia.search_labels(names, "coffee")[0].label == "espresso maker"
    assert estancia.familiar_words(names, [0.0, 0.0, 0.0, 0.3, 0.3], 1)[0].label in ("dog", "hunting dog")
    assert estancia.find_name(["living room", "bathroom"], "sitting room") == "living room"
    assert "kitchen" in estancia.common_rooms()


def test_rooms_are_told_by_their_names(panoramas: pathlib.Path) -> None:
    if estancia.wordnet_hint():
        pytest.skip(estancia.wordnet_hint())
    labels = estancia.load_model().label_sequence(estancia.open_sequence(panoramas, views=1))
    ranked = estancia.rooms_by_name(labels, ["bedroom", "forest", "workshop"])
    assert len(ranked) == len(labels)
    assert sum(r.probability for r in ranked[0]) == pytest.approx(1, abs=1e-4)
