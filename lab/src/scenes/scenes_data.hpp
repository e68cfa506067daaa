// Scene data: images described once for all descriptors that are compared.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/findings/findings.hpp"
#include "runner/experiment.hpp"
#include "scenes/scenes.hpp"

namespace estancia::experiments {

/// A descriptor that is compared.
struct SceneDescriptor {
  /// "inception-v3+gist".
  std::string name;
  /// Their names.
  std::vector<std::string> parts;
};

/// Images that belong together: one sequence, or one half of a data set.
struct SceneImages {
  std::string name;
  /// Features of the images whose room is known and wanted, by all parts.
  Features features;
  /// One an image: those of one run follow each other in one room.
  std::vector<std::string> runs;
  /// Digest of names, rooms and runs.
  std::string framesDigest;
  /// Digests of values and identity, by part.
  std::map<std::string, std::string> partDigests;

  /// Digest of all that a classifier in these parts can depend on.
  std::string digest(const std::vector<std::string>& parts) const;
};

struct ScenesData {
  struct Pair {
    /// Indexes into `images`.
    std::size_t train = 0, test = 0;
  };
  std::vector<SceneDescriptor> descriptors;
  std::vector<SceneImages> images;
  std::vector<Pair> pairs;
  /// Identities of the parts.
  std::vector<std::string> identities;
  /// How PHOG, GIST and ESF of the first image come about.
  std::optional<Images> figures;
};

/// Finds the descriptors, opens the data and describes it. Omissions are reported in `notes`. Throws Error as
/// compareScenes() does, all that can be known beforehand before any image is described.
ScenesData describeScenes(const ScenesOptions& options, const ExperimentRun& run, Progress& progress,
                          std::vector<std::string>& notes);

}  // namespace estancia::experiments
