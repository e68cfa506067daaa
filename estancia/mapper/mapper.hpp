// Topological mapping: LexToMap builds a map online from lexical descriptors (thesis Algorithm 4.1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

/// How thresholds are estimated from the run itself, without ground truth.
struct ThresholdOptions {
  /// τ_join accepts this share of the pairs of different places.
  double farQuantile = 0.03;
  /// τ_revisit / τ_join: moving needs more evidence than staying.
  double revisitRatio = 0.4;
  /// τ_merge / τ_join, between the means of two nodes; 0: never merge.
  double mergeRatio = 0.3;
  // τ_view, between two images of one view, is 0.3 τ_join; τ_sequence, between images of a sequence, half.

  bool operator==(const ThresholdOptions&) const = default;
};
OptionGroup declare(ThresholdOptions& options);

struct Thresholds {
  double join = 0, revisit = 0, merge = 0, view = 0, sequence = 0;
};

struct MapperOptions {
  /// Distance of a frame to a node, see baseDistances().
  std::string distance = "standardized-clr";
  /// τ1; estimated from the run unless given.
  std::optional<double> tauJoin;
  /// τ2; follows from τ_join unless given.
  std::optional<double> tauRevisit;
  /// Images kept in all of the places, to recognize these from another side and by poses; 0: a place is its
  /// mean alone, as in the thesis.
  std::size_t views = 2048;
  /// Frames this far apart [m], whose directions differ by this [degrees], can show the same place.
  double nearDistance = 0.7;
  double nearAngle = 30;
  /// K: the first and last K frames of a node weigh 0, 1/K, … in it, since they show its border; 0: off. Not
  /// while it has fewer than 2K frames.
  std::size_t transitionImages = 0;
  /// Warm-up length [keyframes]: these frames are remapped each time the thresholds are estimated again.
  std::size_t warmupFrames = 600;
  ThresholdOptions thresholds;

  /// The choices of the thesis author's program: rooted Eq. 4.5, k = 15, τ1 = 0.015, τ2 = 0.0015, no merging,
  /// means alone. The thesis prints ten times both (4.5.3), but that distance is at most √(2/L), 0.04 for its
  /// 1,183 labels: no frame would ever leave a node. His maps of 2016-04-27 are named by the values here, and
  /// only with them his sweeps have the nodes of Fig. 4.7 and 4.8.
  static MapperOptions thesis();
  bool operator==(const MapperOptions&) const = default;
};
OptionGroup declare(MapperOptions& options);

/// Changes of a map since they were last taken.
struct MapChanges {
  /// All earlier decisions are void: the frames have been mapped again.
  bool restarted = false;
  std::vector<std::variant<Decision, Merge>> events;
  std::set<int> changedNodes;
  /// From and to. Pairs that Mapper::transitions() does not have are no longer: a merge has redirected them.
  std::set<std::pair<int, int>> changedTransitions;
};

/// Builds the map one descriptor at a time. Deterministic. Memory grows with the nodes, not with the frames,
/// as long as the caller takes the changes. To map images into a file, see MappingSession.
///
/// Standardized distances and automatic thresholds are estimated from the run, again at keyframes 10, 13, 17,
/// … (each time the run has grown by a quarter). During the warm-up, Algorithm 4.1 is then repeated on all
/// frames so far, so that the first minute is mapped with the same scales as the rest.
class Mapper {
 public:
  /// `layout`: the labels and the models that they belong to (Vocabulary::layout()); a number will do for one
  /// model. Throws Error (invalidOption, unknownName) for options that are out of range.
  explicit Mapper(const DescriptorLayout& layout, const MapperOptions& options = {});
  /// Starts with a prior of the labels from images elsewhere: places are distinguished before the run shows
  /// many.
  explicit Mapper(const Vocabulary& vocabulary, const MapperOptions& options = {});
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;
  ~Mapper();

  /// Maps the next frame and returns its place (node id). `pose`: where it was taken, if that is known; poses
  /// distinguish places that look alike, and show that the robot is back. `guess`: the node that it is in by
  /// all frames so far (see Localizer); the frame belongs there unless words contradict. Throws Error when it
  /// is not a descriptor; the mapper is then unchanged.
  int add(DescriptorView descriptor, const std::optional<Pose>& pose = {},
          const std::optional<int>& guess = {});
  /// The next frame is another drive's: the robot may be anywhere. A run that is still warming up is remapped
  /// a last time. What is not recognized becomes a part of the map of its own, until the robot comes to a
  /// known place.
  void beginDrive();
  /// Corrects the poses that add() was given: `pose` returns the one of each frame, as it is known now.
  /// Places are recognized by it from now on; what was decided stays.
  void movePoses(const std::function<std::optional<Pose>(std::size_t frame)>& pose);
  /// The run is over (for now): a run that is still warming up is remapped a last time.
  void finish();

  /// Bounds what places and views take [bytes], or no longer; at least 16 places must fit. Where a new place
  /// does not, the one with fewest images becomes a part of a neighbor. Throws Error (tooLarge), as add()
  /// does where all places hold so many images that none can be spared.
  void setMemory(const std::optional<std::uint64_t>& bytes);

  std::size_t frames() const;
  std::size_t nodes() const;
  const MapperOptions& options() const;
  const Thresholds& thresholds() const;
  /// -1 before the first frame of a drive.
  int currentNode() const;
  /// Indexed by (from, to).
  const std::map<std::pair<int, int>, Transition>& transitions() const;
  MapChanges takeChanges();

  struct Impl;
  explicit Mapper(std::unique_ptr<Impl> impl);
  const Impl& impl() const { return *impl_; }
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
