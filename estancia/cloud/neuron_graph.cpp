// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/neuron_graph.hpp"

namespace estancia {

std::uint32_t NeuronGraph::newBlock() {
  if (free_.empty()) {
    blocks_.emplace_back();
    return static_cast<std::uint32_t>(blocks_.size() - 1);
  }
  const std::uint32_t block = free_.back();
  free_.pop_back();
  blocks_[block] = {};
  return block;
}

NeuronGraph::Edge* NeuronGraph::find(std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t b = first_[from]; b != none; b = blocks_[b].next)
    for (std::uint32_t k = 0; k < blocks_[b].count; ++k)
      if (blocks_[b].edges[k].neighbor == to) return &blocks_[b].edges[k];
  return nullptr;
}

void NeuronGraph::append(std::uint32_t from, Edge edge) {
  // New blocks are put in front, so that only the first one has free space.
  if (blocks_[first_[from]].count == blocks_[first_[from]].edges.size()) {
    const std::uint32_t block = newBlock();
    blocks_[block].next = first_[from];
    first_[from] = block;
  }
  Block& block = blocks_[first_[from]];
  block.edges[block.count++] = edge;
}

void NeuronGraph::drop(std::uint32_t from, std::uint32_t to) {
  Block& block = blocks_[first_[from]];
  *find(from, to) = block.edges[block.count - 1];
  if (--block.count == 0 && block.next != none) {
    free_.push_back(first_[from]);
    first_[from] = block.next;
  }
}

void NeuronGraph::remove(std::uint32_t i) {
  const auto last = static_cast<std::uint32_t>(size() - 1);
  if (i != last) forNeighbors(last, [&](std::uint32_t n) { find(n, last)->neighbor = i; });
  free_.push_back(first_[i]);
  first_[i] = first_[last];
  first_.pop_back();
}

std::uint32_t NeuronGraph::renewedByOther(std::uint32_t winner, Edge& edge, std::uint32_t both) {
  const std::uint32_t birth = find(edge.neighbor, winner)->birth;
  if (both - birth < both - edge.birth) edge.birth = birth;
  return both - edge.birth;
}

std::uint32_t NeuronGraph::age(std::uint32_t a, std::uint32_t b, std::uint32_t wins) const {
  auto* self = const_cast<NeuronGraph*>(this);
  return std::min(wins - self->find(a, b)->birth, wins - self->find(b, a)->birth);
}

}  // namespace estancia
