// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/world_options.hpp"

#include <fmt/ranges.h>

#include <sstream>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/removed_options.hpp"
#include "estancia/map_file/sqlite.hpp"

namespace estancia {
namespace {

constexpr const char* termsKey = "world terms";

/// Options that have gone stay among the terms with what always holds, so that older programs find them.
std::map<std::string, std::string> removedTerms() {
  const std::map<std::string_view, std::string> above{
      {"odometry", ""}, {"clusters", ""}, {"room-segmentation", "areas."}, {"word-map", "areas."}};
  std::map<std::string, std::string> terms;
  for (const RemovedOption& option : removedOptions())
    if (const auto group = above.find(option.path.substr(0, option.path.find('.'))); group != above.end())
      terms[group->second + std::string(option.path)] = option.value;
  return terms;
}

/// All options that change the layers, by their paths below "world".
std::map<std::string, std::string> termsOf(WorldOptions options) {
  std::map<std::string, std::string> terms = declare(options).texts();
  std::erase_if(terms, [](const auto& term) {
    const std::string name = term.first.substr(term.first.rfind('.') + 1);
    return name == "threads" || name == "layers";
  });
  terms.merge(removedTerms());
  return terms;
}

std::string described(const CameraIntrinsics& camera) {
  return fmt::format("{} × {} pixels, fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}", camera.width,
                     camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
}

std::string describedScale(double scale) {
  return scale > 0 ? fmt::format("{:g}", scale) : "that of the image type";
}

}  // namespace

std::string toString(const WorldLayers& layers) {
  std::string names = "places";
  if (layers.zones) names += ",zones";
  if (layers.areas) names += ",areas";
  if (layers.objects) names += ",objects";
  return names;
}

WorldLayers layersFrom(const std::string& names) {
  WorldLayers layers{false, false, false};
  std::istringstream rest(names);
  for (std::string name; std::getline(rest, name, ',');)
    if (name == "zones")
      layers.zones = true;
    else if (name == "areas")
      layers.areas = true;
    else if (name == "objects")
      layers.objects = true;
    else if (name != "places")
      fail(ErrorCode::unknownName, "a map has no layer \"{}\"; it has places, zones, areas and objects",
           printable(name));
  return layers;
}

OptionGroup declare(WorldOptions& options) {
  OptionGroup group("world", "How a drive becomes areas and objects.");
  group
      .add("layers",
           Option::Text{[&options] { return options.layers ? toString(*options.layers) : std::string(); },
                        [&options](const std::string& names) { options.layers = layersFrom(names); }},
           "What the map holds: places,zones,areas,objects, some of them")
      .automatic("all that the drive allows");
  group.add("view-shift", &options.viewShift, "How far the camera moves to a new view.")
      .range(0, 10)
      .unit("m")
      .why("A robot that stands still sees nothing new.");
  group.add("view-turn", &options.viewTurn, "How far the camera turns to a new view.")
      .range(0, 180)
      .unit("degrees");
  group
      .add("crops", &options.crops,
           "Objects that are labeled for each frame: new ones and better views first.")
      .range(0, 1000)
      .why("Each costs as much as the frame itself.");
  group.add(declare(options.areas));
  group.add(declare(options.segments));
  group.add(declare(options.objects));
  OptionGroup odometry = declare(options.odometry);
  std::erase_if(odometry.options(), [](const Option& o) { return o.name().starts_with("odom-"); });
  group.add(std::move(odometry));
  return group;
}

MapTerms::MapTerms(MapStore& store) : store_(store) {
  const auto kept = store.findState(termsKey);
  if (!kept) return;
  try {
    ByteReader bytes(*kept, "what the map was made with", "make the map anew");
    camera_ = bytes.text();
    depthScale_ = bytes.text();
    for (std::size_t i = bytes.count(8); i > 0; --i) {
      std::string path = bytes.text();
      options_[std::move(path)] = bytes.text();
    }
  } catch (const Error& e) {
    if (e.code() != ErrorCode::malformedFile && e.code() != ErrorCode::truncatedFile) throw;
    store_.database().failDamaged("{}", e.what());
  }
}

void MapTerms::write() {
  ByteWriter bytes;
  bytes.text(camera_);
  bytes.text(depthScale_);
  bytes.number(static_cast<std::uint64_t>(options_.size()));
  for (const auto& [path, value] : options_) {
    bytes.text(path);
    bytes.text(value);
  }
  store_.putState(termsKey, bytes.bytes());
}

std::optional<WorldOptions> MapTerms::options() const {
  if (options_.empty()) return std::nullopt;
  WorldOptions options;
  OptionGroup group = declare(options);
  for (const auto& [path, value] : options_)
    if (Option* option = group.find(path); option != nullptr && option->text() != value)
      option->set(value, "world." + path);
  return options;
}

std::vector<std::string> MapTerms::gone() const {
  std::vector<std::string> sentences;
  for (const auto& [path, value] : removedTerms())
    if (const auto kept = options_.find(path); kept != options_.end() && kept->second != value)
      sentences.push_back(describeRemoved(*findRemovedOption(path), "world." + path, kept->second));
  return sentences;
}

void MapTerms::keep(WorldOptions options) {
  const std::map<std::string, std::string> wanted = termsOf(std::move(options));
  if (options_.empty()) {
    options_ = wanted;
    return write();
  }
  std::vector<std::string> others;
  for (const auto& [path, value] : wanted)
    if (const auto kept = options_.find(path);
        kept != options_.end() && kept->second != value && findRemovedOption(path) == nullptr)
      others.push_back(fmt::format("world.{} is {} in the map, and {} is given", path,
                                   printable(kept->second), printable(value)));
  if (!others.empty())
    fail(ErrorCode::mismatch, "{} was made with other options: {}; leave them out, or map anew",
         store_.database().path().string(), fmt::join(others, "; "));
}

void MapTerms::keepCameraOf(const MapTerms& other) {
  camera_ = other.camera_;
  depthScale_ = other.depthScale_;
  write();
}

void MapTerms::forgetCamera() {
  camera_.clear();
  depthScale_.clear();
}

void MapTerms::keep(const CameraIntrinsics& camera, double depthScale) {
  const std::string wanted = described(camera), wantedScale = describedScale(depthScale);
  if (camera_.empty()) {
    camera_ = wanted;
    depthScale_ = wantedScale;
    return write();
  }
  const std::string file = store_.database().path().string();
  if (wanted != camera_)
    fail(ErrorCode::mismatch,
         "{} was made with another camera: {} in the map, and {} now; give the same intrinsics, or map anew",
         file, printable(camera_), wanted);
  if (wantedScale != depthScale_)
    fail(ErrorCode::mismatch,
         "{} was made with another depth scale: {} in the map, and {} now; give the same --depth-scale, or "
         "map anew",
         file, printable(depthScale_), wantedScale);
}

}  // namespace estancia
