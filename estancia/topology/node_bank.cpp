// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/node_bank.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/stats/compared_vectors.hpp"

namespace estancia {

void NodeMemory::merge(const NodeMemory& other) {
  frames += other.frames;
  probabilities.merge(other.probabilities);
  if (embedded) embedded->merge(*other.embedded);
  setNextMergeCheck();
}

void NodeMemory::setNextMergeCheck() {
  nextMergeCheck = frames + std::max<std::uint64_t>(1, frames / 4);
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
  rows_.resize(nodes_.size() * labels_);
  if (distance_.sigmaWeighted) weights_.resize(rows_.size());
  squaredNorms_.resize(nodes_.size());
  refresh(slot);
  return slot;
}

void NodeBank::remove(std::size_t slot) {
  const std::size_t last = nodes_.size() - 1;
  slots_.erase(nodes_[slot].id);
  if (slot != last) {
    nodes_[slot] = std::move(nodes_[last]);
    slots_[nodes_[slot].id] = slot;
    squaredNorms_[slot] = squaredNorms_[last];
    for (std::vector<float>* matrix : {&rows_, &weights_})
      if (!matrix->empty())
        std::copy_n(matrix->begin() + static_cast<std::ptrdiff_t>(last * labels_), labels_,
                    matrix->begin() + static_cast<std::ptrdiff_t>(slot * labels_));
  }
  nodes_.pop_back();
  rows_.resize(nodes_.size() * labels_);
  if (distance_.sigmaWeighted) weights_.resize(rows_.size());
  squaredNorms_.pop_back();
  if (byDotProduct_) bounds_.remove(slot);
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
  const NodeMemory& node = nodes_[slot];
  const std::vector<float> vector = compared(node.moments().mean());
  std::copy(vector.begin(), vector.end(), rows_.begin() + static_cast<std::ptrdiff_t>(slot * labels_));
  squaredNorms_[slot] = dot(vector, vector);
  if (byDotProduct_) bounds_.set(slot, vector);
  if (!distance_.sigmaWeighted) return;
  const std::span<const float> variance = node.moments().variance();
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

double NodeBank::distance(std::size_t slot, std::span<const float> compared) const {
  if (byDotProduct_ && distance_.comparison == Comparison::cosine)  // both are unit vectors
    return std::clamp(1.0 - dot(row(slot), compared), 0.0, 2.0);
  return compare(distance_.comparison, row(slot), compared, weights(slot));
}

std::optional<NodeBank::Nearest> NodeBank::nearest(std::span<const float> compared, std::size_t except,
                                                   std::uint64_t minFrames) const {
  const auto allowed = [&](std::size_t slot) { return slot != except && nodes_[slot].frames >= minFrames; };
  std::optional<Nearest> best;
  const auto consider = [&](std::size_t slot) {
    const double d = distance(slot, compared);
    if (!best || d < best->distance || (d == best->distance && slot < best->slot)) best = Nearest{slot, d};
  };
  if (!byDotProduct_) {
    for (std::size_t slot = 0; slot < nodes_.size(); ++slot)
      if (allowed(slot)) consider(slot);
    return best;
  }
  std::vector<float> lower(nodes_.size());
  bounds_.upperBounds(compared, lower);
  const double comparedNorm = dot(compared, compared);
  std::size_t first = nodes_.size();
  for (std::size_t slot = 0; slot < nodes_.size(); ++slot) {
    lower[slot] =
        distance_.comparison == Comparison::cosine
            ? 1 - lower[slot]
            : std::sqrt(static_cast<float>(std::max(
                  0.0, squaredNorms_[slot] + comparedNorm - 2.0 * lower[slot] - 1e-5 * comparedNorm)));
    if (allowed(slot) && (first == nodes_.size() || lower[slot] < lower[first])) first = slot;
  }
  if (first == nodes_.size()) return std::nullopt;
  consider(first);
  for (std::size_t slot = 0; slot < nodes_.size(); ++slot)
    if (slot != first && lower[slot] <= best->distance && allowed(slot)) consider(slot);
  return best;
}

}  // namespace estancia
