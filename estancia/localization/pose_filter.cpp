// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/pose_filter.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>

namespace estancia {
namespace {

struct Gaussian {
  double mean = 0, sigma = 0;

  explicit Gaussian(const std::vector<float>& values) {
    const auto n = static_cast<double>(values.size());
    for (const float value : values) mean += value / n;
    for (const float value : values) sigma += (value - mean) * (value - mean) / n;
    sigma = std::sqrt(sigma);
  }
  double logDensity(double x) const { return -0.5 * std::pow((x - mean) / sigma, 2) - std::log(sigma); }
};

constexpr double degree = std::numbers::pi / 180;
/// Odometry errs by about this share of what was driven or turned.
constexpr double odometryError = 0.1;
/// How strongly a frame must look like an image before it speaks for "near" rather than "unmapped": the best
/// of the several images near a pose is more alike than any one of them.
constexpr double unmappedEvidence = 3;

std::vector<PlanarPose> posesOf(const std::vector<std::optional<PlanarPose>>& images) {
  std::vector<PlanarPose> poses;
  for (const auto& image : images)
    if (image) poses.push_back(*image);
  return poses;
}

/// Half of the sum is made of values at least this large, each counted up to `most`; `most` where all are 0.
/// Standing still does not change it.
double usualStep(std::vector<double> steps, double most) {
  for (double& step : steps) step = std::min(step, most);
  std::ranges::sort(steps, std::greater<>());
  double rest = std::accumulate(steps.begin(), steps.end(), 0.0) / 2;
  for (const double step : steps)
    if ((rest -= step) < 0) return step;
  return most;
}

/// Twice as far and twice as turned as usual in the mapped drive.
PlanarMotion unknownMotionOf(const std::vector<std::optional<PlanarPose>>& images,
                             const PlaceFilterOptions& options) {
  std::vector<double> distances, turns;
  for (std::size_t i = 1; i < images.size(); ++i) {
    const auto &a = images[i - 1], &b = images[i];
    if (!a || !b) continue;
    distances.push_back(std::hypot(a->x - b->x, a->y - b->y));
    turns.push_back(std::abs(wrapped(a->heading - b->heading)));
  }
  PlanarMotion motion;
  motion.looseDistance = 2 * usualStep(distances, options.nearDistance);
  motion.looseTurn = 2 * usualStep(turns, options.nearAngle * degree);
  return motion;
}

}  // namespace

NearEvidence::NearEvidence(const std::vector<float>& near, const std::vector<float>& far) {
  Gaussian ofNear(near), ofFar(far);
  // The spread of few or equal pairs would be 0, and one frame would decide everything.
  const double smallest = 0.05 * std::max(std::abs(ofFar.mean), 1e-6);
  for (Gaussian* gaussian : {&ofNear, &ofFar}) gaussian->sigma = std::max(gaussian->sigma, smallest);
  first_ = std::min(std::ranges::min(near), std::ranges::min(far));
  const double last = std::max(std::ranges::max(near), std::ranges::max(far));
  step_ = std::max(last - first_, 1e-9) / static_cast<double>(samples - 1);
  for (std::size_t i = 0; i < samples; ++i) {
    const double distance = first_ + step_ * static_cast<double>(i);
    log_.push_back(ofNear.logDensity(distance) - ofFar.logDensity(distance));
  }
  // A wide Gaussian of near pairs would make the largest distances speak for "near", too.
  const auto turning = std::ranges::min_element(log_);
  std::fill(turning, log_.end(), *turning);
  for (auto i = log_.rbegin() + 1; i != log_.rend(); ++i) *i = std::max(*i, *(i - 1));
}

double NearEvidence::ratio(double distance) const {
  const double at = std::clamp((distance - first_) / step_, 0.0, static_cast<double>(samples - 1));
  const auto below = std::min(static_cast<std::size_t>(at), samples - 2);
  return std::exp(std::lerp(log_[below], log_[below + 1], at - static_cast<double>(below)));
}

PoseFilter::PoseFilter(std::vector<std::optional<PlanarPose>> images, NearEvidence evidence,
                       const PlaceFilterOptions& options)
    : images_(std::move(images)),
      evidence_(std::move(evidence)),
      options_(options),
      grid_(posesOf(images_), options.nearDistance * 0.3, options.nearDistance * 2),
      unknown_(unknownMotionOf(images_, options)) {
  findNearImages();
  findNearestImages();
  findUnvisited();
}

void PoseFilter::findUnvisited() {
  isUnvisited_.resize(states());
  for (std::size_t s = 0; s < states(); ++s) {
    const PlanarPose at = grid_.poseOf(s), &image = *images_[nearest_[s]];
    isUnvisited_[s] =
        std::hypot(at.x - image.x, at.y - image.y) > std::max(options_.nearDistance, grid_.cell());
  }
}

/// A Gaussian of half the options' distance and angle, up to both; in wide maps not narrower than the cells.
void PoseFilter::findNearImages() {
  const double sigma = std::max(options_.nearDistance, grid_.cell()) / 2,
               sigmaAngle = options_.nearAngle * degree / 2;
  const auto forAll = [&](const auto& use) {
    for (std::size_t i = 0; i < images_.size(); ++i)
      if (images_[i])
        grid_.forStatesNear(*images_[i], 2 * sigma, 2 * sigmaAngle,
                            [&](std::size_t state) { use(i, state); });
  };
  firstNear_.assign(states() + 1, 0);
  forAll([&](std::size_t, std::size_t state) { ++firstNear_[state + 1]; });
  std::partial_sum(firstNear_.begin(), firstNear_.end(), firstNear_.begin());
  near_.resize(firstNear_.back());
  std::vector<std::size_t> filled(firstNear_.begin(), firstNear_.end() - 1);
  forAll([&](std::size_t i, std::size_t state) {
    const PlanarPose at = grid_.poseOf(state), &image = *images_[i];
    const double distance = std::hypot(at.x - image.x, at.y - image.y) / sigma;
    const double angle = wrapped(at.heading - image.heading) / sigmaAngle;
    const double weight = std::exp(-0.5 * (distance * distance + angle * angle));
    near_[filled[state]++] = {static_cast<std::uint32_t>(i), static_cast<float>(weight)};
  });
}

/// Breadth first over the grid from the images' own states; turning is free: the nearest by position.
void PoseFilter::findNearestImages() {
  constexpr std::uint32_t none = ~0U;
  nearest_.assign(states(), none);
  std::deque<std::size_t> reached;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    if (!images_[i]) continue;
    grid_.forStatesNear(*images_[i], grid_.cell(), PoseGrid::headingStep(), [&](std::size_t state) {
      if (nearest_[state] != none) return;
      nearest_[state] = static_cast<std::uint32_t>(i);
      reached.push_back(state);
    });
  }
  while (!reached.empty()) {
    const std::size_t from = reached.front();
    reached.pop_front();
    const auto claim = [&](std::size_t state) {
      if (state == states() || nearest_[state] != none) return false;
      nearest_[state] = nearest_[from];
      return true;
    };
    for (const std::size_t turned : {grid_.turned(from, 1), grid_.turned(from, -1)})
      if (claim(turned)) reached.push_front(turned);
    for (const std::size_t beside : {grid_.moved(from, 1, 0), grid_.moved(from, -1, 0),
                                     grid_.moved(from, 0, 1), grid_.moved(from, 0, -1)})
      if (claim(beside)) reached.push_back(beside);
  }
}

