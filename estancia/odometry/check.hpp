// A check-up of people's own data: what would break a map, and how to mend it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/io/sequence.hpp"

namespace estancia {

enum class Severity {
  fine,     ///< looked at and sound
  warning,  ///< works, but something is missing or poor
  problem   ///< would give wrong results, or hardly any
};

/// One thing that was looked at.
struct CheckItem {
  Severity severity;
  std::string name;      ///< stable, for machines: "pose-inverted"; docs/how-to/depth.md lists them
  std::string what;      ///< a sentence: what it is
  std::string evidence;  ///< numbers, and how many frames were looked at
  std::string fix;       ///< a sentence: what to do; "" when fine
};

struct CheckReport {
  std::vector<CheckItem> items;
  std::size_t frames = 0;  ///< of the sequence
  std::size_t count(Severity severity) const;
};

struct CheckOptions {
  std::size_t frames = 60;  ///< looked at, evenly over the sequence; more take longer and find rarer faults
};

/// Looks at images, depth, camera, time stamps and poses, each as far as the sequence has it. Where there
/// are depth, camera and poses, it lets pairs of depth images tell which of the usual conventions, scales
/// and delays the poses have: the one under which they agree best, when it is clearly better than the others
/// (three standard errors over the pairs). The same report for the same data. Throws Interrupted.
CheckReport checkSequence(const Sequence& sequence, const CheckOptions& options, Progress& progress);

}  // namespace estancia
