// For every cell of space that has points: the neurons that may be nearest to one of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estancia/cloud/neuron.hpp"

namespace estancia {

/// A cell lists all neurons whose home is within its reach and a tolerance, within which neurons stay of
/// their homes. So no neuron that it does not list is within its reach of any of its points; two neurons
/// found nearer than that are the nearest. (The neighbor lists of molecular dynamics: L. Verlet, Phys. Rev.
/// 159, 1967.) Only cells with points exist: they are bits in rows along x.
class CandidateGrid {
 public:
  /// Cells with this (feasible) edge length, that reach as far as is
  /// demanded, but not further than `reach` edges; `tolerance` is a length.
  void build(const std::vector<Point4>& points, double edge, double reach, double tolerance);
  std::size_t cells() const { return lists_.size(); }
  /// The edge length, or the least of which there are not too many.
  static double feasible(double edge);

  /// The cell of one of the points that it was built with.
  std::uint32_t cellOf(const Point4& p) const {
    return rank(word(coordinate(p.y, 1), coordinate(p.z, 2)), coordinate(p.x, 0));
  }
  void insert(std::uint32_t i, const Neuron& neuron);
  void erase(std::uint32_t i, const Neuron& neuron);
  /// From one home to another.
  void move(std::uint32_t i, const Neuron& from, const Neuron& to);
  void rename(std::uint32_t from, std::uint32_t to, const Neuron& neuron);
  /// Gives a cell at least this reach, as far as its grid goes. Only before anything is inserted.
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

  float edge_ = 2, inverse_ = 0.5F, furthest_ = 0, limit_ = 0, tolerance_ = 0;
  std::array<float, 3> low_{};
  std::array<int, 3> sides_{};
  std::size_t wordsInRow_ = 0;
  std::vector<Word> words_;
  std::vector<List> lists_;
  std::vector<std::uint32_t> pool_;
};

}  // namespace estancia
