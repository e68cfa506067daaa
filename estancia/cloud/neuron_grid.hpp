// Neuron grid: exact search for the two neurons of a Growing Neural Gas nearest to a point, with SIMD.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "estancia/cloud/signals.hpp"

namespace estancia {

/// Half a cache line: what every signal reads of a neuron and of its neighbors. The search grid lists a
/// neuron at its home, from which it must not move too far.
struct alignas(32) Neuron {
  float x = 0, y = 0, z = 0;
  std::uint32_t wins = 0;  ///< modulo 2^32
  float homeX = 0, homeY = 0, homeZ = 0, zero = 0;

  Point4 at() const { return {x, y, z, 0}; }
};

/// Ties are broken by the lower number. Distances are infinite while there is no such neuron.
class NearestTwo {
 public:
  void look(float squaredDistance, std::uint32_t i) {
    // Distance and neuron in one number: the bits of non-negative floats have the order of the floats.
    const std::uint64_t key =
        static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(squaredDistance)) << 32 | i;
    const std::uint64_t worse = first_ > key ? first_ : key;
    second_ = second_ < worse ? second_ : worse;
    first_ = first_ < key ? first_ : key;
  }
  std::uint32_t first() const { return static_cast<std::uint32_t>(first_); }
  std::uint32_t second() const { return static_cast<std::uint32_t>(second_); }
  float squaredDistance() const { return std::bit_cast<float>(static_cast<std::uint32_t>(first_ >> 32)); }
  float squaredDistanceOfSecond() const {
    return std::bit_cast<float>(static_cast<std::uint32_t>(second_ >> 32));
  }

 private:
  static constexpr std::uint64_t none =
      static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity())) << 32;
  std::uint64_t first_ = none, second_ = none;
};

/// Four floats in one register.
using Vector = float __attribute__((vector_size(16)));
using Bits = std::int32_t __attribute__((vector_size(16)));

inline Vector load(const void* from) {
  Vector v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

/// Bit k is the sign of lane k.
inline std::uint64_t signs(Bits lanes) {
#ifdef __SSE2__
  return static_cast<std::uint64_t>(_mm_movemask_ps(reinterpret_cast<__m128>(lanes)));
#elif defined(__aarch64__)
  return vaddvq_u32(vandq_u32(reinterpret_cast<uint32x4_t>(lanes), uint32x4_t{1, 2, 4, 8}));
#else
  return (lanes[0] & 1U) | (lanes[1] & 2U) | (lanes[2] & 4U) | (lanes[3] & 8U);
#endif
}

/// The nearest two of the neurons with these numbers, in any order.
inline NearestTwo nearestAmong(const Point4& p, const std::uint32_t* members, std::uint32_t count,
                               const Neuron* neurons) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr std::uint32_t maxVectorized = 64;
  NearestTwo two;
  std::uint32_t k = 0, column = 0;
  if (count > maxVectorized) {
    for (; k < count; ++k) two.look(squaredDistance(p, neurons[members[k]].at()), members[k]);
    return two;
  }
  // First all distances, four at once, and the two smallest in each of four columns …
  const Vector px = Vector{} + p.x, py = Vector{} + p.y, pz = Vector{} + p.z;
  Vector first = Vector{} + infinity, second = first, distances[maxVectorized / 4];
  const auto four = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    const Vector na = load(&neurons[a]), nb = load(&neurons[b]), nc = load(&neurons[c]),
                 nd = load(&neurons[d]);
    const Vector ab = __builtin_shufflevector(na, nb, 0, 4, 1, 5),
                 cd = __builtin_shufflevector(nc, nd, 0, 4, 1, 5);
    const Vector x = px - __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    const Vector y = py - __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    const Vector z = pz - __builtin_shufflevector(__builtin_shufflevector(na, nb, 2, 6, 3, 7),
                                                  __builtin_shufflevector(nc, nd, 2, 6, 3, 7), 0, 1, 4, 5);
    return (x * x + y * y) + z * z;
  };
  const auto keep = [&](Vector d) {
    const Vector worse = first > d ? first : d;
    second = second < worse ? second : worse;
    first = first < d ? first : d;
  };
  for (; k + 4 <= count; k += 4) {
    const Vector d = four(members[k], members[k + 1], members[k + 2], members[k + 3]);
    distances[column++] = d;
    keep(d);
  }
  if (k < count) {
    const std::uint32_t rest = count - k, last = members[count - 1];
    Vector d = four(members[k], rest > 1 ? members[k + 1] : last, rest > 2 ? members[k + 2] : last, last);
    d = Bits{0, 1, 2, 3} < Bits{} + static_cast<std::int32_t>(rest) ? d : Vector{} + infinity;
    distances[column++] = d;
    keep(d);
  }
  // … then the neurons that have them: mostly two, more where distances are equal.
  const auto fold = [&](Vector other, Vector otherSecond) {
    const Vector worse = first > other ? first : other;
    second = second < otherSecond ? second : otherSecond;
    second = second < worse ? second : worse;
    first = first < other ? first : other;
  };
  fold(__builtin_shufflevector(first, first, 2, 3, 0, 1),
       __builtin_shufflevector(second, second, 2, 3, 0, 1));
  fold(__builtin_shufflevector(first, first, 1, 0, 3, 2),
       __builtin_shufflevector(second, second, 1, 0, 3, 2));
  std::uint64_t near = 0;
  for (std::uint32_t c = 0; c < column; ++c) near |= signs(distances[c] <= second) << (4 * c);
  for (; near != 0; near &= near - 1) {
    const auto at = static_cast<std::uint32_t>(std::countr_zero(near));
    if (at < count) two.look(distances[at / 4][at % 4], members[at]);
  }
  return two;
}

/// The nearest two by position and color: `c` is the color of the point, `colors` are the neurons', weighted.
inline NearestTwo nearestAmong(const Point4& p, const Point4& c, const std::uint32_t* members,
                               std::uint32_t count, const Neuron* neurons, const Point4* colors) {
  NearestTwo two;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t i = members[k];
    const float apart = squaredDistance(p, neurons[i].at());
    // The color adds to it, so most neurons need no look at theirs.
    if (apart <= two.squaredDistanceOfSecond()) two.look(apart + squaredDistance(c, colors[i]), i);
  }
  return two;
}

/// A cell lists all neurons whose home is within its reach plus a tolerance; neurons stay within that
/// tolerance of their homes. So no other neuron is within the reach of any point of the cell: two listed
/// neurons that are nearer are the nearest two. (Verlet lists of molecular dynamics: L. Verlet, Phys. Rev.
/// 159, 1967.) Only cells with points exist; they are bits in rows along x.
class CandidateGrid {
 public:
  /// Cells with this edge length, whose reach is that of demand(), at most `reach` edges;
  /// `tolerance` is a length.
  void build(const std::vector<Point4>& points, double edge, double reach, double tolerance);
  std::size_t cells() const { return lists_.size(); }

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
/// grid does, and finally a search of all neurons. Invariant: after fit() each neuron is in the cell that
/// tolerance() allows for its position; rehome() restores this when it moved. Life cycle: fit() before the
/// first query, and again when the number of neurons has grown.
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
  float tolerance_ = 0;
  bool fitted_ = false;
};

}  // namespace estancia
