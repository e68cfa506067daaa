// SPDX-License-Identifier: Apache-2.0
#include "words/room_answers.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/stats/proportion.hpp"
#include "estancia/world_file/area_names.hpp"
#include "scenes/scene_answers.hpp"
#include "zones/room_classes.hpp"

namespace estancia::experiments {
namespace {

const std::string allRooms = "(all)";

/// Right answers among some.
struct RightAnswers {
  std::size_t right = 0, all = 0;

  void add(bool isRight) {
    ++all;
    right += isRight ? 1 : 0;
  }
  double share() const { return static_cast<double>(right) / static_cast<double>(all); }
};

std::vector<std::size_t> imagesOfGroups(const ImageGroups& groups) {
  std::vector<std::size_t> counts(groups.rooms.size());
  for (const std::size_t group : groups.groupOf)
    if (group < counts.size()) ++counts[group];
  return counts;
}

/// Which images are named right; none of unknown rooms.
std::vector<bool> imagesNamedRight(const RoomPredictions& predictions, const std::vector<Frame>& frames) {
  std::vector<bool> right;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto ranked = rankedRooms(predictions, i);
    right.push_back(!ranked.empty() && sameWords(ranked.front().room, frames[i].room));
  }
  return right;
}

/// Share of the images whose room is known.
Share shareOfImages(const std::vector<Frame>& frames, const std::vector<bool>& right) {
  std::vector<Frame> known;
  std::vector<std::string> rooms;
  std::vector<double> hits;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].room.empty()) continue;
    known.push_back(frames[i]);
    rooms.push_back(frames[i].room);
    hits.push_back(right[i] ? 1 : 0);
  }
  SceneTest test;
  std::map<std::string, int> runs;
  for (const std::string& run : classesOfRuns(known, rooms, {}, 1))
    test.runs.push_back(runs.emplace(run, static_cast<int>(runs.size())).first->second);
  test.runCount = static_cast<int>(runs.size());
  return shareRight(test, hits);
}

}  // namespace

ImageGroups blocksOfRooms(const std::vector<Frame>& frames, std::size_t size) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> imagesOf;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].room.empty()) continue;
    auto room = std::ranges::find(imagesOf, frames[i].room, [](const auto& r) { return r.first; });
    if (room == imagesOf.end()) room = imagesOf.insert(room, {frames[i].room, {}});
    room->second.push_back(i);
  }
  ImageGroups groups;
  for (const auto& [room, images] : imagesOf)
    groups.rooms.insert(groups.rooms.end(), images.size() / size, room);
  groups.groupOf.assign(frames.size(), groups.rooms.size());
  std::size_t first = 0;
  for (const auto& [room, images] : imagesOf) {
    for (std::size_t k = 0; k < images.size() / size * size; ++k)
      groups.groupOf[images[k]] = first + k / size;
    first += images.size() / size;
  }
  return groups;
}

ImageGroups groupsOfAreas(const std::vector<Frame>& frames, const std::vector<int>& areaOf) {
  std::vector<std::map<std::string, std::size_t>> counts;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (areaOf[i] < 0) continue;
    const auto area = static_cast<std::size_t>(areaOf[i]);
    if (area >= counts.size()) counts.resize(area + 1);
    if (!frames[i].room.empty()) ++counts[area][frames[i].room];
  }
  ImageGroups groups;
  for (const auto& rooms : counts) {
    const auto most = std::ranges::max_element(rooms, {}, [](const auto& room) { return room.second; });
    groups.rooms.push_back(most == rooms.end() ? "" : most->first);
  }
  for (const int area : areaOf)
    groups.groupOf.push_back(area < 0 ? counts.size() : static_cast<std::size_t>(area));
  return groups;
}

std::vector<GroupAnswer> nameBlocks(const RoomPredictions& predictions, const ImageGroups& groups) {
  const auto pooled = poolRooms(predictions, groups.groupOf, groups.rooms.size());
  const std::vector<bool> sure = areSureRooms(predictions, groups.groupOf, pooled, GroupedBy::space);
  const std::vector<std::size_t> images = imagesOfGroups(groups);
  std::vector<GroupAnswer> answers;
  for (std::size_t g = 0; g < pooled.size(); ++g) {
    GroupAnswer& answer = answers.emplace_back(GroupAnswer{images[g], groups.rooms[g], "", 0, false});
    if (pooled[g].empty()) continue;
    answer.answer = pooled[g].front().room;
    answer.probability = pooled[g].front().probability;
    answer.isSure = sure[g];
  }
  return answers;
}

std::vector<GroupAnswer> nameAreaGroups(const RoomPredictions& predictions, const ImageGroups& groups) {
  WorldMap world{TopologicalMap{Vocabulary(predictions.rooms)}};  // areas are named without labels
  world.places.predictions = predictions;
  world.areas.resize(groups.rooms.size());
  for (const std::size_t group : groups.groupOf)
    world.areaOfFrame.push_back(group < groups.rooms.size() ? static_cast<int>(group) : -1);
  nameAreasByRooms(world);
  const std::vector<std::size_t> images = imagesOfGroups(groups);
  std::vector<GroupAnswer> answers;
  for (std::size_t g = 0; g < groups.rooms.size(); ++g) {
    const WorldArea& area = world.areas[g];
    answers.push_back(
        {images[g], groups.rooms[g], area.predictedRoom, area.roomProbability, area.isSurelyRoom});
  }
  return answers;
}

CellResults measureRoomAnswers(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                               const std::vector<GroupAnswer>& groups) {
  const std::vector<bool> right = imagesNamedRight(predictions, frames);
  std::map<std::string, RightAnswers> images, named;
  std::size_t maxImages = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].room.empty()) continue;
    images[allRooms].add(right[i]);
    images[frames[i].room].add(right[i]);
    maxImages = std::max(maxImages, images[frames[i].room].all);
  }
  if (images.empty())
    throw Error(ErrorCode::insufficientData, "no image has a known room; nothing to compare with");
  RightAnswers sure;
  for (const GroupAnswer& group : groups) {
    if (group.truth.empty()) continue;
    const bool isRight = sameWords(group.answer, group.truth);
    named[allRooms].add(isRight);
    named[group.truth].add(isRight);
    if (group.isSure) sure.add(isRight);
  }

  CellResults results;
  for (const auto& [room, answers] : images) {
    results.push_back({"images", room, static_cast<double>(answers.all)});
    results.push_back({"accuracy", room, answers.share()});
  }
  const Share share = shareOfImages(frames, right);
  results.push_back({"accuracy_low", allRooms, share.low});
  results.push_back({"accuracy_high", allRooms, share.high});
  results.push_back(
      {"chance", allRooms, static_cast<double>(maxImages) / static_cast<double>(images[allRooms].all)});
  for (const auto& [room, answers] : named) {
    results.push_back({"groups", room, static_cast<double>(answers.all)});
    results.push_back({"pooled_accuracy", room, answers.share()});
  }
  if (named.empty()) return results;
  const RightAnswers& pooled = named[allRooms];
  const auto [low, high] = wilsonInterval(pooled.right, pooled.all);
  results.push_back({"pooled_low", allRooms, low});
  results.push_back({"pooled_high", allRooms, high});
  results.push_back({"sure", allRooms, static_cast<double>(sure.all) / static_cast<double>(pooled.all)});
  if (sure.all > 0) results.push_back({"sure_accuracy", allRooms, sure.share()});
  return results;
}

}  // namespace estancia::experiments
