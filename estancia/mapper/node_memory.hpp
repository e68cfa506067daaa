// Node memory: what the mapper knows of one place, and how it looks in different lights. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "estancia/stats/moments.hpp"

namespace estancia {

/// Bounded size. A node looks like the mean of its frames. Each further drive has a mean of its own, too,
/// since its light may be another: when it is over and what it saw differs, that is an appearance mode, and
/// the mean of the drives before is one. (While it lasts it is none: a frame that was taken for the wrong
/// place would draw all that follow after it.)
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
  /// Modes within `threshold`, those of fewer than `fewest` frames, and the nearest of more than three are
  /// joined.
  void joinModes(double threshold, std::uint64_t fewest, const Distance& distance);
  /// Without this drive; without modes the mean of all frames before.
  std::vector<Moments> modesOfEarlierDrives() const;
  /// When it has grown by a quarter.
  void setNextMergeCheck();
};

}  // namespace estancia
