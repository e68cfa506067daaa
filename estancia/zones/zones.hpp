// AuSeMap: the areas of a run, found and named by their words alone (thesis chapter 5).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/spatial_variance.hpp"
#include "estancia/zones/cut.hpp"

namespace estancia {

struct ZoneOptions {
  /// How two images are compared, by name (compared_vectors.hpp). The default agrees best with rooms and
  /// places where these are known (docs/how-to/zones.md).
  std::string distance = "standardized-clr";
  /// How two zones are compared, by name (linkage.hpp).
  std::string linkage = "ward";
  /// τ_d: zones merge as long as the smallest distance between two is not above it. None: suggestCut().
  std::optional<double> cut;
  /// As many zones, however near or far they lie; instead of a cut.
  std::optional<std::size_t> count;
  int threads = 0;  ///< 0: one a usable core. The result does not depend on it.

  /// What the thesis chose: Kolmogorov–Smirnov distance (Eq. 5.1), average linkage, τ_d = 0.5.
  static ZoneOptions thesis();
};

/// Where a zone's images were taken.
struct ZoneExtent {
  Position center{};       ///< mean position of its posed images in the map [m]
  double spread = 0;       ///< their mean distance to it [m]
  std::size_t images = 0;  ///< how many have a pose, ≥ 1
};

/// Images whose words are alike. Invariant: at least one image; mean and sigma have one value a label.
struct Zone {
  int id = 0;                        ///< 0 for the largest zone; its position in Zones::zones
  std::string name;                  ///< its most telling words: "refrigerator, stove, microwave"
  std::vector<std::size_t> images;   ///< frame numbers, ascending
  std::vector<float> mean;           ///< mean probability of each label
  std::vector<float> sigma;          ///< and its (population) standard deviation
  std::string room;                  ///< the room that most of its images are known to be in, or ""
  double roomShare = 0;              ///< their share of its images whose room is known
  std::optional<ZoneExtent> extent;  ///< absent when no image has a pose
  /// What a classifier takes it for, best first (poolRooms()); empty when none was asked. Not the truth.
  std::vector<RoomProbability> predicted;
};

/// What a true room looks like in words; only to be compared with the zones.
struct RoomWords {
  std::string name;
  std::size_t images = 0;
  std::vector<float> mean;
};

/// A run and its zones. Plain data.
struct Zones {
  Vocabulary vocabulary;
  std::string model;  ///< identity of the labeler
  std::string distance, linkage;
  double cut = 0;         ///< τ_d: merges up to it were done
  std::string cutReason;  ///< one sentence for people: where the cut comes from
  std::vector<Frame> frames;
  std::vector<int> zoneOf;               ///< one a frame
  std::vector<Zone> zones;               ///< by falling size, of equal ones the one seen first; ids 0, 1, …
  std::vector<RoomWords> rooms;          ///< by name; empty where no room is known
  std::optional<Dendrogram> dendrogram;  ///< of the frames; absent where they were not clustered all at once
  std::string classifier = {};           ///< what named the zones' predicted rooms, "" for nothing
};

/// Algorithm 5.1. Throws Error for an empty recording, unknown names, both a cut and a count or one that is
/// none, a linkage that does not fit the distance, and more images than fit into memory; Interrupted when the
/// user asks to stop.
Zones findZones(const DescriptorSequence& recording, const ZoneOptions& options, Progress& progress);

/// All merges of findZones(), and what its cut is suggested from: for whoever cuts the same tree at several
/// heights. `cut` and `count` do not matter. Throws as above.
struct ImageTree {
  Dendrogram dendrogram;
  NearestItems neighbors;
};
ImageTree linkImages(const DescriptorSequence& recording, const ZoneOptions& options, Progress& progress);

/// Throws Error when both a cut and a count are asked for, or a cut that is none.
void requireSound(const ZoneOptions& options);

/// Where findZones() cuts.
struct ZoneCut {
  std::vector<int> groups;  ///< of the leaves
  double distance;          ///< τ_d
  std::string reason;       ///< one sentence for people
};

/// At options.cut, into options.count groups, or where suggestCut() says.
ZoneCut cutTree(const Dendrogram& tree, const NearestItems& neighbors, const ZoneOptions& options);

/// The distances of all pairs of images by options.distance, as options.linkage needs them. Throws as above.
CondensedDistances compareImages(const DescriptorSequence& recording, const ZoneOptions& options,
                                 Progress& progress);

/// Zones of a partition that is known already: `groups[i]` is any number for the group of frame i. Numbers
/// the zones anew by size and fills in all but distance, linkage, cut and dendrogram. Throws Error when there
/// is no frame or not one number a frame.
Zones describeZones(const DescriptorSequence& recording, std::span<const int> groups);

/// Names the zones by what a room classifier says of the run's frames, row i of frame i. Throws Error unless
/// there is a row a frame.
void nameRooms(Zones& zones, const RoomPredictions& predictions);

/// The mean probability of each label over the whole run.
std::vector<float> runMean(const Zones& zones);

}  // namespace estancia
