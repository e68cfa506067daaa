// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/room_segmentation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace estancia {
namespace {

struct Watershed {
  /// CV_32S: the basin of each free cell, -1 elsewhere.
  cv::Mat basins;
  /// The number of cells of each basin.
  std::vector<int> sizes;
  /// The distance to the border at the widest point between adjacent basins [m]; the lower number first.
  std::map<std::pair<int, int>, double> saddles;
};

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

/// Watershed of the distance to the nearest cell that is 0 in `freeSpace` (CV_8U; outside is 0), from the
/// peaks down. Two basins that meet are one where the saddle is hardly below the lower peak: the wall is only
/// rough there (persistence, Edelsbrunner et al. 2002). `cell`: the width of a cell [m].
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

/// Counts of pairs of sample points that see each other, by their regions.
class VisiblePairs {
 public:
  explicit VisiblePairs(std::size_t regions)
      : regions_(regions), seen_(regions * regions), points_(regions) {}

  void addPoint(std::size_t region) { points_[region] += 1; }
  /// Counts one pair of points, one in each region, in both orders.
  void addPair(std::size_t a, std::size_t b) {
    seen_[a * regions_ + b] += 1;
    seen_[b * regions_ + a] += 1;
  }
  /// The share of pairs with a point in each that see each other; 0 without points.
  double share(std::size_t a, std::size_t b) const {
    const double pairs = a == b ? points_[a] * (points_[a] - 1) : points_[a] * points_[b];
    if (a == b && points_[a] == 1) return 1;
    return pairs > 0 ? seen_[a * regions_ + b] / pairs : 0;
  }
  /// Moves all points of `b` to `a`.
  void merge(std::size_t a, std::size_t b) {
    for (std::size_t other = 0; other < regions_; ++other) {
      if (other == a || other == b) continue;
      seen_[a * regions_ + other] += seen_[b * regions_ + other];
      seen_[other * regions_ + a] = seen_[a * regions_ + other];
    }
    seen_[a * regions_ + a] += seen_[b * regions_ + b] + 2 * seen_[a * regions_ + b];
    points_[a] += points_[b];
  }

 private:
  std::size_t regions_;
  std::vector<double> seen_, points_;
};

struct Sample {
  cv::Point at;
  std::size_t region = 0;
};

std::vector<Sample> samplesOf(const cv::Mat& freeSpace, const cv::Mat& regions, double cell) {
  constexpr double spacing = 0.25;  // [m], a third of a door
  constexpr double most = 3000;     // points: 4.5 million lines
  const double area = cv::countNonZero(freeSpace) * cell * cell;
  const double wanted = std::max(spacing, std::sqrt(area / most));
  const int step = std::max(1, static_cast<int>(std::lround(wanted / cell)));
  std::vector<Sample> samples;
  for (int row = step / 2; row < freeSpace.rows; row += step)
    for (int column = step / 2; column < freeSpace.cols; column += step)
      if (const int region = regions.at<int>(row, column); region >= 0)
        samples.push_back({{column, row}, static_cast<std::size_t>(region)});
  return samples;
}

bool sees(const cv::Mat& freeSpace, cv::Point a, cv::Point b) {
  const int steps = std::max({1, std::abs(b.x - a.x), std::abs(b.y - a.y)});
  const double dx = static_cast<double>(b.x - a.x) / steps, dy = static_cast<double>(b.y - a.y) / steps;
  for (int i = 1; i < steps; ++i)
    if (freeSpace.at<unsigned char>(a.y + static_cast<int>(std::lround(i * dy)),
                                    a.x + static_cast<int>(std::lround(i * dx))) == 0)
      return false;
  return true;
}

/// Counts sample points of free space (CV_8U, not 0) on a grid, and pairs that see each other: those between
/// which the straight line is free. `regions`: CV_32S, < 0: none. `cell`: the width of a cell [m].
VisiblePairs countVisible(const cv::Mat& freeSpace, const cv::Mat& regions, std::size_t count, double cell) {
  const std::vector<Sample> samples = samplesOf(freeSpace, regions, cell);
  VisiblePairs pairs(count);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    pairs.addPoint(samples[i].region);
    for (std::size_t j = 0; j < i; ++j)
      if (sees(freeSpace, samples[i].at, samples[j].at)) pairs.addPair(samples[i].region, samples[j].region);
  }
  return pairs;
}

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
      const auto [kept, joined] = *pair;
      root_[joined] = kept;
      sizes_[kept] += sizes_[joined];
      visible_.merge(kept, joined);
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
