// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/neuron_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/cloud/bounds.hpp"

namespace estancia {
namespace {

constexpr std::uint32_t firstCapacity = 20;
constexpr int maxInRow = 512;  // cells
/// Bounds of the rounding error of a length in [-1, 1]: absolute, and relative to a squared length.
constexpr float rounding = 2e-6F, squaredRounding = 1.00001F;

/// std::popcount without a call where the instruction is not part of the base architecture.
std::uint32_t ones(std::uint64_t v) {
  v -= v >> 1 & 0x5555555555555555;
  v = (v & 0x3333333333333333) + (v >> 2 & 0x3333333333333333);
  return static_cast<std::uint32_t>(((v + (v >> 4)) & 0x0f0f0f0f0f0f0f0f) * 0x0101010101010101 >> 56);
}

// Measured on scenes of depth cameras; no result depends on them.
constexpr double edgeOfRms = 2.5;  ///< edge of a fine cell / distance of the neurons to the points
constexpr double coarser = 4;      ///< edge of a coarse cell / edge of a fine one
constexpr double fineReach = 1.75, coarseReach = 2;  ///< at most, in edges of their cells
constexpr float spareReach = 1.3F;                   ///< beyond the present need of a cell
constexpr std::size_t every = 4;  ///< one of this many points determines the reach of its cell
constexpr double toleranceOfEdge = 0.3;
constexpr float homing = 0.3F;  ///< share of the way back: a neuron that moves far mostly returns

}  // namespace

int CandidateGrid::coordinate(float v, int axis) const {
  return std::clamp(static_cast<int>((v - low_[axis]) * inverse_), 0, sides_[axis] - 1);
}

std::uint32_t CandidateGrid::rank(std::size_t row, int x) const {
  const Word& w = words_[row + static_cast<std::size_t>(x >> 6)];
  return w.before + ones(w.cells & ((1ULL << (x & 63)) - 1));
}

/// Whether a cell must list a neuron whose home is at this distance.
bool CandidateGrid::lists(const List& list, float squaredDistance) const {
  const float within = list.reach + tolerance_ + rounding;
  return squaredDistance <= within * within * squaredRounding;
}

void CandidateGrid::build(const std::vector<Point4>& points, double edge, double reach, double tolerance) {
  Bounds<float> box;
  for (const Point4& p : points) box.add({p.x, p.y, p.z});
  low_ = {box.low.x, box.low.y, box.low.z};
  const std::array<float, 3> high{box.high.x, box.high.y, box.high.z};
  edge_ = static_cast<float>(edge);
  inverse_ = 1 / edge_;
  for (std::size_t k = 0; k < 3; ++k) sides_[k] = static_cast<int>((high[k] - low_[k]) * inverse_) + 1;
  wordsInRow_ = static_cast<std::size_t>(sides_[0] + 63) / 64;
  words_.assign(wordsInRow_ * sides_[1] * sides_[2], {});
  for (const Point4& p : points) {
    const int x = coordinate(p.x, 0);
    words_[word(coordinate(p.y, 1), coordinate(p.z, 2)) + (x >> 6)].cells |= 1ULL << (x & 63);
  }
  std::uint32_t count = 0;
  for (int z = 0; z < sides_[2]; ++z)
    for (int y = 0; y < sides_[1]; ++y)
      for (std::size_t k = 0; k < wordsInRow_; ++k) {
        Word& w = words_[word(y, z) + k];
        w.before = count;
        count += ones(w.cells);
      }
  limit_ = static_cast<float>(reach) * edge_;
  tolerance_ = static_cast<float>(tolerance);
  maxReach_ = 0;
  lists_.resize(count);
  for (std::uint32_t c = 0; c < count; ++c) lists_[c] = {0, c * firstCapacity, 0, firstCapacity};
  pool_.assign(static_cast<std::size_t>(count) * firstCapacity, 0);
}

void CandidateGrid::demand(std::uint32_t cell, float reach) {
  float& current = lists_[cell].reach;
  current = std::max(current, std::min(reach, limit_));
  maxReach_ = std::max(maxReach_, current);
}

/// Squared distance of a home from a cell.
float CandidateGrid::squaredDistance(int x, int y, int z, const Neuron& n) const {
  const auto beyond = [this](int c, float v, int axis) {
    const float low = low_[axis] + static_cast<float>(c) * edge_;
    return std::max(std::max(low - v, v - (low + edge_)), 0.0F);
  };
  const float dx = beyond(x, n.homeX, 0), dy = beyond(y, n.homeY, 1), dz = beyond(z, n.homeZ, 2);
  return dx * dx + dy * dy + dz * dz;
}

/// All cells that may list a neuron with a home between these.
template <typename Visit>
void CandidateGrid::forCells(const Neuron& low, const Neuron& high, const Visit& visit) {
  const float around = (maxReach_ + tolerance_) * squaredRounding + 2 * rounding;
  const int x0 = coordinate(low.homeX - around, 0), x1 = coordinate(high.homeX + around, 0);
  const int y0 = coordinate(low.homeY - around, 1), y1 = coordinate(high.homeY + around, 1);
  const int z0 = coordinate(low.homeZ - around, 2), z1 = coordinate(high.homeZ + around, 2);
  for (int z = z0; z <= z1; ++z)
    for (int y = y0; y <= y1; ++y)
      for (int k = x0 >> 6; k <= x1 >> 6; ++k) {
        const Word& w = words_[word(y, z) + static_cast<std::size_t>(k)];
        std::uint64_t bits = w.cells;
        if (k == x0 >> 6) bits &= ~0ULL << (x0 & 63);
        if (k == x1 >> 6) bits &= ~0ULL >> (63 - (x1 & 63));
        if (bits == 0) continue;
        std::uint32_t cell = w.before + ones(w.cells & ((bits & -bits) - 1));
        for (; bits != 0; bits &= bits - 1) visit(lists_[cell++], k * 64 + std::countr_zero(bits), y, z);
      }
}

void CandidateGrid::push(List& list, std::uint32_t i) {
  if (list.count == list.capacity) {  // its old memory stays unused until the next build
    const auto offset = static_cast<std::uint32_t>(pool_.size());
    list.capacity += list.capacity / 2;
    pool_.resize(pool_.size() + list.capacity);
    std::copy_n(&pool_[list.offset], list.count, &pool_[offset]);
    list.offset = offset;
  }
  pool_[list.offset + list.count++] = i;
}

void CandidateGrid::pull(List& list, std::uint32_t i) {
  std::uint32_t* members = &pool_[list.offset];
  *std::find(members, members + list.count, i) = members[list.count - 1];
  --list.count;
}

void CandidateGrid::insert(std::uint32_t i, const Neuron& n) {
  forCells(n, n, [&](List& list, int x, int y, int z) {
    if (lists(list, squaredDistance(x, y, z, n))) push(list, i);
  });
}

void CandidateGrid::erase(std::uint32_t i, const Neuron& n) {
  forCells(n, n, [&](List& list, int x, int y, int z) {
    if (lists(list, squaredDistance(x, y, z, n))) pull(list, i);
  });
}

void CandidateGrid::move(std::uint32_t i, const Neuron& from, const Neuron& to) {
  Neuron low = from, high = from;
  low.homeX = std::min(from.homeX, to.homeX);
  low.homeY = std::min(from.homeY, to.homeY);
  low.homeZ = std::min(from.homeZ, to.homeZ);
  high.homeX = std::max(from.homeX, to.homeX);
  high.homeY = std::max(from.homeY, to.homeY);
  high.homeZ = std::max(from.homeZ, to.homeZ);
  forCells(low, high, [&](List& list, int x, int y, int z) {
    const bool before = lists(list, squaredDistance(x, y, z, from));
    const bool after = lists(list, squaredDistance(x, y, z, to));
    if (before && !after) pull(list, i);
    if (after && !before) push(list, i);
  });
}

void CandidateGrid::rename(std::uint32_t from, std::uint32_t to, const Neuron& n) {
  forCells(n, n, [&](List& list, int x, int y, int z) {
    if (!lists(list, squaredDistance(x, y, z, n))) return;
    std::uint32_t* members = &pool_[list.offset];
    *std::find(members, members + list.count, from) = to;
  });
}

NeuronGrid::NeuronGrid(const std::vector<Point4>& points, const Colors& pointColors)
    : points_(points), pointColors_(pointColors) {}

void NeuronGrid::fit(std::vector<Neuron>& neurons, const Colors& colors, double rms) {
  CandidateGrid fine;
  const double edge = std::max(edgeOfRms * rms, 2.0 / (maxInRow - 1));
  tolerance_ = static_cast<float>(toleranceOfEdge * edge);
  const double maxFromHome = std::sqrt(3.0) * tolerance_;
  fine.build(points_, edge, fineReach, maxFromHome);
  // A cell must reach the second nearest neurons of its points, which the present grid finds.
  std::vector<std::uint32_t> cells(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const std::uint32_t cell = cells[k] = fine.cellOf(points_[k]);
    if (k % every == 0 || fine.list(cell).reach == 0)
      fine.demand(cell, fitted_
                            ? spareReach * std::sqrt(nearestTwo(k, neurons, colors).squaredDistanceOfSecond())
                            : std::numeric_limits<float>::max());
  }
  for (std::size_t k = 0; k < points_.size(); ++k) points_[k].w = std::bit_cast<float>(cells[k]);
  fine_ = std::move(fine);
  coarse_.build(points_, coarser * edge, coarseReach, maxFromHome);
  for (std::uint32_t cell = 0; cell < coarse_.cells(); ++cell)
    coarse_.demand(cell, std::numeric_limits<float>::max());
  for (std::uint32_t i = 0; i < neurons.size(); ++i) insert(i, neurons);
  fitted_ = true;
}

void NeuronGrid::insert(std::uint32_t i, std::vector<Neuron>& neurons) {
  Neuron& n = neurons[i];
  n.homeX = n.x;
  n.homeY = n.y;
  n.homeZ = n.z;
  fine_.insert(i, n);
  coarse_.insert(i, n);
}

void NeuronGrid::erase(std::uint32_t i, const std::vector<Neuron>& neurons) {
  fine_.erase(i, neurons[i]);
  coarse_.erase(i, neurons[i]);
}

void NeuronGrid::rename(std::uint32_t from, std::uint32_t to, const std::vector<Neuron>& neurons) {
  fine_.rename(from, to, neurons[from]);
  coarse_.rename(from, to, neurons[from]);
}

void NeuronGrid::rehome(std::uint32_t i, std::vector<Neuron>& neurons) {
  Neuron& n = neurons[i];
  const Neuron before = n;
  n.homeX = n.x + homing * (before.homeX - n.x);
  n.homeY = n.y + homing * (before.homeY - n.y);
  n.homeZ = n.z + homing * (before.homeZ - n.z);
  fine_.move(i, before, n);
  coarse_.move(i, before, n);
}

NearestTwo NeuronGrid::furtherOut(std::size_t k, const std::vector<Neuron>& neurons,
                                  const Colors& colors) const {
  const Point4& p = points_[k];
  const bool colored = !pointColors_.empty();
  const CandidateGrid::List& list = coarse_.list(coarse_.cellOf(p));
  const std::uint32_t* members = coarse_.members(list);
  const NearestTwo two =
      colored ? nearestAmong(p, pointColors_[k], members, list.count, neurons.data(), colors.data())
              : nearestAmong(p, members, list.count, neurons.data());
  if (two.squaredDistanceOfSecond() <= list.reach * list.reach) return two;
  NearestTwo all;
  for (std::uint32_t i = 0; i < neurons.size(); ++i) {
    const float apart = squaredDistance(p, neurons[i].at());
    all.look(colored ? apart + squaredDistance(pointColors_[k], colors[i]) : apart, i);
  }
  return all;
}

}  // namespace estancia
