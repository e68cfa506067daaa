// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/watershed.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace estancia {
namespace {

/// A saddle that is higher than this share of the lower peak is roughness, no passage.
constexpr double roughness = 0.95;
/// Half the width [m] in which no robot with a camera moves: niches, not rooms.
constexpr double clearance = 0.25;

/// Basins while they grow from their peaks and meet.
class Basins {
 public:
  int add(double peak) {
    parent_.push_back(static_cast<int>(parent_.size()));
    peaks_.push_back(peak);
    return parent_.back();
  }

  int rootOf(int basin) {
    while (parent_[basin] != basin) basin = parent_[basin] = parent_[parent_[basin]];
    return basin;
  }

  /// Two roots meet at this distance to the border, the widest that they will.
  void meet(int a, int b, double saddle) {
    if (peaks_[a] < peaks_[b]) std::swap(a, b);
    if (saddle > roughness * peaks_[b] || peaks_[b] < clearance)
      parent_[b] = a;
    else
      saddles_.try_emplace(std::minmax(a, b), saddle);
  }

  std::size_t size() const { return parent_.size(); }
  const std::map<std::pair<int, int>, double>& saddles() const { return saddles_; }

 private:
  std::vector<int> parent_;
  std::vector<double> peaks_;
  std::map<std::pair<int, int>, double> saddles_;
};

/// Free cells, those farthest from the border first.
std::vector<int> fromThePeaks(const cv::Mat& distance) {
  const auto* far = distance.ptr<float>();
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(distance.total()); ++i)
    if (far[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [far](int a, int b) { return far[a] > far[b]; });
  return order;
}

}  // namespace

Watershed watershedOf(const cv::Mat& freeSpace, const cv::Mat& walls, double cell) {
  cv::Mat distance, inside;  // with a border of cells that are not free: every free cell has eight neighbors
  cv::distanceTransform(walls == 0, inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  inside.setTo(0, freeSpace == 0);
  cv::copyMakeBorder(inside, distance, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  const auto* far = distance.ptr<float>();
  cv::Mat labels(distance.size(), CV_32S, cv::Scalar(-1));
  auto* label = labels.ptr<int>();
  const int w = distance.cols;
  const int around[] = {-w - 1, -w, -w + 1, -1, 1, w - 1, w, w + 1};
  Basins basins;
  for (const int i : fromThePeaks(distance)) {
    int highest = -1;
    for (const int offset : around)
      if (label[i + offset] >= 0 && (highest < 0 || far[i + offset] > far[highest])) highest = i + offset;
    label[i] = highest < 0 ? basins.add(far[i] * cell) : basins.rootOf(label[highest]);
    for (const int offset : around)
      if (label[i + offset] >= 0)
        if (const int other = basins.rootOf(label[i + offset]), own = basins.rootOf(label[i]); other != own)
          basins.meet(own, other, far[i] * cell);
  }

  Watershed result;
  result.basins = labels(cv::Rect(1, 1, freeSpace.cols, freeSpace.rows)).clone();
  std::vector<int> number(basins.size(), -1);
  for (int& basin : cv::Mat_<int>(result.basins)) {
    if (basin < 0) continue;
    int& root = number[basins.rootOf(basin)];
    if (root < 0) root = static_cast<int>(result.sizes.size()), result.sizes.push_back(0);
    ++result.sizes[root];
    basin = root;
  }
  for (const auto& [pair, saddle] : basins.saddles()) {
    const auto [a, b] = std::minmax(number[basins.rootOf(pair.first)], number[basins.rootOf(pair.second)]);
    if (a != b) result.saddles[{a, b}] = std::max(result.saddles[{a, b}], saddle);
  }
  return result;
}

}  // namespace estancia
