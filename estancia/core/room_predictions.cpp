// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/room_predictions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "estancia/core/log_opinion_pool.hpp"

namespace estancia {

namespace {

/// Chosen on the training half of NYU Depth V2 (docs/measured/words.md).
constexpr double timesChance = 2;

/// Best first.
std::vector<RoomProbability> ranked(const std::vector<std::string>& names, std::span<const double> shares) {
  std::vector<RoomProbability> rooms;
  for (std::size_t r = 0; r < names.size(); ++r) rooms.push_back({names[r], shares[r]});
  std::stable_sort(rooms.begin(), rooms.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return rooms;
}

/// The row of an image as if all rooms were equally frequent; zeros stay zeros.
std::vector<float> withoutPrior(const RoomPredictions& predictions, std::size_t image) {
  const DescriptorView row = predictions.probabilities.row(image);
  std::vector<float> even(row.begin(), row.end());
  if (predictions.prior.size() != even.size()) return even;
  double sum = 0;
  for (std::size_t r = 0; r < even.size(); ++r) {
    even[r] = static_cast<float>(static_cast<double>(even[r]) / predictions.prior[r]);
    sum += static_cast<double>(even[r]);
  }
  if (sum > 0)
    for (float& value : even) value = static_cast<float>(static_cast<double>(value) / sum);
  return even;
}

/// Whether the best room remains certain without a label that adds `logOdds`, a number for each room.
bool isToldWithout(const RoomPredictions& predictions, const std::vector<RoomProbability>& rooms,
                   const std::vector<double>& logOdds, GroupedBy by) {
  std::vector<double> rest;
  for (const RoomProbability& room : rooms) {
    const auto found = std::ranges::find(predictions.rooms, room.room) - predictions.rooms.begin();
    rest.push_back(room.probability * std::exp(-logOdds[static_cast<std::size_t>(found)]));
  }
  if (by == GroupedBy::labels)
    return std::all_of(rest.begin() + 1, rest.end(), [&](double other) { return other < rest.front(); });
  const double chance = std::accumulate(rest.begin(), rest.end(), 0.0) / static_cast<double>(rest.size());
  return rest.front() > timesChance * chance;
}

}  // namespace

bool isPredicted(const RoomPredictions& predictions, std::size_t image) {
  return std::ranges::any_of(predictions.probabilities.row(image), [](float p) { return p > 0; });
}

std::vector<RoomProbability> rankedRooms(const RoomPredictions& predictions, std::size_t image) {
  if (image >= predictions.probabilities.size()) return {};
  const DescriptorView row = predictions.probabilities.row(image);
  const double total = std::accumulate(row.begin(), row.end(), 0.0);
  if (total <= 0) return {};
  std::vector<double> shares(row.begin(), row.end());
  for (double& share : shares) share /= total;
  return ranked(predictions.rooms, shares);
}

std::vector<std::vector<RoomProbability>> poolRooms(const RoomPredictions& predictions,
                                                    std::span<const std::size_t> groupOf,
                                                    std::size_t groups) {
  std::vector<LogOpinionPool> pools(groups, LogOpinionPool(predictions.rooms.size()));
  const std::size_t images = std::min(groupOf.size(), predictions.probabilities.size());
  for (std::size_t i = 0; i < images; ++i)
    if (groupOf[i] < groups) pools[groupOf[i]].add(withoutPrior(predictions, i));
  std::vector<std::vector<RoomProbability>> pooled(groups);
  for (std::size_t g = 0; g < groups; ++g)
    if (pools[g].size() > 0) pooled[g] = ranked(predictions.rooms, pools[g].pooled());
  return pooled;
}

std::vector<bool> areSureRooms(const RoomPredictions& predictions, std::span<const std::size_t> groupOf,
                               const std::vector<std::vector<RoomProbability>>& pooled, GroupedBy by) {
  std::vector<bool> sure;
  for (const std::vector<RoomProbability>& rooms : pooled)
    sure.push_back(!rooms.empty() && rooms.front().probability > predictions.sureProbability());
  if (predictions.evidence.empty()) return sure;
  const std::size_t known = std::min(groupOf.size(), predictions.probabilities.size());
  std::vector<double> images(pooled.size(), 0);
  for (std::size_t i = 0; i < known; ++i)
    if (groupOf[i] < pooled.size() && isPredicted(predictions, i)) ++images[groupOf[i]];
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> told;  // by group and label
  for (const RoomEvidence& evidence : predictions.evidence) {
    if (evidence.image >= known || groupOf[evidence.image] >= pooled.size()) continue;
    const std::size_t group = groupOf[evidence.image];
    if (!sure[group]) continue;
    std::vector<double>& sum = told[{group, evidence.label}];
    sum.resize(predictions.rooms.size(), 0);
    for (std::size_t r = 0; r < sum.size(); ++r)
      sum[r] += static_cast<double>(evidence.logOdds[r]) / images[group];
  }
  for (const auto& [key, logOdds] : told)
    if (!isToldWithout(predictions, pooled[key.first], logOdds, by)) sure[key.first] = false;
  return sure;
}

std::string describeRooms(const std::vector<RoomProbability>& rooms, std::size_t maxRooms) {
  std::string text;
  for (std::size_t i = 0; i < std::min(maxRooms, rooms.size()); ++i)
    if (i == 0 || rooms[i].probability >= 0.01)
      text += fmt::format("{}{} {:.0f} %", i == 0 ? "" : ", ", rooms[i].room, 100 * rooms[i].probability);
  return text;
}

}  // namespace estancia
