// Object layer: the objects of a map, made of the segments of its observations and named by images of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/layers/work_time.hpp"
#include "estancia/objects/instance_map.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {

class Labeler;

/// Private to WorldMapper. Invariant: masks, labels and poses are kept by frame, so instances() is a function
/// of all views and poses, in any order of arrival. Life cycle: add() and label() for each observation;
/// restart() with another floor begins anew; finding() copies what it needs, for another thread.
class ObjectLayer {
 public:
  /// `labeler`: null where objects get no words; `crops`: images of objects that it labels in a frame, on
  /// average. Reads the views that the map holds. All must outlive it.
  ObjectLayer(WorldStore& store, const Vocabulary& vocabulary, const InstanceMapOptions& options,
              Labeler* labeler, std::size_t crops);

  /// Forgets what was added; labeled views stay.
  void restart(const Floor& floor);
  /// Adds the segments of the next view. `depth` is that of `seen` [m].
  void add(std::size_t frame, const cv::Mat& depth, const Observation& seen, const Pose& pose);
  /// Labels the segments of the view added last: all by a detector, if the labeler has one; those that are
  /// most worth it by images of them, more after frames that were no views and labeled nothing. `image`: BGR,
  /// of the whole frame. What would not end by the deadline is left to the next views.
  void label(std::size_t frame, const Observation& seen, const cv::Mat& image, const Deadline& deadline = {});
  /// The objects that the views show.
  std::vector<ObjectInstance> instances() const;
  /// The work of finding them as of now, for another thread: it has a copy.
  std::function<std::vector<ObjectInstance>()> finding() const;
  /// Writes these, as people have corrected them. `plan`: of the areas that they stand in; null without
  /// areas. `known`: the known object that each is; `shapes`: the classes by its shape, which a flat one does
  /// not get. Returns those that were not removed.
  std::vector<WorldObject> put(const std::vector<ObjectInstance>& found, const AreaPlan* plan,
                               std::span<const std::optional<KnownPose>> known,
                               std::span<const std::vector<LabelProbability>> shapes);

 private:
  WorldObject worldObject(const ObjectInstance& instance) const;
  void labelRegions(std::size_t frame, const Observation& seen, const cv::Mat& image);
  LexicalDescriptor labelCrop(const cv::Mat& crop);
  std::vector<std::vector<double>> wordsOf(const std::vector<ObjectInstance>& found,
                                           const std::map<SegmentPlace, int>& objectOf) const;

  /// An image that is labeled too late keeps two frames waiting: of ten frames a second, one of 25.
  static constexpr std::chrono::seconds longestUnlabeled{5};

  /// Evidence of a segment for the thing.
  struct Look {
    std::array<std::uint8_t, 3> color{};
    bool flat = false;
    double quality = 0;
  };

  WorldStore& store_;
  const Vocabulary& vocabulary_;
  InstanceMapOptions options_;
  Labeler* labeler_;
  std::size_t crops_;
  std::vector<std::size_t> regionLabels_;
  std::optional<Floor> floor_;
  std::optional<InstanceMap> instances_;
  std::optional<std::size_t> lastFrame_;  // the last frame that was added
  std::size_t frames_ = 1;                // from the one before to it
  std::size_t putOff_ = 0;                // images that there was no time to label
  WorkTime labeling_{longestUnlabeled};   // time of labeling an image
  std::map<SegmentPlace, LabeledSegment> labeled_;
  std::map<SegmentPlace, Look> looks_;
};

}  // namespace estancia
