// Neuron graph: the edges of a Growing Neural Gas with their ages, and the errors of its neurons.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace estancia {

/// Adjacency lists in blocks of two cache lines. Ages are not stored but derived: an edge ages by one
/// whenever one of its ends wins, so its age is the number of wins of both ends since it was last renewed.
/// Each end stores the renewals that it made itself, and the later of the two counts. So a renewal does not
/// touch the other end, which is read only when an edge seems too old.
class NeuronGraph {
 public:
  struct Edge {
    std::uint32_t neighbor;
    std::uint32_t birth;  ///< wins of both ends when this end last renewed it, modulo 2^32
  };

  std::size_t size() const { return first_.size(); }
  /// Adds a neuron without edges.
  void add() { first_.push_back(newBlock()); }
  /// Two neurons that are not connected yet; `wins` is the sum of their wins, here and below.
  void connect(std::uint32_t a, std::uint32_t b, std::uint32_t wins) {
    append(a, {b, wins}), append(b, {a, wins});
  }
  void disconnect(std::uint32_t a, std::uint32_t b) { drop(a, b), drop(b, a); }
  bool isolated(std::uint32_t i) const { return blocks_[first_[i]].count == 0; }
  /// Removes a neuron without edges; the last one takes its number.
  void remove(std::uint32_t i);
  std::uint32_t age(std::uint32_t a, std::uint32_t b, std::uint32_t wins) const;

  /// Neuron `winner` wins before `second`, for the `own`th time: its edges age by one, and that to `second`
  /// is renewed. Calls visit(neighbor) for every edge, which returns the neighbor's wins. Afterwards old()
  /// has the neighbors whose edges are older than `maxAge`; these edges still exist. Returns whether there
  /// was an edge to `second`.
  template <typename Visit>
  bool win(std::uint32_t winner, std::uint32_t own, std::uint32_t second, std::uint32_t maxAge,
           const Visit& visit) {
    old_.clear();
    bool connected = false;
    for (std::uint32_t b = first_[winner]; b != none;) {
      Block& block = blocks_[b];
      b = block.next;
      for (Edge *edge = block.edges.data(), *end = edge + block.count; edge != end; ++edge) {
        const std::uint32_t n = edge->neighbor, both = own + visit(n);
        const bool renewed = n == second;
        connected |= renewed;
        const std::uint32_t birth = renewed ? both : edge->birth;  // branchless: the outcome is unpredictable
        edge->birth = birth;
        if (both - birth > maxAge && renewedByOther(winner, *edge, both) > maxAge) old_.push_back(n);
      }
    }
    return connected;
  }
  const std::vector<std::uint32_t>& old() const { return old_; }

  /// Prefetches what win() reads if this neuron wins.
  void prefetch(std::uint32_t i) const {
    if (i >= size()) return;
    const char* block = reinterpret_cast<const char*>(&blocks_[first_[i]]);
    __builtin_prefetch(block, 1);
    __builtin_prefetch(block + 64, 1);
  }

  template <typename Visit>
  void forNeighbors(std::uint32_t i, const Visit& visit) const {
    for (std::uint32_t b = first_[i]; b != none; b = blocks_[b].next)
      for (std::uint32_t k = 0; k < blocks_[b].count; ++k) visit(blocks_[b].edges[k].neighbor);
  }

 private:
  static constexpr std::uint32_t none = 0xffffffff;
  struct alignas(64) Block {
    std::uint32_t count = 0, next = none;  ///< a block with a next one is full
    std::array<Edge, 15> edges;
  };
  Edge* find(std::uint32_t from, std::uint32_t to);
  void append(std::uint32_t from, Edge edge);
  void drop(std::uint32_t from, std::uint32_t to);
  std::uint32_t newBlock();
  /// Takes over a later renewal by the other end. Returns the age.
  std::uint32_t renewedByOther(std::uint32_t winner, Edge& edge, std::uint32_t both);

  std::vector<std::uint32_t> first_, free_, old_;
  std::vector<Block> blocks_;
};

/// Accumulated errors with a common decay in O(1) and a fast maximum. They only grow between insertions, so
/// the maximum of a block of neurons is updated by the winners alone. Decays are multiplied into one scale
/// for all.
class NeuronErrors {
 public:
  double at(std::uint32_t i) const { return values_[i]; }
  void add(std::uint32_t i, double error) {
    values_[i] += error * inverse_;
    double& max = blocks_[i / block];
    max = std::max(max, values_[i]);
  }
  void prefetch(std::uint32_t i) const { __builtin_prefetch(values_.data() + i, 1); }
  void append(double value) {
    values_.push_back(value);
    if (blocks_.size() * block < values_.size()) blocks_.push_back(0);
    refresh(values_.size() - 1);
  }
  void set(std::uint32_t i, double value) {
    values_[i] = value;
    refresh(i);
  }
  /// The last one takes the number of the removed one.
  void remove(std::uint32_t i) {
    values_[i] = values_.back();
    values_.pop_back();
    refresh(i);
    refresh(values_.size());
    blocks_.resize((values_.size() + block - 1) / block);
  }
  /// The lowest number among equal errors.
  std::uint32_t largest() const {
    const auto b =
        static_cast<std::size_t>(std::max_element(blocks_.begin(), blocks_.end()) - blocks_.begin());
    const auto begin = values_.begin() + static_cast<std::ptrdiff_t>(b * block);
    const auto end = values_.begin() + static_cast<std::ptrdiff_t>(std::min(values_.size(), (b + 1) * block));
    return static_cast<std::uint32_t>(std::max_element(begin, end) - values_.begin());
  }
  void decayAll(double factor) {
    scale_ *= factor;
    inverse_ = 1 / scale_;
    if (scale_ > 1e-100) return;
    for (double& v : values_) v *= scale_;
    for (double& v : blocks_) v *= scale_;
    scale_ = inverse_ = 1;
  }

 private:
  static constexpr std::size_t block = 32;
  void refresh(std::size_t i) {
    const std::size_t b = i / block;
    double max = 0;
    for (std::size_t k = b * block; k < std::min(values_.size(), (b + 1) * block); ++k)
      max = std::max(max, values_[k]);
    blocks_[b] = max;
  }
  std::vector<double> values_, blocks_;
  double scale_ = 1, inverse_ = 1;
};

}  // namespace estancia
