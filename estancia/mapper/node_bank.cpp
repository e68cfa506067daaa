// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_bank.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia {
namespace {

Moments meanOf(const Moments& moments) {
  Moments mean(moments.mean().size(), false);
  mean.merge(moments);
  return mean;
}

}  // namespace

std::vector<const Moments*> NodeMemory::looks() const {
  std::vector<const Moments*> looks{&moments()};
  for (const Moments& mode : modes) looks.push_back(&mode);
  return looks;
}

void NodeMemory::merge(const NodeMemory& other) {
  if (!modes.empty() || !other.modes.empty()) {
    const std::vector<Moments> its = other.modesOfEarlierDrives();
    modes = modesOfEarlierDrives();
    modes.insert(modes.end(), its.begin(), its.end());
  }
  if (!own)
    own = other.own;
  else if (other.own)
    own->merge(*other.own);
  frames += other.frames;
  border = {};
  probabilities.merge(other.probabilities);
  if (embedded) embedded->merge(*other.embedded);
  setNextMergeCheck();
}

void NodeMemory::mergeOfOtherDrives(const NodeMemory& other) {
  NodeMemory its = other;
  for (NodeMemory* node : {this, &its}) {
    node->modes = node->modesOfEarlierDrives();
    if (node->own) node->modes.push_back(std::move(*node->own));
    node->own.reset();
  }
  merge(its);
}

std::vector<Moments> NodeMemory::modesOfEarlierDrives() const {
  if (!modes.empty()) return modes;
  Moments before = meanOf(moments());
  if (own) before.remove(*own);
  return before.weight() > 0 ? std::vector<Moments>{std::move(before)} : std::vector<Moments>();
}

void NodeMemory::endDrive(double threshold, std::uint64_t fewest, const Distance& distance) {
  if (own) {
    modes = modesOfEarlierDrives();
    modes.push_back(std::move(*own));
    own.reset();
  }
  joinModes(threshold, fewest, distance);
  if (modes.size() == 1) modes.clear();  // the mean of all frames is the same
}

void NodeMemory::joinModes(double threshold, std::uint64_t fewest, const Distance& distance) {
  while (modes.size() > 1) {
    std::size_t kept = 0, gone = 1;
    // The means of few frames are joined first.
    std::pair nearest(true, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < modes.size(); ++i)
      for (std::size_t j = i + 1; j < modes.size(); ++j) {
        const bool areMany = std::min(modes[i].weight(), modes[j].weight()) >= static_cast<double>(fewest);
        const std::pair found(areMany, distance(modes[i], modes[j]));
        if (found < nearest) nearest = found, kept = i, gone = j;
      }
    if (nearest.first && nearest.second >= threshold && modes.size() <= maxModes) return;
    modes[kept].merge(modes[gone]);
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(gone));
  }
}

NodeBank::NodeBank(Distance distance, std::size_t labels)
    : distance_(std::move(distance)),
      labels_(labels),
      byDotProduct_(
          !distance_.sigmaWeighted && labels <= QuantizedUpperBounds::maxLength &&
          (distance_.comparison == Comparison::cosine || distance_.comparison == Comparison::euclidean)),
      bounds_(labels) {}

NodeMemory NodeBank::makeNode(int id) const {
  NodeMemory node{id, 0, 0, Moments(labels_, true), std::nullopt};
  if (distance_.embedding != Embedding::identity) node.embedded = Moments(labels_, distance_.sigmaWeighted);
  return node;
}

std::size_t NodeBank::add(NodeMemory node) {
  const std::size_t slot = nodes_.size();
  slots_[node.id] = slot;
  nodes_.push_back(std::move(node));
  rowsOf_.emplace_back();
  if (distance_.sigmaWeighted) weights_.resize(nodes_.size() * labels_);
  refresh(slot);
  return slot;
}

void NodeBank::remove(std::size_t slot) {
  const std::size_t last = nodes_.size() - 1;
  slots_.erase(nodes_[slot].id);
  setRowCount(slot, 0);
  if (slot != last) {
    nodes_[slot] = std::move(nodes_[last]);
    slots_[nodes_[slot].id] = slot;
    rowsOf_[slot] = std::move(rowsOf_[last]);
    for (const std::size_t row : rowsOf_[slot]) slotOfRow_[row] = slot;
    if (distance_.sigmaWeighted) std::ranges::copy(weights(last), weights_.data() + slot * labels_);
  }
  nodes_.pop_back();
  rowsOf_.pop_back();
  if (distance_.sigmaWeighted) weights_.resize(nodes_.size() * labels_);
}

/// Appends rows, or removes some, whose places the last ones take.
void NodeBank::setRowCount(std::size_t slot, std::size_t count) {
  std::vector<std::size_t>& own = rowsOf_[slot];
  for (; own.size() < count; slotOfRow_.push_back(slot)) own.push_back(slotOfRow_.size());
  for (; own.size() > count; slotOfRow_.pop_back()) {
    const std::size_t gone = own.back(), last = slotOfRow_.size() - 1;
    own.pop_back();
    if (byDotProduct_) bounds_.remove(gone);
    if (gone == last) continue;
    std::ranges::copy(row(last), rows_.data() + gone * labels_);
    squaredNorms_[gone] = squaredNorms_[last];
    slotOfRow_[gone] = slotOfRow_[last];
    std::ranges::replace(rowsOf_[slotOfRow_[gone]], last, gone);
  }
  rows_.resize(slotOfRow_.size() * labels_);
  squaredNorms_.resize(slotOfRow_.size());
}

