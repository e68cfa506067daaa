// Sequence check: finds faults of a recording that would spoil a map, and advises how to repair them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

enum class Severity {
  /// Checked and sound.
  fine,
  /// Works, but something is missing or poor.
  warning,
  /// Gives wrong results, or hardly any.
  problem
};

/// One finding.
struct CheckItem {
  Severity severity;
  /// Stable, for programs: "pose-inverted"; docs/how-to/depth.md lists all.
  std::string name;
  /// A sentence: what it is.
  std::string what;
  /// Numbers, and how many frames were checked.
  std::string evidence;
  /// A sentence: what to do; "" when fine.
  std::string fix;
};

struct CheckReport {
  std::vector<CheckItem> items;
  /// Number of frames of the sequence.
  std::size_t frames = 0;
  std::size_t count(Severity severity) const;
};

struct CheckOptions {
  /// Frames that are checked, evenly spread over the sequence; more take longer and find rarer faults.
  std::size_t maxFrames = 60;
};
OptionGroup declare(CheckOptions& options);

/// Checks images, depth, camera, time stamps and poses, as far as the sequence has them. With depth, camera
/// and poses it reprojects pairs of depth images to find the convention, scale and delay of the poses: the
/// one under which the images agree best, if it is clearly better than the others (three standard errors over
/// the pairs). Deterministic. Throws Error (invalidOption); Interrupted.
CheckReport checkSequence(const Sequence& sequence, const CheckOptions& options = {},
                          Progress& progress = Progress::none());

}  // namespace estancia
