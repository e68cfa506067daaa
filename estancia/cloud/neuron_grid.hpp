// Neuron grid: exact search for the two neurons nearest to a point.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/cloud/nearest_two.hpp"

namespace estancia {

/// A cell lists all neurons whose home is within its reach plus a tolerance; neurons stay within that
/// tolerance of their homes. So no other neuron is within the reach of any point of the cell: two listed
/// neurons that are nearer are the nearest two. (Verlet lists of molecular dynamics: L. Verlet, Phys. Rev.
/// 159, 1967.) Only cells with points exist; they are bits in rows along x.
class CandidateGrid {
 public:
  /// Cells with this (feasible) edge length, whose reach is that of demand(), at most `reach` edges;
  /// `tolerance` is a length.
  void build(const std::vector<Point4>& points, double edge, double reach, double tolerance);
  std::size_t cells() const { return lists_.size(); }
  /// The edge length, or the smallest one that does not give too many cells.
  static double feasible(double edge);

  /// The cell of one of the points of build().
  std::uint32_t cellOf(const Point4& p) const {
    return rank(word(coordinate(p.y, 1), coordinate(p.z, 2)), coordinate(p.x, 0));
  }
  void insert(std::uint32_t i, const Neuron& neuron);
  void erase(std::uint32_t i, const Neuron& neuron);
  /// From one home to another.
  void move(std::uint32_t i, const Neuron& from, const Neuron& to);
  void rename(std::uint32_t from, std::uint32_t to, const Neuron& neuron);
  /// Raises the reach of a cell up to the limit. Only before anything is inserted.
  void demand(std::uint32_t cell, float reach);

  struct List {
    float reach;
    std::uint32_t offset, count, capacity;
  };
  const List& list(std::uint32_t cell) const { return lists_[cell]; }
  const std::uint32_t* members(const List& list) const { return &pool_[list.offset]; }

 private:
  struct Word {
    std::uint64_t cells = 0;
    std::uint32_t before = 0;  ///< cells in earlier words
  };
  int coordinate(float v, int axis) const;
  std::size_t word(int y, int z) const { return (static_cast<std::size_t>(z) * sides_[1] + y) * wordsInRow_; }
  std::uint32_t rank(std::size_t row, int x) const;
  bool lists(const List& list, float squaredDistance) const;
  float squaredDistance(int x, int y, int z, const Neuron& neuron) const;
  template <typename Visit>
  void forCells(const Neuron& low, const Neuron& high, const Visit& visit);
  void pull(List& list, std::uint32_t i);
  void push(List& list, std::uint32_t i);

  float edge_ = 2, inverse_ = 0.5F, maxReach_ = 0, limit_ = 0, tolerance_ = 0;
  std::array<float, 3> low_{};
  std::array<int, 3> sides_{};
  std::size_t wordsInRow_ = 0;
  std::vector<Word> words_;
  std::vector<List> lists_;
  std::vector<std::uint32_t> pool_;
};

/// A fine grid answers nearly all queries; where neurons are sparser than the reach of its cells, a coarse
/// grid does, and finally a search of all neurons.
class NeuronGrid {
 public:
  /// Colors of neurons by number, weighted; empty where only positions count.
  using Colors = std::vector<Point4>;

  /// The points of all later queries, and their weighted colors if these count, too. A color adds to the
  /// distance, so a neuron that is too far away by its position alone stays out of question.
  explicit NeuronGrid(const std::vector<Point4>& points, const Colors& pointColors = {});

  /// Fits the cells to neurons whose distance to the points has this root mean square.
  void fit(std::vector<Neuron>& neurons, const Colors& colors, double rms);
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
  NearestTwo nearestTwo(std::size_t k, const std::vector<Neuron>& neurons, const Colors& colors) const {
    const Point4& p = points_[k];
    const CandidateGrid::List& list = fine_.list(std::bit_cast<std::uint32_t>(p.w));
    const std::uint32_t* members = fine_.members(list);
    const NearestTwo two = pointColors_.empty() ? nearestAmong(p, members, list.count, neurons.data())
                                                : nearestAmong(p, pointColors_[k], members, list.count,
                                                               neurons.data(), colors.data());
    return two.squaredDistanceOfSecond() <= list.reach * list.reach ? two : furtherOut(k, neurons, colors);
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
  NearestTwo furtherOut(std::size_t k, const std::vector<Neuron>& neurons, const Colors& colors) const;

  CandidateGrid fine_, coarse_;
  std::vector<Point4> points_;  ///< w is their cell in the fine grid
  Colors pointColors_;
  std::vector<std::uint32_t> cells_;
  float tolerance_ = 0;
  bool fitted_ = false;
};

}  // namespace estancia
