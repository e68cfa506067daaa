// Instance accuracy: things that were found in a map against those that are there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/oriented_box.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/objects/thing_classes.hpp"
#include "estancia/readers/home_truth.hpp"

namespace estancia {

/// A found and a true box that are the same thing, by their positions in the lists.
struct BoxMatch {
  std::size_t found = 0, thing = 0;
  double overlap = 0;
};

/// Matches boxes one to one, those of largest intersection over union first, as long as it is at least
/// `least`. In the order of matching.
std::vector<BoxMatch> matchBoxes(std::span<const OrientedBox> found, std::span<const OrientedBox> things,
                                 double least = 0.25);

/// A thing that is there.
struct TrueThing {
  int id = 0;
  OrientedBox box = {};
  /// Class, as in ThingClasses.
  std::string thingClass = {};
  /// Whether it was shown well enough to be missed.
  bool counts = true;
  /// The labels that name it; empty where no label of the map's vocabulary does.
  std::vector<std::string> labels = {};
};

/// Frames that show a thing, and its pixels in each of them, from which on it counts.
constexpr std::size_t minFramesOfThing = 5, minPixelsOfThing = 150;

/// The things of a home. They count where at least minFramesOfThing of the `images` (by file name; all
/// where none are given) show `minPixels` of their pixels; all of them if the truth does not contain what
/// images show. `vocabulary`: that of the map; nullptr where it names nothing.
std::vector<TrueThing> trueThings(const io::HomeTruth& truth, const ThingClasses& classes,
                                  const Vocabulary* vocabulary, const std::set<std::string>& images = {},
                                  std::size_t minPixels = minPixelsOfThing);

/// Pixels of each thing that a segment shows, by the thing's id; below io::firstInstance structure.
using PixelsOfThings = std::map<int, double>;

/// Adds what each segment of a frame shows. `segments`: a segment image; `mask`: the truth, CV_16U, of that
/// size or of an image of which every n-th pixel was taken; a mask of any other size is ignored.
void addPixels(std::size_t frame, const cv::Mat& segments, const cv::Mat& mask,
               std::map<SegmentPlace, PixelsOfThings>& pixels);

/// An instance of a map.
struct FoundInstance {
  /// On the axes of the true boxes.
  OrientedBox box = {};
  bool hangsAtWall = false;
  /// Its best label; "" where it has none.
  std::string label = {};
  /// Things that its segments show; empty if unknown.
  PixelsOfThings pixels = {};
};

struct InstanceScore {
  /// Things that count, and those of them that an instance is.
  std::size_t things = 0, found = 0;
  /// Instances, and those of them that are a thing, whether it counts or not.
  std::size_t instances = 0, right = 0;
  /// Found objects that the vocabulary can name, and those whose instance has such a name; none where no
  /// instance has a label at all.
  std::size_t nameable = 0, named = 0;
  /// Median distance of the boxes' middles of the found things [m].
  std::optional<double> error = {};

  std::optional<double> recall() const;
  std::optional<double> precision() const;
  std::optional<double> nameAccuracy() const;
};

struct InstanceAccuracy {
  /// All but fixtures, and but instances that are no thing and hang at a wall.
  InstanceScore counted = {};
  /// By class; "none": the instances that are no thing.
  std::map<std::string, InstanceScore> ofClass = {};
  /// Things that most pixels of several instances show, and instances of which another thing has a quarter of
  /// the pixels or more. Absent where no instance has pixels.
  std::optional<std::size_t> split = {}, merged = {};
};

/// An instance is the thing that it is matched with by matchBoxes().
InstanceAccuracy judgeInstances(std::span<const FoundInstance> found, std::span<const TrueThing> things);

}  // namespace estancia
