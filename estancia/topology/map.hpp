// A topological map as plain data: what the mapper makes, the store keeps and everybody reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// A place: the mean and spread of its images' descriptors (thesis Eq. 4.2–4.4).
/// Invariant: mean and sigma have one value a label; frames ≥ 1.
struct Node {
  int id = 0;                ///< stable for the life of the map; merged nodes leave gaps
  std::uint64_t frames = 0;  ///< |N|, how many images it holds
  std::vector<float> mean;   ///< p̄_N(l), Eq. 4.3
  std::vector<float> sigma;  ///< σ_N(l), Eq. 4.4
};

/// The robot has driven from one node to another.
struct Transition {
  int from = 0, to = 0;
  std::uint64_t count = 0;     ///< how often it was driven in this direction
  std::size_t firstFrame = 0;  ///< the frame that made it
};

enum class DecisionKind {
  /// The very first frame makes the first node.
  start,
  /// Within τ_join of the current node: stays there.
  join,
  /// Within τ_revisit of another node, and nearer to it than to the current one: moves there.
  revisit,
  /// Near to no node: makes a new one.
  createNode
};

/// Why a frame went where it went: the stored answer of `estancia explain`.
struct Decision {
  std::size_t frame = 0;
  DecisionKind kind = DecisionKind::start;
  int node = 0;          ///< where the frame went
  int current = -1;      ///< the node the robot was in before; -1 at the start
  double toCurrent = 0;  ///< D(current, I); NaN at the start
  int other = -1;        ///< the nearest other node; -1 when it was not searched or there is none
  double toOther = 0;    ///< D(other, I); NaN when there is none
  double tauJoin = 0, tauRevisit = 0;
};

/// Two nodes turned out to be one place.
struct Merge {
  std::size_t frame = 0;  ///< the frame after which it happened
  int kept = 0, absorbed = 0;
  double distance = 0, threshold = 0;
};

/// A frame of the mapped sequence and where it belongs.
struct MappedFrame : Frame {
  int node = 0;
};

/// The whole map without its images and descriptors. Plain data; nodes are ordered by id.
struct TopologicalMap {
  Vocabulary vocabulary;
  std::string model;     ///< identity of the labeler
  std::string distance;  ///< name of the node distance
  std::vector<Node> nodes;
  std::vector<Transition> transitions;
  std::vector<MappedFrame> frames;  ///< position = frame number
  std::vector<Decision> decisions;  ///< one a frame
  std::vector<Merge> merges;
  /// What a room classifier said of the frames, a row a frame; rows may be missing at the end (frames that
  /// were mapped later). Absent when none was asked.
  std::optional<RoomPredictions> predictions = std::nullopt;

  /// nullptr when there is no such node.
  const Node* findNode(int id) const;
  /// Throws Error naming the nodes there are.
  const Node& getNode(int id) const;
};

/// "start", "join", "revisit", "create-node".
std::string toString(DecisionKind kind);

/// The `count` most probable labels of a node, best first, as label indices.
std::vector<std::size_t> bestLabels(const Node& node, std::size_t count);

}  // namespace estancia
