// Instance accuracy: things that were found in a map against those that are there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/oriented_box.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/readers/home_truth.hpp"

namespace estancia {

/// Thing classes: categories of a home's truth as small things, furniture or fixtures, and labels for them.
struct ThingClasses {
  /// Things of this class belong to the building: whether a map has them counts neither way.
  static constexpr const char* fixture = "fixture";

  /// By category of instances.csv; all others are `otherClass`.
  std::map<std::string, std::string> classOf = {};
  std::string otherClass = "thing";
  /// By category: what labels call its things.
  std::map<std::string, std::vector<std::string>> words = {};

  /// The class of a category.
  const std::string& of(const std::string& category) const;
  /// The labels that name a thing of the category; empty where the vocabulary has none. See findLabels().
  std::vector<std::string> labelsOf(const std::string& category, const Vocabulary& vocabulary) const;
};

/// The keys `other` and `classes` (if `required`) of a configuration; no class has a `reserved` name.
std::vector<ConfigFile::Key> thingClassKeys(ConfigFile& config, ThingClasses& classes, bool required,
                                            const std::set<std::string_view>& reserved = {});

/// Reads TOML: `other = CLASS`, `[classes]` with a list of categories by class, `[words]` with a list of
/// labels by category; each may be missing. Throws Error `FILE:LINE: …` (malformedFile) on unknown or wrong
/// keys, a category in two classes, a category without words.
ThingClasses readThingClasses(const std::filesystem::path& file);

/// A found and a true box that are the same thing, by their positions in the lists.
struct BoxMatch {
  std::size_t found = 0, thing = 0;
  double overlap = 0;
};

/// Matches boxes one to one, those of largest intersection over union first, down to `least`; in that order.
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
  /// Found objects that the vocabulary can name, and those so named; none where no instance has a label.
  std::size_t nameable = 0, named = 0;
  /// Median distance of the boxes' middles of the found things [m].
  std::optional<double> error = {};

  std::optional<double> recall() const { return shareOf(found, things); }
  std::optional<double> precision() const { return shareOf(right, instances); }
  std::optional<double> nameAccuracy() const { return shareOf(named, nameable); }

 private:
  static std::optional<double> shareOf(std::size_t part, std::size_t whole) {
    if (whole == 0) return std::nullopt;
    return static_cast<double>(part) / static_cast<double>(whole);
  }
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
