// Features of a command: images, labels or tables as numbers, and the rooms that are predicted from them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/sequences/feature_table.hpp"
#include "labeling.hpp"

namespace estancia::apps {

/// Describes with a progress bar and the cache, and warns of images that cannot be described.
class FeatureSource {
 public:
  /// With `arguments.stream.strict`, an image that cannot be described is an Error.
  explicit FeatureSource(const ModelArguments& arguments);

  /// SEQ: a map, a label file, a table of features, or images, which are described by `descriptor` (of the
  /// others: the parts that it names; "": all there are).
  Features features(const SequenceArguments& source, const std::string& descriptor,
                    const FeatureTableOptions& tables = {});
  Features features(const Sequence& sequence, const std::string& descriptor);

  /// Predictions of `classifier` for the frames whose labels are known; `sequence` (nullptr: not at hand) is
  /// used for what the labels do not contain.
  RoomPredictions rooms(const RoomClassifier& classifier, const DescriptorSequence& labels,
                        const Sequence* sequence);

 private:
  void warn(const std::vector<std::string>& problems) const;

  DescribeOptions options_;
  bool strict_;
  std::unique_ptr<LabelCache> cache_;
  std::unique_ptr<Progress> progress_;
};

/// Adds how images are described: the group "labeler", `--no-cache` and `--strict`.
void addDescribing(DeclaredOptions& declared, ModelArguments& arguments);

/// Whether SEQ holds numbers instead of images.
bool holdsNumbers(const std::string& path);

/// Names the places of a map file by what `classifier` predicts for its frames; `sequence` as for rooms().
void nameRooms(const std::string& map, const RoomClassifier& classifier, const Sequence* sequence,
               FeatureSource& describing);

/// Adds `--room-classifier`, for the commands that name rooms.
void addRoomClassifierOption(CLI::App& command, std::string& classifier);

/// --rooms-by-name; to be called after that of the classifier, which it excludes.
void addRoomsByNameOption(CLI::App& command, std::vector<std::string>& rooms);

/// The file of `--room-classifier`, absent for "". Throws Error, before the long work begins, if it could not
/// predict the rooms of `source`.
std::optional<RoomClassifier> openRoomClassifier(const std::string& file, const SequenceArguments& source);

}  // namespace estancia::apps
