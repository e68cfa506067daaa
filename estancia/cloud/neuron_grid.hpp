// Neuron grid: exact search for the two neurons nearest to a point.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/cloud/candidate_grid.hpp"
#include "estancia/cloud/nearest_two.hpp"
#include "estancia/cloud/neuron.hpp"

namespace estancia {

/// A fine grid answers nearly all queries; where neurons are sparser than the reach of its cells, a coarse
/// grid does, and finally a search of all neurons.
class NeuronGrid {
 public:
  /// The points of all later queries.
  explicit NeuronGrid(const std::vector<Point4>& points);

  /// Fits the cells to neurons whose distance to the points has this root mean square.
  void fit(std::vector<Neuron>& neurons, double rms);
  void insert(std::uint32_t i, std::vector<Neuron>& neurons);
  void erase(std::uint32_t i, const std::vector<Neuron>& neurons);
  /// The neuron gets the number `to`.
  void rename(std::uint32_t from, std::uint32_t to, const std::vector<Neuron>& neurons);
  /// Largest distance of a neuron from its home along each axis.
  float tolerance() const { return tolerance_; }
  /// After neuron i moved further than that.
  void rehome(std::uint32_t i, std::vector<Neuron>& neurons);

  const Point4& point(std::size_t k) const { return points_[k]; }
  /// The two neurons nearest to point k.
  NearestTwo nearestTwo(std::size_t k, const std::vector<Neuron>& neurons) const {
    const Point4& p = points_[k];
    const CandidateGrid::List& list = fine_.list(std::bit_cast<std::uint32_t>(p.w));
    const NearestTwo two = nearestAmong(p, fine_.members(list), list.count, neurons.data());
    return two.squaredDistanceOfSecond() <= list.reach * list.reach ? two : furtherOut(p, neurons);
  }
  /// Prefetching for nearestTwo(), step by step.
  void prefetchPoint(std::size_t k) const { __builtin_prefetch(&points_[k]); }
  void prefetchCell(std::size_t k) const {
    __builtin_prefetch(&fine_.list(std::bit_cast<std::uint32_t>(points_[k].w)));
  }
  void prefetchList(std::size_t k) const {
    const CandidateGrid::List& list = fine_.list(std::bit_cast<std::uint32_t>(points_[k].w));
    const std::uint32_t* members = fine_.members(list);
    __builtin_prefetch(members);
    __builtin_prefetch(members + 16);
  }

 private:
  NearestTwo furtherOut(const Point4& p, const std::vector<Neuron>& neurons) const;

  CandidateGrid fine_, coarse_;
  std::vector<Point4> points_;  ///< w is their cell in the fine grid
  std::vector<std::uint32_t> cells_;
  float tolerance_ = 0;
  bool fitted_ = false;
};

}  // namespace estancia
