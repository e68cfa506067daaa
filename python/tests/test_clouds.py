# SPDX-License-Identifier: Apache-2.0
"""Point clouds, recognition, segmentation, odometry and objects."""

from __future__ import annotations

import pathlib
import pickle
from typing import Any, Callable

import numpy as np
import pytest

import estancia


def ball(count: int = 4000) -> estancia.PointCloud:
    random = np.random.default_rng(7)
    points = random.normal(size=(count, 3))
    return estancia.PointCloud(0.1 * points / np.linalg.norm(points, axis=1, keepdims=True) + [0, 0, 1])


def test_a_cloud_keeps_what_it_is_given(tmp_path: pathlib.Path) -> None:
    points = np.random.default_rng(1).normal(size=(50, 3)).astype(np.float32)
    colors = np.arange(150, dtype=np.uint8).reshape(50, 3)
    cloud = estancia.PointCloud(points, colors)
    np.testing.assert_array_equal(cloud.points, points)
    np.testing.assert_array_equal(cloud.colors, colors)
    assert cloud.normals is None and len(cloud) == 50
    with pytest.raises(ValueError, match="read-only"):
        cloud.points[0, 0] = 1
    view = cloud.points
    del cloud
    assert view.sum() == pytest.approx(points.sum())  # the view keeps the cloud
    again = estancia.PointCloud(points, colors)
    again.write(tmp_path / "millimeters.ply")
    scaled = estancia.read_cloud(tmp_path / "millimeters.ply", unit="mm")
    np.testing.assert_allclose(1000 * scaled.points, points, rtol=1e-6)
    for name in ("cloud.pcd", "cloud.ply"):
        again.write(tmp_path / name)
        np.testing.assert_array_equal(estancia.read_cloud(tmp_path / name).points, points)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(again)).colors, colors)
    assert estancia.PointCloud(points.reshape(5, 10, 3)).height == 5


@pytest.mark.parametrize("points", [np.zeros((4, 2)), np.zeros(3), np.zeros((2, 2, 2, 3))])
def test_what_are_no_points_is_refused(points: Any) -> None:
    with pytest.raises(estancia.InvalidInputError):
        estancia.PointCloud(points)


def test_filters_and_gas_are_those_of_the_command(command: Callable[..., Any], tmp_path: pathlib.Path) -> None:
    cloud = ball().with_noise(0.002, seed=3)
    cloud.write(tmp_path / "ball.ply")
    command("filter", tmp_path / "ball.ply", "-o", tmp_path / "gng.ply", "--filter", "gng", "--points", 300)
    ours = estancia.filter_cloud(cloud, method="gng", points=300)
    np.testing.assert_array_equal(ours.points, estancia.read_cloud(tmp_path / "gng.ply").points)
    gas = estancia.grow_neural_gas(cloud, neurons=200, signals_per_insertion=100)
    assert len(gas.cloud) == 200 and gas.stop == "neurons" and gas.edges.max() < 200
    normals = estancia.estimate_normals(ball(), radius=0.03).normals
    assert normals is not None
    outward = (ball().points - [0, 0, 1]) / 0.1
    assert np.median(np.abs((normals * outward).sum(axis=1))) > 0.99
    assert 0 < cloud.resolution() < 0.02 and 0.001 < cloud.noise() < 0.004


def test_a_known_object_is_found_as_the_command_finds_it(
    data: Callable[[str], pathlib.Path], command: Callable[..., Any]
) -> None:
    home = data("shot_kinect")
    scene, model = home / "scenes/scene039.pcd", home / "meshes/Frog012_0.ply"
    recognizer = estancia.Recognizer({"frog": estancia.read_cloud(model)})
    found = recognizer.detect(estancia.read_cloud(scene))
    told = command("recognize", scene, "--object", f"frog={model}")
    printed = told["instances"]
    assert len(found) == len(printed) and len(found.maybe) == len(told.get("maybe", []))
    for ours, theirs in zip(found, printed):
        assert ours.model == "frog" and ours.confidence == pytest.approx(theirs["confidence"])
        np.testing.assert_allclose(ours.pose[:3, 3], np.array(theirs["pose"]).reshape(-1, 4)[:3, 3], atol=1e-5)
    assert len(found) == 1
    rate = printed[0]["false_alarm_rate"] / 3  # up to ten times as much is `maybe`
    strict = estancia.Recognizer({"frog": estancia.read_cloud(model)}, false_alarm_rate=rate)
    doubtful = strict.detect(estancia.read_cloud(scene))
    assert doubtful == [] and [one.model for one in doubtful.maybe] == ["frog"]
    image = estancia.draw_clouds(estancia.read_cloud(scene), width=320, height=240)
    assert image.shape == (240, 320, 3) and image.std() > 0
    with pytest.raises(estancia.InvalidInputError):
        estancia.Recognizer(preset="quick")


def test_things_are_segmented_and_a_camera_is_tracked(data: Callable[[str], pathlib.Path]) -> None:
    drive = estancia.open_sequence(data("sevenscenes_redkitchen"))
    camera, depth, image = drive.camera, drive.depth(0), drive.image(0)
    assert camera is not None
    found = estancia.find_clusters(depth, camera, image)
    assert found.clusters and found.planes and max(cluster.points.max() for cluster in found.clusters) < depth.size
    cloud = estancia.PointCloud.from_depth(depth, camera)
    assert cloud.height == depth.shape[0] and estancia.find_clusters(cloud).clusters
    tracker = estancia.RgbdTracker(camera)
    placed = [tracker.add(drive.image(i), drive.depth(i)) for i in range(3)]
    assert placed[0].pose is not None and len(tracker) == 3
    with pytest.raises(estancia.InvalidInputError):
        estancia.find_clusters((1000 * depth).astype(np.uint16), camera)  # type: ignore[arg-type]


def test_objects_are_collected_and_learned(data: Callable[[str], pathlib.Path], tmp_path: pathlib.Path) -> None:
    drive = estancia.open_sequence(data("home_a") / "day")
    done = estancia.collect_objects(drive, tmp_path / "samples", every=20)
    assert done.samples > 5 and done.instances > 1
    with pytest.raises(FileExistsError):
        estancia.collect_objects(drive, tmp_path / "samples", every=20)


def test_poses_are_matrices_and_back() -> None:
    pose = estancia.Pose.planar(1, 2, 0.5)
    again = estancia.Pose.from_matrix(pose.matrix())
    np.testing.assert_allclose(again.matrix(), pose.matrix(), atol=1e-12)
    assert pose.matrix()[:3, 2] == pytest.approx([np.cos(0.5), np.sin(0.5), 0])
    camera = estancia.Camera(640, 480, 500, 500, 319.5, 239.5).scaled_to(320, 240)
    assert (camera.fx, camera.cx) == (250, 159.5)
    with pytest.raises(estancia.InvalidInputError):
        estancia.Pose.from_matrix(np.eye(3))
