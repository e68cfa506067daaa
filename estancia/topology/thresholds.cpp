#include "estancia/topology/thresholds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace estancia {
namespace {

constexpr std::size_t anchors = 256;       // keyframes compared pair by pair: 32,640 pairs
constexpr std::size_t nearLag = 2;         // frames that count as near in time
constexpr std::size_t leastGap = 5;        // frames that count as far in time, at least …
constexpr double gapShare = 0.05;          // … and this share of the run
constexpr std::size_t leastFarPairs = 10;  // below this a quantile says nothing
constexpr double largestRevisitShare = 0.8;
constexpr double leastShare = 1e-4;  // τ_join stays above this share of its default, above mere rounding
constexpr double novelty = 0.05;     // cosine distance of log-ratios beyond a standing camera's noise: about
                                     // .015, at most .04, against .15 and more between views of a moving one
constexpr std::size_t leastViews = 3;    // below this a run has shown nothing but noise
constexpr std::size_t mostRepeats = 10;  // frames of one view that count
constexpr double centrePrior = 20;       // keyframes that each label's centre shrinks to 0 by
constexpr double weightPrior = 1;        // keyframes that the labels' weights shrink by
constexpr double quietShare = 0.01;  // labels with less variance than this share of the typical one fade out

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

std::size_t RunScale::strideAfter(std::size_t keyframes) {
  std::size_t stride = 1;
  while ((keyframes + stride - 1) / stride > anchors) stride *= 2;
  return stride;
}

bool RunScale::counts(std::span<const float> probabilities, std::span<const float> embedded) {
  std::vector<float> ratios(embedded.begin(), embedded.end());
  if (distance_.embedding != Embedding::centredLogRatio)
    embed(Embedding::centredLogRatio, probabilities, ratios, distance_.parts);
  if (lastView_.empty() || compare(Comparison::cosine, ratios, lastView_) > novelty) {
    lastView_ = std::move(ratios);
    memory_.lastView = memory_.frames - 1;
    memory_.repeats = 0;
    ++memory_.views;
    return true;
  }
  return ++memory_.repeats < mostRepeats;
}

void RunScale::add(std::span<const float> probabilities, std::span<const float> embedded) {
  const std::size_t frame = memory_.frames++;
  if (!counts(probabilities, embedded)) return;
  const std::size_t keyframe = memory_.keyframes++;
  moments_.add(embedded);
  const std::size_t stride = strideAfter(keyframe + 1);
  if (stride != strideAfter(std::max<std::size_t>(keyframe, 1))) {
    const auto isSpare = [stride](const auto& entry) { return entry.first % stride > nearLag; };
    std::erase_if(sample_, isSpare);
    std::erase_if(memory_.sampled, isSpare);
  }
  if (keyframe % stride > nearLag) return;
  sample_.emplace(keyframe, std::vector<float>(embedded.begin(), embedded.end()));
  memory_.sampled.emplace(keyframe, frame);
}

/// Weight σ/(σ² + λ): about 1/σ for labels that say something. λ keeps those apart that hardly vary, among
/// them all that never fire, and is larger while the run is too young to tell them.
Standardization RunScale::standardization() const {
  if (!distance_.standardized || memory_.frames == 0) return {};
  if (memory_.views < leastViews)
    return {std::vector<float>(labels_, 0.0F), std::vector<float>(labels_, 1.0F)};
  const auto n = static_cast<double>(memory_.keyframes);
  const auto variance = moments_.variance();
  double sum = 0, squares = 0;
  for (const float v : variance) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double typical = sum > 0 ? squares / sum : 0;  // the variance of the labels that make up the variance
  const double lambda = typical * (quietShare + weightPrior / (n + weightPrior));
  Standardization result{std::vector<float>(labels_), std::vector<float>(labels_, 1.0F)};
  for (std::size_t i = 0; i < labels_; ++i) {
    result.centre[i] = static_cast<float>(moments_.mean()[i] * n / (n + centrePrior));
    if (lambda > 0) result.weight[i] = static_cast<float>(std::sqrt(variance[i]) / (variance[i] + lambda));
  }
  return result;
}

std::optional<Thresholds> RunScale::estimate(const Standardization& standardization) const {
  if (memory_.views < leastViews) return std::nullopt;
  // The bank's own vectors, so that pairs of frames are compared just as frames and nodes will be.
  NodeBank frames(distance_, labels_);
  frames.setStandardization(standardization);
  std::map<std::size_t, std::vector<float>> queries;
  for (const auto& [frame, embedded] : sample_) queries.emplace(frame, frames.makeQuery(embedded));
  const auto distanceOf = [&](const std::vector<float>& a, const std::vector<float>& b) {
    return compare(distance_.comparison, a, b);
  };

  std::vector<double> near, far;
  const std::size_t stride = strideAfter(memory_.keyframes);
  const auto gap = std::max(static_cast<double>(leastGap), gapShare * static_cast<double>(memory_.keyframes));
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

void RunScale::restore(Memory memory, Moments moments,
                       const std::function<std::vector<float>(std::size_t)>& probabilities) {
  memory_ = std::move(memory);
  moments_ = std::move(moments);
  for (const auto& [keyframe, frame] : memory_.sampled) {
    std::vector<float> embedded = probabilities(frame);
    embed(distance_.embedding, embedded, embedded, distance_.parts);
    sample_.emplace(keyframe, std::move(embedded));
  }
  if (memory_.frames == 0) return;
  lastView_ = probabilities(memory_.lastView);
  embed(Embedding::centredLogRatio, lastView_, lastView_, distance_.parts);
}

}  // namespace estancia
