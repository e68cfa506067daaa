// Where in a map is the robot? One frame at a time, then with all frames so far, then with the next few, too.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/topology/bayes_filter.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/topology/node_bank.hpp"

namespace estancia {

struct LocalizerOptions {
  /// Answer this many frames late, and better: fixed-lag smoothing; 0: filter only.
  std::size_t lookahead = 0;
  /// Compare with at most so many stored images, evenly thinned: bounds memory.
  std::size_t mostImages = 50000;
  PlaceFilterOptions belief;
};

struct Localization {
  int node = 0;                  ///< nearest node by this frame alone
  std::size_t nearestImage = 0;  ///< nearest stored image (frame number of the map) by this frame alone
  double distance = 0;           ///< to that image
  int beliefNode = 0;            ///< most probable node by all frames
  std::size_t beliefImage = 0;   ///< most probable image of that node
  double confidence = 0;         ///< probability of beliefNode
};

/// What of a map localization needs. `images` holds the descriptors of frames 0, stride, 2·stride … of the
/// map.
struct LocalizerMap {
  const TopologicalMap* map;
  const NodeBank* bank;
  DescriptorMatrix images;
  std::size_t stride = 1;
};

class Localizer {
 public:
  /// The map and bank must outlive the localizer. Throws Error on an empty map.
  Localizer(const LocalizerMap& map, LocalizerOptions options);

  /// Takes the next frame; gives the answers that are final now, in order of frames: its own one without
  /// lookahead, none or several with it.
  std::vector<Localization> add(DescriptorView probabilities);
  /// The answers still waiting for frames to come.
  std::vector<Localization> finish();

 private:
  struct Waiting {
    Localization answer;
    std::vector<float> filtered, likelihood;
  };
  std::vector<Localization> settle(std::size_t count);
  void setBelief(Localization& answer, const std::vector<float>& state) const;

  const TopologicalMap& map_;
  const NodeBank& bank_;
  std::size_t stride_;
  LocalizerOptions options_;
  Distance distance_;
  std::vector<float> images_;  ///< rows made ready for comparing
  PlaceFilter belief_;
  std::vector<float> state_;
  std::deque<Waiting> waiting_;
};

}  // namespace estancia
