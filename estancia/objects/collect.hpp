// Object samples: images and point clouds of objects, collected from a sequence with depth (thesis 6.3.1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct CollectOptions {
  ClusterOptions clusters = {};
  std::size_t first = 0;
  std::size_t every = 1;
  std::size_t maxFrames = 0;
  std::size_t maxViews = 500;
  /// Replace the samples in an existing folder, once new ones have been collected.
  bool replace = false;
  /// Throw Error at a frame that cannot be read instead of skipping it.
  bool strict = false;
};
OptionGroup declare(CollectOptions& options);

/// Statistics of collectObjects().
struct Collected {
  std::size_t frames = 0;
  /// Frames whose image or depth cannot be read.
  std::size_t unread = 0;
  /// Frames without a supporting plane.
  std::size_t withoutPlane = 0;
  /// Frames without an object.
  std::size_t withoutCluster = 0;
  /// Frames with an object of more than half of the pixels: under-segmented, or too near.
  std::size_t huge = 0;
  std::size_t samples = 0, instances = 0;
  /// Samples that are flat, or cut by the image border.
  std::size_t flat = 0, atBorder = 0;
  /// Views that were left out as their object had maxViews.
  std::size_t full = 0;
};

/// The largest margin around an object that its samples keep, as a share of its longer side.
constexpr double maxCollectedMargin = 0.5;

/// Segments each frame into objects, tracks them, and makes `folder` (object_samples.hpp): each tracked
/// object is an instance, each view of it a sample, flat ones and those at the border included. The reasons
/// for skipped frames go to `problems`. The folder appears at the end; and also, with the samples so far,
/// after Interrupted or another failure; without any sample it is not made. Throws Error when the sequence
/// has no depth or camera (invalidInput), on invalid options, when no frame can be read (fileUnreadable),
/// without a name of the folder (invalidOption), when it exists and is not empty, unless it is to be replaced
/// and has samples only (fileExists), and when FOLDER.part, where they are collected, cannot be made
/// (fileUnwritable), or exists and is not that of a killed run (fileExists).
Collected collectObjects(const Sequence& sequence, const std::filesystem::path& folder,
                         const CollectOptions& options = {}, Progress& progress = Progress::none(),
                         std::vector<std::string>* problems = nullptr);

}  // namespace estancia
