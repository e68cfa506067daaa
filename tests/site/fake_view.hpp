// A live view that tests change by hand.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/live/edits.hpp"
#include "estancia/live/live_view.hpp"
#include "estancia/site/page_server.hpp"
#include "estancia/world_query/changes.hpp"
#include "support/sample_world.hpp"

namespace estancia::test {

/// Any port that is free, unless one is wanted.
inline ServerOptions optionsAt(int port = 0) {
  ServerOptions options;
  options.port = port;
  return options;
}

/// The robot stands in the kitchen of sampleWorld(), until the test moves it.
class FakeView final : public LiveView {
 public:
  FakeView() {
    WorldMap world = sampleWorld();
    world.places.drives = {Drive{}, Drive{.firstFrame = 4, .name = "second"}};
    world_ = std::make_shared<const WorldMap>(std::move(world));
    status_.revision = 7;
    status_.mapRevision = 3;
    status_.state = "mapping";
    status_.source = "/dev/video0";
    status_.frames = 8;
    status_.frame = "frame_2.png";
    status_.timestamp = 1.5;
    status_.pose = Pose::planar(2, 2, 0.5);
    status_.words = {{"coffee mug", 0.6F}, {"<b>cup</b>", 0.2F}};
    status_.places = {{0, 0.9}, {2, 0.1}};
    status_.area = 0;
    status_.areaProbability = 0.95;
    status_.areaName = "kitchen";
    status_.decision = "It is within τ_join of place 0.";
  }

  LiveStatus status() const override {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return status_.revision != revision; });
    return status_;
  }
  std::shared_ptr<const std::vector<unsigned char>> image() const override {
    const std::lock_guard lock(mutex_);
    return image_;
  }
  std::shared_ptr<const WorldMap> world() const override {
    const std::lock_guard lock(mutex_);
    return world_;
  }
  std::vector<unsigned char> objectImage(int object) const override {
    return object == 1 ? *image() : std::vector<unsigned char>();
  }
  std::vector<unsigned char> placeImage(int node) const override {
    return node == 2 ? *image() : std::vector<unsigned char>();
  }
  /// Object 1 was moved into the area that it is in now, and place 2 looks different.
  nlohmann::ordered_json changes(const std::optional<std::size_t>& since) const override {
    if (since.value_or(1) != 1) throw Error(ErrorCode::unknownName, "the map has one drive after the first");
    Changes found{.since = 1, .world = world()};
    const cv::Point3d now = world()->objects[1].center;
    found.objects.push_back({ObjectChange::Kind::moved, 1, 1, true, {1, 2, 0.5}, now, 0.02, 0, 1});
    found.objects.push_back({ObjectChange::Kind::appeared, {}, 1, false, {}, now, 0.02, 0, 1});
    found.objects.push_back({ObjectChange::Kind::gone, {}, {}, false, {1, 2, 0.5}, {}, 0.02, 0, 0});
    found.places.push_back({2, 1.2, {{"umbrella", 0.1F, 0.6F}}});
    return toJson(found);
  }
  using LiveView::edit;
  void edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) override {
    const std::lock_guard lock(mutex_);
    requireRevision(mapRevision, status_.mapRevision);
    edits_.push_back(edit);
    const auto* naming = std::get_if<NameArea>(&edit);
    if (naming == nullptr) return;
    WorldMap world = *world_;
    if (world.findArea(naming->area) == nullptr)
      throw Error(ErrorCode::unknownName, "the map has no such area");
    world.areas[static_cast<std::size_t>(naming->area)].givenName = naming->name;
    world_ = std::make_shared<const WorldMap>(std::move(world));
    ++status_.revision, ++status_.mapRevision;
    changed_.notify_all();
  }

  /// `change(status, world)`; null takes the map away.
  template <class Change>
  void change(const Change& change) {
    const std::lock_guard lock(mutex_);
    change(status_, world_);
    ++status_.revision;
    changed_.notify_all();
  }
  void setImage(std::vector<unsigned char> jpeg) {
    const std::lock_guard lock(mutex_);
    image_ = std::make_shared<const std::vector<unsigned char>>(std::move(jpeg));
  }
  std::vector<MapEdit> edits() const {
    const std::lock_guard lock(mutex_);
    return edits_;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  LiveStatus status_;
  std::shared_ptr<const WorldMap> world_;
  std::shared_ptr<const std::vector<unsigned char>> image_ =
      std::make_shared<const std::vector<unsigned char>>(std::vector<unsigned char>{0xFF, 0xD8, 0xFF, 0xD9});
  std::vector<MapEdit> edits_;
};

}  // namespace estancia::test