NodeMemory::Distance NodeBank::distanceOfModes() const {
  return [this](const Moments& a, const Moments& b) {
    return compare(distance_.comparison, compared(a.mean()), compared(b.mean()));
  };
}

void NodeBank::joinModes(std::size_t slot, double threshold, std::uint64_t fewest) {
  if (nodes_[slot].modes.empty()) return;
  nodes_[slot].joinModes(threshold, fewest, distanceOfModes());
  refresh(slot);
}

std::vector<int> NodeBank::endDrive(double threshold, std::uint64_t fewest) {
  const NodeMemory::Distance distance = distanceOfModes();
  std::vector<int> changed;
  for (std::size_t slot = 0; slot < nodes_.size(); ++slot) {
    NodeMemory& node = nodes_[slot];
    if (node.modes.empty() && !node.own) continue;
    node.endDrive(threshold, fewest, distance);
    refresh(slot);
    changed.push_back(node.id);
  }
  return changed;
}

std::vector<int> NodeBank::forgetModes() {
  std::vector<int> changed;
  for (std::size_t slot = 0; slot < nodes_.size(); ++slot) {
    NodeMemory& node = nodes_[slot];
    if (node.modes.empty()) continue;
    node.modes.clear();  // what this drive has seen, own, is a part of the mean, too
    refresh(slot);
    changed.push_back(node.id);
  }
  return changed;
}

std::size_t NodeBank::slotOf(int id) const {
  const auto found = slots_.find(id);
  if (found == slots_.end())
    fail(ErrorCode::corruptFile, "the mapper state lacks node {}; map the sequence again", id);
  return found->second;
}

std::span<const float> NodeBank::weights(std::size_t slot) const {
  if (!distance_.sigmaWeighted) return {};
  return {weights_.data() + slot * labels_, labels_};
}

void NodeBank::setStandardization(Standardization standardization) {
  standardization_ = std::move(standardization);
  for (std::size_t slot = 0; slot < nodes_.size(); ++slot) refresh(slot);
}

std::vector<float> NodeBank::compared(std::span<const float> embedded) const {
  return comparedVector(distance_, standardization_, embedded);
}

void NodeBank::refresh(std::size_t slot) {
  const std::vector<const Moments*> looks = nodes_[slot].looks();
  setRowCount(slot, looks.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::size_t row = rowsOf_[slot][i];
    const std::vector<float> vector = compared(looks[i]->mean());
    std::ranges::copy(vector, rows_.data() + row * labels_);
    squaredNorms_[row] = dot(vector, vector);
    if (byDotProduct_) bounds_.set(row, vector);
  }
  if (distance_.sigmaWeighted) setWeights(slot);
}

void NodeBank::setWeights(std::size_t slot) {
  const std::span<const float> variance = nodes_[slot].moments().variance();
  float* weight = weights_.data() + slot * labels_;
  for (std::size_t i = 0; i < labels_; ++i) {
    // A probability's σ is at most ½, summed up or centered, too, so 1 − 2σ lies in [0, 1] (thesis 4.3.2);
    // log-ratios have no such bound.
    if (distance_.embedding != Embedding::centeredLogRatio) {
      weight[i] = std::max(0.0F, 1 - 2 * std::sqrt(variance[i]));
    } else {
      const float own = standardization_.weight.empty() ? 1.0F : standardization_.weight[i];
      weight[i] = 1 / (1 + variance[i] * own * own);
    }
  }
}

double NodeBank::rowDistance(std::size_t number, std::span<const float> compared) const {
  if (byDotProduct_ && distance_.comparison == Comparison::cosine)  // both are unit vectors
    return std::clamp(1.0 - dot(row(number), compared), 0.0, 2.0);
  return compare(distance_.comparison, row(number), compared, weights(slotOfRow_[number]));
}

double NodeBank::distance(std::size_t slot, std::span<const float> compared) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::size_t row : rowsOf_[slot]) nearest = std::min(nearest, rowDistance(row, compared));
  return nearest;
}

std::optional<NodeBank::Nearest> NodeBank::nearest(std::span<const float> compared, std::size_t except,
                                                   std::uint64_t minFrames) const {
  const auto allowed = [&](std::size_t row) {
    const std::size_t slot = slotOfRow_[row];
    return slot != except && nodes_[slot].frames >= minFrames;
  };
  std::optional<Nearest> best;
  const auto consider = [&](std::size_t row) {
    const std::size_t slot = slotOfRow_[row];
    const double d = rowDistance(row, compared);
    if (!best || d < best->distance || (d == best->distance && slot < best->slot)) best = Nearest{slot, d};
  };
  if (!byDotProduct_) {
    for (std::size_t row = 0; row < rows(); ++row)
      if (allowed(row)) consider(row);
    return best;
  }
  std::vector<float> lower(rows());
  bounds_.upperBounds(compared, lower);
  const double comparedNorm = dot(compared, compared);
  std::size_t first = rows();
  for (std::size_t row = 0; row < rows(); ++row) {
    lower[row] = distance_.comparison == Comparison::cosine
                     ? 1 - lower[row]
                     : std::sqrt(static_cast<float>(std::max(
                           0.0, squaredNorms_[row] + comparedNorm - 2.0 * lower[row] - 1e-5 * comparedNorm)));
    if (allowed(row) && (first == rows() || lower[row] < lower[first])) first = row;
  }
  if (first == rows()) return std::nullopt;
  consider(first);
  for (std::size_t row = 0; row < rows(); ++row)
    if (row != first && lower[row] <= best->distance && allowed(row)) consider(row);
  return best;
}

}  // namespace estancia
