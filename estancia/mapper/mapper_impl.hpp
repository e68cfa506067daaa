// Mapper implementation: the state of Algorithm 4.1, and how it is saved in a map file. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "estancia/map_file/store.hpp"
#include "estancia/mapper/lost_drive.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/mapper/node_bank.hpp"
#include "estancia/mapper/thresholds.hpp"
#include "estancia/mapper/view_memory.hpp"

namespace estancia {

/// State of Algorithm 4.1 over all drives. Invariant: `current` is a slot of `bank`, or empty before the
/// first frame of a drive; transitions, views and lost nodes refer to nodes by id. The first drive warms up
/// (its frames stay in `warmup` until thresholds are estimated, then they are mapped again); a further drive
/// is `lost` until it is recognized.
struct Mapper::Impl {
  Impl(const DescriptorLayout& layout, const MapperOptions& chosen, LabelPrior known);

  /// A frame as it came.
  struct Image {
    std::vector<float> probabilities;
    std::optional<Pose> pose;
  };
  /// On its way into a node: also as the distance embeds it.
  struct FrameDescriptor {
    std::vector<float> probabilities, embedded;
  };
  FrameDescriptor embeddedFrame(DescriptorView probabilities) const;

  void add(DescriptorView probabilities, const std::optional<Pose>& pose, const std::optional<int>& guess);
  /// The next frame, which was mapped before: its place and why are known, and nothing is warmed up.
  void replay(DescriptorView probabilities, const Decision& known);
  void finish() {
    if (isWarmingUp() && scale.frames() > 1) estimateScales(true);
  }
  void beginDrive();
  int currentNode() const { return current ? bank[*current].id : -1; }

  bool isAutomatic() const { return distance.standardized || !options.tauJoin; }
  bool isWarmingUp() const;
  void forgetLabelStatistics();
  /// The thesis' places are their means alone.
  bool hasModes() const { return !isFirstDrive && thresholds.merge > 0 && options.transitionImages == 0; }
  void endModes();
  void forgetModes() {
    for (const int id : bank.forgetModes()) changes.changedNodes.insert(id);
  }
  /// The bank as it will be after the drive, with this drive's appearance modes added.
  NodeBank bankAtRest() const;
  void estimateScales(bool warmingUp);
  void remapWarmup();
  void setStandardization();
  void place(std::size_t frame, const FrameDescriptor& descriptor, const std::optional<Pose>& pose,
             const std::optional<int>& guess = {});
  void decide(const PlaceView& seen, const std::optional<int>& guess, Decision& decision);
  bool isLocalized(const PlaceView& seen, const std::optional<int>& guess, Decision& decision) const;
  bool isRecognized(const PlaceView& seen, Decision& decision);
  /// A drive begins that may be in another building: with standardized distances that takes evidence.
  void getLost();
  void stayLost(const PlaceView& seen, Decision& decision);
  /// Whether two nodes of near means can be one place; those that a drive's own scale separated look alike.
  bool mayBeOne(int a, int b) const;
  /// The view (without views: the mean of a node) of earlier drives most similar to the image, embedded.
  std::optional<std::span<const float>> nearestKnown(const PlaceView& seen) const;
  /// Whether takeAlone() keeps to the memory.
  bool hasRoomFor(const Impl& alone) const;
  /// The places of a drive that is still lost are those of `alone` now, which mapped it as if it were the
  /// first: its frame i is frame `number(i)` here. The changes before must have been taken.
  void takeAlone(const Impl& alone, const std::function<std::size_t(std::size_t)>& number,
                 const std::function<std::optional<Pose>(std::size_t)>& pose);
  void join(std::size_t slot, std::size_t frame, const FrameDescriptor& descriptor);
  std::size_t createNode();
  /// A transition that changes; `frame` is its first one if it is new.
  Transition& transition(int from, int to, std::size_t frame);
  void mergeDuplicateNodes(std::size_t frame);
  void merge(std::size_t kept, std::size_t gone, const Merge& why);
  void absorbLostNode(int next, const Decision& decision);
  void redirectTransitions(int absorbed, int kept);
  void setMemory(const std::optional<std::uint64_t>& bytes);
  /// Whether another place needs room, with what modes take.
  bool isFull() const;
  /// Modes go first, where there are some. Then the place with fewest images becomes a part of a neighbor.
  void makeRoom(std::size_t frame);
  /// Whether both are of the drive that is lost, or neither is: those of two buildings are no neighbors.
  bool areOfOneSide(std::size_t slot, std::size_t other) const;
  /// Slot of the most similar adjacent place; if there is none, of any place.
  std::size_t neighborOf(std::size_t slot) const;
  /// Decision of the newest frame, unless the changes were taken since.
  const Decision& lastDecision() const;
  /// The frames whose descriptors restore() asks for.
  void addNeededFrames(std::vector<std::size_t>& frames) const;

  /// The mapper's own memory, to go on later; nodes are saved apart by nodeState(), views by views.state().
  std::string state() const;
  std::string nodeState(std::size_t slot) const;
  struct Saved {
    LabelPrior prior;
    std::string state;
    std::vector<std::pair<int, std::string>> nodes;
    std::string views;
    std::vector<Transition> transitions;
    /// Descriptor of frame i, as stored.
    std::function<LexicalDescriptor(std::size_t)> descriptor;
    std::function<std::optional<Pose>(std::size_t)> pose;
  };
  /// Throws Error (corruptFile) when the state is damaged.
  static Mapper restore(const DescriptorLayout& layout, const MapperOptions& options, const Saved& saved);

  std::size_t labels;
  MapperOptions options;
  Distance distance;
  LabelPrior prior;
  ThresholdEstimator scale;
  NodeBank bank;
  ViewMemory views;
  Thresholds thresholds;
  std::size_t nextEstimate;
  /// Slot of the current node; nothing before the first frame of a drive.
  std::optional<std::size_t> current;
  /// Only the first drive warms up: frames of further drives are not mapped again.
  bool isFirstDrive = true;
  /// State of a further drive until it is recognized.
  std::optional<LostDrive> lost;
  /// A lost drive has re-entered the map: the frames before must be mapped alone before the next is added.
  bool isBack = false;
  /// The node that a further drive started in, as long as the robot has been in no other one.
  std::optional<int> lostNode;
  /// Absorbed node → absorbing node since this drive began: a guess may name an absorbed one.
  std::map<int, int> absorbedBy;
  int nextId = 0;
  /// The first id of the nodes that this drive makes.
  int firstOfDrive = 0;
  /// Parts of the map were mapped with scales of their own.
  bool hadOtherScales = false;
  std::size_t maxNodes = std::numeric_limits<std::size_t>::max();
  std::map<std::pair<int, int>, Transition> transitions;
  /// All frames of the warm-up.
  std::vector<Image> warmup;
  MapChanges changes;
};

/// A map's settings as JSON, and back. Throws Error (corruptFile) on unknown or malformed settings.
std::string settingsToJson(const MapperOptions& options);
MapperOptions settingsFromJson(const std::string& text);
/// A sentence for each setting that has another, fixed value now.
std::vector<std::string> goneSettings(const std::string& text);

// The states of a map file that a mapper is kept as.
inline constexpr const char* mapperStateKey = "mapper";
inline constexpr const char* mapperViewsKey = "views";
inline constexpr const char* mapperPriorKey = "label-prior";

/// The mapper that a map file was made with, as it was at the last commit.
Mapper restoreMapper(const MapStore& store);

}  // namespace estancia
