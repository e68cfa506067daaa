// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zones.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "estancia/core/fail.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/words/label_concepts.hpp"
#include "estancia/zones/image_tree.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

/// Groups of frames as lists, the largest first, of equal ones the one seen first.
std::vector<std::vector<std::size_t>> membersOf(std::span<const int> groups) {
  std::map<int, std::size_t> positions;
  std::vector<std::vector<std::size_t>> members;  // members in the order of arrival
  for (std::size_t frame = 0; frame < groups.size(); ++frame) {
    const auto [entry, isNew] = positions.emplace(groups[frame], members.size());
    if (isNew) members.emplace_back();
    members[entry->second].push_back(frame);
  }
  std::stable_sort(members.begin(), members.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return members;
}

Moments momentsOf(const DescriptorMatrix& descriptors, const std::vector<std::size_t>& images, bool spread) {
  Moments moments(descriptors.labels(), spread);
  for (const std::size_t image : images) moments.add(descriptors.row(image));
  return moments;
}

void findRoom(const std::vector<Frame>& frames, Zone& zone) {
  std::map<std::string, std::size_t> rooms;
  std::size_t known = 0;
  for (const std::size_t image : zone.images) {
    const std::string& room = frames[image].room;
    if (room.empty()) continue;
    ++known;
    const std::size_t count = ++rooms[room];
    if (count > rooms[zone.room]) zone.room = room;
  }
  if (known > 0) zone.roomShare = static_cast<double>(rooms[zone.room]) / static_cast<double>(known);
}

std::optional<ZoneExtent> extentOf(const std::vector<Frame>& frames, const std::vector<std::size_t>& images) {
  ZoneExtent extent;
  for (const std::size_t image : images) {
    const auto& pose = frames[image].pose;
    if (!pose) continue;
    ++extent.images;
    const auto n = static_cast<double>(extent.images);
    extent.center[0] += (pose->x - extent.center[0]) / n;
    extent.center[1] += (pose->y - extent.center[1]) / n;
    extent.center[2] += (pose->z - extent.center[2]) / n;
  }
  if (extent.images == 0) return std::nullopt;
  for (const std::size_t image : images)
    if (const auto& pose = frames[image].pose)
      extent.spread +=
          std::hypot(pose->x - extent.center[0], pose->y - extent.center[1], pose->z - extent.center[2]) /
          static_cast<double>(extent.images);
  return extent;
}

std::vector<float> toVector(std::span<const float> values) {
  return {values.begin(), values.end()};
}

std::vector<RoomWords> roomsOf(const DescriptorSequence& sequence) {
  std::map<std::string, std::vector<std::size_t>> members;
  for (std::size_t frame = 0; frame < sequence.frames.size(); ++frame)
    if (!sequence.frames[frame].room.empty()) members[sequence.frames[frame].room].push_back(frame);
  std::vector<RoomWords> rooms;
  for (const auto& [name, images] : members)
    rooms.push_back({name, images.size(), toVector(momentsOf(sequence.descriptors, images, false).mean())});
  return rooms;
}

}  // namespace

ZoneOptions ZoneOptions::thesis() {
  ZoneOptions options;
  options.distance = "ks";
  options.linkage = "average";
  options.cut = 0.5;
  options.reach = 0;
  return options;
}

OptionGroup declare(ZoneOptions& options) {
  Choices distances;
  for (const Distance& distance : baseDistances())
    if (!distance.sigmaWeighted) distances.push_back({distance.name, distance.explanation});
  OptionGroup group("zones", "How images become zones.");
  group.add("distance", &options.distance, "Distance of two images.").choices(std::move(distances));
  group.add("linkage", &options.linkage, "Distance of two zones.").choices(linkages());
  group.add("cut", &options.cut, "Zones merge up to this distance (tau_d).")
      .range(0)
      .automatic("where the modularity of the zones is largest")
      .why("A larger distance gives fewer, larger zones.");
  group.add("count", &options.count, "This number of zones, instead of a cut.")
      .range(1)
      .automatic("by the cut");
  group
      .add("reach", &options.reach,
           "Images of a run that were taken within about this distance are compared by what is seen from all "
           "of them.")
      .range(0)
      .unit("m")
      .automatic("0.5 for a map; 0, each image by itself, for images in any order")
      .why("A larger distance gives fewer, larger zones.");
  group.add("threads", &options.threads, "Threads of the clustering.")
      .range(0, 1024)
      .why("0: one a usable core.");
  group.add(declare(options.naming));
  return group;
}

