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

/// Columns and rows have less than 32 bits: poses are within 10 000 km, cells not below 1 cm.
std::int64_t keyOf(std::int64_t column, std::int64_t row) {
  return row * (std::int64_t{1} << 32) + column;
}

int wrappedHeading(std::int64_t heading) {
  const auto h = static_cast<int>(heading % PoseGrid::headings);
  return h < 0 ? h + PoseGrid::headings : h;
}

/// Gaussian weights of the steps −r … r, r at 3 σ; a single 1 for a σ that does not reach the next cell.
std::vector<float> kernelOf(double sigma) {
  constexpr double smallest = 0.3;  // cells; the next one would get less than 1 %
  if (!(sigma > smallest)) return {1};
  const int r = static_cast<int>(std::ceil(3 * std::min(sigma, 100.0)));
  std::vector<float> kernel;
  double total = 0;
  for (int i = -r; i <= r; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
    total += kernel.back();
  }
  for (float& weight : kernel) weight /= static_cast<float>(total);
  return kernel;
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

PoseGrid::PoseGrid(std::span<const PlanarPose> mapped, double cell, double reach) : cell_(cell) {
  while (!layOut(mapped, reach)) cell_ *= 1.5;
}

bool PoseGrid::layOut(std::span<const PlanarPose> mapped, double reach) {
  cellOf_.clear();
  columns_.clear();
  rows_.clear();
  const auto steps = static_cast<std::int64_t>(reach / cell_) + 1;
  for (const PlanarPose& pose : mapped) {
    const std::int64_t column = indexOf(pose.x), row = indexOf(pose.y);
    for (std::int64_t r = row - steps; r <= row + steps; ++r)
      for (std::int64_t c = column - steps; c <= column + steps; ++c) {
        if (std::hypot(middleOf(c) - pose.x, middleOf(r) - pose.y) > std::max(reach, cell_)) continue;
        if (!cellOf_.try_emplace(keyOf(c, r), static_cast<std::int32_t>(cells())).second) continue;
        columns_.push_back(static_cast<std::int32_t>(c));
        rows_.push_back(static_cast<std::int32_t>(r));
        if (states() > 1'000'000) return false;
      }
  }
  return true;
}

std::int64_t PoseGrid::indexOf(double coordinate) const {
  return static_cast<std::int64_t>(std::floor(coordinate / cell_));
}

std::int32_t PoseGrid::cellAt(std::int64_t column, std::int64_t row) const {
  const auto found = cellOf_.find(keyOf(column, row));
  return found == cellOf_.end() ? -1 : found->second;
}

PlanarPose PoseGrid::poseOf(std::size_t state) const {
  const std::size_t cell = state % cells();
  return {middleOf(columns_[cell]), middleOf(rows_[cell]),
          (static_cast<double>(state / cells()) + 0.5) * headingStep()};
}

void PoseGrid::forStatesNear(const PlanarPose& pose, double distance, double angle,
                             const std::function<void(std::size_t)>& use) const {
  const auto steps = static_cast<std::int64_t>(distance / cell_) + 1;
  const std::int64_t column = indexOf(pose.x), row = indexOf(pose.y);
  for (std::int64_t r = row - steps; r <= row + steps; ++r)
    for (std::int64_t c = column - steps; c <= column + steps; ++c) {
      const std::int32_t cell = cellAt(c, r);
      if (cell < 0) continue;
      const PlanarPose middle = poseOf(static_cast<std::size_t>(cell));
      if (std::hypot(middle.x - pose.x, middle.y - pose.y) > distance) continue;
      for (std::size_t h = 0; h < headings; ++h) {
        const double heading = (static_cast<double>(h) + 0.5) * headingStep();
        if (std::abs(wrapped(heading - pose.heading)) <= angle)
          use(h * cells() + static_cast<std::size_t>(cell));
      }
    }
}

std::size_t PoseGrid::moved(std::size_t state, std::int64_t columns, std::int64_t rows) const {
  const std::size_t cell = state % cells();
  const std::int32_t to = cellAt(columns_[cell] + columns, rows_[cell] + rows);
  return to < 0 ? states() : state - cell + static_cast<std::size_t>(to);
}

std::size_t PoseGrid::turned(std::size_t state, std::int64_t steps) const {
  const auto heading = wrappedHeading(static_cast<std::int64_t>(state / cells()) + steps);
  return static_cast<std::size_t>(heading) * cells() + state % cells();
}

/// `use(from, to, weight)`, with trilinear weights, for moves within the grid of states with `moves(from)`.
template <typename Moves, typename Use>
void PoseGrid::forEachMove(const PlanarMotion& motion, const Moves& moves, const Use& use) const {
  const double turn = motion.turn / headingStep();
  const double turnFloor = std::floor(turn);
  for (int h = 0; h < headings; ++h) {
    const double heading = (h + 0.5) * headingStep();
    const double c = std::cos(heading), s = std::sin(heading);
    const double dx = (c * motion.forward - s * motion.left) / cell_;
    const double dy = (s * motion.forward + c * motion.left) / cell_;
    const double dxFloor = std::floor(dx), dyFloor = std::floor(dy);
    for (int corner = 0; corner < 8; ++corner) {
      const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
      const auto share = [](double part, int upper) { return upper == 1 ? part : 1 - part; };
      const auto weight =
          static_cast<float>(share(dx - dxFloor, i) * share(dy - dyFloor, j) * share(turn - turnFloor, k));
      if (weight <= 0) continue;
      const auto toHeading =
          static_cast<std::size_t>(wrappedHeading(h + static_cast<std::int64_t>(turnFloor) + k));
      for (std::size_t cell = 0; cell < cells(); ++cell) {
        const std::size_t from = static_cast<std::size_t>(h) * cells() + cell;
        if (!moves(from)) continue;
        const std::int32_t to = cellAt(columns_[cell] + static_cast<std::int64_t>(dxFloor) + i,
                                       rows_[cell] + static_cast<std::int64_t>(dyFloor) + j);
        if (to >= 0) use(from, toHeading * cells() + static_cast<std::size_t>(to), weight);
      }
    }
  }
}

void PoseGrid::move(std::span<const float> in, const PlanarMotion& motion, std::span<float> out) const {
  forEachMove(
      motion, [&](std::size_t from) { return in[from] != 0; },
      [&](std::size_t from, std::size_t to, float weight) { out[to] += weight * in[from]; });
}

void PoseGrid::moveBackward(std::span<const float> in, const PlanarMotion& motion,
                            std::span<float> out) const {
  forEachMove(
      motion, [](std::size_t) { return true; },
      [&](std::size_t from, std::size_t to, float weight) { out[from] += weight * in[to]; });
}

void PoseGrid::blur(std::vector<float>& values, double distance, double angle) const {
  const std::vector<float> place = kernelOf(distance / cell_), turn = kernelOf(angle / headingStep());
  std::vector<float> blurred(values.size());
  const auto along = [&](const std::vector<float>& kernel, auto neighborAt) {
    if (kernel.size() == 1) return;
    const auto r = static_cast<std::int64_t>(kernel.size() / 2);
    std::fill(blurred.begin(), blurred.end(), 0.0F);
    for (std::size_t state = 0; state < values.size(); ++state) {
      if (values[state] == 0) continue;
      for (std::int64_t step = -r; step <= r; ++step)
        if (const std::size_t to = neighborAt(state, step); to < values.size())
          blurred[to] += kernel[static_cast<std::size_t>(step + r)] * values[state];
    }
    std::swap(values, blurred);
  };
  along(place, [&](std::size_t state, std::int64_t step) { return moved(state, step, 0); });
  along(place, [&](std::size_t state, std::int64_t step) { return moved(state, 0, step); });
  along(turn, [&](std::size_t state, std::int64_t step) { return turned(state, step); });
}

}  // namespace estancia
