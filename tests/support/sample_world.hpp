// A small made-up home with places, areas and objects, as plain data and as a map file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/areas/plan_areas.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia::test {

/// A name that tries what is to be quoted.
inline const std::string hostileName = "Ana's \"old\" <chair> & co\nlamp";

/// Rooms of the sample world, as rectangles of the floor [m]; a wall stands between them.
inline const std::vector<cv::Rect2d> sampleRooms{{0, 0, 4, 8}, {4, 0, 2, 4}, {4, 4, 2, 4}, {6, 0, 4, 8}};
/// Doors at 2 m and 6 m up, on the walls at x = 4 and x = 6.
inline AreaPlan samplePlan() {
  AreaPlan plan{{}, Floor(cv::Vec3d(0, 0, 1)), FloorCells(0.1, {0, 0, 100, 80}), {}, {}};
  plan.areaOf = cv::Mat(80, 100, CV_32S, cv::Scalar(-1));
  plan.walls = cv::Mat(80, 100, CV_8U, cv::Scalar(0));
  for (std::size_t i = 0; i < sampleRooms.size(); ++i) {
    const cv::Rect2d& room = sampleRooms[i];
    const cv::Rect cells(static_cast<int>(room.x * 10), static_cast<int>(room.y * 10),
                         static_cast<int>(room.width * 10), static_cast<int>(room.height * 10));
    plan.areaOf(cells) = static_cast<int>(i);
    plan.areas.push_back({.id = static_cast<int>(i),
                          .size = room.area(),
                          .center = (room.tl() + room.br()) / 2,
                          .outline = {room.tl(), {room.br().x, room.y}, room.br(), {room.x, room.br().y}}});
  }
  const auto wall = [&plan](cv::Rect cells) {
    plan.areaOf(cells) = -1;
    plan.walls(cells) = 255;
  };
  for (const int x : {40, 60})
    for (const auto& [from, to] : {std::pair{0, 16}, {24, 56}, {64, 80}}) wall({x, from, 1, to - from});
  wall({40, 40, 20, 1});
  return plan;
}

inline MappedFrame sampleFrame(std::size_t number, int node, double x, double y, double degrees) {
  MappedFrame frame;
  frame.number = number;
  frame.name = "frame_" + std::to_string(number) + ".png";
  frame.timestamp = static_cast<double>(number) / 2;
  frame.pose = Pose::planar(x, y, degrees * std::numbers::pi / 180);
  frame.node = node;
  return frame;
}

/// Places 0 kitchen, 1 bathroom, 2 corridor, 3 living room, in areas of the same numbers; driven 0 → 1 → 3 →
/// 2 → 0. The way through the bathroom is the shorter one.
inline TopologicalMap samplePlaces() {
  TopologicalMap map{.vocabulary = Vocabulary({"coffee mug", "cup, mug", "umbrella", "dining table, board",
                                               "bathtub", "folding chair"}),
                     .model = "model-1",
                     .distance = "hellinger"};
  const auto node = [](int id, std::uint64_t frames, std::vector<float> mean) {
    return Node{id, frames, std::move(mean), std::vector<float>(6, 0.01F)};
  };
  map.nodes = {node(0, 3, {0.3F, 0.2F, 0.0F, 0.4F, 0.0F, 0.1F}), node(1, 1, {0, 0, 0, 0, 0.9F, 0.1F}),
               node(2, 1, {0.1F, 0.1F, 0.1F, 0.1F, 0.1F, 0.5F}),
               node(3, 3, {0.1F, 0.2F, 0.5F, 0.0F, 0.0F, 0.2F})};
  map.frames = {sampleFrame(0, 0, 2, 1, 90),  sampleFrame(1, 0, 2, 4, 90), sampleFrame(2, 0, 2, 2, 0),
                sampleFrame(3, 1, 5, 2, 0),   sampleFrame(4, 3, 7, 2, 0),  sampleFrame(5, 3, 7.5, 4, 90),
                sampleFrame(6, 3, 7, 6, 180), sampleFrame(7, 2, 5, 6, 180)};
  map.transitions = {{0, 1, 1, 3}, {1, 3, 1, 4}, {3, 2, 1, 7}, {2, 0, 1, 8}};
  for (std::size_t i = 0; i < map.frames.size(); ++i)
    map.decisions.push_back({i, i == 0 ? DecisionKind::start : DecisionKind::join, map.frames[i].node,
                             i == 0 ? -1 : map.frames[i - 1].node, 0.1, -1, std::nan(""), 0.3, 0.25});
  return map;
}

