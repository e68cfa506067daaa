// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/pose_grid.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

constexpr std::size_t maxStates = 1'000'000;

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
        if (states() > maxStates) return false;
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
