// Category spread: the thesis' measure M of zones by classes of one category, and distances between classes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/findings/findings.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::experiments {

/// The class that an image belongs to, and what kind of class that is: the room "corridor 2" is a corridor.
struct ImageClass {
  /// Name "": not known, the image is left out.
  std::string category, name;
};

/// Two classes of one category, and how differently their images spread over the zones.
struct ClassPair {
  std::string category, first, second;
  /// Euclidean distance of the two distributions over zones / √2, in [0, 1].
  double distance = 0;
};

/// M of Eq. 5.2 and the pairs it is the mean of (Table 5.3).
struct CategorySpread {
  /// By category, then by the classes' names.
  std::vector<ClassPair> pairs;
  /// 0: classes of a category lie in the same zones; absent without a pair.
  std::optional<double> m;
};

/// Compares how the classes of each category spread over the zones (thesis 5.5.3, Fig. 5.5). `zoneOf` are any
/// numbers, one an image, as are `classes`. Throws Error (mismatch) when their lengths differ or one class
/// stands under two categories.
CategorySpread measureCategories(std::span<const int> zoneOf, std::span<const ImageClass> classes);

/// The mean over all pairs, each as heavy as the next: categories with many classes count more. So reads
/// Eq. 5.2, and so come the values under Table 5.3 about.
std::optional<double> meanDistance(std::span<const ClassPair> pairs);

/// The percent of each class' images in each zone (Fig. 5.5): classes down, zones across, the largest first,
/// those beyond the twentieth together. `classes` has one name an image, "" where not known. Throws as above.
ResultTable classHistograms(std::span<const int> zoneOf, std::span<const std::string> classes,
                            ResultTable head);

/// How far classes lie apart in labels.
struct ClassDistances {
  /// C names, by the alphabet.
  std::vector<std::string> classes;
  /// C×C, row-major, symmetric: the mean distance of an image of one class and an image of the other; on the
  /// diagonal that of two different images of the class, NaN where there is only one.
  std::vector<double> mean;

  /// C×C: the distance of the classes' mean descriptors, 0 on the diagonal, as the thesis has it (Fig. 5.4).
  /// Empty for distances whose scales are estimated from images.
  std::vector<double> ofMeans;

  double at(std::size_t a, std::size_t b) const { return mean[a * classes.size() + b]; }
};

/// By any distance: ZoneOptions::distance, "ks" for the thesis'. `classes` has one name a frame, "" where not
/// known. O(N² L). Throws Error when the lengths differ (mismatch), no class is known (insufficientData), or
/// the distance is not (unknownName).
ClassDistances classDistances(const DescriptorSequence& sequence, std::span<const std::string> classes,
                              const ZoneOptions& options, Progress& progress = Progress::none());

}  // namespace estancia::experiments
