// LexToMap: online topological mapping from lexical descriptors (thesis Algorithm 4.1).
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/topology/node_bank.hpp"
#include "estancia/topology/thresholds.hpp"

namespace estancia {

struct MapperOptions {
  std::string distance = "standardized-clr";  ///< see baseDistances(); the default is what measurement says
  std::optional<double> tauJoin;              ///< τ1; found by the run itself unless given
  std::optional<double> tauRevisit;           ///< τ2; follows from τ_join unless given
  /// Move only to a node nearer than the current one (the original program does)
  bool nearerThanCurrent = true;
  /// K: the first and last k images of a stay weigh i/k, they blur a node; 0: off.
  std::size_t transitionImages = 0;
  /// The run's first frames, decided again whenever the scales have been found anew.
  std::size_t warmupFrames = 600;
  ThresholdOptions thresholds;

  /// The thesis' own choices: rooted Eq. 4.5, k = 15, τ1 = τ2 = 0.015, no merging. The thesis prints τ1 =
  /// 0.15 (4.5.3), but that distance is at most √(2/L), 0.04 for its 1,183 labels: no image would ever leave
  /// a node. In the author's own sweeps τ1 runs from 0.01 to 0.05, with a single node from 0.05 on.
  static MapperOptions thesis();

  std::string toJson() const;
  /// Throws Error on unknown or malformed settings.
  static MapperOptions fromJson(const std::string& text);
};

/// Builds the map one descriptor at a time. Deterministic; memory grows with the nodes, not with the frames,
/// as long as the caller takes the news.
///
/// Standardized distances and automatic thresholds need to know the run. They are found again at frames 10,
/// 13, 17, … (each time the run has grown by a quarter). While the run is young (warmupFrames), Algorithm 4.1
/// is then repeated on all frames so far, so that the first minute is mapped by the same scales as the rest.
class Mapper {
 public:
  /// Throws Error on an unknown distance, thresholds that are not positive, or more than 1,000
  /// transitionImages. `layout`: how many labels, of how many models; a number will do for one
  /// (Vocabulary::layout()).
  Mapper(const DescriptorLayout& layout, MapperOptions options);

  /// Maps the next frame. Throws Error when it is no descriptor; the mapper is then as it was.
  void add(DescriptorView probabilities);
  /// The run is over (for now): a young run is decided once more with all it has told.
  void finish();

  std::size_t frames() const { return scale_.frames(); }
  const MapperOptions& options() const { return options_; }
  const NodeBank& bank() const { return bank_; }
  const Thresholds& thresholds() const { return thresholds_; }
  int currentNode() const;
  std::size_t currentSlot() const { return current_; }
  /// By (from, to).
  const std::map<std::pair<int, int>, Transition>& transitions() const { return transitions_; }

  /// What happened since the last call, for the map file.
  struct MapChanges {
    bool restarted = false;  ///< forget all decisions before: they have been made again
    std::vector<std::variant<Decision, Merge>> events;
    std::set<int> changedNodes;
    bool redirected = false;  ///< a merge has changed transitions: write all of them anew
    std::set<std::pair<int, int>> changedTransitions;
  };
  MapChanges takeChanges();

  /// The mapper's own memory, for --continue; nodes are saved apart by nodeState().
  std::string state() const;
  std::string nodeState(std::size_t slot) const;
  /// Restores a saved mapper. `descriptor(i)` gives frame i's stored descriptor.
  static Mapper restore(const DescriptorLayout& layout, MapperOptions options, const std::string& state,
                        const std::vector<std::pair<int, std::string>>& nodes,
                        const std::function<LexicalDescriptor(std::size_t)>& descriptor);

 private:
  struct Image {  ///< one frame on its way into a node
    std::vector<float> words, embedded;
  };
  Image makeImage(DescriptorView probabilities) const;
  bool isAutomatic() const;
  bool isWarmingUp() const;
  void rescale(bool young);
  void remapWarmup();
  void place(std::size_t frame, const Image& image);
  void join(std::size_t slot, const Image& image);
  std::size_t createNode();
  void leave();
  void addTransition(int from, int to, std::size_t frame);
  void mergeDuplicateNodes(std::size_t frame);

  std::size_t labels_;
  MapperOptions options_;
  Distance distance_;
  ThresholdEstimator scale_;
  NodeBank bank_;
  Thresholds thresholds_;
  std::size_t nextRescale_;
  std::size_t current_ = 0;  ///< slot of the current node
  int nextId_ = 0;
  std::size_t stay_ = 0;      ///< images since the robot entered the current node
  std::deque<Image> recent_;  ///< the last transitionImages images of this stay
  std::map<std::pair<int, int>, Transition> transitions_;
  std::vector<std::vector<float>> young_;  ///< descriptors of all frames while the run is young
  MapChanges changes_;
};

}  // namespace estancia
