// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/removed_options.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

constexpr std::string_view byPreset = "the preset sets it (--preset)";
constexpr std::string_view byValidation = "cross-validation finds it";
constexpr std::string_view ofGas = "`estancia filter` has it: filter a cloud first, then recognize in that";
constexpr std::string_view ofTracks =
    "an object is found again within 5 cm or half its size, by an overlap of 0.3, for 5 frames";

constexpr RemovedOption removed[] = {
    {"classifier.c", "", byValidation},
    {"classifier.folds", "5", ""},
    {"classifier.gamma", "", byValidation},
    {"classifier.metric", "", byValidation},
    {"classifier.neighbors", "", byValidation},
    {"classifier.trees", "500", ""},
    {"clusters.crease-depth", "0.0022", ""},
    {"clusters.min-plane-area", "0.25", ""},
    {"clusters.plane-tolerance", "0.01", ""},
    {"clusters.seed", "1", ""},
    {"download.connect-seconds", "20", ""},
    {"download.max-bytes", "4294967296", ""},
    {"download.pause-seconds", "2", ""},
    {"download.stall-seconds", "60", ""},
    {"filter.along-edges", "0.01", ""},
    {"filter.anywhere", "0.002", ""},
    {"filter.temper", "0.4", ""},
    {"filter.turn-around", "0.005", ""},
    {"label-stream.ahead", "16", ""},
    {"label-stream.readers", "2", ""},
    {"mapper.nearer-than-current", "true", ""},
    {"model-filter.leaf", "", "it is the one that leaves model-filter.points"},
    {"odometry.keyframe-overlap", "0.7", ""},
    {"odometry.loop-candidates", "8", "it is always 8, and `odometry estimate --no-loops` closes no loops"},
    {"odometry.max-gap", "1", ""},
    {"odometry.max-motion", "0.7", ""},
    {"odometry.max-rmse", "0.03", ""},
    {"odometry.max-turn", "50", ""},
    {"odometry.min-correction", "0.02", ""},
    {"odometry.min-correlation", "0.5", ""},
    {"odometry.min-loop-keyframes", "4", ""},
    {"odometry.min-loop-overlap", "0.4", ""},
    {"odometry.min-overlap", "0.35", ""},
    {"odometry.odom-shift", "3", "maps are made without wheel odometry"},
    {"odometry.odom-turn", "2", "maps are made without wheel odometry"},
    {"recognition.match-distance", "", byPreset},
    {"recognition.match-each", "", byPreset},
    {"recognition.max-hypotheses", "", byPreset},
    {"recognition.min-matches", "", byPreset},
    {"recognition.neighbors", "", byPreset},
    {"recognition.scene-keypoint-spacing", "", byPreset},
    {"room-segmentation.min-area", "0.5", ""},
    {"scene-filter.leaf", "", "it is the one that leaves scene-filter.points"},
    {"shape.seed", "1", ""},
    {"thresholds.sequence-ratio", "0.5", ""},
    {"thresholds.view-ratio", "0.3", ""},
    {"tracks.max-distance", "0.05", ""},
    {"tracks.max-unseen", "5", ""},
    {"tracks.min-overlap", "0.3", ""},
    {"word-map.cell", "0.2", ""},
    {"word-map.words", "64", ""},
    {"zone-stream.relink-every", "20", ""},
    // Groups with all that was in them.
    {"areas.word-map", "", "its cells are 0.2 m wide and keep 64 words"},
    {"collect.tracks", "", ofTracks},
    {"fetch.download", "", "servers have 20 s to connect and 60 s of silence, and files have at most 4 GiB"},
    {"model-filter.gng", "", ofGas},
    {"prediction.tracks", "", ofTracks},
    {"scene-filter.gng", "", ofGas},
};

}  // namespace

std::span<const RemovedOption> removedOptions() {
  return removed;
}

const RemovedOption* findRemovedOption(std::string_view path) {
  std::string wanted = fmt::format(".{}.", path);
  std::ranges::replace(wanted, '_', '-');
  const auto found = std::ranges::find_if(removed, [&](const RemovedOption& option) {
    return wanted.find(fmt::format(".{}.", option.path)) != std::string::npos;
  });
  return found == std::ranges::end(removed) ? nullptr : found;
}

std::string describeRemoved(const RemovedOption& option, std::string_view path) {
  return option.instead.empty() ? fmt::format("{} has gone: it is always {}", path, option.value)
                                : fmt::format("{} has gone: {}", path, option.instead);
}

std::string describeRemoved(const RemovedOption& option, std::string_view path, std::string_view kept) {
  return fmt::format("{}, and was {} when the map was made", describeRemoved(option, path), printable(kept));
}

}  // namespace estancia
