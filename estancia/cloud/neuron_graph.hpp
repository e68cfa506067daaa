// The edges of a neural gas and their ages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace estancia {

/// Adjacency lists in blocks of two cache lines. Ages are not counted but told apart: an edge grows older by
/// one whenever one of its ends wins, so its age is what both ends have won since it was last renewed. Each
/// end remembers the renewals that it made itself, the later of the two counts. So a renewal costs nothing at
/// the other end, which is looked up only when an edge seems too old.
class NeuronGraph {
 public:
  struct Edge {
    std::uint32_t neighbor;
    std::uint32_t birth;  ///< wins of both ends when this end last renewed it, modulo 2^32
  };

  std::size_t size() const { return first_.size(); }
  /// Adds a neuron without edges.
  void add();
  /// Two that are not connected yet; `wins` are those of both together, here and below.
  void connect(std::uint32_t a, std::uint32_t b, std::uint32_t wins);
  void disconnect(std::uint32_t a, std::uint32_t b);
  bool isolated(std::uint32_t i) const { return blocks_[first_[i]].count == 0; }
  /// Removes a neuron without edges; the last one takes its number.
  void remove(std::uint32_t i);
  std::uint32_t age(std::uint32_t a, std::uint32_t b, std::uint32_t wins) const;

  /// Neuron `winner` wins before `second`, for the `own`th time: its edges are older by one than before, that
  /// to `second` is new again. Calls visit(neighbor) for every edge there was, which returns the neighbor's
  /// wins. Afterwards old() has the neighbors to which an edge is older than `maximalAge`; these edges are
  /// still there. Returns whether an edge to `second` was.
  template <typename Visit>
  bool win(std::uint32_t winner, std::uint32_t own, std::uint32_t second, std::uint32_t maximalAge,
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
        const std::uint32_t birth =
            renewed ? both : edge->birth;  // no branch: which one it is nobody can guess
        edge->birth = birth;
        if (both - birth > maximalAge && renewedByOther(winner, *edge, both) > maximalAge) old_.push_back(n);
      }
    }
    return connected;
  }
  const std::vector<std::uint32_t>& old() const { return old_; }

  /// Calls for what win() will read, should this neuron win.
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
  /// Takes over a later renewal by the other end; returns the age.
  std::uint32_t renewedByOther(std::uint32_t winner, Edge& edge, std::uint32_t both);

  std::vector<std::uint32_t> first_, free_, old_;
  std::vector<Block> blocks_;
};

}  // namespace estancia
