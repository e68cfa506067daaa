// What classifiers work on: images, words or tables as numbers, and the rooms that they are taken for.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/describe/features.hpp"
#include "labeling.hpp"

namespace estancia::apps {

/// Describes with a progress bar and the cache, and warns of images that cannot be described.
class FeatureSource {
 public:
  explicit FeatureSource(const ModelArguments& arguments);

  /// SEQ: a map, a label file, a table of features, or images, which are described by `descriptor` (of the
  /// others: the parts that it names; "": all there are).
  Features features(const SequenceArguments& source, const std::string& descriptor);

  /// `strict`: an image that cannot be described is an Error.
  Features features(const Sequence& sequence, const std::string& descriptor, bool strict = false);

  /// What `classifier` says of the frames whose words are known; `sequence` (nullptr: not at hand) shows
  /// what the words do not tell.
  RoomPredictions rooms(const RoomClassifier& classifier, const DescriptorSequence& words,
                        const Sequence* sequence);

 private:
  void warn(const std::vector<std::string>& problems) const;

  DescribeOptions options_;
  std::unique_ptr<LabelCache> cache_;
  std::unique_ptr<Progress> progress_;
};

/// Whether SEQ holds numbers instead of images.
bool holdsNumbers(const std::string& path);

/// Names the places of a map file by what `classifier` says of its frames; `sequence` as for rooms().
void nameRooms(const std::string& map, const RoomClassifier& classifier, const Sequence* sequence,
               FeatureSource& describing);

/// Adds `--room-classifier`, for the commands that name rooms.
void addRoomClassifierOption(CLI::App& command, std::string& classifier);

/// The file of `--room-classifier`, absent for "". Throws Error, before the long work begins, when it could
/// not tell the rooms of `source`.
std::optional<RoomClassifier> openRoomClassifier(const std::string& file, const SequenceArguments& source);

}  // namespace estancia::apps
