// Mapper implementation: the state of Algorithm 4.1, and how it is saved in a map file. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/topology/mapper.hpp"
#include "estancia/topology/node_bank.hpp"
#include "estancia/topology/thresholds.hpp"

namespace estancia {

struct Mapper::Impl {
  Impl(const DescriptorLayout& layout, const MapperOptions& chosen);

  /// A frame's descriptor on its way into a node: as it came, and as the distance embeds it.
  struct FrameDescriptor {
    std::vector<float> probabilities, embedded;
  };
  FrameDescriptor embeddedFrame(DescriptorView probabilities) const;

  void add(DescriptorView probabilities);
  void finish();
  int currentNode() const { return bank.size() == 0 ? -1 : bank[current].id; }

  bool isAutomatic() const;
  bool isWarmingUp() const;
  void estimateScales(bool warmingUp);
  void remapWarmup();
  void place(std::size_t frame, const FrameDescriptor& descriptor);
  Decision undecided(std::size_t frame) const;
  void join(std::size_t slot, const FrameDescriptor& descriptor);
  std::size_t createNode();
  void leave();
  void addTransition(int from, int to, std::size_t frame);
  void mergeDuplicateNodes(std::size_t frame);
  void redirectTransitions(int absorbed, int kept);

  /// The mapper's own memory, to go on later; nodes are saved apart by nodeState().
  std::string state() const;
  std::string nodeState(std::size_t slot) const;
  /// `descriptor(i)` gives frame i's stored descriptor. Throws Error (corruptFile) when the state is damaged.
  static Mapper restore(const DescriptorLayout& layout, const MapperOptions& options,
                        const std::string& state, const std::vector<std::pair<int, std::string>>& nodes,
                        const std::function<LexicalDescriptor(std::size_t)>& descriptor);

  std::size_t labels;
  MapperOptions options;
  Distance distance;
  ThresholdEstimator scale;
  NodeBank bank;
  Thresholds thresholds;
  std::size_t nextEstimate;
  /// Slot of the current node.
  std::size_t current = 0;
  int nextId = 0;
  /// Frames since the robot entered the current node.
  std::size_t stay = 0;
  /// The last transitionImages frames of this stay.
  std::deque<FrameDescriptor> recent;
  std::map<std::pair<int, int>, Transition> transitions;
  /// The probabilities of all frames of the warm-up.
  std::vector<std::vector<float>> warmup;
  MapChanges changes;
};

/// A map's settings as JSON, and back. Throws Error (corruptFile) on unknown or malformed settings.
std::string settingsToJson(const MapperOptions& options);
MapperOptions settingsFromJson(const std::string& text);

}  // namespace estancia
