// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/scores.hpp"

#include <algorithm>

#include "estancia/core/fail.hpp"

namespace estancia {

std::size_t Confusion::total() const {
  std::size_t sum = 0;
  for (const auto& row : counts)
    for (const std::size_t count : row) sum += count;
  return sum;
}

double Confusion::accuracy() const {
  std::size_t right = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) right += counts[r][r];
  return static_cast<double>(right) / static_cast<double>(total());
}

double Confusion::balancedAccuracy() const {
  double shares = 0;
  std::size_t known = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) {
    std::size_t sum = 0;
    for (const std::size_t count : counts[r]) sum += count;
    if (sum == 0) continue;
    ++known;
    shares += static_cast<double>(counts[r][r]) / static_cast<double>(sum);
  }
  return shares / static_cast<double>(known);
}

Confusion confusionOf(const std::vector<std::string>& truth, const std::vector<std::string>& predicted) {
  if (truth.size() != predicted.size() || truth.empty())
    fail(ErrorCode::mismatch, "there are {} predictions and {} true rooms; give one of each an image",
         predicted.size(), truth.size());
  Confusion confusion{truth, {}};
  auto& rooms = confusion.rooms;
  rooms.insert(rooms.end(), predicted.begin(), predicted.end());
  std::sort(rooms.begin(), rooms.end());
  rooms.erase(std::unique(rooms.begin(), rooms.end()), rooms.end());
  confusion.counts.assign(rooms.size(), std::vector<std::size_t>(rooms.size()));
  const auto indexOf = [&](const std::string& room) {
    return static_cast<std::size_t>(std::lower_bound(rooms.begin(), rooms.end(), room) - rooms.begin());
  };
  for (std::size_t i = 0; i < truth.size(); ++i) ++confusion.counts[indexOf(truth[i])][indexOf(predicted[i])];
  return confusion;
}

std::vector<std::string> mostProbable(const std::vector<std::string>& rooms,
                                      const DescriptorMatrix& probabilities) {
  std::vector<std::string> best;
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    const DescriptorView row = probabilities.row(i);
    best.push_back(rooms[static_cast<std::size_t>(std::max_element(row.begin(), row.end()) - row.begin())]);
  }
  return best;
}

Confusion testRooms(const RoomClassifier& classifier, const Features& features, int threads) {
  std::vector<std::string> truth, predicted;
  const std::vector<std::string> all =
      mostProbable(classifier.rooms(), classifier.predict(features, threads));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (features.frames[i].room.empty()) continue;
    truth.push_back(features.frames[i].room);
    predicted.push_back(all[i]);
  }
  if (truth.empty())
    throw Error(ErrorCode::insufficientData,
                "no image has a known room; give a table of rooms (--rooms), or a folder of images per room "
                "(--type classes)");
  return confusionOf(truth, predicted);
}

}  // namespace estancia
