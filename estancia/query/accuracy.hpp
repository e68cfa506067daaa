// Localization accuracy: recall, room and position error against ground truth. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

/// One way to answer, judged by every truth there is; a measure is absent where its truth is unknown.
struct Accuracy {
  /// Share of frames whose answer lies in their true room.
  std::optional<double> room;
  /// Share of frames, of those that have an admissible image, whose answer is one (recall@1).
  std::optional<double> recall;
  /// Distance between the answer's and the frame's true position [m].
  std::optional<double> medianError;
};

struct LocalizationAccuracy {
  std::size_t frames = 0;
  /// By single frames.
  Accuracy nearestImage;
  /// By the Bayes filter.
  Accuracy belief;
  /// Share of frames whose node's room is their true room.
  std::optional<double> nodeRoom, beliefNodeRoom;
  /// Share of frames in whose believed zone (Localizer::setZones()) most frames have their true room.
  std::optional<double> beliefZoneRoom = {};
  /// Frames that have an admissible image: those that the recall is of.
  std::size_t judgedFrames = 0;
};

/// Statistics of the answers that need no ground truth.
struct LocalizationSummary {
  struct Place {
    int node = 0;
    std::size_t frames = 0;
    double medianConfidence = 0;
  };
  /// The places that were believed, those of most frames first.
  std::vector<Place> places;
  /// Median confidence over all frames; absent without any.
  std::optional<double> medianConfidence;
  /// Share of frames whose view is more probably unmapped than not; absent where the map has no poses.
  std::optional<double> unmapped;
};

LocalizationSummary summarizeLocalization(std::span<const Localization> answers);

/// For each query frame, in order, the map's frames that count as right.
using AdmissibleImages = std::vector<std::set<std::size_t>>;

/// A CSV `query,refs` with a header: the query's number and the numbers of its admissible map frames,
/// separated by blanks. Throws Error (malformedFile) naming file and line.
AdmissibleImages readAdmissibleImages(const std::filesystem::path& path);

/// `zoneOf`: the zones that the localizer was given; empty for none. `frames` and `answers` belong together.
/// `numbers[i]` is the place of frames[i] in its sequence, which `admissible` counts by. Where that is empty,
/// an image is admissible that was taken near, as defined by `near`. Throws Error (mismatch) when
/// `admissible` does not reach that far.
LocalizationAccuracy measureLocalization(const TopologicalMap& map, const std::vector<Frame>& frames,
                                         const std::vector<std::size_t>& numbers,
                                         const std::vector<Localization>& answers,
                                         const AdmissibleImages& admissible, const PlaceFilterOptions& near,
                                         const std::vector<int>& zoneOf = {});

}  // namespace estancia