void validate(const ZoneOptions& options) {
  ZoneOptions copy = options;
  declare(copy).validate();
  if (options.cut && options.count)
    throw Error(ErrorCode::invalidOption, "zones.cut and zones.count exclude each other; give one of them");
}

Zones findZones(const DescriptorSequence& sequence, const ZoneOptions& options, Progress& progress) {
  // Algorithm 5.1: every image is a cluster of its own (lines 1–4); the distances of all pairs (5–7); the two
  // nearest clusters are merged, again and again (8–22). The thesis stops while it merges, and its test is
  // misprinted (line 12: "Dist < τ_d"): merging stops once the smallest distance is above τ_d (5.5.3). Here
  // all merges are made and the tree is cut at τ_d, with the same result.
  ImageTree tree = linkImages(sequence, options, progress);
  const ZoneCut cut = cutTree(tree.dendrogram, tree.neighbors, options);
  Zones zones = describeZones(sequence, cut.groups, options.naming);
  zones.distance = options.distance;
  zones.linkage = options.linkage;
  zones.cut = cut.distance;
  zones.cutReason = cut.reason;
  zones.dendrogram = std::move(tree.dendrogram);
  return zones;
}

Zones describeZones(const DescriptorSequence& sequence, std::span<const int> groups,
                    const NamingOptions& naming) {
  if (sequence.frames.empty())
    throw Error(ErrorCode::insufficientData, "there are no images to make zones of; give at least one");
  if (groups.size() != sequence.frames.size())
    fail(ErrorCode::mismatch, "{} zone numbers do not belong to {} frames; give one a frame", groups.size(),
         sequence.frames.size());
  Zones result{.vocabulary = sequence.vocabulary, .model = sequence.model, .frames = sequence.frames};
  result.zoneOf.resize(groups.size());
  std::vector<std::vector<float>> means;
  for (std::vector<std::size_t>& images : membersOf(groups)) {
    Zone zone;
    zone.id = static_cast<int>(result.zones.size());
    for (const std::size_t image : images) result.zoneOf[image] = zone.id;
    zone.images = std::move(images);
    const Moments moments = momentsOf(sequence.descriptors, zone.images, true);
    zone.mean = toVector(moments.mean());
    for (const float variance : moments.variance()) zone.sigma.push_back(std::sqrt(variance));
    findRoom(sequence.frames, zone);
    zone.extent = extentOf(sequence.frames, zone.images);
    means.push_back(zone.mean);
    result.zones.push_back(std::move(zone));
  }
  const std::vector<std::string> names =
      nameZones(result.vocabulary, means, runMean(result), *installedConcepts(result.vocabulary, naming));
  for (std::size_t i = 0; i < names.size(); ++i) result.zones[i].name = names[i];
  result.rooms = roomsOf(sequence);
  return result;
}

void nameRooms(Zones& zones, const RoomPredictions& predictions) {
  if (predictions.probabilities.size() != zones.frames.size())
    fail(ErrorCode::mismatch, "predictions for {} frames do not belong to zones of {} frames",
         predictions.probabilities.size(), zones.frames.size());
  const std::vector<std::size_t> groups(zones.zoneOf.begin(), zones.zoneOf.end());
  auto pooled = poolRooms(predictions, groups, zones.zones.size());
  if (predictions.areByName) {
    const std::vector<bool> sure = areSureRooms(predictions, groups, pooled, GroupedBy::labels);
    for (std::size_t i = 0; i < pooled.size(); ++i)
      if (!sure[i]) pooled[i].clear();
  }
  for (std::size_t i = 0; i < zones.zones.size(); ++i) zones.zones[i].predicted = std::move(pooled[i]);
  zones.classifier = predictions.areByName ? "" : predictions.classifier;
}

std::vector<float> runMean(const Zones& zones) {
  Moments mean(zones.vocabulary.size(), false);
  for (const Zone& zone : zones.zones) mean.add(zone.mean, static_cast<double>(zone.images.size()));
  return toVector(mean.mean());
}

}  // namespace estancia
