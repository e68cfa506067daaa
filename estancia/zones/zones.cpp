#include "estancia/zones/zones.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/stats/compared_vectors.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

/// Groups of frames as lists, the largest first, of equal ones the one seen first.
std::vector<std::vector<std::size_t>> membersOf(std::span<const int> groups) {
  std::map<int, std::size_t> positions;
  std::vector<std::vector<std::size_t>> members;  // as they are seen
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

std::vector<RoomWords> roomsOf(const DescriptorSequence& recording) {
  std::map<std::string, std::vector<std::size_t>> members;
  for (std::size_t frame = 0; frame < recording.frames.size(); ++frame)
    if (!recording.frames[frame].room.empty()) members[recording.frames[frame].room].push_back(frame);
  std::vector<RoomWords> rooms;
  for (const auto& [name, images] : members)
    rooms.push_back({name, images.size(), toVector(momentsOf(recording.descriptors, images, false).mean())});
  return rooms;
}

}  // namespace

ZoneOptions ZoneOptions::thesis() {
  ZoneOptions options;
  options.distance = "ks";
  options.linkage = "average";
  options.cut = 0.5;
  return options;
}

void requireSound(const ZoneOptions& options) {
  if (options.cut && options.count)
    throw Error("zones are cut at a distance or by their number, not by both");
  if (options.cut && !(std::isfinite(*options.cut) && *options.cut >= 0))
    throw Error(fmt::format("a cut at {} is none; give a distance of 0 or more", *options.cut));
}

ZoneCut cutTree(const Dendrogram& tree, const NearestItems& neighbors, const ZoneOptions& options) {
  if (options.count) {
    std::vector<int> groups = tree.cutInto(*options.count);
    const std::size_t done = tree.leaves() - *options.count;
    return {std::move(groups), done == 0 ? 0 : tree.merges()[done - 1].height,
            *options.count == 1 ? "1 zone was asked for"
                                : fmt::format("{} zones were asked for", *options.count)};
  }
  if (options.cut) return {tree.cutAt(*options.cut), *options.cut, "it was given"};
  SuggestedCut suggested = suggestCut(tree, neighbors);
  return {tree.cutAt(suggested.distance), suggested.distance, std::move(suggested.reason)};
}

CondensedDistances compareImages(const DescriptorSequence& recording, const ZoneOptions& options,
                                 Progress& progress) {
  const Distance distance = getDistance(options.distance, recording.vocabulary.layout().parts);
  const Comparison comparison = comparisonFor(distance, getLinkage(options.linkage));
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    requireProbabilities(recording.descriptors.row(i), recording.vocabulary.size(), recording.frames[i].name);
  requireClusteringMemory(recording.frames.size(), recording.vocabulary.size());
  const DescriptorMatrix vectors = comparedVectors(recording.descriptors, distance);
  return pairwiseDistances(vectors, comparison, options.threads, progress);
}

ImageTree linkImages(const DescriptorSequence& recording, const ZoneOptions& options, Progress& progress) {
  if (recording.frames.empty()) throw Error("there are no zones without images; give at least one");
  CondensedDistances distances = compareImages(recording, options, progress);
  NearestItems neighbors = findNeighbors(distances);
  return {link(std::move(distances), getLinkage(options.linkage), {}, progress), std::move(neighbors)};
}

Zones findZones(const DescriptorSequence& recording, const ZoneOptions& options, Progress& progress) {
  requireSound(options);
  // Algorithm 5.1: every image is a cluster of its own (lines 1–4); the distances of all pairs (5–7); the two
  // nearest become one, again and again (8–22). The thesis stops while it merges, and prints that test the
  // wrong way round (line 12: "Dist < τ_d"); meant is that merging stops once the smallest distance is above
  // τ_d (5.5.3). Here all mergers are made and the tree is cut at τ_d, which comes to the same.
  ImageTree tree = linkImages(recording, options, progress);
  const ZoneCut cut = cutTree(tree.dendrogram, tree.neighbors, options);
  Zones zones = describeZones(recording, cut.groups);
  zones.distance = options.distance;
  zones.linkage = options.linkage;
  zones.cut = cut.distance;
  zones.cutReason = cut.reason;
  zones.dendrogram = std::move(tree.dendrogram);
  return zones;
}

Zones describeZones(const DescriptorSequence& recording, std::span<const int> groups) {
  if (recording.frames.empty()) throw Error("there are no zones without images; give at least one");
  if (groups.size() != recording.frames.size())
    throw Error(fmt::format("{} zone numbers do not belong to {} frames; give one a frame", groups.size(),
                            recording.frames.size()));
  Zones result{recording.vocabulary, recording.model, {}, {}, 0, {}, recording.frames, {}, {}, {}, {}};
  result.zoneOf.resize(groups.size());
  std::vector<std::vector<float>> means;
  for (std::vector<std::size_t>& images : membersOf(groups)) {
    Zone zone;
    zone.id = static_cast<int>(result.zones.size());
    for (const std::size_t image : images) result.zoneOf[image] = zone.id;
    zone.images = std::move(images);
    const Moments moments = momentsOf(recording.descriptors, zone.images, true);
    zone.mean = toVector(moments.mean());
    for (const float variance : moments.variance()) zone.sigma.push_back(std::sqrt(variance));
    findRoom(recording.frames, zone);
    zone.extent = extentOf(recording.frames, zone.images);
    means.push_back(zone.mean);
    result.zones.push_back(std::move(zone));
  }
  const std::vector<std::string> names = nameZones(result.vocabulary, means, runMean(result));
  for (std::size_t i = 0; i < names.size(); ++i) result.zones[i].name = names[i];
  result.rooms = roomsOf(recording);
  return result;
}

void nameRooms(Zones& zones, const RoomPredictions& predictions) {
  if (predictions.probabilities.size() != zones.frames.size())
    throw Error(fmt::format("the rooms of {} images were predicted, but the zones are of {}",
                            predictions.probabilities.size(), zones.frames.size()));
  const std::vector<std::size_t> groups(zones.zoneOf.begin(), zones.zoneOf.end());
  auto pooled = poolRooms(predictions, groups, zones.zones.size());
  for (std::size_t i = 0; i < zones.zones.size(); ++i) zones.zones[i].predicted = std::move(pooled[i]);
  zones.classifier = predictions.classifier;
}

std::vector<float> runMean(const Zones& zones) {
  Moments mean(zones.vocabulary.size(), false);
  for (const Zone& zone : zones.zones) mean.add(zone.mean, static_cast<double>(zone.images.size()));
  return toVector(mean.mean());
}

}  // namespace estancia
