// A sequence with depth → samples of the things in it, to be labeled and learned from (thesis 6.3.1).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/cloud/clusters.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/objects/tracks.hpp"

namespace estancia {

struct CollectOptions {
  ClusterOptions clusters = {};
  TrackOptions tracks = {};
  std::size_t first = 0;    ///< frame to begin with
  std::size_t every = 1;    ///< only each such frame; at least 1
  std::size_t frames = 0;   ///< that are looked at; 0: all
  std::size_t views = 500;  ///< of one thing (thesis Table 6.2); later ones are left out; at least 1
  bool replace = false;     ///< samples that are there already, once new ones have been gathered
  bool strict = false;      ///< throw Error at a frame that cannot be read instead of leaving it out
};

/// What came of it.
struct Collected {
  std::size_t frames = 0;          ///< looked at
  std::size_t unread = 0;          ///< of them without a readable image or depth
  std::size_t withoutPlane = 0;    ///< nothing to stand on or against was seen
  std::size_t withoutCluster = 0;  ///< nothing stands about
  std::size_t huge = 0;            ///< with a cluster of more than half of the pixels
  std::size_t samples = 0, instances = 0;
  std::size_t flat = 0, atBorder = 0;  ///< samples that are
  std::size_t full = 0;                ///< views left out as their thing had enough
};

/// Labelers see at most so much around collected things, in shares of their longer side.
constexpr double mostCollectedMargin = 0.5;

/// Cuts each frame into things, follows them from frame to frame, and makes `folder` (object_samples.hpp): a
/// thing is an instance, each sight of it a sample, flat ones and those at the border included. Why frames
/// are left out is told in `problems`, one sentence each. The folder is there when all is done, and also,
/// with what was gathered until then, when the user asks to stop, which throws Interrupted, or something goes
/// wrong; without any sample it is not made. Throws Error when the sequence has no depth or camera, no frame
/// at all can be read, on options out of range, and as NewSamples does.
Collected collectObjects(const Sequence& sequence, const std::filesystem::path& folder,
                         const CollectOptions& options, Progress& progress,
                         std::vector<std::string>* problems = nullptr);

}  // namespace estancia
