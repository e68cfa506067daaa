// SPDX-License-Identifier: Apache-2.0
#include "scenes/descriptor_figures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <span>
#include <string>

#include "estancia/core/png.hpp"

namespace estancia::experiments {
namespace {

using Numbers = std::span<const float>;
constexpr int figureSide = 480;  // pixels

float largestOf(Numbers numbers) {
  return std::max(*std::max_element(numbers.begin(), numbers.end()), 1e-9F);
}

/// The image in gray, dark enough to draw on.
cv::Mat backgroundOf(const cv::Mat& image) {
  cv::Mat gray, background;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  cv::resize(gray * 0.4, gray, {figureSide, figureSide}, 0, 0, cv::INTER_AREA);
  cv::cvtColor(gray, background, cv::COLOR_GRAY2BGR);
  return background;
}

/// One level of PHOG: in each of side × side cells a ray a bin, by its share of the level's largest.
cv::Mat drawPhog(const cv::Mat& image, Numbers level, int side) {
  cv::Mat canvas = backgroundOf(image);
  const double cell = static_cast<double>(figureSide) / side, largest = largestOf(level);
  const std::size_t bins = level.size() / static_cast<std::size_t>(side * side);
  for (std::size_t i = 0; i < level.size(); ++i) {
    const auto place = static_cast<int>(i / bins);
    const double turn =
        2 * std::numbers::pi * (static_cast<double>(i % bins) + 0.5) / static_cast<double>(bins);
    const double length = 0.48 * cell * level[i] / largest;
    const cv::Point2d middle((place % side + 0.5) * cell, (place / side + 0.5) * cell);
    cv::line(canvas, middle, middle + length * cv::Point2d(std::cos(turn), std::sin(turn)), {80, 220, 255}, 2,
             cv::LINE_AA);
  }
  for (int k = 1; k < side; ++k) {
    const int at = cvRound(k * cell);
    cv::line(canvas, {at, 0}, {at, figureSide}, {160, 160, 160});
    cv::line(canvas, {0, at}, {figureSide, at}, {160, 160, 160});
  }
  return canvas;
}

/// GIST: in each of 4 × 4 blocks of the central square a ring a scale, the finest outside, and in it an arc
/// an orientation, the brighter the more energy: a filter's wave runs from the middle of its arc to the
/// center.
cv::Mat drawGist(const cv::Mat& image, Numbers gist) {
  constexpr int blocks = 4, orientations = 8, scales = 4;
  const int square = std::min(image.cols, image.rows);
  cv::Mat canvas =
      backgroundOf(image({(image.cols - square) / 2, (image.rows - square) / 2, square, square}));
  const int cell = figureSide / blocks;
  for (int i = 0; i < scales * orientations * blocks * blocks; ++i) {
    const int block = i % (blocks * blocks), orientation = i / (blocks * blocks) % orientations;
    const int ring = scales - i / (blocks * blocks * orientations);
    const int radius = ring * cell / (2 * scales + 2);
    const cv::Point middle(block % blocks * cell + cell / 2, block / blocks * cell + cell / 2);
    const double energy = gist[static_cast<std::size_t>(i)] / largestOf(gist);
    for (const double turn : {0.0, 180.0})
      cv::ellipse(canvas, middle, {radius, radius}, turn - 180.0 / orientations * orientation, -9, 9,
                  {60 + 20 * energy, 40 + 180 * energy, 40 + 215 * energy}, cell / (2 * scales + 2) - 1);
  }
  return canvas;
}

/// ESF: ten histograms of 64 bins, each by its own largest.
cv::Mat drawEsf(Numbers esf) {
  constexpr int columns = 3, height = figureSide / 4, width = figureSide / columns;
  cv::Mat canvas(figureSide, figureSide, CV_8UC3, cv::Scalar(30, 30, 30));
  const char* names[] = {"angle in",   "angle out",   "angle mixed",  "area in",        "area out",
                         "area mixed", "distance in", "distance out", "distance mixed", "ratio"};
  for (int h = 0; h < 10; ++h) {
    const Numbers bins = esf.subspan(static_cast<std::size_t>(h) * 64, 64);
    const cv::Point corner(h % columns * width + 12, (h / columns + 1) * height - 10);
    for (int b = 0; b < 64; ++b) {
      const int tall = cvRound((height - 36) * bins[static_cast<std::size_t>(b)] / largestOf(bins));
      cv::rectangle(canvas, cv::Rect(corner.x + 2 * b, corner.y - tall, 2, tall + 1), {80, 220, 255},
                    cv::FILLED);
    }
    cv::putText(canvas, names[h], {corner.x, corner.y - height + 30}, cv::FONT_HERSHEY_SIMPLEX, 0.42,
                {230, 230, 230}, 1, cv::LINE_AA);
  }
  return canvas;
}

}  // namespace

std::optional<Images> descriptorFigures(const cv::Mat& image, const Features& features) {
  Images figures{"How descriptors come about (Fig. 3.3 to 3.5)",
                 "Drawn from the numbers that describe " + features.frames.at(0).name + ".",
                 {},
                 false};
  const Numbers all = features.values.row(0);
  std::size_t at = 0;
  const auto add = [&](const cv::Mat& drawn, const std::string& caption) {
    figures.images.push_back({toPng(drawn), caption});
  };
  for (const DescriptorPart& part : features.parts) {
    const Numbers numbers = all.subspan(at, part.size());
    at += part.size();
    if (part.name == "phog")
      for (std::size_t level = 0, from = 0, side = 1; level < 3; from += 30 * side * side, side *= 2, ++level)
        add(drawPhog(image, numbers.subspan(from, 30 * side * side), static_cast<int>(side)),
            "PHOG, level " + std::to_string(level) + ": directions in which edges grow brighter, by cell");
    if (part.name == "gist") add(drawGist(image, numbers), "GIST: energies by block, scale and orientation");
    if (part.name == "esf") add(drawEsf(numbers), "ESF: ten histograms of random points' triangles");
  }
  if (figures.images.empty()) return std::nullopt;
  return figures;
}

}  // namespace estancia::experiments