/// 0: a dining table in the kitchen; 1: a mug on it; 2: what may be a cup in the living room; 3: an umbrella
/// there; 4: named hostileName; 5: of no size and no words.
inline std::vector<WorldObject> sampleObjects() {
  std::vector<WorldObject> objects(6);
  const auto put = [&objects](std::size_t id, cv::Point3d center, cv::Point3d size, std::size_t first,
                              std::size_t last, std::size_t best, int area) {
    WorldObject& object = objects[id];
    object.id = static_cast<int>(id), object.center = center, object.size = size,
    object.views = last - first + 1;
    object.firstFrame = first, object.lastFrame = last, object.bestFrame = best, object.area = area;
    object.color = {200, 100, 50};
  };
  put(0, {2, 6.5, 0.375}, {1.6, 0.9, 0.75}, 0, 1, 1, 0);
  put(1, {2.2, 6.4, 0.8}, {0.1, 0.08, 0.1}, 0, 1, 1, 0);
  put(2, {9.2, 2, 0.5}, {0.1, 0.1, 0.1}, 4, 4, 4, 3);
  put(3, {7.5, 7.6, 0.5}, {0.2, 0.2, 1}, 5, 5, 5, 3);
  put(4, {8, 6, 0.4}, {0.5, 0.5, 0.8}, 5, 6, 5, 3);
  put(5, {5, 2.5, 0}, {}, 3, 3, 3, 1);
  objects[0].words = {{"dining table, board", 0.8F}, {"folding chair", 0.1F}};
  objects[1].words = {{"coffee mug", 0.6F}, {"cup, mug", 0.25F}};
  objects[2].words = {{"umbrella", 0.4F}, {"cup, mug", 0.3F}};
  objects[3].words = {{"umbrella", 0.7F}, {"cup, mug", 0.01F}};
  objects[4].words = {{"folding chair", 0.5F}};
  objects[4].givenName = hostileName;
  objects[0].support = objects[2].support = objects[3].support = objects[4].support = Support::floor;
  objects[1].support = Support::object, objects[1].onObject = 0;
  objects[0].yaw = std::numbers::pi / 2;
  return objects;
}

inline WorldMap sampleWorld() {
  WorldMap world{.places = samplePlaces(), .plan = samplePlan()};
  const char* names[] = {"kitchen", "", "corridor", "Ana's \"room\""};
  const char* found[] = {"dining table, cup", "bathtub", "folding chair", "umbrella, cup"};
  for (std::size_t i = 0; i < world.plan->areas.size(); ++i) {
    Area& area = world.plan->areas[i];
    area.name = found[i];
    for (const MappedFrame& frame : world.places.frames) area.frames += frame.node == area.id ? 1 : 0;
    world.areas.push_back({area, names[i]});
    if (*names[i] != 0) world.edits.push_back({AreaEdit::Kind::name, area.center, {}, names[i]});
  }
  for (const MappedFrame& frame : world.places.frames) world.areaOfFrame.push_back(frame.node);
  world.zoneOfFrame.assign(world.places.frames.size(), -1);
  world.objects = sampleObjects();
  return world;
}

/// The sample world, where the way back from the corridor to the kitchen was driven, too.
inline WorldMap sampleRoundTrip() {
  WorldMap world = sampleWorld();
  world.places.frames.push_back(sampleFrame(8, 0, 2, 4, 180));
  world.places.decisions.push_back({8, DecisionKind::join, 0, 2, 0.1, -1, std::nan(""), 0.3, 0.25});
  world.areaOfFrame.push_back(0);
  world.zoneOfFrame.push_back(-1);
  return world;
}

/// Writes the world as a map file. Object 1 has a image.
inline void writeWorld(const WorldMap& world, const std::filesystem::path& path) {
  const TopologicalMap& map = world.places;
  MapStore store =
      MapStore::create(path, {map.vocabulary, map.model, R"({"distance":")" + map.distance + "\"}"});
  for (std::size_t i = 0; i < map.frames.size(); ++i) {
    store.addFrame(map.frames[i], std::vector<float>(map.vocabulary.size(), 0.1F));
    store.putDecision(map.decisions[i]);
  }
  for (const Node& node : map.nodes) store.putNode(node, "");
  for (const Transition& transition : map.transitions) store.putTransition(transition);
  WorldStore layers(store, MapStore::Access::write);
  if (world.plan) {
    PlannedFrames planned{*world.plan, {}, world.areaOfFrame};
    for (const MappedFrame& frame : map.frames) planned.frames.push_back(frame.number);
    layers.putAreas(planned);
  }
  for (const AreaEdit& edit : world.edits) layers.addEdit(edit);
  const std::vector<unsigned char> image{0xFF, 0xD8, 0xFF, 0xD9};
  layers.putView({.frame = 1, .segment = 0, .quality = 1}, image);
  if (world.objects.size() > 1) layers.putObjects(world.objects, {{{1, 0}, 1}});
  store.commit();
}

}  // namespace estancia::test
