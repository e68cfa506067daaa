// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/phog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {

cv::Mat grayOf(const cv::Mat& image, int maxSide) {
  if (image.empty()) throw Error(ErrorCode::invalidInput, "phog: the view has no image; give one");
  if (image.type() != CV_8UC3 && image.type() != CV_8UC1)
    throw Error(ErrorCode::invalidInput, "phog: the image is neither BGR nor gray with 8 bits; convert it");
  cv::Mat gray = image;
  if (const int side = std::max(image.cols, image.rows); side > maxSide) {
    const double scale = static_cast<double>(maxSide) / side;
    cv::resize(gray, gray,
               {std::max(1, cvRound(image.cols * scale)), std::max(1, cvRound(image.rows * scale))}, 0, 0,
               cv::INTER_AREA);
  }
  if (gray.channels() == 3) cv::cvtColor(gray, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

struct Gradient {
  cv::Mat dx, dy;  ///< CV_16S

  explicit Gradient(const cv::Mat& gray) { cv::spatialGradient(gray, dx, dy, 3, cv::BORDER_REPLICATE); }
};

/// The magnitude that 70 % of the pixels stay below, to 1/64 of the largest; 0 when all are alike.
double highThreshold(const Gradient& gradient) {
  cv::Mat squares(gradient.dx.size(), CV_32S);
  int largest = 0;
  for (int y = 0; y < squares.rows; ++y) {
    const auto* dx = gradient.dx.ptr<short>(y);
    const auto* dy = gradient.dy.ptr<short>(y);
    int* square = squares.ptr<int>(y);
    for (int x = 0; x < squares.cols; ++x) {
      square[x] = dx[x] * dx[x] + dy[x] * dy[x];
      largest = std::max(largest, square[x]);
    }
  }
  if (largest == 0) return 0;
  constexpr int steps = 64;
  const float top = std::sqrt(static_cast<float>(largest)), scale = steps / top;
  std::array<std::size_t, steps + 1> counts{};
  for (int y = 0; y < squares.rows; ++y) {
    const int* square = squares.ptr<int>(y);
    for (int x = 0; x < squares.cols; ++x)
      ++counts[static_cast<std::size_t>(std::sqrt(static_cast<float>(square[x])) * scale)];
  }
  std::size_t below = 0;
  int step = 0;
  while (step < steps && static_cast<double>(below += counts[static_cast<std::size_t>(step)]) <=
                             0.7 * static_cast<double>(squares.total()))
    ++step;
  return (step + 1) * static_cast<double>(top) / steps;
}

/// Canny's edges with the thresholds of the image's own contrast, as in MATLAB's edge(), which the authors
/// used: σ = √2, high where 70 % are below, low at 40 % of it.
cv::Mat edgesOf(const cv::Mat& gray) {
  cv::Mat smooth, edges;
  cv::GaussianBlur(gray, smooth, {9, 9}, std::numbers::sqrt2, std::numbers::sqrt2, cv::BORDER_REPLICATE);
  const Gradient gradient(smooth);
  const double high = highThreshold(gradient);
  if (high == 0) return cv::Mat::zeros(gray.size(), CV_8U);
  cv::Canny(gradient.dx, gradient.dy, edges, 0.4 * high, high, true);
  return edges;
}

}  // namespace

OptionGroup declare(PhogOptions& options) {
  OptionGroup group("phog", "PHOG: pyramid histogram of oriented gradients.");
  group.add("bins", &options.bins, "Bins of edge orientation in every cell.").range(1, 360);
  group.add("levels", &options.levels, "Last level of the pyramid; level v has 2^v x 2^v cells.")
      .range(0, 4)
      .why("more levels tell more about positions");
  group.add("range", &options.range, "Range of orientations: 180 or 360.")
      .range(180, 360)
      .unit("degrees")
      .why("with 180, an edge from dark to light equals one from light to dark");
  group.add("max-side", &options.maxSide, "Larger images are reduced to this side.")
      .range(16)
      .unit("pixels")
      .why("the scale of edges is then the same in images of all sizes");
  return group;
}

void validate(const PhogOptions& options) {
  PhogOptions copy = options;
  declare(copy).validate();
  if (options.range != 180 && options.range != 360)
    fail(ErrorCode::invalidOption, "phog.range is {}; give 180 or 360 degrees", options.range);
}

std::vector<float> phog(const cv::Mat& image, const PhogOptions& options) {
  validate(options);
  const cv::Mat gray = grayOf(image, options.maxSide);
  const cv::Mat edges = edgesOf(gray);
  const Gradient gradient(gray);  // gradient of the image before smoothing, as in the paper

  // Votes in the smallest cells. A larger cell holds four smaller ones, whatever the size of the image.
  const int bins = options.bins, side = 1 << options.levels;
  std::vector<double> votes(static_cast<std::size_t>(side * side * bins));
  const double turn = options.range * std::numbers::pi / 180;
  for (int y = 0; y < gray.rows; ++y) {
    const auto* edge = edges.ptr<uchar>(y);
    const auto* dx = gradient.dx.ptr<short>(y);
    const auto* dy = gradient.dy.ptr<short>(y);
    const int row = static_cast<int>(static_cast<long>(y) * side / gray.rows);
    for (int x = 0; x < gray.cols; ++x) {
      if (edge[x] == 0) continue;
      double angle = std::atan2(static_cast<float>(dy[x]), static_cast<float>(dx[x]));
      if (angle < 0)  // opposite directions are the same for 180 degrees, to the last bit
        angle = options.range == 360 ? angle + turn
                                     : std::atan2(static_cast<float>(-dy[x]), static_cast<float>(-dx[x]));
      const int bin = static_cast<int>(angle / turn * bins) % bins;
      const int cell = row * side + static_cast<int>(static_cast<long>(x) * side / gray.cols);
      votes[static_cast<std::size_t>(cell * bins + bin)] += std::hypot(dx[x], dy[x]);
    }
  }

  // The pyramid, from its base to its top, then in the paper's order.
  std::vector<std::vector<double>> levels{std::move(votes)};
  for (int s = side / 2; s > 0; s /= 2) {
    const std::vector<double>& fine = levels.back();
    std::vector<double> coarse(static_cast<std::size_t>(s * s * bins));
    for (int row = 0; row < 2 * s; ++row)
      for (int column = 0; column < 2 * s; ++column)
        for (int bin = 0; bin < bins; ++bin)
          coarse[static_cast<std::size_t>((row / 2 * s + column / 2) * bins + bin)] +=
              fine[static_cast<std::size_t>((row * 2 * s + column) * bins + bin)];
    levels.push_back(std::move(coarse));
  }
  double sum = 0;
  for (const auto& level : levels)
    for (const double v : level) sum += v;
  std::vector<float> descriptor;
  std::for_each(levels.rbegin(), levels.rend(), [&](const auto& level) {
    for (const double v : level) descriptor.push_back(sum > 0 ? static_cast<float>(v / sum) : 0);
  });
  return descriptor;
}

std::vector<DescriptorPart> Phog::parts() const {
  DescriptorPart part{"phog",
                      PartKind::histogram,
                      {},
                      fmt::format("phog 1, {} bins of {} degrees, levels 0 to {}, at most {} pixels",
                                  options_.bins, options_.range, options_.levels, options_.maxSide)};
  for (int level = 0; level <= options_.levels; ++level)
    for (int cell = 0; cell < 1 << (2 * level); ++cell)
      for (int bin = 0; bin < options_.bins; ++bin)
        part.columns.push_back(fmt::format("phog {}.{}.{}", level, cell, bin));
  return {std::move(part)};
}

}  // namespace estancia
