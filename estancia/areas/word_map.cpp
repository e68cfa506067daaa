// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/word_map.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {
namespace {

/// Smaller cells cost memory; words are no more exact than the views that cross [m].
constexpr double cellWidth = 0.2;
/// Rare words are forgotten where cells keep few.
constexpr std::size_t wordsOfCell = 64;

/// A cell's place on the floor, counted in cells from its origin, whatever the grid has grown to.
std::uint64_t keyOf(const cv::Point2d& at) {
  const auto place = [](double x) {
    return static_cast<std::uint32_t>(std::llround(std::floor(x / cellWidth)));
  };
  return std::uint64_t{place(at.x)} << 32 | place(at.y);
}

/// The probability of one of several labels.
struct Evidence {
  double sum = 0, squares = 0;
};

/// Lower end of the mean's standard error (weighted; Kish's effective number of images). An image more that
/// does not show the word, as weighty as the mean one, keeps single glances from being certain.
float lowerBound(const Evidence& evidence, double weight, double squaredWeight) {
  const double effective = weight * weight / squaredWeight;
  const double total = weight * (1 + 1 / effective);
  const double mean = evidence.sum / total;
  const double variance = std::max(0.0, evidence.squares / total - mean * mean);
  return static_cast<float>(std::max(0.0, mean - std::sqrt(variance / (effective + 1))));
}

}  // namespace

WordMap::WordMap(const Floor& floor, std::size_t labels)
    : floor_(floor), labels_(labels), cells_(cellWidth) {}

void WordMap::add(DescriptorView descriptor, const cv::Mat& depth, const CameraIntrinsics& camera,
                  const Pose& pose) {
  requireProbabilities(descriptor, labels_, "word map");
  const CameraIntrinsics scaled = camera.scaledTo(depth.cols, depth.rows);
  const cv::Affine3d rigid = rigidOf(pose);
  const int step = std::max(1, depth.cols / 80);
  Shares shares;
  std::size_t pixels = 0;
  for (int v = step / 2; v < depth.rows; v += step)
    for (int u = step / 2; u < depth.cols; u += step) {
      ++pixels;
      const double z = depth.at<float>(v, u);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const cv::Vec3d point = rigid * cv::Vec3d(scaled.slopeX(u) * z, scaled.slopeY(v) * z, z);
      const cv::Point2d at = floor_.position(point);
      cells_.cover(at.x, at.y, 0);
      shares[keyOf(at)] += 1;
    }
  for (auto& [key, share] : shares) share /= static_cast<double>(pixels);
  pool(descriptor, shares);
}

void WordMap::add(DescriptorView descriptor, double fieldOfView, const Pose& pose) {
  // Rooms are some meters wide; what is nearer fills more of the image.
  constexpr double reach = 4;
  requireProbabilities(descriptor, labels_, "word map");
  const PlanarPose here = floor_.project(pose);
  Shares shares;
  double total = 0;
  const int rays = 32;
  for (int ray = 0; ray < rays; ++ray)
    for (double range = cellWidth; range < reach; range += cellWidth) {
      const double angle = here.heading + fieldOfView * ((ray + 0.5) / rays - 0.5);
      const cv::Point2d at(here.x + range * std::cos(angle), here.y + range * std::sin(angle));
      cells_.cover(at.x, at.y, 0);
      const double weight = std::exp(-range / (reach / 2));
      shares[keyOf(at)] += weight;
      total += weight;
    }
  for (auto& [key, share] : shares) share /= total;
  pool(descriptor, shares);
}

void WordMap::pool(DescriptorView descriptor, const Shares& shares) {
  const float chance = 1 / static_cast<float>(labels_);
  std::vector<std::uint32_t> likely;
  for (std::size_t label = 0; label < labels_; ++label)
    if (descriptor[label] > chance) likely.push_back(static_cast<std::uint32_t>(label));
  for (const auto& [key, share] : shares) {
    Cell& cell = seen_[key];
    cell.weight += share;
    cell.squaredWeight += share * share;
    std::vector<Word> merged;
    merged.reserve(cell.words.size() + likely.size());
    auto word = cell.words.begin();
    for (const std::uint32_t label : likely) {
      while (word != cell.words.end() && word->label < label) merged.push_back(*word++);
      Word sum = word != cell.words.end() && word->label == label ? *word++ : Word{label, 0, 0};
      const auto weighted = static_cast<float>(share) * descriptor[label];
      sum.sum += weighted;
      sum.squares += weighted * descriptor[label];
      merged.push_back(sum);
    }
    merged.insert(merged.end(), word, cell.words.end());
    cell.words = std::move(merged);
    if (cell.words.size() > 2 * wordsOfCell) keepBest(cell);
  }
}

void WordMap::keepBest(Cell& cell) const {
  const auto kept = cell.words.begin() + static_cast<std::ptrdiff_t>(wordsOfCell);
  std::nth_element(cell.words.begin(), kept, cell.words.end(), [](const Word& a, const Word& b) {
    return a.sum != b.sum ? a.sum > b.sum : a.label < b.label;
  });
  cell.words.erase(kept, cell.words.end());
  cell.words.shrink_to_fit();
  std::sort(cell.words.begin(), cell.words.end(),
            [](const Word& a, const Word& b) { return a.label < b.label; });
}

cv::Point WordMap::cellOf(std::uint64_t key) const {
  const auto place = [](std::uint64_t bits) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(bits));
  };
  return cells_.at((place(key >> 32) + 0.5) * cellWidth, (place(key) + 0.5) * cellWidth);
}

FloorHeat WordMap::heat(std::span<const std::size_t> labels) const {
  for (const std::size_t label : labels)
    if (label >= labels_) fail(ErrorCode::invalidInput, "there is no label {} of {}", label, labels_);
  FloorHeat heat{cells_, cv::Mat(cells_.rows(), cells_.columns(), CV_32F, cv::Scalar(0))};
  for (const auto& [key, cell] : seen_) {
    Evidence evidence;
    for (const Word& word : cell.words)
      if (std::find(labels.begin(), labels.end(), word.label) != labels.end()) {
        evidence.sum += word.sum;
        evidence.squares += word.squares;
      }
    if (evidence.sum > 0)
      heat.values.at<float>(cellOf(key)) = lowerBound(evidence, cell.weight, cell.squaredWeight);
  }
  if (!heat.values.empty()) cv::GaussianBlur(heat.values, heat.values, {}, 1.0);
  return heat;
}

std::vector<float> WordMap::mean(const cv::Mat& mask) const {
  std::vector<double> sums(labels_);
  double weight = 0;
  std::vector<std::uint64_t> keys;  // in an order of their own: sums are the same for any hash
  for (const auto& [key, cell] : seen_)
    if (mask.at<unsigned char>(cellOf(key)) != 0) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  for (const std::uint64_t key : keys) {
    const Cell& cell = seen_.at(key);
    weight += cell.weight;
    for (const Word& word : cell.words) sums[word.label] += word.sum;
  }
  std::vector<float> mean(labels_, 0.0F);
  if (weight > 0)
    std::transform(sums.begin(), sums.end(), mean.begin(),
                   [weight](double sum) { return static_cast<float>(sum / weight); });
  return mean;
}

}  // namespace estancia
