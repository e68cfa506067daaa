#include "estancia/core/room_predictions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace estancia {

namespace {

constexpr double leastProbability = 0.001;

/// Best first, scaled so that they add up to 1; none where there is nothing to scale.
std::vector<RoomProbability> ranked(const std::vector<std::string>& names, std::span<const double> sums) {
  const double total = std::accumulate(sums.begin(), sums.end(), 0.0);
  std::vector<RoomProbability> rooms;
  if (total <= 0) return rooms;
  for (std::size_t r = 0; r < names.size(); ++r) rooms.push_back({names[r], sums[r] / total});
  std::stable_sort(rooms.begin(), rooms.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return rooms;
}

}  // namespace

std::vector<RoomProbability> roomsOf(const RoomPredictions& predictions, std::size_t image) {
  if (image >= predictions.probabilities.size()) return {};
  const DescriptorView row = predictions.probabilities.row(image);
  return ranked(predictions.rooms, std::vector<double>(row.begin(), row.end()));
}

std::vector<std::vector<RoomProbability>> poolRooms(const RoomPredictions& predictions,
                                                    std::span<const std::size_t> groupOf,
                                                    std::size_t groups) {
  const std::size_t rooms = predictions.rooms.size();
  std::vector<double> sums(groups * rooms, 0);  // of logarithms
  std::vector<std::size_t> counts(groups, 0);
  const std::size_t images = std::min(groupOf.size(), predictions.probabilities.size());
  for (std::size_t i = 0; i < images; ++i) {
    const DescriptorView row = predictions.probabilities.row(i);
    if (groupOf[i] >= groups || std::ranges::all_of(row, [](float p) { return p <= 0; })) continue;
    ++counts[groupOf[i]];
    for (std::size_t r = 0; r < rooms; ++r)
      sums[groupOf[i] * rooms + r] += std::log(std::max(leastProbability, static_cast<double>(row[r])));
  }
  std::vector<std::vector<RoomProbability>> pooled(groups);
  for (std::size_t g = 0; g < groups; ++g) {
    if (counts[g] == 0) continue;
    const std::span<double> own = std::span(sums).subspan(g * rooms, rooms);
    for (double& value : own) value = std::exp(value / static_cast<double>(counts[g]));
    pooled[g] = ranked(predictions.rooms, own);
  }
  return pooled;
}

std::string describeRooms(const std::vector<RoomProbability>& rooms, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(most, rooms.size()); ++i)
    if (i == 0 || rooms[i].probability >= 0.01)
      text += fmt::format("{}{} {:.0f} %", i == 0 ? "" : ", ", rooms[i].room, 100 * rooms[i].probability);
  return text;
}

}  // namespace estancia
