// The images of a comparison of scene classifiers, described once by everything that is compared.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/describe/features.hpp"
#include "experiments/src/runner/experiment.hpp"
#include "experiments/src/scenes/scenes.hpp"

namespace estancia::experiments {

/// A descriptor that is compared.
struct SceneDescriptor {
  std::string name;                ///< "inception-v3+gist"
  std::vector<std::string> parts;  ///< their names
};

/// Images that belong together: one sequence, or one half of a data set.
struct SceneImages {
  std::string name;
  Features features;              ///< of the images whose room is known and wanted, by all parts
  std::vector<std::string> runs;  ///< one an image: those of one run follow each other in one room
  std::string framesDigest;       ///< of names, rooms and runs
  std::map<std::string, std::string> partDigests;  ///< of values and identity, by part

  /// Of all that a classifier in these parts can depend on.
  std::string digest(const std::vector<std::string>& parts) const;
};

struct ScenesData {
  struct Pair {
    std::size_t train = 0, test = 0;  ///< of `images`
  };
  std::vector<SceneDescriptor> descriptors;
  std::vector<SceneImages> images;
  std::vector<Pair> pairs;
  std::vector<std::string> identities;  ///< of the parts
};

/// Finds the descriptors, opens the data and describes it. What is left out is told in `notes`. Throws Error
/// as compareScenes() does, all that can be known beforehand before any image is described.
ScenesData describeScenes(const ScenesOptions& options, const ExperimentRun& run, Progress& progress,
                          std::vector<std::string>& notes);

}  // namespace estancia::experiments
