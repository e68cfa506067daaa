// Topological map: places (nodes), transitions and frames as plain data, and how a map file is read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

struct DescriptorSequence;

/// A place: mean and standard deviation of its frames' descriptors (thesis Eq. 4.2–4.4).
/// Invariant: mean and sigma have one value a label; frames ≥ 1.
struct Node {
  /// Stable for the life of the map; merged nodes leave gaps.
  int id = 0;
  /// |N|: how many frames it holds.
  std::uint64_t frames = 0;
  /// p̄_N(l), Eq. 4.3.
  std::vector<float> mean = {};
  /// σ_N(l), Eq. 4.4.
  std::vector<float> sigma = {};
};

/// The robot has driven from one node to another.
struct Transition {
  int from = 0, to = 0;
  /// How often it was driven in this direction.
  std::uint64_t count = 0;
  /// The frame that made it.
  std::size_t firstFrame = 0;
};

/// One run of a robot. Its frames follow each other; between two drives the robot may have been carried.
struct Drive {
  std::size_t firstFrame = 0;
  /// Name of its sequence; "" if none was given.
  std::string name = {};
  /// Sequence::fingerprint() of the sequence's first frame.
  std::string fingerprint = {};
  /// Whether the poses of its frames are known in the map's frame. Else they are in one of its own, and its
  /// frames have none in the map until enough places were recognized.
  bool isAligned = true;
  /// T_map_drive where that was found so.
  std::optional<Pose> alignment = {};
};

enum class DecisionKind {
  /// The first frame of a drive makes a node where it shows no known place.
  start,
  /// Within τ_join of the current node: stays there.
  join,
  /// Within τ_revisit of another node and nearer to it than to the current one, or one of its earlier images
  /// shows the same (ViewMemory): moves there.
  revisit,
  /// Near to no node: makes a new one.
  createNode,
  /// Localized in this place by all frames of the drive so far, and words do not contradict.
  localize
};

/// Why a frame belongs to its node: what `estancia explain` reports.
struct Decision {
  std::size_t frame = 0;
  DecisionKind kind = DecisionKind::start;
  /// Where the frame went.
  int node = 0;
  /// The node that the robot was in before; -1 at the start.
  int current = -1;
  /// D(current, I); NaN at the start.
  double toCurrent = 0;
  /// The nearest other node; -1 when it was not searched or there is none. The current node where only one of
  /// its images kept the frame there.
  int other = -1;
  /// D(other, I), or the distance to its image; NaN when there is none.
  double toOther = 0;
  double tauJoin = 0;
  /// Threshold of toOther.
  double tauRevisit = 0;
};

/// Two nodes turned out to be one place.
struct Merge {
  /// The frame after which it happened.
  std::size_t frame = 0;
  int kept = 0, absorbed = 0;
  double distance = 0, threshold = 0;
};

/// A frame of the mapped sequence and the node that it belongs to.
struct MappedFrame : Frame {
  int node = 0;
  /// In the map file: which one it was of all that were mapped.
  std::size_t number = 0;
};

/// Frames that follow each other at one place, by their numbers in the map file.
struct Visit {
  int node = 0;
  std::size_t firstFrame = 0, lastFrame = 0;
};

/// The whole map without its images and descriptors. Plain data; nodes are ordered by id.
struct TopologicalMap {
  Vocabulary vocabulary;
  /// Identity of the labeler.
  std::string model = {};
  /// Name of the node distance.
  std::string distance = {};
  std::vector<Node> nodes = {};
  std::vector<Transition> transitions = {};
  /// In order of their numbers. A frame that is named elsewhere in this struct is one of these, by its place
  /// in this list: where the file does not keep it (FileBudget), or was not read in full (MapStore::load()),
  /// the last one before it.
  std::vector<MappedFrame> frames = {};
  /// In order of frames, the first of frame 0; none in a map without frames.
  std::vector<Drive> drives = {};
  /// One a frame; none where only some frames were read.
  std::vector<Decision> decisions = {};
  std::vector<Merge> merges = {};
  /// A room classifier's predictions, a row a frame; rows may be missing at the end (frames that were mapped
  /// later). Absent when no classifier was run.
  std::optional<RoomPredictions> predictions = std::nullopt;
  /// Visits of all frames of the file. Absent where `frames` holds all frames, from which they follow.
  std::optional<std::vector<Visit>> visits = std::nullopt;

  /// Whether there are frames between these that were mapped, but are not kept in the file or were not read.
  bool isThinned() const;
  /// The frame of that number in the file, as a place in `frames`; the last one before it where it is
  /// missing.
  std::size_t indexOf(std::size_t number) const;
  /// Nothing where it is missing.
  std::optional<std::size_t> findFrame(std::size_t number) const;
  /// nullptr when there is no such node.
  const Node* findNode(int id) const;
  /// The drive of a frame, as an index.
  std::size_t driveOf(std::size_t frame) const;
  /// Whether the robot may have been carried before this frame.
  bool beginsDrive(std::size_t frame) const;
  /// Throws Error (unknownName) that lists the nodes.
  const Node& getNode(int id) const;
};

/// Adds a frame to the last visit, or, at another place, as the first of a new one.
void addFrame(std::vector<Visit>& visits, int node, std::size_t frame);

/// Visits of all frames of the map's file.
std::vector<Visit> visitsOf(const TopologicalMap& map);

/// The visits of a map file. Throws Error as readMap() does.
std::vector<Visit> readVisits(const std::filesystem::path& path);

/// "start", "join", "revisit", "create-node", "localize".
std::string toString(DecisionKind kind);

/// The `count` most probable labels of a node, best first, as label indices.
std::vector<std::size_t> bestLabels(const Node& node, std::size_t count);

/// Treatment of an existing file of that name.
enum class ExistingMap { refuse, replace };

/// Whether the file begins as a map file does, intact or not, whatever its name.
bool isMapFile(const std::filesystem::path& path);

/// Reads a map file as of its last commit, also while it is being written. Throws Error: fileNotFound,
/// unsupportedFile (another program's, or another format version), corruptFile (damaged or cut off).
TopologicalMap readMap(const std::filesystem::path& path);

/// The frames of a map file with their descriptors, as of one moment. Throws Error as readMap() does.
DescriptorSequence readMapDescriptors(const std::filesystem::path& path);

}  // namespace estancia
