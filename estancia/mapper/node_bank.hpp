// Node bank: the nodes of a growing map, laid out for fast exact nearest-neighbor search.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "estancia/distances/distance.hpp"
#include "estancia/mapper/node_border.hpp"
#include "estancia/mapper/quantized_bounds.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia {

/// What the mapper knows of one place, of bounded size, and how it looks in different lights. A node looks
/// like the mean of its frames. Each further drive has a mean of its own, too, since its light may be
/// another: when it is over and what it saw differs, that is an appearance mode, and the mean of the drives
/// before is one. (While it lasts it is none: a frame that was taken for the wrong place would draw all that
/// follow after it.)
///
/// Invariant: `own` exists only during a further drive and is part of `probabilities`; endDrive() turns it
/// into a mode or drops it.
struct NodeMemory {
  int id = 0;
  std::uint64_t frames = 0;
  /// Look for a duplicate when the node holds this many frames.
  std::uint64_t nextMergeCheck = 0;
  /// Moments of the frames' probabilities (Eq. 4.2).
  Moments probabilities;
  /// Moments of their embedded descriptors; absent when these are the probabilities themselves.
  std::optional<Moments> embedded;
  /// Means of its appearance in earlier drives, if one mean does not suffice.
  std::vector<Moments> modes = {};
  /// Moments of the frames of this drive, if that is a further one.
  std::optional<Moments> own = {};
  /// Images that do not weigh 1 yet; none unless transitionImages > 0.
  NodeBorder border = {};

  static constexpr std::size_t maxModes = 3;

  /// Moments that distances are computed from.
  const Moments& moments() const { return embedded ? *embedded : probabilities; }
  /// Means used for comparison: the overall mean and the modes.
  std::vector<const Moments*> looks() const;

  /// Adds all frames of `other`.
  void merge(const NodeMemory& other);
  /// Adds the frames of other drives.
  void mergeOfOtherDrives(const NodeMemory& other);
  using Distance = std::function<double(const Moments&, const Moments&)>;
  /// Adds this drive's mean as an appearance mode; see joinModes().
  void endDrive(double threshold, std::uint64_t fewest, const Distance& distance);
  /// Joins modes within `threshold`, those of fewer than `fewest` frames, and the nearest of more than three.
  void joinModes(double threshold, std::uint64_t fewest, const Distance& distance);
  /// Without this drive; without modes the mean of all frames before.
  std::vector<Moments> modesOfEarlierDrives() const;
  /// When it has grown by a quarter.
  void setNextMergeCheck() { nextMergeCheck = frames + std::max<std::uint64_t>(1, frames / 4); }
};

/// Owns the nodes. Distances are exact whatever the shortcut (a test compares with a plain scan).
///
/// Invariant: each row (vector to compare with) belongs to the node slotOfRow_ names, rowsOf_ is the inverse,
/// and rows_, squaredNorms_ and bounds_ have one entry a row under the current standardization. A node is
/// added, changed through update() only, and removed; slots change then, ids never.
class NodeBank {
 public:
  NodeBank(Distance distance, std::size_t labels);

  NodeMemory makeNode(int id) const;
  /// Returns its slot. Slots are positions 0 … size()−1 and change when a node is removed.
  std::size_t add(NodeMemory node);
  void remove(std::size_t slot);
  std::size_t size() const { return nodes_.size(); }
  const NodeMemory& operator[](std::size_t slot) const { return nodes_[slot]; }
  /// Throws Error when there is no such node.
  std::size_t slotOf(int id) const;

  /// Changes a node through `change(NodeMemory&)` and brings the search up to date.
  template <class Change>
  void update(std::size_t slot, Change change) {
    change(nodes_[slot]);
    refresh(slot);
  }

  /// A drive is over; see NodeMemory::endDrive(). The ids of the nodes that have changed.
  std::vector<int> endDrive(double threshold, std::uint64_t fewest);
  /// Where a node has taken in another; see NodeMemory::joinModes().
  void joinModes(std::size_t slot, double threshold, std::uint64_t fewest);
  /// Nodes are compared as their means alone. The ids of those that have changed.
  std::vector<int> forgetModes();
  /// Number of vectors to compare with: one mean a node, and one a mode.
  std::size_t rows() const { return slotOfRow_.size(); }

  /// New scales; O(nodes · labels).
  void setStandardization(Standardization standardization);
  const Standardization& standardization() const { return standardization_; }

  /// An embedded descriptor as distance() and nearest() compare it.
  std::vector<float> compared(std::span<const float> embedded) const;

  /// To what the node looks like in one of its modes.
  double distance(std::size_t slot, std::span<const float> compared) const;
  /// Mean of its frames, as used for comparison.
  std::vector<float> mean(std::size_t slot) const { return compared(nodes_[slot].moments().mean()); }

  struct Nearest {
    std::size_t slot;
    double distance;
  };
  /// The nearest node but that in slot `except`, of at least `minFrames` frames; the lower slot wins a tie.
  std::optional<Nearest> nearest(std::span<const float> compared, std::size_t except,
                                 std::uint64_t minFrames = 1) const;

 private:
  std::span<const float> row(std::size_t row) const { return {rows_.data() + row * labels_, labels_}; }
  std::span<const float> weights(std::size_t slot) const;
  double rowDistance(std::size_t row, std::span<const float> compared) const;
  void refresh(std::size_t slot);
  void setRowCount(std::size_t slot, std::size_t count);
  void setWeights(std::size_t slot);
  NodeMemory::Distance distanceOfModes() const;

  Distance distance_;
  std::size_t labels_;
  bool byDotProduct_;  ///< the distance grows as the dot product falls: bounds_ can rule nodes out
  Standardization standardization_;
  std::vector<NodeMemory> nodes_;
  std::unordered_map<int, std::size_t> slots_;    ///< by id
  std::vector<std::vector<std::size_t>> rowsOf_;  ///< rows of each node, one a look
  std::vector<std::size_t> slotOfRow_;
  std::vector<float> rows_;           ///< the compared vectors, rows()×labels
  std::vector<float> weights_;        ///< weights of σ-weighted distances, size()×labels
  std::vector<double> squaredNorms_;  ///< squared norms of the rows
  QuantizedUpperBounds bounds_;
};

}  // namespace estancia
