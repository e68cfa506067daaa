#include "estancia/cloud/neuron_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace estancia {
namespace {

// Measured on scenes of depth cameras; no result depends on them.
constexpr double edgeOfRms = 2.5;  ///< edge of a fine cell / distance of the neurons to the points
constexpr double coarser = 4;      ///< edge of a coarse cell / edge of a fine one
constexpr double fineReach = 1.75, coarseReach = 2;  ///< at most, in edges of their cells
constexpr float spareReach = 1.3F;                   ///< beyond the present need of a cell
constexpr std::size_t every = 4;  ///< one of this many points determines the reach of its cell
constexpr double toleranceOfEdge = 0.3;
constexpr float homing = 0.3F;  ///< share of the way back: a neuron that moves far mostly returns

}  // namespace

NeuronGrid::NeuronGrid(const std::vector<Point4>& points) : points_(points), cells_(points.size()) {}

void NeuronGrid::fit(std::vector<Neuron>& neurons, double rms) {
  CandidateGrid fine;
  const double edge = CandidateGrid::feasible(edgeOfRms * rms);
  tolerance_ = static_cast<float>(toleranceOfEdge * edge);
  const double maxFromHome = std::sqrt(3.0) * tolerance_;
  fine.build(points_, edge, fineReach, maxFromHome);
  // A cell must reach the second nearest neurons of its points, which the present grid finds.
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const std::uint32_t cell = fine.cellOf(points_[k]);
    cells_[k] = cell;
    if (k % every == 0 || fine.list(cell).reach == 0)
      fine.demand(cell, fitted_ ? spareReach * std::sqrt(nearestTwo(k, neurons).squaredDistanceOfSecond())
                                : std::numeric_limits<float>::max());
  }
  for (std::size_t k = 0; k < points_.size(); ++k) points_[k].w = std::bit_cast<float>(cells_[k]);
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

NearestTwo NeuronGrid::furtherOut(const Point4& p, const std::vector<Neuron>& neurons) const {
  const CandidateGrid::List& list = coarse_.list(coarse_.cellOf(p));
  const NearestTwo two = nearestAmong(p, coarse_.members(list), list.count, neurons.data());
  if (two.squaredDistanceOfSecond() <= list.reach * list.reach) return two;
  NearestTwo all;
  for (std::uint32_t i = 0; i < neurons.size(); ++i) all.look(squaredDistance(p, neurons[i].at()), i);
  return all;
}

}  // namespace estancia
