// Candidate grid: the neurons that may be nearest to a point, listed for each occupied cell of space.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/cloud/neuron.hpp"

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

}  // namespace estancia
