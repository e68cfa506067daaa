// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/mutual_visibility.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace estancia {
namespace {

struct Sample {
  cv::Point at;
  int region = 0;
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
        samples.push_back({{column, row}, region});
  return samples;
}

bool sees(const cv::Mat& freeSpace, cv::Point a, cv::Point b) {
  const int steps = std::max(std::abs(b.x - a.x), std::abs(b.y - a.y));
  const double dx = steps == 0 ? 0 : static_cast<double>(b.x - a.x) / steps;
  const double dy = steps == 0 ? 0 : static_cast<double>(b.y - a.y) / steps;
  for (int i = 1; i < steps; ++i)
    if (freeSpace.at<unsigned char>(a.y + static_cast<int>(std::lround(i * dy)),
                                    a.x + static_cast<int>(std::lround(i * dx))) == 0)
      return false;
  return true;
}

}  // namespace

void VisiblePairs::merge(std::size_t a, std::size_t b) {
  for (std::size_t other = 0; other < regions_; ++other) {
    if (other == a || other == b) continue;
    seen_[a * regions_ + other] += seen_[b * regions_ + other];
    seen_[other * regions_ + a] = seen_[a * regions_ + other];
  }
  seen_[a * regions_ + a] += seen_[b * regions_ + b] + 2 * seen_[a * regions_ + b];
  points_[a] += points_[b];
}

VisiblePairs countVisible(const cv::Mat& freeSpace, const cv::Mat& regions, std::size_t count, double cell) {
  const std::vector<Sample> samples = samplesOf(freeSpace, regions, cell);
  VisiblePairs pairs(count);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    pairs.addPoint(static_cast<std::size_t>(samples[i].region));
    for (std::size_t j = 0; j < i; ++j)
      if (sees(freeSpace, samples[i].at, samples[j].at))
        pairs.addPair(static_cast<std::size_t>(samples[i].region),
                      static_cast<std::size_t>(samples[j].region));
  }
  return pairs;
}

}  // namespace estancia
