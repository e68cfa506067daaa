// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session_impl.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"
#include "estancia/world_query/changed_objects.hpp"

namespace estancia {
namespace {

constexpr double enoughFramesOfPlace = 5;  // frames of a place in each epoch
constexpr std::size_t wordsOfPlace = 5;

/// The images of a place in one epoch.
struct EpochOfPlace {
  Moments words, embedded;
};

PlaceChange changeOf(int node, double distance, const Vocabulary& vocabulary, std::span<const float> before,
                     std::span<const float> now) {
  PlaceChange change{node, distance, {}};
  std::vector<float> differences;
  for (std::size_t i = 0; i < now.size(); ++i) differences.push_back(std::abs(now[i] - before[i]));
  for (const std::size_t label : bestLabels(DescriptorView(differences), wordsOfPlace))
    change.words.push_back({vocabulary[label], before[label], now[label]});
  return change;
}

/// Places whose mean images of the two epochs would be two places, most different first.
std::vector<PlaceChange> changedPlaces(const TopologicalMap& map, const MapStore& store,
                                       std::size_t firstNow) {
  const Mapper mapper = restoreMapper(store);
  const Mapper::Impl& scale = mapper.impl();
  const Moments nothing(map.vocabulary.size(), false);
  const EpochOfPlace none{nothing, nothing};
  std::map<int, std::array<EpochOfPlace, 2>> places;
  store.forEachDescriptor(0, [&](std::size_t frame, DescriptorView descriptor) {
    const std::size_t index = map.indexOf(frame);
    auto& epochs = places.try_emplace(map.frames.at(index).node, std::array{none, none}).first->second;
    EpochOfPlace& epoch = epochs[index >= firstNow ? 1 : 0];
    epoch.words.add(descriptor);
    epoch.embedded.add(scale.embeddedFrame(descriptor).embedded);
    return true;
  });
  std::vector<PlaceChange> changes;
  for (const auto& [node, epochs] : places) {
    const auto& [before, now] = epochs;
    if (std::min(before.words.weight(), now.words.weight()) < enoughFramesOfPlace) continue;
    const double distance = compare(scale.distance.comparison, scale.bank.compared(before.embedded.mean()),
                                    scale.bank.compared(now.embedded.mean())) /
                            scale.thresholds.join;
    if (distance >= 1)
      changes.push_back(changeOf(node, distance, map.vocabulary, before.words.mean(), now.words.mean()));
  }
  std::ranges::sort(changes, std::ranges::greater{}, &PlaceChange::distance);
  return changes;
}

}  // namespace

std::string toString(ObjectChange::Kind kind) {
  constexpr const char* names[] = {"moved", "gone", "new"};
  return names[static_cast<int>(kind)];
}

Changes findChanges(const std::filesystem::path& path, std::optional<std::size_t> since) {
  MapStore map = MapStore::open(path, MapStore::Access::read);
  map.beginReading();
  const WorldStore store(map, MapStore::Access::read);
  WorldMap world{map.load()};
  store.read(world);
  KnownStore(map).read(world);
  const std::vector<Drive>& drives = world.places.drives;
  if (drives.size() < 2)
    fail(ErrorCode::insufficientData,
         "{} has only one drive; changes are told between drives: go on with "
         "another one by `estancia map --continue`",
         path.string());
  Changes changes{since.value_or(drives.size() - 1)};
  if (changes.since == 0 || changes.since >= drives.size())
    fail(ErrorCode::unknownName, "--since: the drives that others came before are 1 to {}, and {} is given",
         drives.size() - 1, changes.since);
  const std::size_t firstNow = drives[changes.since].firstFrame;
  changes.objects = changedObjects(world, store, firstNow);
  changes.places = changedPlaces(world.places, map, firstNow);
  changes.world = std::make_shared<const WorldMap>(std::move(world));
  return changes;
}

}  // namespace estancia
