#include "estancia/topology/thresholds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace estancia {
namespace {

constexpr std::size_t anchors = 256;       // frames compared pair by pair: 32,640 pairs
constexpr std::size_t nearLag = 2;         // frames that count as near in time
constexpr std::size_t leastGap = 5;        // frames that count as far in time, at least …
constexpr double gapShare = 0.05;          // … and this share of the run
constexpr std::size_t leastFarPairs = 10;  // below this a quantile says nothing
constexpr double largestRevisitShare = 0.8;
constexpr double leastShare = 1e-4;  // τ_join stays above this share of its default: a robot that stands
                                     // sees identical images, whose distances are mere rounding
constexpr double priorFrames = 20;   // how many frames the scales' prior counts for

/// Linear interpolation between order statistics (R's type 7). `values` is sorted.
double quantile(const std::vector<double>& values, double q) {
  const double position = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace

Thresholds thresholdsFrom(double tauJoin, const ThresholdOptions& options) {
  return {tauJoin, options.revisitRatio * tauJoin, options.mergeRatio * tauJoin};
}

RunScale::RunScale(Distance distance, std::size_t labels, ThresholdOptions options)
    : distance_(std::move(distance)), labels_(labels), options_(options), moments_(labels, true) {}

std::size_t RunScale::strideAfter(std::size_t frames) {
  std::size_t stride = 1;
  while ((frames + stride - 1) / stride > anchors) stride *= 2;
  return stride;
}

std::vector<std::size_t> RunScale::sampledFrames(std::size_t frames) {
  const std::size_t stride = strideAfter(frames);
  std::vector<std::size_t> sampled;
  for (std::size_t anchor = 0; anchor < frames; anchor += stride)
    for (std::size_t frame = anchor; frame < std::min({anchor + nearLag + 1, anchor + stride, frames});
         ++frame)
      sampled.push_back(frame);
  return sampled;
}

void RunScale::add(std::span<const float> embedded) {
  moments_.add(embedded);
  const std::size_t stride = strideAfter(frames_ + 1);
  if (stride != strideAfter(std::max<std::size_t>(frames_, 1)))
    std::erase_if(sample_, [stride](const auto& entry) { return entry.first % stride > nearLag; });
  if (frames_ % stride <= nearLag)
    sample_.emplace(frames_, std::vector<float>(embedded.begin(), embedded.end()));
  ++frames_;
}

Standardization RunScale::standardization() const {
  if (!distance_.standardized || frames_ == 0) return {};
  // Early on every label's centre shrinks to 0 and its variance to the mean variance of all labels.
  const double n = static_cast<double>(frames_);
  const auto variance = moments_.variance();
  const double meanVariance =
      std::accumulate(variance.begin(), variance.end(), 0.0) / static_cast<double>(labels_);
  Standardization result{std::vector<float>(labels_), std::vector<float>(labels_)};
  for (std::size_t i = 0; i < labels_; ++i) {
    result.centre[i] = static_cast<float>(moments_.mean()[i] * n / (n + priorFrames));
    const double shrunk = (n * variance[i] + priorFrames * meanVariance) / (n + priorFrames);
    result.scale[i] = shrunk > 0 ? static_cast<float>(std::sqrt(shrunk)) : 1.0F;
  }
  return result;
}

std::optional<Thresholds> RunScale::estimate(const Standardization& standardization) const {
  // The bank's own vectors, so that pairs of frames are compared just as frames and nodes will be.
  NodeBank frames(distance_, labels_);
  frames.setStandardization(standardization);
  std::map<std::size_t, std::vector<float>> queries;
  for (const auto& [frame, embedded] : sample_) queries.emplace(frame, frames.makeQuery(embedded));
  const auto distanceOf = [&](const std::vector<float>& a, const std::vector<float>& b) {
    return compare(distance_.comparison, a, b);
  };

  std::vector<double> near, far;
  const std::size_t stride = strideAfter(frames_);
  const auto gap = std::max(static_cast<double>(leastGap), gapShare * static_cast<double>(frames_));
  for (const auto& [frame, query] : queries) {
    if (frame % stride != 0) continue;
    for (std::size_t lag = 1; lag <= nearLag; ++lag)
      if (const auto next = queries.find(frame + lag); next != queries.end())
        near.push_back(distanceOf(query, next->second));
    for (auto other = queries.upper_bound(frame + static_cast<std::size_t>(gap)); other != queries.end();
         ++other)
      if (other->first % stride == 0) far.push_back(distanceOf(query, other->second));
  }
  if (far.size() < leastFarPairs || near.empty()) return std::nullopt;
  std::sort(near.begin(), near.end());
  std::sort(far.begin(), far.end());
  const auto below = std::lower_bound(far.begin(), far.end(), quantile(near, 0.5)) - far.begin();
  const double revisited =
      std::min(largestRevisitShare, 2.0 * static_cast<double>(below) / static_cast<double>(far.size()));
  const double tauJoin = quantile(far, revisited + options_.farQuantile * (1 - revisited));
  return thresholdsFrom(std::max(tauJoin, leastShare * distance_.tauJoin), options_);
}

void RunScale::restore(std::size_t frames, Moments moments,
                       std::map<std::size_t, std::vector<float>> sample) {
  frames_ = frames;
  moments_ = std::move(moments);
  sample_ = std::move(sample);
}

}  // namespace estancia