std::span<const PoseFilter::Near> PoseFilter::nearOf(std::size_t state) const {
  return {near_.data() + firstNear_[state], near_.data() + firstNear_[state + 1]};
}

bool PoseFilter::isStep(const PlanarMotion& motion) const {
  return motion.distance() + motion.looseDistance >= grid_.cell() / 2 ||
         std::abs(motion.turn) + motion.looseTurn >= PoseGrid::headingStep() / 2;
}

void PoseFilter::predict(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const {
  const double before = std::accumulate(in.begin(), in.end(), 0.0);
  // Probabilities below that of a jump are spread like a jump: most states of a large map, at no cost.
  const auto least = static_cast<float>(options_.anywhere * before / static_cast<double>(states()));
  std::vector<float> likely(in.begin(), in.end()), moved(states(), 0.0F);
  for (float& p : likely)
    if (p <= least) p = 0;
  grid_.move(likely, motion, moved);
  grid_.blur(moved, motion.looseDistance + odometryError * motion.distance(),
             motion.looseTurn + odometryError * std::abs(motion.turn));
  const double after = std::accumulate(moved.begin(), moved.end(), 0.0);
  // Probability that left the grid is spread likewise.
  const double anywhere = (before - (1 - options_.anywhere) * after) / static_cast<double>(states());
  for (std::size_t s = 0; s < states(); ++s)
    out[s] = static_cast<float>((1 - options_.anywhere) * moved[s] + anywhere);
}

void PoseFilter::backward(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const {
  const auto moved = [&](std::span<const float> values) {
    std::vector<float> blurred(values.begin(), values.end()), result(states(), 0.0F);
    grid_.blur(blurred, motion.looseDistance + odometryError * motion.distance(),
               motion.looseTurn + odometryError * std::abs(motion.turn));
    grid_.moveBackward(blurred, motion, result);
    return result;
  };
  const std::vector<float> ahead = moved(in), kept = moved(std::vector<float>(states(), 1.0F));
  const double mean = std::accumulate(in.begin(), in.end(), 0.0) / static_cast<double>(states());
  const double stays = 1 - options_.anywhere;
  for (std::size_t s = 0; s < states(); ++s)
    out[s] = static_cast<float>(stays * ahead[s] + (1 - stays * kept[s]) * mean);
}

std::vector<float> PoseFilter::likelihood(std::span<const float> distances) const {
  // Never 0: where a frame is like no image, the images are unlikely alike.
  constexpr double least = 1e-20;
  std::vector<float> ratios;
  for (const float distance : distances)
    ratios.push_back(
        static_cast<float>(std::max(std::pow(evidence_.ratio(distance), options_.temper), least)));
  return ratios;
}

void PoseFilter::observe(std::span<const float> likelihood, std::span<float> state) const {
  const double unmapped = std::pow(unmappedEvidence, options_.temper);
  double total = 0;
  for (std::size_t s = 0; s < state.size(); ++s) {
    double weighted = 0, weights = 0, largest = 0;
    for (const Near& near : nearOf(s)) {
      weighted += near.weight * likelihood[near.image];
      weights += near.weight;
      largest = std::max<double>(largest, near.weight);
    }
    double ratio = (1 - largest) * unmapped;
    if (weights > 0) ratio += largest * weighted / weights;
    state[s] *= static_cast<float>(ratio);
    total += state[s];
  }
  const auto scale = static_cast<float>(1 / total);  // never 0: `anywhere` keeps every state alive
  for (float& p : state) p *= scale;
}

Belief PoseFilter::belief(std::span<const float> state, std::span<const float> likelihood) const {
  Belief belief{std::vector<double>(images_.size(), 0.0), std::vector<double>(images_.size(), 0.0), 0.0, 0.0};
  for (std::size_t s = 0; s < state.size(); ++s) {
    if (isUnvisited_[s]) *belief.unvisited += state[s];
    double weights = 0, largest = 0;
    for (const Near& near : nearOf(s)) {
      weights += near.weight * likelihood[near.image];
      largest = std::max<double>(largest, near.weight);
    }
    const double far = state[s] * (1 - largest);
    *belief.unmapped += far;
    belief.nearest[nearest_[s]] += far;
    for (const Near& near : nearOf(s)) {
      const double share = state[s] * largest * near.weight * likelihood[near.image] / weights;
      belief.images[near.image] += share;
      belief.nearest[near.image] += share;
    }
  }
  return belief;
}

}  // namespace estancia
