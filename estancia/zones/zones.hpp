// Semantic zones (AuSeMap): the areas of a run, clustered and named by their labels alone (thesis chapter 5).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/stats/dendrogram.hpp"
#include "estancia/words/installed_words.hpp"

namespace estancia {

struct ZoneOptions {
  /// Distance of two images, see baseDistances(). The default agrees best with rooms and places where these
  /// are known (docs/how-to/zones.md).
  std::string distance = "standardized-clr";
  /// Distance of two zones, see linkages().
  std::string linkage = "ward";
  /// τ_d: zones merge while the smallest distance between two is not above it. Absent: where modularity is
  /// largest.
  std::optional<double> cut;
  /// This number of zones, instead of a cut.
  std::optional<std::size_t> count;
  /// Images of a run are compared by what is seen around them: descriptors of images within about this
  /// distance [m] (for images without poses, of a like way through the run) are pooled. 0 or absent: each by
  /// itself, as in the thesis, and in any order.
  std::optional<double> reach;
  NamingOptions naming;
  /// 0: one a usable core. The result does not depend on it.
  int threads = 0;

  /// For the images of a drive.
  static constexpr double reachOfRun = 0.5;

  /// The thesis' choice: Kolmogorov–Smirnov distance (Eq. 5.1), average linkage, τ_d = 0.5.
  static ZoneOptions thesis();
};
OptionGroup declare(ZoneOptions& options);
/// Throws Error (invalidOption, unknownName) for values out of range, and for both a cut and a count.
void validate(const ZoneOptions& options);

/// Where a zone's images were taken.
struct ZoneExtent {
  /// Mean position of its posed images in the map [m].
  std::array<double, 3> center{};
  /// Their mean distance to it [m].
  double spread = 0;
  /// How many have a pose, ≥ 1.
  std::size_t images = 0;
};

/// A cluster of images. Invariant: at least one image; mean and sigma have one value a label.
struct Zone {
  /// 0 for the largest zone; its position in Zones::zones.
  int id = 0;
  /// Its most telling words: "refrigerator, stove, microwave".
  std::string name = {};
  /// Frame numbers, ascending.
  std::vector<std::size_t> images = {};
  /// Mean and (population) standard deviation of each label's probability.
  std::vector<float> mean = {}, sigma = {};
  /// The true room of most of its images, or "".
  std::string room = {};
  /// Their share of its images whose room is known.
  double roomShare = 0;
  /// Absent when no image has a pose.
  std::optional<ZoneExtent> extent = {};
  /// A room classifier's prediction, best first (poolRooms()); empty when none was run. Not the truth.
  std::vector<RoomProbability> predicted = {};
};

/// Labels of a true room; only to be compared with the zones.
struct RoomWords {
  std::string name;
  std::size_t images = 0;
  std::vector<float> mean;
};

/// A run and its zones. Plain data.
struct Zones {
  Vocabulary vocabulary;
  /// Identity of the labeler.
  std::string model = {};
  std::string distance = {}, linkage = {};
  /// τ_d: merges up to it were done.
  double cut = 0;
  /// Where the cut comes from, one sentence.
  std::string cutReason = {};
  std::vector<Frame> frames = {};
  /// One a frame.
  std::vector<int> zoneOf = {};
  /// By falling size, of equal ones the one seen first; ids 0, 1, …
  std::vector<Zone> zones = {};
  /// By name; empty where no room is known.
  std::vector<RoomWords> rooms = {};
  /// Dendrogram of the frames; absent where they were not clustered all at once.
  std::optional<Dendrogram> dendrogram = {};
  /// The classifier that predicted the zones' rooms, "" for none.
  std::string classifier = {};
};

/// Algorithm 5.1: clusters the images of a run. Throws Error: insufficientData without images, invalidOption
/// and unknownName for the options, also a linkage that does not fit the distance; tooLarge for more images
/// than fit into memory; Interrupted when the user asks to stop.
Zones findZones(const DescriptorSequence& sequence, const ZoneOptions& options = {},
                Progress& progress = Progress::none());

/// Zones of a partition that is known already: `groups[i]` is any number for the group of frame i. Numbers
/// the zones by size and fills in all but distance, linkage, cut and dendrogram. Throws Error when there
/// is no frame (insufficientData) or not one number a frame (mismatch).
Zones describeZones(const DescriptorSequence& sequence, std::span<const int> groups,
                    const NamingOptions& naming = {});

/// Names the zones' rooms by a classifier's predictions, row i for frame i. Throws Error (mismatch) unless
/// there is a row a frame.
void nameRooms(Zones& zones, const RoomPredictions& predictions);

/// The mean probability of each label over the whole run.
std::vector<float> runMean(const Zones& zones);

/// Reads a zone file, equal in every value to what was written. Throws Error: fileNotFound, unsupportedFile
/// (not a zone file, or another version), corruptFile (damaged or cut short).
Zones readZones(const std::filesystem::path& file);

/// Writes the file whole or not at all, replacing what was there. Throws Error (fileUnwritable).
void writeZones(const Zones& zones, const std::filesystem::path& file);

/// The file's text: {"format": "estancia-zones", "version": 3, "vocabulary": {"digest", "labels", "parts"},
/// "model", "settings": {"distance", "linkage", "cut", "cut_reason"}, "zones": […], "rooms": […],
/// "frames": […], "dendrogram": […]}; docs/how-to/zones.md lists every key. Probabilities have the fewest
/// digits that read back as the same float32; texts that are not UTF-8 are written as {"hex": …}.
std::string zoneFileText(const Zones& zones);

/// Whether the file begins as a zone file does, intact or not: distinguishes it from a map, whatever its
/// name.
bool isZoneFile(const std::filesystem::path& file);

}  // namespace estancia
