// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/room_segmentation.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "estancia/areas/mutual_visibility.hpp"
#include "estancia/areas/watershed.hpp"

namespace estancia {
namespace {

/// Basins that are being merged into rooms.
class Merging {
 public:
  Merging(const Watershed& watershed, VisiblePairs visible, double cell)
      : saddles_(watershed.saddles),
        sizes_(watershed.sizes),
        visible_(std::move(visible)),
        cellArea_(cell * cell),
        root_(sizes_.size()) {
    std::iota(root_.begin(), root_.end(), 0);
  }

  int rootOf(int basin) const {
    while (root_[basin] != basin) basin = root_[basin];
    return basin;
  }
  /// Cells of a root.
  int size(int root) const { return sizes_[root]; }

  /// Merges the two neighbors that are most likely one room, until none are.
  void merge(const RoomSegmentationOptions& options) {
    for (;;) {
      double best = options.mutualVisibility;
      std::optional<std::pair<int, int>> pair;
      for (const auto& [neighbors, saddle] : openings())
        if (const double score = scoreOf(neighbors.first, neighbors.second, saddle, options); score > best) {
          best = score;
          pair = neighbors;
        }
      if (!pair) return;
      join(pair->first, pair->second);
    }
  }

 private:
  /// The widest passage between each pair of neighbors, as half its width [m].
  std::map<std::pair<int, int>, double> openings() const {
    std::map<std::pair<int, int>, double> widest;
    for (const auto& [pair, saddle] : saddles_) {
      const std::pair<int, int> roots = std::minmax({rootOf(pair.first), rootOf(pair.second)});
      if (roots.first != roots.second) widest[roots] = std::max(widest[roots], saddle);
    }
    return widest;
  }

  /// The share of pairs of points on both sides that see each other, relative to that within the less convex
  /// side. Above 1 for pieces that are too small to be a room: they go to where the opening is widest.
  double scoreOf(int a, int b, double saddle, const RoomSegmentationOptions& options) const {
    if (std::min(sizes_[a], sizes_[b]) * cellArea_ < options.minArea) return 2 + saddle;
    const double own = std::min(visible_.share(a, a), visible_.share(b, b));
    return own > 0 ? visible_.share(a, b) / own : 2 + saddle;  // no point in it: too small as well
  }

  void join(int a, int b) {
    root_[b] = a;
    sizes_[a] += sizes_[b];
    visible_.merge(a, b);
  }

  std::map<std::pair<int, int>, double> saddles_;
  std::vector<int> sizes_;
  VisiblePairs visible_;
  double cellArea_;
  std::vector<int> root_;
};

/// Rooms 1, 2 … by falling size; 0 for specks behind a wall, which noise let the camera see through.
cv::Mat numbered(const cv::Mat& basins, const std::vector<int>& roots, const Merging& merging,
                 double minCells) {
  std::vector<int> order = roots;
  std::sort(order.begin(), order.end());
  order.erase(std::unique(order.begin(), order.end()), order.end());
  std::erase_if(order, [&](int root) { return merging.size(root) < minCells; });
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return merging.size(a) > merging.size(b); });
  std::vector<int> number(roots.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<int>(i) + 1;
  cv::Mat_<int> rooms(basins.size(), 0);
  std::transform(basins.begin<int>(), basins.end<int>(), rooms.begin(),
                 [&](int basin) { return basin < 0 ? 0 : number[roots[basin]]; });
  return rooms;
}

}  // namespace

OptionGroup declare(RoomSegmentationOptions& options) {
  OptionGroup group("room-segmentation", "How free space is split into rooms.");
  group
      .add("mutual-visibility", &options.mutualVisibility,
           "Two sides of a passage are one room where more than this share of their points see each other.")
      .range(0, 1)
      .why("Smaller values merge rooms with wide openings.");
  return group;
}

cv::Mat segmentRooms(const cv::Mat& freeSpace, const cv::Mat& walls, double cell,
                     const RoomSegmentationOptions& options) {
  if (freeSpace.empty()) return {};
  validate(options);
  cv::Mat closed;  // single cells without evidence are no walls
  cv::morphologyEx(freeSpace, closed, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  const Watershed watershed = watershedOf(closed, walls, cell);
  Merging merging(watershed, countVisible(closed, watershed.basins, watershed.sizes.size(), cell), cell);
  merging.merge(options);
  std::vector<int> roots;
  for (std::size_t i = 0; i < watershed.sizes.size(); ++i)
    roots.push_back(merging.rootOf(static_cast<int>(i)));
  return numbered(watershed.basins, roots, merging, options.minArea / (cell * cell));
}

}  // namespace estancia
